#include "compiler/jit/test_rig.h"
#include "compiler/ir/walk.h"

namespace pineda::jit::test {
namespace {

using ir::Op;
using ir::Rate;

class Rates {
 public:
  explicit Rates(ir::Kernel& kernel) : k_(kernel) {}

  void region(ir::RegionId id) {
    for (size_t i = 0; i < k_.regions[id].insts.size(); ++i) visit(k_.regions[id].insts[i]);
  }

 private:
  Rate& rate(ir::Value v) { return k_.at(v).rate; }

  Rate of_operands(ir::Value v) {
    Rate r = Rate::kWave;
    ir::for_each_operand(k_, v, [&](ir::Value x) { r = std::max(r, k_.at(x).rate); });
    return r;
  }

  void visit(ir::Value v) {
    ir::Inst& inst = k_.at(v);
    switch (inst.op) {
      case Op::kLane: case Op::kUnpackMask: case Op::kLocal: case Op::kLocalLoad: case Op::kAtomic: case Op::kLoopArg:
        if (inst.op != Op::kLoopArg) inst.rate = Rate::kLane;
        return;
      case Op::kBallot: inst.rate = Rate::kWave; return;
      case Op::kLoad: inst.rate = inst.lane_stride() != 0 ? Rate::kLane : of_operands(v); return;
      case Op::kIf:
        region(inst.region[0]);
        region(inst.region[1]);
        inst.rate = rate(inst.operand[0]);
        return;
      case Op::kLoop: loop(v); return;
      case Op::kResult: result(v); return;
      default: inst.rate = of_operands(v);
    }
  }

  void loop(ir::Value v) {
    const ir::Inst inst = k_.at(v);
    const auto args = k_.lists[inst.list];
    for (size_t k = 0; k < args.size(); ++k) rate(k_.regions[inst.region[0]].insts[k]) = std::min(Rate::kLane, std::max(Rate::kWave, rate(args[k])));
    for (bool changed = true; changed;) {
      changed = false;
      region(inst.region[0]);
      for (size_t k = 0; k < args.size(); ++k) {
        Rate& arg = rate(k_.regions[inst.region[0]].insts[k]);
        const Rate next = rate(ir::yielded(k_, inst.region[0])[k + 1]);
        if (next > arg) {
          arg = next;
          changed = true;
        }
      }
    }
    rate(v) = rate(ir::yielded(k_, inst.region[0])[0]);
  }

  void result(ir::Value v) {
    const ir::Inst& owner = k_.at(k_.at(v).operand[0]);
    const uint64_t skip = owner.op == Op::kLoop ? 1 : 0;
    Rate r = owner.rate;
    for (uint32_t i = 0; i < ir::region_count(owner.op); ++i) r = std::max(r, rate(ir::yielded(k_, owner.region[i])[k_.at(v).imm + skip]));
    rate(v) = r;
  }

  ir::Kernel& k_;
};

}  // namespace

void assign_rates(ir::Kernel& kernel) { Rates(kernel).region(kernel.wave); }

}  // namespace pineda::jit::test
