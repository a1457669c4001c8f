// GLSL.std.450: packing. Component i goes to the i-th lowest bits.
#include "compiler/spirv/glsl450.h"

namespace pineda::spirv {
namespace {

using ir::Op;
using ir::Type;
using ir::Value;

// round(clamp(c) * scale), as GLSL's packSnorm and packUnorm define it.
template <uint32_t kCount, bool kSigned>
void pack_norm(Translator& t, const Instruction& inst) {
  constexpr uint32_t kBits = 32 / kCount;
  constexpr double kScale = kSigned ? (1u << (kBits - 1)) - 1 : (1u << kBits) - 1;
  const Values v = glsl_operand(t, inst, 0, true, kCount);
  if (t.b.type(v[0]) != Type::kF32) inst.fail("needs 32-bit floats");
  Value out;
  for (uint32_t i = 0; i < kCount; ++i) {
    const Value clamped = t.b.fmin(t.b.fmax(v[i], t.b.f32(kSigned ? -1 : 0)), t.b.f32(1));
    const Value rounded = t.b.fround_even(t.b.fmul(clamped, t.b.f32(kScale)));
    const Value whole = t.b.convert(Op::kFToS, Type::kI32, rounded);
    const Value field = t.b.shl(t.b.and_(whole, t.b.i32((1u << kBits) - 1)), t.b.i32(kBits * i));
    out = out ? t.b.or_(out, field) : field;
  }
  t.define(inst, Values{out});
}

template <uint32_t kCount, bool kSigned>
void unpack_norm(Translator& t, const Instruction& inst) {
  constexpr uint32_t kBits = 32 / kCount;
  constexpr double kScale = kSigned ? (1u << (kBits - 1)) - 1 : (1u << kBits) - 1;
  const Value packed = t.scalar(inst, kFirstOperand, Type::kI32);
  Values out;
  for (uint32_t i = 0; i < kCount; ++i) {
    const Value top = t.b.shl(packed, t.b.i32(32 - kBits * (i + 1)));
    const Value shift = t.b.i32(32 - kBits);
    const Value field = kSigned ? t.b.ashr(top, shift) : t.b.lshr(top, shift);
    const Value scaled = t.b.fdiv(t.b.convert(Op::kSToF, Type::kF32, field), t.b.f32(kScale));
    out.push_back(kSigned ? t.b.fmax(scaled, t.b.f32(-1)) : scaled);  // the most negative code is -1 too
  }
  t.define(inst, std::move(out));
}

void pack_half(Translator& t, const Instruction& inst) {
  const Values v = glsl_operand(t, inst, 0, true, 2);
  if (t.b.type(v[0]) != Type::kF32) inst.fail("needs 32-bit floats");
  Value half[2];
  for (uint32_t i = 0; i < 2; ++i) {
    const Value bits = t.b.bitcast(Type::kI16, t.b.convert(Op::kFConvert, Type::kF16, v[i]));
    half[i] = t.b.convert(Op::kZExt, Type::kI32, bits);
  }
  t.define(inst, Values{t.b.or_(half[0], t.b.shl(half[1], t.b.i32(16)))});
}

void unpack_half(Translator& t, const Instruction& inst) {
  const Value packed = t.scalar(inst, kFirstOperand, Type::kI32);
  Values out;
  for (uint32_t i = 0; i < 2; ++i) {
    const Value bits = t.b.convert(Op::kTrunc, Type::kI16, t.b.lshr(packed, t.b.i32(16 * i)));
    out.push_back(t.b.convert(Op::kFConvert, Type::kF32, t.b.bitcast(Type::kF16, bits)));
  }
  t.define(inst, std::move(out));
}

void pack_double(Translator& t, const Instruction& inst) {
  const Values v = glsl_operand(t, inst, 0, false, 2);
  if (t.b.type(v[0]) != Type::kI32) inst.fail("needs 32-bit integers");
  const Value high = t.b.shl(t.b.convert(Op::kZExt, Type::kI64, v[1]), t.b.i64(32));
  t.define(inst, Values{t.b.bitcast(Type::kF64, t.b.or_(t.b.convert(Op::kZExt, Type::kI64, v[0]), high))});
}

void unpack_double(Translator& t, const Instruction& inst) {
  const Value bits = t.b.bitcast(Type::kI64, t.scalar(inst, kFirstOperand, Type::kF64));
  t.define(inst,
           Values{t.b.convert(Op::kTrunc, Type::kI32, bits), t.b.convert(Op::kTrunc, Type::kI32, t.b.lshr(bits, t.b.i64(32)))});
}

constexpr ExtRow kRows[] = {
    PINEDA_GLSL_ROW(PackSnorm4x8, 1, pack_norm<4, true>),
    PINEDA_GLSL_ROW(PackUnorm4x8, 1, pack_norm<4, false>),
    PINEDA_GLSL_ROW(PackSnorm2x16, 1, pack_norm<2, true>),
    PINEDA_GLSL_ROW(PackUnorm2x16, 1, pack_norm<2, false>),
    PINEDA_GLSL_ROW(PackHalf2x16, 1, pack_half),
    PINEDA_GLSL_ROW(PackDouble2x32, 1, pack_double),
    PINEDA_GLSL_ROW(UnpackDouble2x32, 1, unpack_double),
    PINEDA_GLSL_ROW(UnpackSnorm2x16, 1, unpack_norm<2, true>),
    PINEDA_GLSL_ROW(UnpackUnorm2x16, 1, unpack_norm<2, false>),
    PINEDA_GLSL_ROW(UnpackHalf2x16, 1, unpack_half),
    PINEDA_GLSL_ROW(UnpackSnorm4x8, 1, unpack_norm<4, true>),
    PINEDA_GLSL_ROW(UnpackUnorm4x8, 1, unpack_norm<4, false>),
};

}  // namespace

std::span<const ExtRow> glsl_pack_rows() { return kRows; }

}  // namespace pineda::spirv
