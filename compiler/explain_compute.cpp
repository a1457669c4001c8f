// Runs the passes over a compute kernel one after the other and counts what each took away.
#include <set>

#include "base/deep_stack.h"
#include "compiler/explain.h"
#include "compiler/explain_walk.h"
#include "compiler/ir/ranges.h"
#include "compiler/ir/walk.h"
#include "compiler/ir/wave_frame.h"
#include "compiler/kernels/kernels.h"
#include "compiler/passes/passes.h"

namespace pineda::compiler {
namespace {

using ir::Inst;
using ir::Op;
using ir::Rate;

struct Census {
  uint32_t instructions = 0, constants = 0, loads = 0, stores = 0, locals = 0, local_accesses = 0, ifs = 0, loops = 0, limits = 0;
};

template <typename Fn>
void for_each_inst_of_all(const ir::Kernel& kernel, Fn&& fn) {
  for (const ir::RegionId root : {kernel.draw, kernel.prim, kernel.wave}) {
    if (root != 0) for_each_likely(kernel, root, false, [&](const Inst& inst, bool) { fn(inst); });
  }
}

Census census(const ir::Kernel& kernel) {
  Census c;
  for_each_inst_of_all(kernel, [&](const Inst& inst) {
    ++c.instructions;
    c.constants += inst.op == Op::kConst;
    c.loads += inst.op == Op::kLoad;
    c.stores += inst.op == Op::kStore;
    c.locals += inst.op == Op::kLocal;
    c.local_accesses += inst.op == Op::kLocalLoad || inst.op == Op::kLocalStore;
    c.ifs += inst.op == Op::kIf;
    c.loops += inst.op == Op::kLoop;
    c.limits += bool{ir::limit_of(inst)};
  });
  return c;
}

uint32_t computing(const Census& c) { return c.instructions - c.constants; }

uint32_t less(uint32_t before, uint32_t after) { return before > after ? before - after : 0; }

uint32_t count(const ir::Kernel& kernel, ir::RegionId root) {
  uint32_t n = 0;
  if (root != 0) for_each_likely(kernel, root, false, [&](const Inst&, bool) { ++n; });
  return n;
}

// As the back end decides it of constants; what the Ifs and Loops around tell it comes on top (jit/emit_bounds.cpp).
bool is_known_inside(const ir::Kernel& kernel, const Inst& inst) {
  const Inst& limit = kernel.at(ir::limit_of(inst));
  if (limit.op != Op::kConst) return false;
  const ir::Type type = inst.op == Op::kLoad ? inst.type : kernel.at(inst.operand[2]).type;
  const uint64_t reach_bytes = uint64_t{kLanes - 1} * inst.lane_stride() + ir::size_bytes(type);
  return ir::upper_bound(kernel, inst.operand[1]) + reach_bytes <= limit.imm;
}

// A limit "condition ? limit : 0" has a condition of its own, which the back end keeps apart (Emitter::set_limit).
ir::Value plain_limit(const ir::Kernel& kernel, ir::Value limit, std::set<uint32_t>& guards) {
  while (ir::is_guarded_limit(kernel.at(limit), kernel)) {
    const ir::Value condition = kernel.at(limit).operand[0];
    if (kernel.at(condition).rate == Rate::kLane) guards.insert(condition.id);
    limit = kernel.at(limit).operand[1];
  }
  return limit;
}

void count_checks(const ir::Kernel& kernel, BoundsChecks& checks) {
  std::set<uint32_t> guards;
  for (const ir::RegionId root : {kernel.draw, kernel.prim, kernel.wave}) {
    if (root == 0) continue;
    for_each_likely(kernel, root, false, [&](const Inst& inst, bool checked) {
      if (checked && ir::is_memory(inst.op) && !ir::limit_of(inst)) ++checks.per_wave;
      if (!ir::limit_of(inst)) return;
      const ir::Value limit = plain_limit(kernel, ir::limit_of(inst), guards);
      const bool varies = kernel.at(inst.operand[1]).rate == Rate::kLane || kernel.at(limit).rate == Rate::kLane;
      ++(is_known_inside(kernel, inst) ? checks.known
         : root != kernel.wave         ? checks.per_draw
         : varies                      ? checks.per_lane
                                       : checks.per_wave);
    });
  }
  checks.indices = static_cast<uint32_t>(guards.size());
}

void count_branches(const ir::Kernel& kernel, Branches& branches) {
  for_each_likely(kernel, kernel.wave, false, [&](const Inst& inst, bool) {
    if (!ir::has_regions(inst.op) || is_check(inst)) return;
    const ir::Value condition = inst.op == Op::kIf ? inst.operand[0] : ir::yielded(kernel, inst.region[0])[0];
    ++(kernel.at(condition).rate == Rate::kLane ? branches.divergent : branches.uniform);
  });
}

void count_barriers(const ir::Kernel& kernel, ComputeSizes& sizes) {
  const std::vector<bool> with_barriers = ir::regions_with_barriers(kernel);
  for_each_inst_of_all(kernel, [&](const Inst& inst) {
    sizes.barriers += inst.op == Op::kBarrier;
    sizes.group_constructs += ir::is_group_construct(inst, with_barriers);
  });
  sizes.frame_bytes = ir::wave_frame(kernel).bytes;
}

// The passes up to the point where optimize() (passes/optimize.cpp) makes their second round, in its order.
void remove_step_by_step(ir::Kernel& kernel, ComputeSizes& sizes) {
  using namespace passes;
  Removed& removed = sizes.removed;
  Census now = census(kernel);
  // Runs passes and gives what was there before them.
  const auto step = [&](auto&& run) {
    const Census before = now;
    run();
    now = census(kernel);
    return before;
  };
  const Census built = step([&] { ssa(kernel); });
  removed.variables = less(built.locals, now.locals);
  removed.accesses = less(built.local_accesses, now.local_accesses);
  Census before = step([&] { dce(kernel); });
  removed.dead = less(computing(before), computing(now));
  before = step([&] {
    fold(kernel, Form::kTruth);
    ssa(kernel);  // arrays whose indices are constant now
    fold(kernel, Form::kTruth);
    dce(kernel);
  });
  removed.constant = less(computing(before), computing(now));
  removed.decided = less(built.ifs, now.ifs);
  before = step([&] {
    cse(kernel);
    dce(kernel);
  });
  removed.equal = less(computing(before), computing(now));
  removed.equal_loads = less(before.loads, now.loads);
  before = step([&] {
    while (unroll(kernel)) {
      fold(kernel, Form::kTruth);
      cse(kernel);
      dce(kernel);
    }
  });
  sizes.branches.unrolled = less(before.loops, now.loops);
  before = step([&] { optimize(kernel, Form::kTruth); });
  sizes.branches.flattened = less(before.ifs, now.ifs);
}

}  // namespace

ComputeSizes measure_compute_kernel(ir::Kernel kernel) {
  ComputeSizes sizes;
  with_deep_stack([&] {
    const Census built = census(kernel);
    sizes.kernel.built = built.instructions;
    sizes.kernel.built_loads = built.loads;
    sizes.kernel.built_stores = built.stores;
    sizes.branches.built = built.ifs + built.loops;
    sizes.checks.built = built.limits;
    remove_step_by_step(kernel, sizes);
    const Census kept = census(kernel);
    sizes.kernel.kept = kept.instructions;
    sizes.kernel.loads = kept.loads;
    sizes.kernel.stores = kept.stores;
    sizes.kernel.per_draw = count(kernel, kernel.draw);
    sizes.kernel.per_primitive = count(kernel, kernel.prim);
    count_checks(kernel, sizes.checks);
    count_branches(kernel, sizes.branches);
    count_barriers(kernel, sizes);
  });
  return sizes;
}

Result<ComputeSizes> measure_compute(const ComputeSource& source) {
  Result<ir::Kernel> kernel = kernels::build_compute(source, kernels::shader_of(*source.module));
  if (!kernel) return std::unexpected(kernel.error());
  return measure_compute_kernel(std::move(*kernel));
}

}  // namespace pineda::compiler
