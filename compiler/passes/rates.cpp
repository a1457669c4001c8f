// The slowest rate at which each value is constant, by an optimistic fixed point: everything starts at Draw and rises. "Constant"
// speaks of active lanes only, so a uniform value inside a divergent If is uniform; what leaves the If by way of a Result is not.
#include <algorithm>

#include "base/abi.h"
#include "compiler/passes/passes.h"
#include "compiler/passes/rewrite.h"

namespace pineda::passes {
namespace {

using ir::Inst;
using ir::Op;
using ir::Rate;
using ir::RegionId;
using ir::Value;

class Rater {
 public:
  explicit Rater(ir::Kernel& kernel) : kernel_(kernel), with_barriers_(ir::regions_with_barriers(kernel)) {
    for (Inst& inst : kernel.insts) inst.rate = Rate::kDraw;
  }

  void run() {
    do {
      changed_ = false;
      for (RegionId root : {kernel_.draw, kernel_.prim, kernel_.wave}) region(root, {});
    } while (changed_);
  }

 private:
  Rate rate(Value v) const { return kernel_.at(v).rate; }

  // Only LoopArgs depend on what comes after them: another sweep is needed when one has to rise.
  void region(RegionId id, Value owner) {
    for (Value v : kernel_.regions[id].insts) {
      const Inst inst = kernel_.at(v);
      for (uint32_t r = 0; r < ir::region_count(inst.op); ++r) region(inst.region[r], v);
      const Rate next = std::max(inst.rate, compute(inst, owner));
      if (inst.op == Op::kLoop) changed_ |= loop_args_must_rise(inst);
      kernel_.at(v).rate = next;
    }
  }

  // A construct that holds a barrier is run by the workgroup, so what it carries may be the primitive's.
  Rate construct(const Inst& inst) const { return ir::is_group_construct(inst, with_barriers_) ? Rate::kPrim : Rate::kWave; }

  Rate of_operands(const Inst& inst) const {
    Rate out = Rate::kDraw;
    for (Value operand : inst.operand) {
      if (operand) out = std::max(out, rate(operand));
    }
    return out;
  }

  Rate compute(const Inst& inst, Value owner) const {
    switch (inst.op) {
      case Op::kConst:
      case Op::kDrawPtr:
      case Op::kThreadPtr:
        return Rate::kDraw;
      case Op::kPrimPtr:
        return Rate::kPrim;
      case Op::kWavePtr:
      case Op::kBallot:
        return Rate::kWave;
      case Op::kLoad:
        if (inst.lane_stride() != 0) return Rate::kLane;
        return std::max(of_operands(inst), inst.flags & ir::kInvariant ? Rate::kDraw : Rate::kWave);
      case Op::kShuffle:
        return std::max(Rate::kWave, rate(inst.operand[1]));  // one lane's value: the operand's rate does not matter
      case Op::kReduce:
        return inst.scan() == ir::Scan::kReduce && inst.cluster_lanes() == kLanes ? Rate::kWave : Rate::kLane;
      case Op::kIf:
        return std::max(construct(inst), rate(inst.operand[0]));
      case Op::kLoop:
        return std::max(construct(inst), rate(ir::yielded(kernel_, inst.region[0])[0]));
      case Op::kResult:
        return result(inst);
      case Op::kLoopArg:
        return carried(kernel_.at(owner), inst.imm);
      case Op::kLane:
      case Op::kUnpackMask:
      case Op::kLocal:
      case Op::kLocalLoad:
      case Op::kAtomic:
      case Op::kStore:
      case Op::kLocalStore:
      case Op::kCall:
      case Op::kYield:
        return Rate::kLane;
      default:
        return of_operands(inst);
    }
  }

  Rate result(const Inst& inst) const {
    const Inst& owner = kernel_.at(inst.operand[0]);
    Rate out = owner.rate;
    if (owner.op == Op::kLoop) {  // lanes that left earlier keep their own last value
      return std::max(out, rate(ir::yielded(kernel_, owner.region[0])[inst.imm + 1]));
    }
    for (RegionId side : owner.region) out = std::max(out, rate(ir::yielded(kernel_, side)[inst.imm]));
    return out;
  }

  // In the body only lanes that go on are active, and all of them have made the same number of turns.
  Rate carried(const Inst& loop, uint64_t k) const {
    return std::max({construct(loop), rate(kernel_.lists[loop.list][k]), rate(ir::yielded(kernel_, loop.region[0])[k + 1])});
  }

  bool loop_args_must_rise(const Inst& loop) const {
    const auto& body = kernel_.regions[loop.region[0]].insts;
    for (size_t k = 0; k < kernel_.lists[loop.list].size(); ++k) {
      if (carried(loop, k) > rate(body[k])) return true;
    }
    return false;
  }

  ir::Kernel& kernel_;
  const std::vector<bool> with_barriers_;  // by region
  bool changed_ = false;
};

}  // namespace

void rates(ir::Kernel& k) { Rater(k).run(); }

}  // namespace pineda::passes
