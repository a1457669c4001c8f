// Arithmetic, bit and conversion instructions: component by component, one IR operation each where the IR has it.
#include <cmath>
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

template <Op kOp>
void unary_int(Translator& t, const Instruction& inst) {
  map1<false>(t, inst, [&](ir::Value a) { return t.b.op(kOp, t.b.type(a), {a}); });
}
template <Op kOp>
void binary_int(Translator& t, const Instruction& inst) {
  map2<false>(t, inst, [&](ir::Value a, ir::Value c) { return t.b.op(kOp, t.b.type(a), {a, c}); });
}

void f_negate(Translator& t, const Instruction& inst) {
  map1<true>(t, inst, [&](ir::Value a) { return t.b.fneg(a); });
}
void f_add(Translator& t, const Instruction& inst) {
  map2<true>(t, inst, [&](ir::Value a, ir::Value c) { return t.fadd(a, c); });
}
void f_sub(Translator& t, const Instruction& inst) {
  map2<true>(t, inst, [&](ir::Value a, ir::Value c) { return t.fsub(a, c); });
}
void f_mul(Translator& t, const Instruction& inst) {
  map2<true>(t, inst, [&](ir::Value a, ir::Value c) { return t.fmul(a, c); });
}
void f_div(Translator& t, const Instruction& inst) {
  map2<true>(t, inst, [&](ir::Value a, ir::Value c) { return t.b.fdiv(a, c); });
}
// Vulkan, "Precision of Individual Operations": OpFRem is x - y * trunc(x / y), OpFMod is x - y * floor(x / y).
void f_rem(Translator& t, const Instruction& inst) {
  map2<true>(t, inst, [&](ir::Value x, ir::Value y) { return t.fsub(x, t.fmul(y, t.b.ftrunc(t.b.fdiv(x, y)))); });
}
void f_mod(Translator& t, const Instruction& inst) {
  map2<true>(t, inst, [&](ir::Value x, ir::Value y) { return t.fsub(x, t.fmul(y, t.b.ffloor(t.b.fdiv(x, y)))); });
}

void s_negate(Translator& t, const Instruction& inst) {
  map1<false>(t, inst, [&](ir::Value a) { return t.b.isub(t.b.zero(t.b.type(a)), a); });
}
// The sign of the divisor: the remainder, plus the divisor where it is not zero and their signs differ.
void s_mod(Translator& t, const Instruction& inst) {
  map2<false>(t, inst, [&](ir::Value x, ir::Value y) {
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
      [&](ir::Value a, ir::Value, ir::Value sum) { return t.b.convert(Op::kZExt, Type::kI32, t.b.ult(sum, a)); });
}
void sub_borrow(Translator& t, const Instruction& inst) {
  pair_of_results(
      t, inst, [&](ir::Value a, ir::Value c) { return t.b.isub(a, c); },
      [&](ir::Value a, ir::Value c, ir::Value) { return t.b.convert(Op::kZExt, Type::kI32, t.b.ult(a, c)); });
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

// ---- bit fields: offset and count are scalars, count may be 0 or 32 ----

ir::Value low_bits(Translator& t, ir::Value count) {
  const ir::Value all = t.b.ule(t.b.i32(32), count);
  return t.b.select(all, t.b.i32(~0u), t.b.isub(t.b.shl(t.b.i32(1), count), t.b.i32(1)));
}

void bit_field_insert(Translator& t, const Instruction& inst) {
  Values base = t.integers(inst, 3);
  const Values insert = t.integers(inst, 4);
  same_size(inst, base, insert);
  const ir::Value offset = t.scalar(inst, 5, Type::kI32), count = t.scalar(inst, 6, Type::kI32);
  const ir::Value mask = t.b.shl(low_bits(t, count), offset);
  for (size_t i = 0; i < base.size(); ++i) {
    base[i] = t.b.or_(t.b.and_(base[i], t.b.not_(mask)), t.b.and_(t.b.shl(insert[i], offset), mask));
  }
  t.define(inst, std::move(base));
}

void bit_field_u_extract(Translator& t, const Instruction& inst) {
  Values base = t.integers(inst, 3);
  const ir::Value offset = t.scalar(inst, 4, Type::kI32), mask = low_bits(t, t.scalar(inst, 5, Type::kI32));
  for (ir::Value& v : base) v = t.b.and_(t.b.lshr(v, offset), mask);
  t.define(inst, std::move(base));
}

void bit_field_s_extract(Translator& t, const Instruction& inst) {
  Values base = t.integers(inst, 3);
  const ir::Value offset = t.scalar(inst, 4, Type::kI32), count = t.scalar(inst, 5, Type::kI32);
  const ir::Value right = t.b.isub(t.b.i32(32), count), left = t.b.isub(right, offset);
  const ir::Value empty = t.b.ieq(count, t.b.i32(0));
  for (ir::Value& v : base) v = t.b.select(empty, t.b.i32(0), t.b.ashr(t.b.shl(v, left), right));
  t.define(inst, std::move(base));
}

// ---- conversions ----

template <Op kOp, bool kFromFloat>
void convert(Translator& t, const Instruction& inst) {
  map1<kFromFloat>(t, inst, [&](ir::Value a) { return t.b.convert(kOp, kFromFloat ? Type::kI32 : Type::kF32, a); });
}

// Between integers of one width, which is all that is advertised.
void convert_same_width(Translator& t, const Instruction& inst) {
  map1<false>(t, inst, [](ir::Value a) { return a; });
}

void bitcast(Translator& t, const Instruction& inst) {
  Values v = t.values(inst, 3);
  const pineda::spirv::Type& to = t.result_type(inst);
  const pineda::spirv::Type& from = t.type_of(inst, 3);
  const auto scalar = [&](const pineda::spirv::Type& type) {
    return type.kind == TypeKind::kVector ? t.m.type(type.element).scalar : type.scalar;
  };
  const auto is_bits = [](Type type) { return type == Type::kI32 || type == Type::kF32; };
  if (!is_bits(scalar(to)) || !is_bits(scalar(from))) inst.fail("only numbers can be cast");
  for (ir::Value& x : v) x = t.b.bitcast(scalar(to), x);
  t.define(inst, std::move(v));
}

// Values too small for a normal binary16 become zero, values too large infinity (SPIR-V, OpQuantizeToF16).
void quantize_to_f16(Translator& t, const Instruction& inst) {
  map1<true>(t, inst, [&](ir::Value a) {
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
    PINEDA_SPIRV_ROW(ShiftLeftLogical, 5, binary_int<Op::kShl>),
    PINEDA_SPIRV_ROW(ShiftRightLogical, 5, binary_int<Op::kLShr>),
    PINEDA_SPIRV_ROW(ShiftRightArithmetic, 5, binary_int<Op::kAShr>),
    PINEDA_SPIRV_ROW(BitwiseOr, 5, binary_int<Op::kOr>),
    PINEDA_SPIRV_ROW(BitwiseXor, 5, binary_int<Op::kXor>),
    PINEDA_SPIRV_ROW(BitwiseAnd, 5, binary_int<Op::kAnd>),
    PINEDA_SPIRV_ROW(Not, 4, unary_int<Op::kNot>),
    PINEDA_SPIRV_ROW(BitReverse, 4, unary_int<Op::kBitReverse>),
    PINEDA_SPIRV_ROW(BitCount, 4, unary_int<Op::kPopCount>),
    PINEDA_SPIRV_ROW(BitFieldInsert, 7, bit_field_insert),
    PINEDA_SPIRV_ROW(BitFieldUExtract, 6, bit_field_u_extract),
    PINEDA_SPIRV_ROW(BitFieldSExtract, 6, bit_field_s_extract),
    PINEDA_SPIRV_ROW(ConvertFToS, 4, convert<Op::kFToS, true>),
    PINEDA_SPIRV_ROW(ConvertFToU, 4, convert<Op::kFToU, true>),
    PINEDA_SPIRV_ROW(ConvertSToF, 4, convert<Op::kSToF, false>),
    PINEDA_SPIRV_ROW(ConvertUToF, 4, convert<Op::kUToF, false>),
    PINEDA_SPIRV_ROW(UConvert, 4, convert_same_width),
    PINEDA_SPIRV_ROW(SConvert, 4, convert_same_width),
    PINEDA_SPIRV_ROW(Bitcast, 4, bitcast),
    PINEDA_SPIRV_ROW(QuantizeToF16, 4, quantize_to_f16),
};

}  // namespace

std::span<const OpRow> arith_rows() { return kRows; }

}  // namespace pineda::spirv
