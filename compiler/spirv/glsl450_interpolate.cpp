// GLSL.std.450: inputs at other places of the pixel (Vulkan 1.3, "Interpolation Functions").
#include "compiler/spirv/glsl450.h"
#include "compiler/spirv/module.h"

namespace pineda::spirv {
namespace {

// Scalar `at` of the input variable, which must be a located float.
ir::Value input_at(Translator& t, const Instruction& inst, std::span<const InterfaceEntry> entries, size_t at,
                   const InterpolationPlace& place) {
  if (at >= entries.size()) inst.fail("the operand is not inside its variable");
  const std::optional<InterfaceScalar>& scalar = entries[at].scalar;
  const ir::Value value = scalar && !scalar->built_in ? t.stage.input_at(t.b, *scalar, place) : ir::Value{};
  if (!value || t.b.type(value) != ir::Type::kF32) inst.fail("this input cannot be interpolated here");
  return value;
}

// `place` is the same for all scalars of the input that the first operand points to. Of an element that is chosen at run time
// all candidates are interpolated, as FlatMemory::load chooses among all of them; an index outside gives one of them.
void interpolate(Translator& t, const Instruction& inst, const InterpolationPlace& place) {
  const Pointer p = t.pointer(inst, kFirstOperand);
  const auto entries = t.m.interface_entries.find(p.variable);
  if (p.storage != spv::StorageClassInput || entries == t.m.interface_entries.end()) inst.fail("the operand must be an input");
  const uint32_t step = p.index ? t.m.variable(p.variable)->dynamic_step : 0;
  if (p.index && step == 0) inst.fail("the pointer was computed before its base");
  Values out;
  const size_t count = t.m.flat_scalars(p.pointee).size();
  for (size_t i = 0; i < count; ++i) {
    const auto first = static_cast<uint32_t>(p.offset + i);
    ir::Value value = input_at(t, inst, entries->second, first, place);
    for (uint32_t at = first + step; step != 0 && at < entries->second.size(); at += step)
      value = t.b.select(t.b.ieq(p.index, t.b.i32(at - first)), input_at(t, inst, entries->second, at, place), value);
    out.push_back(value);
  }
  t.define(inst, out);
}

void at_centroid(Translator& t, const Instruction& inst) { interpolate(t, inst, {.centroid = true}); }

void at_sample(Translator& t, const Instruction& inst) {
  interpolate(t, inst, {.sample = t.scalar(inst, kFirstOperand + 1, ir::Type::kI32)});
}

void at_offset(Translator& t, const Instruction& inst) {
  const Values offset = glsl_operand(t, inst, 1, true, 2);
  interpolate(t, inst, {.offset = {offset[0], offset[1]}});
}

constexpr ExtRow kRows[] = {
    PINEDA_GLSL_ROW(InterpolateAtCentroid, 1, at_centroid),
    PINEDA_GLSL_ROW(InterpolateAtSample, 2, at_sample),
    PINEDA_GLSL_ROW(InterpolateAtOffset, 2, at_offset),
};

}  // namespace

std::span<const ExtRow> glsl_interpolate_rows() { return kRows; }

}  // namespace pineda::spirv
