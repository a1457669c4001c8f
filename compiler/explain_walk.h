// Walks over kernels that were optimised, as explain counts them.
#pragma once

#include "compiler/ir/walk.h"

namespace pineda::compiler {

// What passes/consecutive makes of an access: an If whose likely side does without a check, and whose other side is hardly run.
inline bool is_check(const ir::Inst& inst) { return inst.op == ir::Op::kIf && inst.flags & ir::kLikely; }

// Calls fn(inst, checked) for each instruction but those of the unlikely sides; `checked`: on a likely one.
template <typename Fn>
void for_each_likely(const ir::Kernel& kernel, ir::RegionId region, bool checked, Fn&& fn) {
  for (const ir::Value v : kernel.regions[region].insts) {
    const ir::Inst& inst = kernel.at(v);
    fn(inst, checked);
    const uint32_t sides = is_check(inst) ? 1 : ir::region_count(inst.op);
    for (uint32_t r = 0; r < sides; ++r) for_each_likely(kernel, inst.region[r], checked || is_check(inst), fn);
  }
}

}  // namespace pineda::compiler
