// Integer operations. Semantics: ops.inc.
#include <array>

#include "compiler/jit/emitter.h"

namespace pineda::jit {

using ir::Op;
using ir::Type;

Emitter::V Emitter::emit_int(const ir::Inst& inst) {
  switch (inst.op) {
    case Op::kUMulHi:
      return emit_mul_high(arg(inst, 0), arg(inst, 1), false);
    case Op::kSMulHi:
      return emit_mul_high(arg(inst, 0), arg(inst, 1), true);
    case Op::kMAdd16:
      return emit_madd16(arg(inst, 0), arg(inst, 1));
    case Op::kUDiv:
    case Op::kSDiv:
    case Op::kURem:
    case Op::kSRem:
      return emit_divide(inst);
    case Op::kShl:
    case Op::kLShr:
    case Op::kAShr:
      return emit_shift(inst);
    default:
      break;
  }
  if (inst.op >= Op::kIEq) return emit_int_compare(inst);
  V a = arg(inst, 0);
  if (inst.op >= Op::kClz) return emit_bit_count(inst, a);
  if (inst.op == Op::kNot) return b_.CreateXor(a, llvm::Constant::getAllOnesValue(a->getType()));
  V b = arg(inst, 1);
  switch (inst.op) {
    case Op::kIAdd:
      return b_.CreateAdd(a, b);
    case Op::kISub:
      return b_.CreateSub(a, b);
    case Op::kIMul:
      return b_.CreateMul(a, b);
    case Op::kAnd:
      return b_.CreateAnd(a, b);
    case Op::kOr:
      return b_.CreateOr(a, b);
    case Op::kXor:
      return b_.CreateXor(a, b);
    case Op::kSMin:
      return b_.CreateBinaryIntrinsic(llvm::Intrinsic::smin, a, b);
    case Op::kSMax:
      return b_.CreateBinaryIntrinsic(llvm::Intrinsic::smax, a, b);
    case Op::kUMin:
      return b_.CreateBinaryIntrinsic(llvm::Intrinsic::umin, a, b);
    default:
      return b_.CreateBinaryIntrinsic(llvm::Intrinsic::umax, a, b);
  }
}

Emitter::V Emitter::emit_bit_count(const ir::Inst& inst, V a) {
  constexpr bool kZeroIsDefined = false;  // the intrinsics' flag "is_zero_poison"
  switch (inst.op) {
    case Op::kClz:
      return b_.CreateBinaryIntrinsic(llvm::Intrinsic::ctlz, a, b_.getInt1(kZeroIsDefined));
    case Op::kCtz:
      return b_.CreateBinaryIntrinsic(llvm::Intrinsic::cttz, a, b_.getInt1(kZeroIsDefined));
    case Op::kPopCount:
      return b_.CreateUnaryIntrinsic(llvm::Intrinsic::ctpop, a);
    default:
      return b_.CreateUnaryIntrinsic(llvm::Intrinsic::bitreverse, a);
  }
}

Emitter::V Emitter::emit_mul_high(V a, V b, bool is_signed) {
  const unsigned bits = a->getType()->getScalarSizeInBits();
  llvm::Type* wide = with_element(a->getType(), b_.getIntNTy(2 * bits));
  V product = b_.CreateMul(b_.CreateIntCast(a, wide, is_signed), b_.CreateIntCast(b, wide, is_signed));
  return b_.CreateTrunc(b_.CreateLShr(product, bits), a->getType());
}

// pmaddwd
Emitter::V Emitter::emit_madd16(V a, V b) {
  if (!is_vector(a)) {
    const auto product = [&](uint64_t shift) {
      const auto half = [&](V v) { return b_.CreateAShr(b_.CreateShl(v, 16 - shift), 16); };
      return b_.CreateMul(half(a), half(b));
    };
    return b_.CreateAdd(product(0), product(16));
  }
  const uint32_t lanes = features_.vector_bits / 32;
  const llvm::Intrinsic::ID id = lanes == 16  ? llvm::Intrinsic::x86_avx512_pmaddw_d_512
                                 : lanes == 8 ? llvm::Intrinsic::x86_avx2_pmadd_wd
                                              : llvm::Intrinsic::x86_sse2_pmadd_wd;
  llvm::Type* halves = llvm::FixedVectorType::get(b_.getInt16Ty(), 2 * lanes);
  std::vector<V> x = lanes == kLanes ? std::vector<V>{a} : split(a, lanes);
  const std::vector<V> y = lanes == kLanes ? std::vector<V>{b} : split(b, lanes);
  for (size_t i = 0; i < x.size(); ++i) {
    x[i] = b_.CreateIntrinsic(id, {}, {b_.CreateBitCast(x[i], halves), b_.CreateBitCast(y[i], halves)});
  }
  return join(std::move(x));
}

// a / 0 = all ones, a % 0 = a, INT_MIN / -1 = INT_MIN, INT_MIN % -1 = 0. With the divisor replaced by 1 in those cases, the
// quotient is a: right for the last two as it is.
Emitter::V Emitter::emit_divide(const ir::Inst& inst) {
  V a = arg(inst, 0), b = arg(inst, 1);
  llvm::Type* type = a->getType();
  const bool is_signed = inst.op == Op::kSDiv || inst.op == Op::kSRem;
  const bool wants_quotient = inst.op == Op::kUDiv || inst.op == Op::kSDiv;
  V is_zero = b_.CreateICmpEQ(b, int_const(type, 0));
  V replace = is_zero;
  if (is_signed) {
    const unsigned bits = type->getScalarSizeInBits();
    V least = int_const(type, 1ull << (bits - 1));
    V overflow = b_.CreateAnd(b_.CreateICmpEQ(a, least), b_.CreateICmpEQ(b, llvm::Constant::getAllOnesValue(type)));
    replace = b_.CreateOr(is_zero, overflow);
  }
  V divisor = b_.CreateSelect(replace, int_const(type, 1), b);
  V q = quotient(a, divisor, is_signed, kernel_.at(inst.operand[1]).op == Op::kConst);
  if (wants_quotient) return b_.CreateSelect(is_zero, llvm::Constant::getAllOnesValue(type), q);
  return b_.CreateSelect(is_zero, a, b_.CreateSub(a, b_.CreateMul(q, divisor)));
}

// The divisor is not 0, and not -1 where a is INT_MIN.
Emitter::V Emitter::quotient(V a, V b, bool is_signed, bool constant_divisor) {
  const unsigned bits = a->getType()->getScalarSizeInBits();
  if (!is_vector(a) || constant_divisor || bits == 64) return is_signed ? b_.CreateSDiv(a, b) : b_.CreateUDiv(a, b);
  llvm::Type* i32 = with_element(a->getType(), b_.getInt32Ty());
  V q = quotient_by_f64(b_.CreateIntCast(a, i32, is_signed), b_.CreateIntCast(b, i32, is_signed), is_signed);
  return b_.CreateTrunc(q, a->getType());
}

// There is no vector integer division. In binary64 it is exact: the operands are, and if a / b is not an integer it lies at least
// 1 / |b| below the next one, while the rounding error of the quotient is at most 2^-53 * |a / b| < 2^-21 / |b|, so rounding
// never reaches that integer. Adding 1.5 * 2^52 leaves the integer, two's complement, in the low bits of the significand; unlike
// fptosi this has no undefined case.
Emitter::V Emitter::quotient_by_f64(V a, V b, bool is_signed) {
  llvm::Type* f64 = with_element(a->getType(), b_.getDoubleTy());
  V x = is_signed ? b_.CreateSIToFP(a, f64) : b_.CreateUIToFP(a, f64);
  V y = is_signed ? b_.CreateSIToFP(b, f64) : b_.CreateUIToFP(b, f64);
  V q = b_.CreateUnaryIntrinsic(llvm::Intrinsic::trunc, b_.CreateFDiv(x, y));
  V biased = b_.CreateFAdd(q, float_const(f64, 0x1.8p52));
  return b_.CreateTrunc(b_.CreateBitCast(biased, with_element(a->getType(), b_.getInt64Ty())), a->getType());
}

Emitter::V Emitter::emit_shift(const ir::Inst& inst) {
  V a = arg(inst, 0);
  V count = b_.CreateAnd(arg(inst, 1), int_const(a->getType(), a->getType()->getScalarSizeInBits() - 1));
  switch (inst.op) {
    case Op::kShl:
      return b_.CreateShl(a, count);
    case Op::kLShr:
      return b_.CreateLShr(a, count);
    default:
      return b_.CreateAShr(a, count);
  }
}

Emitter::V Emitter::emit_int_compare(const ir::Inst& inst) {
  V a = arg(inst, 0), b = arg(inst, 1);
  switch (inst.op) {
    case Op::kIEq:
      return from_i1(b_.CreateICmpEQ(a, b));
    case Op::kINe:
      return from_i1(b_.CreateICmpNE(a, b));
    case Op::kULt:
      return from_i1(b_.CreateICmpULT(a, b));
    case Op::kULe:
      return from_i1(b_.CreateICmpULE(a, b));
    case Op::kSLt:
      return from_i1(b_.CreateICmpSLT(a, b));
    default:
      return from_i1(b_.CreateICmpSLE(a, b));
  }
}

// ZExt, SExt, Trunc
Emitter::V Emitter::emit_int_convert(const ir::Inst& inst) {
  V a = arg(inst, 0);
  if (kernel_.at(inst.operand[0]).type == Type::kB1) a = to_i1(a);
  llvm::Type* to = value_type(inst.type, is_vector(a));
  switch (inst.op) {
    case Op::kZExt:
      return b_.CreateZExt(a, to);
    case Op::kSExt:
      return b_.CreateSExt(a, to);
    default:
      if (is_vector(a) && inst.type == Type::kI32) return low_words(inst, a);
      return b_.CreateTrunc(a, to);
  }
}

// I64 to I32 in lanes: every other word of the register. Said as a shuffle, LLVM makes one instruction of it where a truncation
// is three, and one for the upper words too (a pair of texels comes as one I64).
Emitter::V Emitter::low_words(const ir::Inst& inst, V a) {
  int first = 0;
  const ir::Inst& def = kernel_.at(inst.operand[0]);
  if (def.op == Op::kLShr && is_lane(def.operand[0]) && kernel_.at(def.operand[1]).op == Op::kConst &&
      kernel_.at(def.operand[1]).imm == 32) {
    a = vector(def.operand[0]);
    first = 1;
  }
  V words = b_.CreateBitCast(a, llvm::FixedVectorType::get(b_.getInt32Ty(), 2 * kLanes));
  std::array<int, kLanes> picked;
  for (int l = 0; l < static_cast<int>(kLanes); ++l) picked[l] = 2 * l + first;
  return b_.CreateShuffleVector(words, picked);
}

}  // namespace pineda::jit
