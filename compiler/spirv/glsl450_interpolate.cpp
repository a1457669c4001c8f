// GLSL.std.450: inputs at other places of the pixel (Vulkan 1.3, "Interpolation Functions").
#include "compiler/spirv/glsl450.h"
#include "compiler/spirv/module.h"

namespace pineda::spirv {
namespace {

// `place` is the same for all scalars of the input that the first operand points to.
void interpolate(Translator& t, const Instruction& inst, const InterpolationPlace& place) {
  const Pointer p = t.pointer(inst, kFirstOperand);
  const auto entries = t.m.interface_entries.find(p.variable);
  if (p.storage != spv::StorageClassInput || entries == t.m.interface_entries.end()) inst.fail("the operand must be an input");
  if (p.index) inst.fail("an input that is indexed by a variable cannot be interpolated elsewhere");
  Values out;
  const size_t count = t.m.flat_scalars(p.pointee).size();
  for (size_t i = 0; i < count; ++i) {
    if (p.offset + i >= entries->second.size()) inst.fail("the operand is not inside its variable");
    const std::optional<InterfaceScalar>& scalar = entries->second[p.offset + i].scalar;
    const ir::Value value = scalar && !scalar->built_in ? t.stage.input_at(t.b, *scalar, place) : ir::Value{};
    if (!value || t.b.type(value) != ir::Type::kF32) inst.fail("this input cannot be interpolated here");
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
