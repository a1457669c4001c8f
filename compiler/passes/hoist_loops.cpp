// Loop-invariant code motion inside of the wave: what a loop's body computes from values of before the loop moves in front of it,
// out of every loop that allows it, also from under an If in the body. The same instructions may move as in hoist.cpp, and for
// the same reason: they may run where nobody asked for them.
#include <algorithm>

#include "compiler/passes/passes.h"
#include "compiler/passes/rewrite.h"

namespace pineda::passes {
namespace {

using ir::Inst;
using ir::Op;
using ir::RegionId;
using ir::Value;

class LoopHoister {
 public:
  explicit LoopHoister(ir::Kernel& kernel) : kernel_(kernel), depth_(kernel.insts.size()) {}

  void region(RegionId id) {
    const std::vector<Value> old = std::move(kernel_.regions[id].insts);
    std::vector<Value> out;
    out.reserve(old.size());
    for (Value v : old) {
      const Inst inst = kernel_.at(v);
      const size_t depth = lowest_depth(inst);
      depth_[v.id] = static_cast<uint32_t>(depth);
      if (depth < in_front_of_.size()) {
        in_front_of_[depth].push_back(v);
        continue;
      }
      if (inst.op == Op::kLoop) {
        in_front_of_.emplace_back();
        region(inst.region[0]);
        out.insert(out.end(), in_front_of_.back().begin(), in_front_of_.back().end());
        in_front_of_.pop_back();
      } else if (inst.op == Op::kIf) {
        for (RegionId side : inst.region) region(side);
      }
      out.push_back(v);
    }
    kernel_.regions[id].insts = std::move(out);
  }

 private:
  // How many of the enclosing loops an instruction must stay in.
  size_t lowest_depth(const Inst& inst) const {
    const size_t here = in_front_of_.size();
    if (here == 0 || !is_movable(inst)) return here;
    size_t out = 0;
    for (Value operand : inst.operand) {
      if (operand) out = std::max<size_t>(out, depth_[operand.id]);
    }
    return out;
  }

  static bool is_movable(const Inst& inst) {
    switch (inst.op) {
      case Op::kLoad:
        return (inst.flags & ir::kInvariant) && (ir::limit_of(inst) || (inst.flags & ir::kSpeculate));
      case Op::kLocal:
      case Op::kLoopArg:
      case Op::kResult:
        return false;
      default:
        return ir::op_info(inst.op).effect == ir::Effect::kPure;
    }
  }

  ir::Kernel& kernel_;
  std::vector<uint32_t> depth_;                  // by value: number of loops around the place where it stands now
  std::vector<std::vector<Value>> in_front_of_;  // by enclosing loop, outermost first: what moves in front of it
};

}  // namespace

void hoist_loops(ir::Kernel& k) { LoopHoister(k).region(k.wave); }

}  // namespace pineda::passes
