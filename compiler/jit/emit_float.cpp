// Floating point: IEEE operations, one LLVM instruction each, no flag that would let LLVM change a value. F16 is computed in F32
// and rounded again, which is correct rounding for + - * / sqrt because 24 >= 2 * 11 + 2 (Figueroa, "When is double rounding
// innocuous?", SIGNUM 1995).
#include "compiler/jit/emitter.h"

namespace pineda::jit {

using ir::Op;
using ir::Type;

Emitter::V Emitter::emit_float(const ir::Inst& inst) {
  switch (inst.op) {
    case Op::kFMa:
      return emit_fma(inst);
    case Op::kFNeg:
    case Op::kFAbs:
      return emit_float_sign(inst);
    case Op::kFMin:
    case Op::kFMax:
      return emit_min_max(inst);
    case Op::kFCanon:
      return emit_canon(inst);
    default:
      break;
  }
  if (inst.op >= Op::kFEq) return emit_float_compare(inst);
  V a = widen(arg(inst, 0), inst.type);
  V b = ir::op_info(inst.op).operands > 1 ? widen(arg(inst, 1), inst.type) : nullptr;
  switch (inst.op) {
    case Op::kFAdd:
      return narrow(b_.CreateFAdd(a, b), inst.type);
    case Op::kFSub:
      return narrow(b_.CreateFSub(a, b), inst.type);
    case Op::kFMul:
      return narrow(b_.CreateFMul(a, b), inst.type);
    case Op::kFDiv:
      return narrow(b_.CreateFDiv(a, b), inst.type);
    case Op::kFSqrt:
      return narrow(b_.CreateUnaryIntrinsic(llvm::Intrinsic::sqrt, a), inst.type);
    case Op::kFFloor:
      return narrow(b_.CreateUnaryIntrinsic(llvm::Intrinsic::floor, a), inst.type);
    case Op::kFCeil:
      return narrow(b_.CreateUnaryIntrinsic(llvm::Intrinsic::ceil, a), inst.type);
    case Op::kFTrunc:
      return narrow(b_.CreateUnaryIntrinsic(llvm::Intrinsic::trunc, a), inst.type);
    case Op::kFRoundEven:
      return narrow(b_.CreateUnaryIntrinsic(llvm::Intrinsic::roundeven, a), inst.type);
    default:
      return fail("unknown float operation", a->getType());
  }
}

Emitter::V Emitter::widen(V x, Type type) { return type == Type::kF16 ? half_to_f32(x) : x; }
Emitter::V Emitter::narrow(V x, Type type) { return type == Type::kF16 ? f32_to_half(x) : x; }

Emitter::V Emitter::emit_float_compare(const ir::Inst& inst) {
  const Type type = kernel_.at(inst.operand[0]).type;
  V a = widen(arg(inst, 0), type), b = widen(arg(inst, 1), type);
  switch (inst.op) {
    case Op::kFEq:
      return from_i1(b_.CreateFCmpOEQ(a, b));
    case Op::kFNe:
      return from_i1(b_.CreateFCmpUNE(a, b));
    case Op::kFLt:
      return from_i1(b_.CreateFCmpOLT(a, b));
    default:
      return from_i1(b_.CreateFCmpOLE(a, b));
  }
}

Emitter::V Emitter::emit_float_sign(const ir::Inst& inst) {
  V a = arg(inst, 0);
  const bool negate = inst.op == Op::kFNeg;
  if (inst.type == Type::kF16) {
    return negate ? b_.CreateXor(a, int_const(a->getType(), 0x8000)) : b_.CreateAnd(a, int_const(a->getType(), 0x7fff));
  }
  return negate ? b_.CreateFNeg(a) : b_.CreateUnaryIntrinsic(llvm::Intrinsic::fabs, a);
}

// Exactly minps(b, a) and maxps(b, a) with swapped roles: see ops.inc for NaN and zeros.
Emitter::V Emitter::emit_min_max(const ir::Inst& inst) {
  V a = arg(inst, 0), b = arg(inst, 1);
  V x = widen(a, inst.type), y = widen(b, inst.type);
  V take_b = inst.op == Op::kFMin ? b_.CreateFCmpOLT(y, x) : b_.CreateFCmpOLT(x, y);
  return b_.CreateSelect(take_b, b, a);
}

// On the bits, as integers: for LLVM all NaNs are alike, so a select between floats might be folded away.
Emitter::V Emitter::emit_canon(const ir::Inst& inst) {
  V a = arg(inst, 0);
  if (inst.type == Type::kF16) {
    V magnitude = b_.CreateAnd(a, int_const(a->getType(), 0x7fff));
    return b_.CreateSelect(b_.CreateICmpUGT(magnitude, int_const(a->getType(), 0x7c00)), int_const(a->getType(), 0x7e00), a);
  }
  const bool is_f32 = inst.type == Type::kF32;
  llvm::Type* bits = with_element(a->getType(), is_f32 ? b_.getInt32Ty() : b_.getInt64Ty());
  V nan = int_const(bits, is_f32 ? 0x7fc00000u : 0x7ff8000000000000u);
  V canonical = b_.CreateSelect(b_.CreateFCmpUNO(a, a), nan, b_.CreateBitCast(a, bits));
  return b_.CreateBitCast(canonical, a->getType());
}

// ---- fused multiply-add ---------------------------------------------------------------------------------------------------

Emitter::V Emitter::emit_fma(const ir::Inst& inst) {
  V a = arg(inst, 0), b = arg(inst, 1), c = arg(inst, 2);
  if (inst.type == Type::kF64) {
    if (!features_.fma) return fma_f64_by_call(a, b, c);
    return b_.CreateIntrinsic(llvm::Intrinsic::fma, {a->getType()}, {a, b, c});
  }
  if (inst.type == Type::kF32 && features_.fma) return b_.CreateIntrinsic(llvm::Intrinsic::fma, {a->getType()}, {a, b, c});
  if (inst.type == Type::kF32) return fma_f32_by_call(a, b, c);
  llvm::Type* f64 = with_element(a->getType(), b_.getDoubleTy());
  const auto to_f64 = [&](V x) { return b_.CreateFPExt(half_to_f32(x), f64); };
  return convert_float(fma_to_odd_f64(to_f64(a), to_f64(b), to_f64(c)), Type::kF64, inst.type);
}

// The emulation takes about 50 instructions for 4 lanes. It is emitted once per kernel, as a function that preserves all
// registers but its result's: in line, a shader of 30 FMAs took 150 ms to compile.
Emitter::V Emitter::fma_f32_by_call(V a, V b, V c) {
  constexpr uint32_t kPart = 4;
  if (fma_function_ == nullptr) fma_function_ = create_fma_function(kPart);
  const auto call = [&](V x, V y, V z) {
    llvm::CallInst* result = b_.CreateCall(fma_function_, {x, y, z});
    result->setCallingConv(fma_function_->getCallingConv());
    return result;
  };
  if (!is_vector(a)) {
    const auto first_lane = [&](V x) {
      return b_.CreateInsertElement(llvm::Constant::getNullValue(llvm::FixedVectorType::get(x->getType(), kPart)), x,
                                    uint64_t{0});
    };
    return b_.CreateExtractElement(call(first_lane(a), first_lane(b), first_lane(c)), uint64_t{0});
  }
  std::vector<V> parts;
  const std::vector<V> x = split(a, kPart), y = split(b, kPart), z = split(c, kPart);
  for (size_t i = 0; i < x.size(); ++i) parts.push_back(call(x[i], y[i], z[i]));
  return join(std::move(parts));
}

llvm::Function* Emitter::create_fma_function(uint32_t lanes) {
  llvm::Type* f32 = llvm::FixedVectorType::get(b_.getFloatTy(), lanes);
  auto* type = llvm::FunctionType::get(f32, {f32, f32, f32}, false);
  llvm::Function* function = llvm::Function::Create(type, llvm::Function::InternalLinkage, "fma", module_);
  function->setCallingConv(llvm::CallingConv::PreserveAll);
  function->setDoesNotThrow();
  function->addFnAttr(llvm::Attribute::NoInline);
  llvm::IRBuilderBase::InsertPointGuard guard(b_);
  b_.SetInsertPoint(llvm::BasicBlock::Create(context_, "", function));
  const auto to_f64 = [&](V x) { return b_.CreateFPExt(x, with_element(f32, b_.getDoubleTy())); };
  V sum = fma_to_odd_f64(to_f64(function->getArg(0)), to_f64(function->getArg(1)), to_f64(function->getArg(2)));
  b_.CreateRet(b_.CreateFPTrunc(sum, f32));
  return function;
}

// Without FMA3 there is no short exact sequence for binary64 (Boldo and Melquiond's needs an exponent range that is wider than
// the format), so the C library's correctly rounded fma() is called: the one external symbol that kernels may name (see
// link.cpp).
Emitter::V Emitter::fma_f64_by_call(V a, V b, V c) {
  llvm::Type* f64 = b_.getDoubleTy();
  llvm::FunctionCallee callee = module_.getOrInsertFunction(kFmaSymbol, f64, f64, f64, f64);
  llvm::cast<llvm::Function>(callee.getCallee())->setDoesNotThrow();
  if (!is_vector(a)) return b_.CreateCall(callee, {a, b, c});
  V result = llvm::Constant::getNullValue(a->getType());
  for (uint32_t l = 0; l < kLanes; ++l) {
    const auto lane = [&](V x) { return b_.CreateExtractElement(x, l); };
    result = b_.CreateInsertElement(result, b_.CreateCall(callee, {lane(a), lane(b), lane(c)}), l);
  }
  return result;
}

// a * b + c rounded once, for operands that are binary32 (or binary16) values held in binary64.
//
// The product of two 24-bit significands has 48 bits and an exponent in [-298, 256]: exact in binary64. The sum s = RN(p + c) is
// not, so rounding s again to binary32 could go wrong. TwoSum (Knuth; Moller) gives its exact error e, as no operation overflows.
// If e != 0 and the significand of s is even, s is moved one unit toward e: that is the sum rounded to odd, and RN_24(RO_53(x)) =
// RN_24(x) because 53 >= 24 + 2 (Boldo and Melquiond, "Emulation of a FMA and correctly rounded sums: proved algorithms using
// rounding to odd", IEEE Trans. Computers 57(4), 2008, theorem 3), which holds for subnormal binary32 results too: they only keep
// fewer bits. Infinities and NaN: then e is NaN, `e != 0` ordered is false, and s is already the IEEE answer.
Emitter::V Emitter::fma_to_odd_f64(V a, V b, V c) {
  V p = b_.CreateFMul(a, b);
  V s = b_.CreateFAdd(p, c);
  V c_part = b_.CreateFSub(s, p);
  V p_part = b_.CreateFSub(s, c_part);
  V error = b_.CreateFAdd(b_.CreateFSub(c, c_part), b_.CreateFSub(p, p_part));
  return round_to_odd(s, error, with_element(s->getType(), b_.getInt64Ty()));
}

// `rounded` = RN(x), `error` has the sign of x - rounded, or is zero or NaN when nothing is to be done. Moves an even significand
// to the odd neighbour on the side of x. As sign-magnitude integers neighbours differ by 1, across binades too; equal signs mean
// away from zero.
Emitter::V Emitter::round_to_odd(V rounded, V error, llvm::Type* bits_type) {
  V bits = b_.CreateBitCast(rounded, bits_type);
  V error_bits = b_.CreateBitCast(error, bits_type);
  const unsigned top = bits_type->getScalarSizeInBits() - 1;
  V step = b_.CreateOr(b_.CreateAShr(b_.CreateXor(bits, error_bits), top),
                       int_const(bits_type, 1));  // +1 away from zero, -1 toward it
  V even = b_.CreateICmpEQ(b_.CreateAnd(bits, int_const(bits_type, 1)), int_const(bits_type, 0));
  V inexact = b_.CreateFCmpONE(error, float_const(error->getType(), 0));
  V moved = b_.CreateAdd(bits, b_.CreateSelect(b_.CreateAnd(even, inexact), step, int_const(bits_type, 0)));
  return b_.CreateBitCast(moved, rounded->getType());
}

}  // namespace pineda::jit
