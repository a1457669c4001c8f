// Conversions between number formats. Semantics: ops.inc; binary16: base/half.h.
#include "compiler/jit/emitter.h"

namespace pineda::jit {

using ir::Op;
using ir::Type;

Emitter::V Emitter::emit_convert(const ir::Inst& inst) {
  const Type from = kernel_.at(inst.operand[0]).type;
  switch (inst.op) {
    case Op::kFToS:
      return float_to_int(arg(inst, 0), from, inst.type, true);
    case Op::kFToU:
      return float_to_int(arg(inst, 0), from, inst.type, false);
    case Op::kSToF:
      return int_to_float(arg(inst, 0), inst.type, true);
    case Op::kUToF:
      return int_to_float(arg(inst, 0), inst.type, false);
    case Op::kFConvert:
      return convert_float(arg(inst, 0), from, inst.type);
    case Op::kBitcast: {
      V a = arg(inst, 0);
      return b_.CreateBitCast(a, value_type(inst.type, is_vector(a)));
    }
    default:
      return emit_int_convert(inst);
  }
}

// ---- float to integer -----------------------------------------------------------------------------------------------------

Emitter::V Emitter::float_to_int(V x, Type from, Type to, bool is_signed) {
  x = widen(x, from);
  const bool from_f64 = from == Type::kF64;
  llvm::Type* target = value_type(to, is_vector(x));
  if (from_f64 || to == Type::kI64 || !is_vector(x)) {
    const auto id = is_signed ? llvm::Intrinsic::fptosi_sat : llvm::Intrinsic::fptoui_sat;
    return b_.CreateIntrinsic(id, {target, x->getType()}, {x});
  }
  if (to == Type::kI32) return is_signed ? f32_to_i32(x) : f32_to_u32(x);
  // Narrow targets: their bounds are binary32 values, so clamp there. NaN fails both comparisons' first and becomes 0 at the end.
  const unsigned bits = target->getScalarSizeInBits();
  const double high = is_signed ? (1 << (bits - 1)) - 1 : (1 << bits) - 1, low = is_signed ? -(1 << (bits - 1)) : 0;
  V top = float_const(x->getType(), high), bottom = float_const(x->getType(), low);
  V clamped = b_.CreateSelect(b_.CreateFCmpOLT(top, x), top, x);
  clamped = b_.CreateSelect(b_.CreateFCmpOLT(clamped, bottom), bottom, clamped);
  return b_.CreateTrunc(f32_to_i32(clamped), target);
}

// cvttps2dq gives 0x80000000 for everything out of range: right below, all ones to flip above, zero for NaN.
Emitter::V Emitter::f32_to_i32(V x) {
  V r = truncate_f32(x);
  V too_big = b_.CreateFCmpOGE(x, float_const(x->getType(), 0x1p31));
  r = b_.CreateXor(r, b_.CreateSExt(too_big, r->getType()));
  return b_.CreateSelect(b_.CreateFCmpUNO(x, x), int_const(r->getType(), 0), r);
}

// max(x, 0) maps NaN and negative numbers to 0. AVX-512 has the unsigned conversion, all ones when out of range.
// Else with r = trunc(x): below 2^31 r is the answer. From 2^31 on r is 0x80000000, whose sign, smeared, lets trunc(x - 2^31) in;
// the subtraction is exact up to 2^32, above which all ones are set.
Emitter::V Emitter::f32_to_u32(V x) {
  V zero = float_const(x->getType(), 0);
  x = b_.CreateSelect(b_.CreateFCmpOGT(x, zero), x, zero);
  if (features_.vector_bits == 512) return truncate_f32_unsigned_512(x);
  V r = truncate_f32(x);
  V upper = truncate_f32(b_.CreateFSub(x, float_const(x->getType(), 0x1p31)));
  r = b_.CreateOr(r, b_.CreateAnd(upper, b_.CreateAShr(r, 31)));
  V too_big = b_.CreateFCmpOGE(x, float_const(x->getType(), 0x1p32));
  return b_.CreateOr(r, b_.CreateSExt(too_big, r->getType()));
}

// The instruction itself: LLVM's fptosi is poison out of range.
Emitter::V Emitter::truncate_f32(V x) {
  llvm::Type* i32 = b_.getInt32Ty();
  if (features_.vector_bits == 512) {
    V off = llvm::Constant::getNullValue(lane_type(i32));
    constexpr int kCurrentRounding = 4;
    return b_.CreateIntrinsic(llvm::Intrinsic::x86_avx512_mask_cvttps2dq_512, {},
                              {x, off, b_.getInt16(0xffff), b_.getInt32(kCurrentRounding)});
  }
  const bool wide = features_.vector_bits == 256;
  std::vector<V> parts = split(x, wide ? 8 : 4);
  for (V& part : parts) {
    part = b_.CreateIntrinsic(wide ? llvm::Intrinsic::x86_avx_cvtt_ps2dq_256 : llvm::Intrinsic::x86_sse2_cvttps2dq, {}, {part});
  }
  return join(std::move(parts));
}

Emitter::V Emitter::truncate_f32_unsigned_512(V x) {
  V off = llvm::Constant::getNullValue(lane_type(b_.getInt32Ty()));
  constexpr int kCurrentRounding = 4;
  return b_.CreateIntrinsic(llvm::Intrinsic::x86_avx512_mask_cvttps2udq_512, {},
                            {x, off, b_.getInt16(0xffff), b_.getInt32(kCurrentRounding)});
}

// The 16 lanes in runs of `lanes`, and back: for what exists for one width only.
std::vector<Emitter::V> Emitter::split(V x, uint32_t lanes) {
  std::vector<V> parts;
  for (uint32_t first = 0; first < kLanes; first += lanes) {
    std::vector<int> from(lanes);
    for (uint32_t l = 0; l < lanes; ++l) from[l] = static_cast<int>(first + l);
    parts.push_back(b_.CreateShuffleVector(x, from));
  }
  return parts;
}

Emitter::V Emitter::join(std::vector<V> parts) {
  while (parts.size() > 1) {  // pairwise
    std::vector<V> joined;
    for (size_t i = 0; i < parts.size(); i += 2) {
      const auto n = llvm::cast<llvm::FixedVectorType>(parts[i]->getType())->getNumElements();
      std::vector<int> all(2 * n);
      for (size_t l = 0; l < all.size(); ++l) all[l] = static_cast<int>(l);
      joined.push_back(b_.CreateShuffleVector(parts[i], parts[i + 1], all));
    }
    parts = std::move(joined);
  }
  return parts[0];
}

// ---- integer to float -----------------------------------------------------------------------------------------------------

Emitter::V Emitter::int_to_float(V x, Type to, bool is_signed) {
  const bool to_f16 = to == Type::kF16;
  // To F16 by way of F64, which is exact below 2^53; above, everything is infinite in F16 anyway.
  llvm::Type* type = value_type(to_f16 ? Type::kF64 : to, is_vector(x));
  V result = is_signed ? b_.CreateSIToFP(x, type) : b_.CreateUIToFP(x, type);
  return to_f16 ? convert_float(result, Type::kF64, Type::kF16) : result;
}

// ---- float to float -------------------------------------------------------------------------------------------------------

Emitter::V Emitter::convert_float(V x, Type from, Type to) {
  if (from == to) return x;
  if (from == Type::kF16) x = half_to_f32(x);
  if (to == Type::kF16) return f32_to_half(from == Type::kF64 ? f64_to_odd_f32(x) : x);
  llvm::Type* type = value_type(to, is_vector(x));
  if (x->getType() == type) return x;
  return to == Type::kF64 ? b_.CreateFPExt(x, type) : b_.CreateFPTrunc(x, type);
}

// F64 to F16 through F32 would round twice; through F32 rounded to odd it does not (24 >= 11 + 2, see fma_to_odd_f64).
Emitter::V Emitter::f64_to_odd_f32(V x) {
  llvm::Type* f32 = with_element(x->getType(), b_.getFloatTy());
  V rounded = b_.CreateFPTrunc(x, f32);
  V error64 =
      b_.CreateFSub(x, b_.CreateFPExt(rounded, x->getType()));  // exact (Sterbenz), or -inf/+inf when `rounded` is infinite
  // Only the sign of the error and whether it is zero matter, so bring it to F32 without underflow.
  V one = float_const(f32, 1);
  V sign = b_.CreateIntrinsic(llvm::Intrinsic::copysign, {f32}, {one, b_.CreateFPTrunc(error64, f32)});
  V inexact = b_.CreateFCmpONE(error64, float_const(x->getType(), 0));
  return round_to_odd(rounded, b_.CreateSelect(inexact, sign, float_const(f32, 0)), with_element(f32, b_.getInt32Ty()));
}

// With F16C: vcvtph2ps. Else: binary16's exponent and significand moved to binary32's place and multiplied by 2^112 are the
// value, subnormals included (the product is exact); infinities and NaN get the largest exponent.
Emitter::V Emitter::half_to_f32(V h) {
  llvm::Type* f32 = with_element(h->getType(), b_.getFloatTy());
  if (features_.half) return b_.CreateFPExt(b_.CreateBitCast(h, with_element(h->getType(), b_.getHalfTy())), f32);
  llvm::Type* i32 = with_element(h->getType(), b_.getInt32Ty());
  V bits = b_.CreateZExt(h, i32);
  V magnitude = b_.CreateAnd(bits, int_const(i32, 0x7fff));
  V scaled = b_.CreateFMul(b_.CreateBitCast(b_.CreateShl(magnitude, 13), f32), float_const(f32, 0x1p112));
  V special = b_.CreateICmpUGT(magnitude, int_const(i32, 0x7bff));
  V result = b_.CreateOr(b_.CreateBitCast(scaled, i32), b_.CreateSelect(special, int_const(i32, 0x7f800000), int_const(i32, 0)));
  V sign = b_.CreateShl(b_.CreateAnd(bits, int_const(i32, 0x8000)), 16);
  return b_.CreateBitCast(b_.CreateOr(result, sign), f32);
}

// With F16C: vcvtps2ph. Else, for |x|:
//   normal results    add half a unit less one bit plus the last kept bit, then shift: round to nearest even on the integer
//   subnormal ones    x + 0.5 in binary32 has a unit of 2^-24, binary16's smallest subnormal: the addition itself rounds
//   overflow          65520 and above: infinity; NaN: 0x7e00
Emitter::V Emitter::f32_to_half(V x) {
  llvm::Type* i16 = with_element(x->getType(), b_.getInt16Ty());
  if (features_.half) return b_.CreateBitCast(b_.CreateFPTrunc(x, with_element(x->getType(), b_.getHalfTy())), i16);
  llvm::Type* i32 = with_element(x->getType(), b_.getInt32Ty());
  V bits = b_.CreateBitCast(x, i32);
  V magnitude = b_.CreateAnd(bits, int_const(i32, 0x7fffffff));
  V odd = b_.CreateAnd(b_.CreateLShr(magnitude, 13), int_const(i32, 1));
  constexpr uint32_t kRebias = 112u << 23;
  V normal = b_.CreateLShr(b_.CreateAdd(b_.CreateAdd(magnitude, odd), int_const(i32, 0xfffu - kRebias)), 13);
  V shifted = b_.CreateFAdd(b_.CreateBitCast(magnitude, x->getType()), float_const(x->getType(), 0.5));
  V subnormal = b_.CreateSub(b_.CreateBitCast(shifted, i32), int_const(i32, 0x3f000000));
  V result = b_.CreateSelect(b_.CreateICmpULT(magnitude, int_const(i32, 0x38800000)), subnormal, normal);
  result = b_.CreateSelect(b_.CreateICmpUGT(magnitude, int_const(i32, 0x477fefff)), int_const(i32, 0x7c00), result);
  result = b_.CreateSelect(b_.CreateICmpUGT(magnitude, int_const(i32, 0x7f800000)), int_const(i32, 0x7e00), result);
  V sign = b_.CreateAnd(b_.CreateLShr(bits, 16), int_const(i32, 0x8000));
  return b_.CreateTrunc(b_.CreateOr(result, sign), i16);
}

}  // namespace pineda::jit
