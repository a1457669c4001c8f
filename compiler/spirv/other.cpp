// Calls, extended instructions, derivatives, barriers and discards.
#include <algorithm>

#include "base/abi.h"
#include "compiler/spirv/opcodes.h"

namespace pineda::spirv {
namespace {

using ir::Value;

// ---- derivatives: differences inside a 2x2 quad, whose lanes are 0 1 / 2 3 (base/abi.h) ----
//
// Fine: each row (column) its own difference. Coarse: the first row's (column's) for the whole quad. The plain instructions, for
// which Vulkan allows either, are fine.

constexpr uint32_t pattern(uint32_t a, uint32_t c, uint32_t d, uint32_t e) { return a | c << 2 | d << 4 | e << 6; }

struct Difference {
  uint32_t to, from;  // QuadSwizzle patterns
};
constexpr Difference kFineX{pattern(1, 1, 3, 3), pattern(0, 0, 2, 2)}, kFineY{pattern(2, 3, 2, 3), pattern(0, 1, 0, 1)};
constexpr Difference kCoarseX{pattern(1, 1, 1, 1), pattern(0, 0, 0, 0)}, kCoarseY{pattern(2, 2, 2, 2), pattern(0, 0, 0, 0)};

Value difference(Translator& t, Value v, const Difference& d) {
  return t.fsub(t.b.quad_swizzle(v, d.to), t.b.quad_swizzle(v, d.from));
}

Values derivative_operand(Translator& t, const Instruction& inst) {
  if (!t.is_fragment()) inst.fail("derivatives need a fragment shader");
  t.found().uses_derivatives = true;
  return t.floats(inst, 3);
}

template <const Difference& kDifference>
void derivative(Translator& t, const Instruction& inst) {
  Values v = derivative_operand(t, inst);
  for (Value& x : v) x = difference(t, x, kDifference);
  t.define(inst, std::move(v));
}

template <const Difference& kX, const Difference& kY>
void width(Translator& t, const Instruction& inst) {
  Values v = derivative_operand(t, inst);
  for (Value& x : v) x = t.fadd(t.b.fabs(difference(t, x, kX)), t.b.fabs(difference(t, x, kY)));
  t.define(inst, std::move(v));
}

// ---- barriers ----

// A workgroup of one wave runs in lockstep: every lane has done what stands before the barrier. The same holds for a barrier
// whose execution scope is the subgroup.
void control_barrier(Translator& t, const Instruction& inst) {
  t.found().uses_barriers = true;
  if (t.m.stage != VK_SHADER_STAGE_COMPUTE_BIT) return;
  const uint32_t scope = t.m.constant_u32(inst, inst.word(1));
  if (scope == spv::ScopeSubgroup || scope == spv::ScopeInvocation) return;
  uint64_t invocations = 1;
  for (uint32_t size : t.m.info.local_size) invocations *= size;
  if (invocations > kLanes) t.b.barrier();
}

// Our loads, stores and atomics are never reordered, and the targets keep their order (x86's total store order).
void memory_barrier(Translator&, const Instruction&) {}

// ---- lanes ----

void demote(Translator& t, const Instruction& inst) {
  if (!t.is_fragment()) inst.fail("needs a fragment shader");
  t.discard();
}

void is_helper(Translator& t, const Instruction& inst) {
  const Value lanes = t.lanes_with_effects();
  t.define(inst, Values{lanes ? t.b.not_(lanes) : t.b.b1(false)});
}

void extended(Translator& t, const Instruction& inst) {
  if (t.m.is_ignored_import(inst.word(3))) return;  // non-semantic: may always be left out
  if (inst.word(3) != t.m.glsl_std_450 || t.m.glsl_std_450 == 0) inst.fail("the instruction set was not imported");
  glsl_std_450(t, inst);
}

constexpr OpRow kRows[] = {
    PINEDA_SPIRV_ROW(FunctionCall, 4, [](Translator& t, const Instruction& inst) { t.call(inst); }),
    PINEDA_SPIRV_ROW(ExtInst, 5, extended),
    PINEDA_SPIRV_ROW(DPdx, 4, derivative<kFineX>),
    PINEDA_SPIRV_ROW(DPdy, 4, derivative<kFineY>),
    PINEDA_SPIRV_ROW(DPdxFine, 4, derivative<kFineX>),
    PINEDA_SPIRV_ROW(DPdyFine, 4, derivative<kFineY>),
    PINEDA_SPIRV_ROW(DPdxCoarse, 4, derivative<kCoarseX>),
    PINEDA_SPIRV_ROW(DPdyCoarse, 4, derivative<kCoarseY>),
    PINEDA_SPIRV_ROW(Fwidth, 4, width<kFineX, kFineY>),
    PINEDA_SPIRV_ROW(FwidthFine, 4, width<kFineX, kFineY>),
    PINEDA_SPIRV_ROW(FwidthCoarse, 4, width<kCoarseX, kCoarseY>),
    PINEDA_SPIRV_ROW(ControlBarrier, 4, control_barrier),
    PINEDA_SPIRV_ROW(MemoryBarrier, 3, memory_barrier),
    PINEDA_SPIRV_ROW(DemoteToHelperInvocation, 1, demote),
    PINEDA_SPIRV_ROW(IsHelperInvocationEXT, 3, is_helper),
};

}  // namespace

std::span<const OpRow> other_rows() { return kRows; }

}  // namespace pineda::spirv
