// Helpers of the GLSL.std.450 handlers: component-wise maps over operands, which begin at word 5.
#pragma once

#include <spirv/unified1/GLSL.std.450.h>

#include "compiler/spirv/opcodes.h"

namespace pineda::spirv {

#define PINEDA_GLSL_ROW(name, operands, ...) \
  { GLSLstd450##name, #name, operands, __VA_ARGS__ }

inline constexpr uint32_t kFirstOperand = 5;

inline Values glsl_operand(Translator& t, const Instruction& inst, uint32_t n, bool wants_float, size_t size = 0) {
  Values v = wants_float ? t.floats(inst, kFirstOperand + n) : t.integers(inst, kFirstOperand + n);
  if (size != 0 && v.size() != size) inst.fail("the operands have different sizes");
  const ir::Type first = t.component_of(t.type_of(inst, kFirstOperand)), own = t.b.type(v[0]);
  if (own != first && ir::is_float(own) == ir::is_float(first)) inst.fail("the operands have different types");
  return v;
}

// A number of the type of `like`.
inline ir::Value number(Translator& t, ir::Value like, double v) { return t.b.fconst(t.b.type(like), v); }
inline ir::Value integer(Translator& t, ir::Value like, uint64_t v) { return t.b.constant(t.b.type(like), v); }

// Runs `fn` on 32-bit floats: the functions that GLSL.std.450 has for 16 and 32 bits only, computed for halves in binary32.
template <typename Fn, typename... Rest>
ir::Value in_f32(Translator& t, const Instruction& inst, Fn fn, ir::Value first, Rest... rest) {
  const ir::Type type = t.b.type(first);
  if (type == ir::Type::kF32) return fn(first, rest...);
  if (type != ir::Type::kF16) inst.fail("needs 16- or 32-bit floats");
  const auto widen = [&](ir::Value v) { return t.b.convert(ir::Op::kFConvert, ir::Type::kF32, v); };
  return t.b.convert(ir::Op::kFConvert, type, fn(widen(first), widen(rest)...));
}

template <bool kFloat, typename Fn>
void glsl_map1(Translator& t, const Instruction& inst, Fn fn) {
  Values a = glsl_operand(t, inst, 0, kFloat);
  for (ir::Value& v : a) v = fn(v);
  t.define(inst, std::move(a));
}

template <bool kFloat, typename Fn>
void glsl_map2(Translator& t, const Instruction& inst, Fn fn) {
  Values a = glsl_operand(t, inst, 0, kFloat);
  const Values c = glsl_operand(t, inst, 1, kFloat, a.size());
  for (size_t i = 0; i < a.size(); ++i) a[i] = fn(a[i], c[i]);
  t.define(inst, std::move(a));
}

template <bool kFloat, typename Fn>
void glsl_map3(Translator& t, const Instruction& inst, Fn fn) {
  Values a = glsl_operand(t, inst, 0, kFloat);
  const Values c = glsl_operand(t, inst, 1, kFloat, a.size()), d = glsl_operand(t, inst, 2, kFloat, a.size());
  for (size_t i = 0; i < a.size(); ++i) a[i] = fn(a[i], c[i], d[i]);
  t.define(inst, std::move(a));
}

}  // namespace pineda::spirv
