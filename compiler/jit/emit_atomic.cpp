// Atomics: the active lanes one after the other, in lane order, sequentially consistent; plain loads and stores where no other
// thread looks.
#include "compiler/ir/walk.h"
#include "compiler/jit/emitter.h"

namespace pineda::jit {

using ir::AtomicOp;
using RMW = llvm::AtomicRMWInst;

namespace {

RMW::BinOp rmw_op(AtomicOp op) {
  switch (op) {
    case AtomicOp::kAdd:
      return RMW::Add;
    case AtomicOp::kAnd:
      return RMW::And;
    case AtomicOp::kOr:
      return RMW::Or;
    case AtomicOp::kXor:
      return RMW::Xor;
    case AtomicOp::kSMin:
      return RMW::Min;
    case AtomicOp::kSMax:
      return RMW::Max;
    case AtomicOp::kUMin:
      return RMW::UMin;
    case AtomicOp::kUMax:
      return RMW::UMax;
    default:
      return RMW::Xchg;
  }
}

}  // namespace

// The result per lane is collected on the stack: the loop's lane number is not a constant.
Emitter::V Emitter::emit_atomic(const ir::Inst& inst) {
  const Access a = access_of(inst, element_type(inst.type));
  const LaneSlots slots = spill_addresses(lane_addresses(a));
  V in_bounds = lanes_in_bounds(a);
  V active = in_bounds == nullptr ? exec_bits() : b_.CreateZExt(mask_bits(exec_and(in_bounds)), b_.getInt32Ty());
  llvm::Type* type = lane_type(a.element);
  V values = spill(vector(inst.operand[2]), "values");
  const bool compare = inst.atomic_op() == AtomicOp::kCompareExchange;
  V comparands = compare ? spill(vector(inst.operand[ir::kComparandIndex]), "comparands") : nullptr;
  V results = spill(llvm::Constant::getNullValue(type), "results");
  for_each_lane(active, [&](V lane) {
    V at = b_.CreateIntToPtr(slot_address(slots, lane), b_.getPtrTy());
    V value = slot_load(values, a.element, lane);
    const llvm::MaybeAlign natural(a.size_bytes);
    constexpr auto kOrder = llvm::AtomicOrdering::SequentiallyConsistent;
    V old;
    if (inst.flags & ir::kPrivate) {
      V expected = compare ? slot_load(comparands, a.element, lane) : nullptr;
      old = b_.CreateAlignedLoad(a.element, at, llvm::Align(a.size_bytes));
      b_.CreateAlignedStore(modified(inst.atomic_op(), old, value, expected), at, llvm::Align(a.size_bytes));
    } else if (inst.atomic_op() == AtomicOp::kFAdd) {
      old = atomic_fadd(at, value);
    } else if (compare) {
      V expected = slot_load(comparands, a.element, lane);
      old = b_.CreateExtractValue(b_.CreateAtomicCmpXchg(at, expected, value, natural, kOrder, kOrder), 0);
    } else {
      old = b_.CreateAtomicRMW(rmw_op(inst.atomic_op()), at, value, natural, kOrder);
    }
    slot_store(results, old, lane);
  });
  return b_.CreateLoad(type, results);
}

// What an atomic leaves where `old` was.
Emitter::V Emitter::modified(AtomicOp op, V old, V value, V expected) {
  const auto intrinsic = [&](llvm::Intrinsic::ID id) { return b_.CreateBinaryIntrinsic(id, old, value); };
  switch (op) {
    case AtomicOp::kAdd:
      return b_.CreateAdd(old, value);
    case AtomicOp::kAnd:
      return b_.CreateAnd(old, value);
    case AtomicOp::kOr:
      return b_.CreateOr(old, value);
    case AtomicOp::kXor:
      return b_.CreateXor(old, value);
    case AtomicOp::kSMin:
      return intrinsic(llvm::Intrinsic::smin);
    case AtomicOp::kSMax:
      return intrinsic(llvm::Intrinsic::smax);
    case AtomicOp::kUMin:
      return intrinsic(llvm::Intrinsic::umin);
    case AtomicOp::kUMax:
      return intrinsic(llvm::Intrinsic::umax);
    case AtomicOp::kExchange:
      return value;
    case AtomicOp::kFAdd:
      return add_float_bits(old, value);
    case AtomicOp::kCompareExchange:
      return b_.CreateSelect(b_.CreateICmpEQ(old, expected), value, old);
  }
  return value;
}

// The bits of the sum of two numbers given by their bits; a NaN in FCanon's pattern.
Emitter::V Emitter::add_float_bits(V a, V b) {
  llvm::Type* bits = a->getType();
  const bool is_f32 = bits->isIntegerTy(32);
  llvm::Type* number = is_f32 ? b_.getFloatTy() : b_.getDoubleTy();
  V nan = llvm::ConstantInt::get(bits, is_f32 ? 0x7fc00000u : 0x7ff8000000000000u);
  V sum = b_.CreateFAdd(b_.CreateBitCast(a, number), b_.CreateBitCast(b, number));
  return b_.CreateSelect(b_.CreateFCmpUNO(sum, sum), nan, b_.CreateBitCast(sum, bits));
}

// Not LLVM's atomicrmw fadd: it would leave the NaN of the ISA in memory.
Emitter::V Emitter::atomic_fadd(V at, V value) {
  llvm::Type* bits = value->getType();
  const llvm::Align natural(bits->getIntegerBitWidth() / 8);
  constexpr auto kOrder = llvm::AtomicOrdering::SequentiallyConsistent;
  llvm::LoadInst* first = b_.CreateAlignedLoad(bits, at, natural);
  first->setAtomic(kOrder);
  llvm::BasicBlock *before = b_.GetInsertBlock(), *again = block("fadd"), *done = block("fadd.done");
  b_.CreateBr(again);
  start(again);
  llvm::PHINode* expected = b_.CreatePHI(bits, 2);
  expected->addIncoming(first, before);
  V exchange = b_.CreateAtomicCmpXchg(at, expected, add_float_bits(expected, value), natural, kOrder, kOrder);
  V found = b_.CreateExtractValue(exchange, 0);
  expected->addIncoming(found, again);
  b_.CreateCondBr(b_.CreateExtractValue(exchange, 1), done, again);
  start(done);
  return found;
}

}  // namespace pineda::jit
