// Arithmetic, bit and conversion instructions: component by component, one IR operation each where the IR has it.
#include <bit>
#include <limits>

#include "compiler/spirv/opcodes.h"

namespace pineda::spirv {
namespace {

using ir::Op;
using ir::Type;

Values operand(Translator& t, const Instruction& inst, uint32_t word, bool wants_float) {
  return wants_float ? t.floats(inst, word) : t.integers(inst, word);
}

void same_size(const Instruction& inst, const Values& a, const Values& c) {
  if (a.size() != c.size()) inst.fail("the operands have different sizes");
}

template <bool kFloat, typename Fn>
void map1(Translator& t, const Instruction& inst, Fn fn) {
  Values a = operand(t, inst, 3, kFloat);
  for (ir::Value& v : a) v = fn(v);
  t.define(inst, std::move(a));
}

template <bool kFloat, typename Fn>
void map2(Translator& t, const Instruction& inst, Fn fn) {
  Values a = operand(t, inst, 3, kFloat);
  const Values c = operand(t, inst, 4, kFloat);
  same_size(inst, a, c);
  for (size_t i = 0; i < a.size(); ++i) a[i] = fn(a[i], c[i]);
  t.define(inst, std::move(a));
}

// Both operands of one type.
template <bool kFloat, typename Fn>
void map_same(Translator& t, const Instruction& inst, Fn fn) {
  map2<kFloat>(t, inst, [&](ir::Value a, ir::Value c) {
    if (t.b.type(a) != t.b.type(c)) inst.fail("the operands have different types");
    return fn(a, c);
  });
}

template <Op kOp>
void unary_int(Translator& t, const Instruction& inst) {
  map1<false>(t, inst, [&](ir::Value a) { return t.b.op(kOp, t.b.type(a), {a}); });
}
template <Op kOp>
void binary_int(Translator& t, const Instruction& inst) {
  map_same<false>(t, inst, [&](ir::Value a, ir::Value c) { return t.b.op(kOp, t.b.type(a), {a, c}); });
}

void f_negate(Translator& t, const Instruction& inst) {
  map1<true>(t, inst, [&](ir::Value a) { return t.b.fneg(a); });
}
void f_add(Translator& t, const Instruction& inst) {
  map_same<true>(t, inst, [&](ir::Value a, ir::Value c) { return t.fadd(a, c); });
}
void f_sub(Translator& t, const Instruction& inst) {
  map_same<true>(t, inst, [&](ir::Value a, ir::Value c) { return t.fsub(a, c); });
}
void f_mul(Translator& t, const Instruction& inst) {
  map_same<true>(t, inst, [&](ir::Value a, ir::Value c) { return t.fmul(a, c); });
}
void f_div(Translator& t, const Instruction& inst) {
  map_same<true>(t, inst, [&](ir::Value a, ir::Value c) { return t.b.fdiv(a, c); });
}
// Vulkan, "Precision of Individual Operations": OpFRem is x - y * trunc(x / y), OpFMod is x - y * floor(x / y).
void f_rem(Translator& t, const Instruction& inst) {
  map_same<true>(t, inst, [&](ir::Value x, ir::Value y) { return t.fsub(x, t.fmul(y, t.b.ftrunc(t.b.fdiv(x, y)))); });
}
void f_mod(Translator& t, const Instruction& inst) {
  map_same<true>(t, inst, [&](ir::Value x, ir::Value y) { return t.fsub(x, t.fmul(y, t.b.ffloor(t.b.fdiv(x, y)))); });
}

void s_negate(Translator& t, const Instruction& inst) {
  map1<false>(t, inst, [&](ir::Value a) { return t.b.isub(t.b.zero(t.b.type(a)), a); });
}
// The sign of the divisor: the remainder, plus the divisor where it is not zero and their signs differ.
void s_mod(Translator& t, const Instruction& inst) {
  map_same<false>(t, inst, [&](ir::Value x, ir::Value y) {
    const ir::Value zero = t.b.zero(t.b.type(x)), r = t.b.srem(x, y);
    const ir::Value differs = t.b.and_(t.b.ine(r, zero), t.b.slt(t.b.xor_(r, y), zero));
    return t.b.select(differs, t.b.iadd(r, y), r);
  });
}

// OpIAddCarry, OpISubBorrow, OpUMulExtended, OpSMulExtended: a struct of two; all first halves, then all second halves.
template <typename Low, typename High>
void pair_of_results(Translator& t, const Instruction& inst, Low low, High high) {
  const Values a = t.integers(inst, 3), c = t.integers(inst, 4);
  same_size(inst, a, c);
  if (t.b.type(a[0]) != t.b.type(c[0])) inst.fail("the operands have different types");
  Values out, second;
  for (size_t i = 0; i < a.size(); ++i) {
    out.push_back(low(a[i], c[i]));
    second.push_back(high(a[i], c[i], out.back()));
  }
  out.insert(out.end(), second.begin(), second.end());
  t.define(inst, std::move(out));
}

void add_carry(Translator& t, const Instruction& inst) {
  pair_of_results(
      t, inst, [&](ir::Value a, ir::Value c) { return t.b.iadd(a, c); },
      [&](ir::Value a, ir::Value, ir::Value sum) { return t.b.convert(Op::kZExt, t.b.type(a), t.b.ult(sum, a)); });
}
void sub_borrow(Translator& t, const Instruction& inst) {
  pair_of_results(
      t, inst, [&](ir::Value a, ir::Value c) { return t.b.isub(a, c); },
      [&](ir::Value a, ir::Value c, ir::Value) { return t.b.convert(Op::kZExt, t.b.type(a), t.b.ult(a, c)); });
}
void mul_extended_u(Translator& t, const Instruction& inst) {
  pair_of_results(
      t, inst, [&](ir::Value a, ir::Value c) { return t.b.imul(a, c); },
      [&](ir::Value a, ir::Value c, ir::Value) { return t.b.umul_hi(a, c); });
}
void mul_extended_s(Translator& t, const Instruction& inst) {
  pair_of_results(
      t, inst, [&](ir::Value a, ir::Value c) { return t.b.imul(a, c); },
      [&](ir::Value a, ir::Value c, ir::Value) { return t.b.smul_hi(a, c); });
}

// ---- shifts and bit fields: the amounts may have another width than what is shifted ----

// An integer as one of another width; amounts are unsigned (SPIR-V 3.52.14).
ir::Value resized(Translator& t, ir::Value v, Type to) {
  if (t.b.type(v) == to) return v;
  return t.b.convert(ir::size_bytes(to) < ir::size_bytes(t.b.type(v)) ? Op::kTrunc : Op::kZExt, to, v);
}

template <Op kOp>
void shift(Translator& t, const Instruction& inst) {
  map2<false>(t, inst, [&](ir::Value a, ir::Value by) { return t.b.op(kOp, t.b.type(a), {a, resized(t, by, t.b.type(a))}); });
}

ir::Value amount(Translator& t, const Instruction& inst, uint32_t word, Type type) {
  const Values v = t.integers(inst, word);
  if (v.size() != 1) inst.fail("offset and count must be scalars");
  return resized(t, v[0], type);
}

uint64_t width_of(Type type) { return 8 * ir::size_bytes(type); }

ir::Value low_bits(Translator& t, ir::Value count) {  // count may be 0 or the whole width
  const Type type = t.b.type(count);
  const ir::Value all = t.b.ule(t.b.constant(type, width_of(type)), count), one = t.b.constant(type, 1);
  return t.b.select(all, t.b.constant(type, ~0ull), t.b.isub(t.b.shl(one, count), one));
}

void bit_field_insert(Translator& t, const Instruction& inst) {
  Values base = t.integers(inst, 3);
  const Values insert = t.integers(inst, 4);
  same_size(inst, base, insert);
  const Type type = t.b.type(base[0]);
  if (t.b.type(insert[0]) != type) inst.fail("the operands have different types");
  const ir::Value offset = amount(t, inst, 5, type), count = amount(t, inst, 6, type);
  const ir::Value mask = t.b.shl(low_bits(t, count), offset);
  for (size_t i = 0; i < base.size(); ++i) {
    base[i] = t.b.or_(t.b.and_(base[i], t.b.not_(mask)), t.b.and_(t.b.shl(insert[i], offset), mask));
  }
  t.define(inst, std::move(base));
}

void bit_field_u_extract(Translator& t, const Instruction& inst) {
  Values base = t.integers(inst, 3);
  const Type type = t.b.type(base[0]);
  const ir::Value offset = amount(t, inst, 4, type), mask = low_bits(t, amount(t, inst, 5, type));
  for (ir::Value& v : base) v = t.b.and_(t.b.lshr(v, offset), mask);
  t.define(inst, std::move(base));
}

void bit_field_s_extract(Translator& t, const Instruction& inst) {
  Values base = t.integers(inst, 3);
  const Type type = t.b.type(base[0]);
  const ir::Value offset = amount(t, inst, 4, type), count = amount(t, inst, 5, type), zero = t.b.zero(type);
  const ir::Value right = t.b.isub(t.b.constant(type, width_of(type)), count), left = t.b.isub(right, offset);
  const ir::Value empty = t.b.ieq(count, zero);
  for (ir::Value& v : base) v = t.b.select(empty, zero, t.b.ashr(t.b.shl(v, left), right));
  t.define(inst, std::move(base));
}

// ---- conversions ----

Type wanted_result(Translator& t, const Instruction& inst, bool wants_float) {
  const Type type = t.component_of(t.result_type(inst));
  if (wants_float ? !ir::is_float(type) : !ir::is_int(type)) inst.fail("the result is not of the right kind");
  return type;
}

template <Op kOp, bool kFromFloat>
void convert(Translator& t, const Instruction& inst) {
  const Type to = wanted_result(t, inst, !kFromFloat);
  map1<kFromFloat>(t, inst, [&](ir::Value a) { return t.b.convert(kOp, to, a); });
}

template <Op kWiden>
void resize(Translator& t, const Instruction& inst) {
  const Type to = wanted_result(t, inst, false);
  map1<false>(t, inst, [&](ir::Value a) {
    return t.b.convert(ir::size_bytes(to) < ir::size_bytes(t.b.type(a)) ? Op::kTrunc : kWiden, to, a);
  });
}

// The count has the result's width; BitCount's operand may have another.
void bit_count(Translator& t, const Instruction& inst) {
  const Type to = wanted_result(t, inst, false);
  map1<false>(t, inst, [&](ir::Value a) { return resized(t, t.b.popcount(a), to); });
}

// Toward zero: the nearest number, moved one step where it lies beyond. Bits of finite numbers and infinity are in the order of
// their magnitudes, so the step is one unit of the pattern.
ir::Value narrowed_toward_zero(Translator& t, ir::Value a, Type to) {
  const Type bits = ir::size_bytes(to) == 2 ? Type::kI16 : Type::kI32;
  const ir::Value nearest = t.b.convert(Op::kFConvert, to, a);
  const ir::Value beyond = t.b.flt(t.b.fabs(a), t.b.fabs(t.b.convert(Op::kFConvert, t.b.type(a), nearest)));
  const ir::Value pattern = t.b.bitcast(bits, nearest);
  return t.b.bitcast(to, t.b.isub(pattern, t.b.convert(Op::kZExt, bits, beyond)));
}

void f_convert(Translator& t, const Instruction& inst) {
  const Type to = wanted_result(t, inst, true);
  const auto mode = t.m.decorations_of(inst.word(2)).rounding_mode.value_or(spv::FPRoundingModeRTE);
  if (mode != spv::FPRoundingModeRTE && mode != spv::FPRoundingModeRTZ) inst.fail("FPRoundingMode must be RTE or RTZ in Vulkan");
  map1<true>(t, inst, [&](ir::Value a) {
    const bool narrows = ir::size_bytes(to) < ir::size_bytes(t.b.type(a));
    return narrows && mode == spv::FPRoundingModeRTZ ? narrowed_toward_zero(t, a, to) : t.b.convert(Op::kFConvert, to, a);
  });
}

// Between numbers of equal total width: the first component holds the lowest bits. Physical pointers are 64-bit integers.
void bitcast(Translator& t, const Instruction& inst) {
  const Values from = t.values(inst, 3);
  const Type to = t.component_of(t.result_type(inst));
  const auto is_bits = [](Type type) { return ir::is_int(type) || ir::is_float(type); };
  const pineda::spirv::Type& source = t.type_of(inst, 3);
  const bool is_vector = source.is_scalar() || source.kind == TypeKind::kVector;
  if (!is_vector || !is_bits(to) || !is_bits(t.b.type(from[0]))) inst.fail("only numbers can be cast");
  const auto integer = [](Type type) {
    constexpr Type kBySize[] = {Type::kI8, Type::kI16, Type::kI32, Type::kI64};
    return kBySize[std::countr_zero(ir::size_bytes(type))];
  };
  const Type from_bits = integer(t.b.type(from[0])), to_bits = integer(to);
  const uint32_t from_size = ir::size_bytes(from_bits), to_size = ir::size_bytes(to_bits);
  Values out;
  if (from_size >= to_size) {
    for (ir::Value v : from) {
      const ir::Value bits = t.b.bitcast(from_bits, v);
      for (uint32_t at = 0; at < from_size; at += to_size) {
        const ir::Value part = t.b.lshr(bits, t.b.constant(from_bits, 8 * at));
        out.push_back(t.b.bitcast(to, t.b.convert(Op::kTrunc, to_bits, part)));
      }
    }
  } else {
    const uint32_t parts = to_size / from_size;
    if (from.size() % parts != 0) inst.fail("the operand does not have the result's width");
    for (size_t i = 0; i < from.size(); i += parts) {
      ir::Value bits = t.b.zero(to_bits);
      for (uint32_t k = 0; k < parts; ++k) {
        const ir::Value part = t.b.convert(Op::kZExt, to_bits, t.b.bitcast(from_bits, from[i + k]));
        bits = t.b.or_(bits, t.b.shl(part, t.b.constant(to_bits, uint64_t{8} * k * from_size)));
      }
      out.push_back(t.b.bitcast(to, bits));
    }
  }
  t.define(inst, std::move(out));
}

// Values too small for a normal binary16 become zero, values too large infinity (SPIR-V, OpQuantizeToF16).
void quantize_to_f16(Translator& t, const Instruction& inst) {
  map1<true>(t, inst, [&](ir::Value a) {
    if (t.b.type(a) != Type::kF32) inst.fail("needs 32-bit floats");
    const ir::Value half = t.b.convert(Op::kFConvert, Type::kF32, t.b.convert(Op::kFConvert, Type::kF16, a));
    const ir::Value is_small = t.b.flt(t.b.fabs(a), t.b.f32(0x1p-14));
    return t.b.select(is_small, t.b.fmul(a, t.b.f32(0)), half);
  });
}

constexpr OpRow kRows[] = {
    PINEDA_SPIRV_ROW(FNegate, 4, f_negate),
    PINEDA_SPIRV_ROW(FAdd, 5, f_add),
    PINEDA_SPIRV_ROW(FSub, 5, f_sub),
    PINEDA_SPIRV_ROW(FMul, 5, f_mul),
    PINEDA_SPIRV_ROW(FDiv, 5, f_div),
    PINEDA_SPIRV_ROW(FRem, 5, f_rem),
    PINEDA_SPIRV_ROW(FMod, 5, f_mod),
    PINEDA_SPIRV_ROW(SNegate, 4, s_negate),
    PINEDA_SPIRV_ROW(IAdd, 5, binary_int<Op::kIAdd>),
    PINEDA_SPIRV_ROW(ISub, 5, binary_int<Op::kISub>),
    PINEDA_SPIRV_ROW(IMul, 5, binary_int<Op::kIMul>),
    PINEDA_SPIRV_ROW(UDiv, 5, binary_int<Op::kUDiv>),
    PINEDA_SPIRV_ROW(SDiv, 5, binary_int<Op::kSDiv>),
    PINEDA_SPIRV_ROW(UMod, 5, binary_int<Op::kURem>),
    PINEDA_SPIRV_ROW(SRem, 5, binary_int<Op::kSRem>),
    PINEDA_SPIRV_ROW(SMod, 5, s_mod),
    PINEDA_SPIRV_ROW(IAddCarry, 5, add_carry),
    PINEDA_SPIRV_ROW(ISubBorrow, 5, sub_borrow),
    PINEDA_SPIRV_ROW(UMulExtended, 5, mul_extended_u),
    PINEDA_SPIRV_ROW(SMulExtended, 5, mul_extended_s),
    PINEDA_SPIRV_ROW(ShiftLeftLogical, 5, shift<Op::kShl>),
    PINEDA_SPIRV_ROW(ShiftRightLogical, 5, shift<Op::kLShr>),
    PINEDA_SPIRV_ROW(ShiftRightArithmetic, 5, shift<Op::kAShr>),
    PINEDA_SPIRV_ROW(BitwiseOr, 5, binary_int<Op::kOr>),
    PINEDA_SPIRV_ROW(BitwiseXor, 5, binary_int<Op::kXor>),
    PINEDA_SPIRV_ROW(BitwiseAnd, 5, binary_int<Op::kAnd>),
    PINEDA_SPIRV_ROW(Not, 4, unary_int<Op::kNot>),
    PINEDA_SPIRV_ROW(BitReverse, 4, unary_int<Op::kBitReverse>),
    PINEDA_SPIRV_ROW(BitCount, 4, bit_count),
    PINEDA_SPIRV_ROW(BitFieldInsert, 7, bit_field_insert),
    PINEDA_SPIRV_ROW(BitFieldUExtract, 6, bit_field_u_extract),
    PINEDA_SPIRV_ROW(BitFieldSExtract, 6, bit_field_s_extract),
    PINEDA_SPIRV_ROW(ConvertFToS, 4, convert<Op::kFToS, true>),
    PINEDA_SPIRV_ROW(ConvertFToU, 4, convert<Op::kFToU, true>),
    PINEDA_SPIRV_ROW(ConvertSToF, 4, convert<Op::kSToF, false>),
    PINEDA_SPIRV_ROW(ConvertUToF, 4, convert<Op::kUToF, false>),
    PINEDA_SPIRV_ROW(UConvert, 4, resize<Op::kZExt>),
    PINEDA_SPIRV_ROW(SConvert, 4, resize<Op::kSExt>),
    PINEDA_SPIRV_ROW(FConvert, 4, f_convert),
    PINEDA_SPIRV_ROW(Bitcast, 4, bitcast),
    PINEDA_SPIRV_ROW(QuantizeToF16, 4, quantize_to_f16),
};

}  // namespace

std::span<const OpRow> arith_rows() { return kRows; }

}  // namespace pineda::spirv
