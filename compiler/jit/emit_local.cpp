// Locals: per-lane arrays on the stack (in a kernel with barriers: in the wave's frame), [count x <16 x T>], so that an element
// with a uniform index is one vector. Those of one element, or indexed by constants only, become registers by LLVM's SROA.
#include "compiler/ir/walk.h"
#include "compiler/jit/emitter.h"

namespace pineda::jit {

using ir::Op;
using ir::Type;

namespace {
// Worker threads have 8 MiB by default, an application's thread that runs a tiny submit may have less; kernels do not probe.
constexpr uint64_t kMaxLocalBytes = 256 * 1024;
}  // namespace

// A B1 element takes a 32-bit word, 0 or -1, on every ISA.
llvm::Type* Emitter::local_element(Type t) const { return t == Type::kB1 ? llvm::Type::getInt32Ty(context_) : element_type(t); }

Emitter::V Emitter::to_local(V value, Type t) {
  return t == Type::kB1 ? b_.CreateSExt(to_i1(value), lane_type(b_.getInt32Ty())) : value;
}

Emitter::V Emitter::from_local(V value, Type t) {
  if (t != Type::kB1 || !features_.mask_registers) return value;
  return b_.CreateICmpSLT(value, llvm::Constant::getNullValue(value->getType()));
}

void Emitter::create_locals() {
  if (has_barriers()) return;  // then they are in the waves' frames
  llvm::IRBuilderBase::InsertPointGuard guard(b_);
  b_.SetInsertPoint(entry_->getTerminator());
  uint64_t total_bytes = 0;
  ir::for_each_inst(kernel_, kernel_.wave, [&](ir::Value v) {
    const ir::Inst& inst = kernel_.at(v);
    if (inst.op != Op::kLocal) return;
    llvm::Type* type = llvm::ArrayType::get(lane_type(local_element(inst.type)), inst.imm);
    total_bytes += module_.getDataLayout().getTypeAllocSize(type).getFixedValue();
    llvm::AllocaInst* slot = b_.CreateAlloca(type, nullptr, "local");
    slot->setAlignment(llvm::Align(64));
    local_slot_[v.id] = slot;
  });
  if (total_bytes > kMaxLocalBytes) {
    fail(
        "its private arrays need " + std::to_string(total_bytes) + " bytes of stack, more than " + std::to_string(kMaxLocalBytes),
        b_.getVoidTy());
  }
}

// A loop, not memset: kernels call no library. (No pass of our list would turn it into one.)
void Emitter::clear_local(ir::Value local) {
  V slot = local_slot_[local.id];
  llvm::Type* row = lane_type(local_element(kernel_.at(local).type));
  const uint64_t count = kernel_.at(local).imm;
  constexpr uint64_t kUnrolled = 16;
  V zero = llvm::Constant::getNullValue(row);
  if (count <= kUnrolled) {
    for (uint64_t i = 0; i < count; ++i) b_.CreateStore(zero, b_.CreateConstGEP1_64(row, slot, i));
    return;
  }
  llvm::BasicBlock *before = b_.GetInsertBlock(), *loop = block("clear"), *done = block("clear.done");
  b_.CreateBr(loop);
  start(loop);
  llvm::PHINode* i = b_.CreatePHI(b_.getInt64Ty(), 2);
  i->addIncoming(b_.getInt64(0), before);
  b_.CreateStore(zero, b_.CreateGEP(row, slot, i));
  V next = b_.CreateAdd(i, b_.getInt64(1));
  i->addIncoming(next, loop);
  b_.CreateCondBr(b_.CreateICmpEQ(next, b_.getInt64(count)), done, loop);
  start(done);
}

Emitter::LocalElement Emitter::local_element_at(const ir::Inst& inst) {
  const ir::Inst& local = kernel_.at(inst.operand[0]);
  V slot = local_slot_[inst.operand[0].id];
  LocalElement e{.type = local.type, .row = lane_type(local_element(local.type)), .in_range = nullptr, .address = nullptr};
  const ir::Value index = inst.operand[1];
  const ir::Inst& index_inst = kernel_.at(index);
  V count = b_.getInt32(static_cast<uint32_t>(local.imm));
  if (index_inst.op == Op::kConst) {
    if (index_inst.imm < local.imm) e.address = b_.CreateConstGEP1_64(e.row, slot, index_inst.imm);
    return e;  // null address: never in range
  }
  if (!is_lane(index)) {
    V i = scalar(index);
    e.in_range = b_.CreateICmpULT(i, count);
    V safe = b_.CreateSelect(e.in_range, i, b_.getInt32(0));
    e.address = b_.CreateGEP(e.row, slot, b_.CreateZExt(safe, b_.getInt64Ty()));
    return e;
  }
  V i = vector(index);
  e.in_range = from_i1(b_.CreateICmpULT(i, b_.CreateVectorSplat(kLanes, count)));
  const uint32_t size_bytes = e.row->getScalarSizeInBits() / 8;
  std::vector<uint32_t> lane_offset(kLanes);
  for (uint32_t l = 0; l < kLanes; ++l) lane_offset[l] = l * size_bytes;
  V row_offset = b_.CreateMul(i, int_const(i->getType(), size_bytes * kLanes));
  e.varying = {.base = b_.CreatePtrToInt(slot, b_.getInt64Ty()),
               .offset = b_.CreateAdd(row_offset, llvm::ConstantDataVector::get(context_, lane_offset)),
               .size_bytes = size_bytes,
               .element = e.row->getScalarType(),
               .base_readable = true,
               .small_offset = true};
  return e;
}

// 0 when the index is out of range.
Emitter::V Emitter::emit_local_load(const ir::Inst& inst) {
  const LocalElement e = local_element_at(inst);
  V zero = llvm::Constant::getNullValue(e.row);
  V row;
  if (e.varying.base != nullptr) {
    row = gather(e.varying, e.in_range);
  } else if (e.address == nullptr) {
    row = zero;
  } else {
    row = b_.CreateLoad(e.row, e.address);
    if (e.in_range != nullptr) row = b_.CreateSelect(e.in_range, row, zero);
  }
  V value = from_local(row, e.type);
  if (inst.rate == ir::Rate::kLane) return value;
  return first_active_lane(row, e.type);
}

// Dropped when the index is out of range.
void Emitter::emit_local_store(const ir::Inst& inst) {
  const LocalElement e = local_element_at(inst);
  V value = to_local(vector(inst.operand[2]), e.type);
  if (e.varying.base != nullptr) return scatter(e.varying, value, exec_and(e.in_range));
  if (e.address == nullptr) return;
  V keep_new = exec_.full() ? nullptr : exec_.lanes;
  if (e.in_range != nullptr) {
    V in_range = broadcast_value(e.in_range);
    keep_new = keep_new == nullptr ? in_range : b_.CreateAnd(keep_new, in_range);
  }
  if (keep_new != nullptr) value = b_.CreateSelect(to_i1(keep_new), value, b_.CreateLoad(e.row, e.address));
  b_.CreateStore(value, e.address);
}

// A local that only ever held uniform values may be rated uniform: all active lanes agree, so any of them will do.
Emitter::V Emitter::first_active_lane(V row, Type t) {
  V lane = b_.CreateBinaryIntrinsic(llvm::Intrinsic::cttz, exec_bits(), b_.getTrue());
  V element = b_.CreateExtractElement(row, lane);
  return t == Type::kB1 ? b_.CreateICmpSLT(element, b_.getInt32(0)) : element;
}

}  // namespace pineda::jit
