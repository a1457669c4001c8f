// Small helpers that every reader of a Kernel needs: which operands an instruction has, which regions, where its limit is.
#pragma once

#include <vector>

#include "compiler/ir/ir.h"

namespace pineda::ir {

constexpr bool is_memory(Op op) { return op == Op::kLoad || op == Op::kStore || op == Op::kAtomic; }
constexpr bool has_regions(Op op) { return op == Op::kIf || op == Op::kLoop; }
constexpr bool has_list(Op op) { return op == Op::kLoop || op == Op::kYield; }
// Ops whose Inst::imm is a small number of their own: count, pattern or index.
constexpr bool has_index_imm(Op op) {
  return op == Op::kLocal || op == Op::kQuadSwizzle || op == Op::kReduce || op == Op::kLoopArg || op == Op::kResult ||
         op == Op::kCall;
}

// Index in Inst::operand of the optional limit.
constexpr uint32_t limit_index(Op op) { return op == Op::kLoad ? 2 : 3; }
inline constexpr uint32_t kComparandIndex = 4;
inline Value limit_of(const Inst& inst) { return is_memory(inst.op) ? inst.operand[limit_index(inst.op)] : Value{}; }

// Number of regions that an instruction owns.
constexpr uint32_t region_count(Op op) { return op == Op::kIf ? 2 : op == Op::kLoop ? 1 : 0; }

// Every value that the instruction names, in order; `fn` may replace it (Value&) when the kernel is mutable.
template <typename KernelT, typename Fn>
void for_each_operand(KernelT& kernel, Value v, Fn&& fn) {
  auto& inst = kernel.insts[v.id];
  for (auto& operand : inst.operand) {
    if (operand) fn(operand);
  }
  if (has_list(inst.op)) {
    for (auto& value : kernel.lists[inst.list]) fn(value);
  }
}

// A limit of the form "condition ? limit : 0": the accesses that have it read the condition themselves (jit/emit_bounds.cpp).
inline bool is_guarded_limit(const Inst& inst, const Kernel& kernel) {
  return inst.op == Op::kSelect && kernel.at(inst.operand[2]).op == Op::kConst && kernel.at(inst.operand[2]).imm == 0;
}

// Calls fn for each value that the machine code of v may read: the operands, and what guards a limit.
template <typename Fn>
void for_each_read(const Kernel& kernel, Value v, Fn&& fn) {
  for_each_operand(kernel, v, fn);
  Value limit = limit_of(kernel.at(v));
  while (limit && is_guarded_limit(kernel.at(limit), kernel)) {
    fn(kernel.at(limit).operand[0]);
    limit = kernel.at(limit).operand[1];
    fn(limit);
  }
}

// The Yield that ends a region of an If or Loop.
inline Value yield_of(const Kernel& kernel, RegionId region) { return kernel.regions[region].insts.back(); }
inline const std::vector<Value>& yielded(const Kernel& kernel, RegionId region) {
  return kernel.lists[kernel.at(yield_of(kernel, region)).list];
}

// Calls fn(value) for each instruction of a region and of the regions in it, in program order. fn must not add to the regions.
template <typename Fn>
void for_each_inst(const Kernel& kernel, RegionId region, Fn&& fn) {
  for (Value v : kernel.regions[region].insts) {
    fn(v);
    const Inst& inst = kernel.at(v);
    for (uint32_t r = 0; r < region_count(inst.op); ++r) for_each_inst(kernel, inst.region[r], fn);
  }
}

// By region: whether a Barrier stands in it or in a region inside of it.
inline std::vector<bool> regions_with_barriers(const Kernel& kernel) {
  std::vector<bool> out(kernel.regions.size());
  const auto visit = [&](auto&& self, RegionId region) -> bool {
    bool found = false;
    for (Value v : kernel.regions[region].insts) {
      const Inst& inst = kernel.at(v);
      found |= inst.op == Op::kBarrier;
      for (uint32_t r = 0; r < region_count(inst.op); ++r) found |= self(self, inst.region[r]);
    }
    return out[region] = found;
  };
  if (kernel.wave != 0) visit(visit, kernel.wave);
  return out;
}

// Whether a whole workgroup runs this instruction together: an If or Loop that holds a Barrier.
inline bool is_group_construct(const Inst& inst, const std::vector<bool>& with_barriers) {
  return has_regions(inst.op) && (with_barriers[inst.region[0]] || (inst.op == Op::kIf && with_barriers[inst.region[1]]));
}

}  // namespace pineda::ir
