// Masks and the operations that cross lanes.
#include "compiler/jit/emitter.h"

namespace pineda::jit {

using ir::Type;

Emitter::V Emitter::to_i1(V b1) {
  if (!is_vector(b1) || features_.mask_registers) return b1;
  return b_.CreateICmpSLT(b1, llvm::Constant::getNullValue(b1->getType()));  // the sign bit is what vblendvps and vmovmskps read
}

Emitter::V Emitter::from_i1(V bits) {
  if (!is_vector(bits) || features_.mask_registers) return bits;
  return b_.CreateSExt(bits, lane_type(b_.getInt32Ty()));
}

Emitter::V Emitter::mask_not(V mask) { return b_.CreateXor(mask, llvm::Constant::getAllOnesValue(mask->getType())); }

Emitter::V Emitter::full_mask() { return llvm::Constant::getAllOnesValue(value_type(Type::kB1, true)); }

Emitter::V Emitter::exec_and(V mask) { return exec_.full() ? mask : b_.CreateAnd(exec_.lanes, mask); }

// On wide masks: fold the halves by OR down to one register, then look at its sign bits (vmovmskps).
Emitter::V Emitter::any(V mask) {
  if (features_.mask_registers) return b_.CreateICmpNE(mask_bits(mask), b_.getInt16(0));
  uint32_t lanes = kLanes;
  while (lanes * 32 > features_.vector_bits) {
    lanes /= 2;
    std::vector<int> low(lanes), high(lanes);
    for (uint32_t l = 0; l < lanes; ++l) {
      low[l] = static_cast<int>(l);
      high[l] = static_cast<int>(l + lanes);
    }
    mask = b_.CreateOr(b_.CreateShuffleVector(mask, low), b_.CreateShuffleVector(mask, high));
  }
  V bits = b_.CreateBitCast(b_.CreateICmpSLT(mask, llvm::Constant::getNullValue(mask->getType())), b_.getIntNTy(lanes));
  return b_.CreateICmpNE(bits, int_const(bits->getType(), 0));
}

Emitter::V Emitter::mask_bits(V mask) { return b_.CreateBitCast(to_i1(mask), b_.getInt16Ty()); }

Emitter::V Emitter::exec_bits() {
  if (exec_.full()) return b_.getInt32((1u << kLanes) - 1);
  return b_.CreateZExt(mask_bits(exec_.lanes), b_.getInt32Ty());
}

namespace {

llvm::Constant* lane_bits(llvm::LLVMContext& context) {  // 1 << lane
  std::vector<uint32_t> single(kLanes);
  for (uint32_t l = 0; l < kLanes; ++l) single[l] = 1u << l;
  return llvm::ConstantDataVector::get(context, single);
}

}  // namespace

// With mask registers each lane tests its bit (vpbroadcastd, vptestmd). A bitcast of i16 to <16 x i1> would be one kmovw, but
// LLVM 19's DAG combiner never ends on some logic of several such masks: it moves `or` in front of the bitcasts, and then an x86
// combine moves it behind them again.
Emitter::V Emitter::mask_from_bits(V bits16) {
  if (!features_.mask_registers) return from_i1(b_.CreateBitCast(bits16, lane_type(b_.getInt1Ty())));
  V bits = b_.CreateVectorSplat(kLanes, b_.CreateZExt(bits16, b_.getInt32Ty()));
  V own = b_.CreateAnd(bits, lane_bits(context_));
  return b_.CreateICmpNE(own, llvm::Constant::getNullValue(own->getType()));
}

// `cond` is an i1 or a mask; a and b have one shape.
Emitter::V Emitter::select(V cond, V a, V b) {
  if (is_vector(cond) || !is_vector(a)) return b_.CreateSelect(to_i1(cond), a, b);
  return b_.CreateSelect(cond, a, b);  // a uniform choice between two vectors
}

Emitter::V Emitter::emit_unpack_mask(const ir::Inst& inst) {
  if (!is_lane(inst.operand[0])) return mask_from_bits(b_.CreateTrunc(scalar(inst.operand[0]), b_.getInt16Ty()));
  V bits = vector(inst.operand[0]);
  V own = b_.CreateAnd(bits, lane_bits(context_));
  return from_i1(b_.CreateICmpNE(own, llvm::Constant::getNullValue(own->getType())));
}

Emitter::V Emitter::emit_ballot(const ir::Inst& inst) {
  if (!is_lane(inst.operand[0])) return b_.CreateSelect(scalar(inst.operand[0]), exec_bits(), b_.getInt32(0));
  return b_.CreateZExt(mask_bits(exec_and(vector(inst.operand[0]))), b_.getInt32Ty());
}

Emitter::V Emitter::emit_quad_swizzle(const ir::Inst& inst) {
  if (!is_lane(inst.operand[0])) return scalar(inst.operand[0]);
  std::vector<int> from(kLanes);
  for (uint32_t l = 0; l < kLanes; ++l) from[l] = static_cast<int>((l & ~3u) + (inst.imm >> 2 * (l & 3) & 3));
  return b_.CreateShuffleVector(vector(inst.operand[0]), from);
}

}  // namespace pineda::jit
