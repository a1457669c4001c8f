// Shuffle and Reduce (ir.h, "Subgroups").
#include <algorithm>

#include "compiler/ir/semantics.h"
#include "compiler/jit/emitter.h"

namespace pineda::jit {

using ir::ReduceOp;
using ir::Type;

// A constant for the lanes that are not active.
Emitter::V Emitter::only_active(V x, Type type, uint64_t identity_imm) {
  if (exec_.full()) return x;
  V other = emit_constant({.op = ir::Op::kConst, .type = type, .imm = identity_imm});
  return b_.CreateSelect(to_i1(exec_.lanes), x, broadcast_value(other));
}

Emitter::V Emitter::permute(V x, const std::vector<int>& from) { return b_.CreateShuffleVector(x, from); }

// `index`: <16 x i32>, below 16.
Emitter::V Emitter::permute(V x, V index) {
  if (auto* constants = llvm::dyn_cast<llvm::Constant>(index)) {
    std::vector<int> from(kLanes);
    for (uint32_t l = 0; l < kLanes; ++l) {
      from[l] = static_cast<int>(llvm::cast<llvm::ConstantInt>(constants->getAggregateElement(l))->getZExtValue());
    }
    return permute(x, from);
  }
  llvm::Type *type = x->getType(), *words = lane_type(b_.getInt32Ty());
  const uint32_t bits = type->getScalarSizeInBits();
  if (bits == 32) return b_.CreateBitCast(permute_words(b_.CreateBitCast(x, words), index), type);
  if (bits < 32) {
    llvm::Type* narrow = lane_type(b_.getIntNTy(bits));
    V word = permute_words(b_.CreateZExt(b_.CreateBitCast(x, narrow), words), index);
    return b_.CreateBitCast(b_.CreateTrunc(word, narrow), type);
  }
  llvm::Type* wide = lane_type(b_.getInt64Ty());
  V whole = b_.CreateBitCast(x, wide);
  V low = permute_words(b_.CreateTrunc(whole, words), index);
  V high = permute_words(b_.CreateTrunc(b_.CreateLShr(whole, int_const(wide, 32)), words), index);
  V joined = b_.CreateOr(b_.CreateZExt(low, wide), b_.CreateShl(b_.CreateZExt(high, wide), int_const(wide, 32)));
  return b_.CreateBitCast(joined, type);
}

// vpermd: 16 lanes on AVX-512; on AVX2 from each half of x, then a choice by bit 3 of the index; else lane by lane.
Emitter::V Emitter::permute_words(V x, V index) {
  if (features_.scatters) return b_.CreateIntrinsic(llvm::Intrinsic::x86_avx512_permvar_si_512, {}, {x, index});
  if (features_.gathers) {
    const std::vector<V> sources = split(x, 8), indices = split(index, 8);
    std::vector<V> out;
    for (V i : indices) {
      V low = b_.CreateIntrinsic(llvm::Intrinsic::x86_avx2_permd, {}, {sources[0], i});
      V high = b_.CreateIntrinsic(llvm::Intrinsic::x86_avx2_permd, {}, {sources[1], i});
      out.push_back(b_.CreateSelect(b_.CreateICmpUGT(i, int_const(i->getType(), 7)), high, low));
    }
    return join(out);
  }
  V slot = spill(x, "shuffled");
  V out = llvm::Constant::getNullValue(x->getType());
  for (uint64_t l = 0; l < kLanes; ++l) {
    V from = b_.CreateZExt(b_.CreateExtractElement(index, l), b_.getInt64Ty());
    out = b_.CreateInsertElement(out, slot_load(slot, b_.getInt32Ty(), from), l);
  }
  return out;
}

Emitter::V Emitter::emit_shuffle(const ir::Inst& inst) {
  V index = get(inst.operand[1], is_lane(inst.operand[1]));
  index = b_.CreateAnd(index, int_const(index->getType(), kLanes - 1));
  V x = only_active(vector(inst.operand[0]), inst.type, 0);
  if (!is_vector(index)) {
    V element = b_.CreateExtractElement(x, index);
    return inst.type == Type::kB1 && !features_.mask_registers ? b_.CreateICmpSLT(element, b_.getInt32(0)) : element;
  }
  if (inst.type != Type::kB1 || !features_.mask_registers) return permute(x, index);
  V words = permute(b_.CreateSExt(x, lane_type(b_.getInt32Ty())), index);
  return b_.CreateICmpSLT(words, llvm::Constant::getNullValue(words->getType()));
}

// Vectors of one shape; booleans are masks.
Emitter::V Emitter::combine(ReduceOp op, Type type, V a, V b) {
  switch (op) {
    case ReduceOp::kIAdd:
      return b_.CreateAdd(a, b);
    case ReduceOp::kIMul:
      return b_.CreateMul(a, b);
    case ReduceOp::kSMin:
      return b_.CreateBinaryIntrinsic(llvm::Intrinsic::smin, a, b);
    case ReduceOp::kSMax:
      return b_.CreateBinaryIntrinsic(llvm::Intrinsic::smax, a, b);
    case ReduceOp::kUMin:
      return b_.CreateBinaryIntrinsic(llvm::Intrinsic::umin, a, b);
    case ReduceOp::kUMax:
      return b_.CreateBinaryIntrinsic(llvm::Intrinsic::umax, a, b);
    case ReduceOp::kAnd:
      return b_.CreateAnd(a, b);
    case ReduceOp::kOr:
      return b_.CreateOr(a, b);
    case ReduceOp::kXor:
      return b_.CreateXor(a, b);
    case ReduceOp::kFAdd:
      return narrow(b_.CreateFAdd(widen(a, type), widen(b, type)), type);
    case ReduceOp::kFMul:
      return narrow(b_.CreateFMul(widen(a, type), widen(b, type)), type);
    case ReduceOp::kFMin:
      return b_.CreateSelect(b_.CreateFCmpOLT(widen(b, type), widen(a, type)), b, a);
    case ReduceOp::kFMax:
      return b_.CreateSelect(b_.CreateFCmpOLT(widen(a, type), widen(b, type)), b, a);
    case ReduceOp::kCount:
      break;
  }
  return a;
}

// A full reduction works on the lower half of what it had each time, down to one SSE register.
Emitter::V Emitter::emit_reduce(const ir::Inst& inst) {
  const ReduceOp op = inst.reduce_op();
  const auto cluster = static_cast<int>(inst.cluster_lanes());
  const int lanes = kLanes;
  V x = only_active(vector(inst.operand[0]), inst.type, ir::reduce_identity(op, inst.type, false));
  if (inst.scan() == ir::Scan::kReduce && cluster == lanes) {
    constexpr int kSmallest = 4;
    int width = lanes;
    for (int step = lanes / 2; step > 0; step /= 2) {
      std::vector<int> low, high;
      const int kept = inst.type == Type::kF16 ? lanes : std::max(step, kSmallest);  // F16 is converted 16 at a time
      for (int l = 0; l < kept; ++l) {
        low.push_back(l);
        high.push_back((l + step) % width);
      }
      x = combine(op, inst.type, permute(x, low), permute(x, high));
      width = kept;
    }
    V element = b_.CreateExtractElement(x, uint64_t{0});
    if (inst.type == Type::kB1 && !features_.mask_registers) element = b_.CreateICmpSLT(element, b_.getInt32(0));
    return shape(element, inst.rate == ir::Rate::kLane);
  }
  const auto pattern = [&](const std::function<int(int)>& source) {
    std::vector<int> from;
    for (int l = 0; l < lanes; ++l) from.push_back(source(l));
    return from;
  };
  if (inst.scan() == ir::Scan::kReduce) {
    for (int step = cluster / 2; step > 0; step /= 2) {
      x = combine(op, inst.type, x,
                  permute(x, pattern([&](int l) { return (l & ~(cluster - 1)) | ((l + step) & (cluster - 1)); })));
    }
    return permute(x, pattern([&](int l) { return l & ~(cluster - 1); }));
  }
  // A choice between two vectors by lane is one shuffle of both: indices from `lanes` on are the second's.
  for (int step = 1; step < cluster; step *= 2) {
    V combined = combine(op, inst.type, permute(x, pattern([&](int l) { return l >= step ? l - step : l; })), x);
    x = b_.CreateShuffleVector(combined, x, pattern([&](int l) { return (l & (cluster - 1)) >= step ? l : lanes + l; }));
  }
  if (inst.scan() == ir::Scan::kInclusive) return x;
  V first =
      broadcast_value(emit_constant({.op = ir::Op::kConst, .type = inst.type, .imm = ir::reduce_identity(op, inst.type, true)}));
  return b_.CreateShuffleVector(x, first, pattern([&](int l) { return (l & (cluster - 1)) == 0 ? lanes + l : l - 1; }));
}

}  // namespace pineda::jit
