// What the passes share for rewriting a kernel in place.
#pragma once

#include <vector>

#include "compiler/ir/ir.h"
#include "compiler/ir/walk.h"

namespace pineda::passes {

// Values that other values stand for. Program order makes this simple: by the time that an operand is looked up, its replacement
// is final.
class Aliases {
 public:
  explicit Aliases(const ir::Kernel& kernel) : to_(kernel.insts.size()) {}

  ir::Value resolve(ir::Value v) const {
    while (v.id < to_.size() && to_[v.id]) v = to_[v.id];
    return v;
  }
  void set(ir::Value from, ir::Value to) {  // `to` unset: `from` stands for itself again
    if (from.id >= to_.size()) to_.resize(from.id + 1);
    to_[from.id] = to;
  }
  ir::Value get(ir::Value from) const { return from.id < to_.size() ? to_[from.id] : ir::Value{}; }

  // Replaces what the instruction names.
  void apply(ir::Kernel& kernel, ir::Value inst) const {
    ir::for_each_operand(kernel, inst, [&](ir::Value& operand) { operand = resolve(operand); });
  }

 private:
  std::vector<ir::Value> to_;  // by instruction index; unset: itself
};

inline ir::Value add_inst(ir::Kernel& kernel, const ir::Inst& inst) {
  kernel.insts.push_back(inst);
  return {static_cast<uint32_t>(kernel.insts.size() - 1)};
}

// Const whose raw zero bits are zero for every type.
inline ir::Value add_zero(ir::Kernel& kernel, ir::Type type) { return add_inst(kernel, {.op = ir::Op::kConst, .type = type}); }

inline bool writes(const ir::Inst& inst) {
  return ir::op_info(inst.op).effect == ir::Effect::kWrite || inst.op == ir::Op::kBarrier;  // other waves write before a barrier
}

// Renumbers everything in program order and drops what no region holds.
void compact(ir::Kernel& kernel);

}  // namespace pineda::passes
