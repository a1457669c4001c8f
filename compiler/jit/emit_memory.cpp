// Load and Store: classification of the address and the accesses that need no gather; bounds are in emit_bounds.cpp. See ir.h,
// "Memory".
#include "compiler/ir/walk.h"
#include "compiler/jit/emitter.h"

namespace pineda::jit {

using ir::Op;
using ir::Type;

bool Emitter::Access::uniform() const {
  return !is_vector(base) && !is_vector(offset) && (limit == nullptr || !is_vector(limit)) && where == nullptr &&
         lane_stride_bytes == 0;
}

bool Emitter::Access::contiguous() const { return !is_vector(base) && !is_vector(offset) && lane_stride_bytes == size_bytes; }

Emitter::Access Emitter::access_of(const ir::Inst& inst, llvm::Type* element) {
  const auto own_shape = [&](ir::Value v) { return get(v, is_lane(v)); };
  // What the control flow tells holds for active lanes only.
  const bool with_facts = (inst.flags & (ir::kSpeculate | ir::kAllLanes)) == 0;
  const uint64_t bound = upper_bound(inst.operand[1], with_facts);
  Access a{.base = own_shape(inst.operand[0]),
           .offset = own_shape(inst.operand[1]),
           .lane_stride_bytes = inst.lane_stride(),
           .size_bytes = static_cast<uint32_t>(element->getPrimitiveSizeInBits() / 8),
           .element = element,
           .invariant = (inst.flags & ir::kInvariant) != 0,
           .small_offset = bound < kSmallOffset,
           .offset_bound = bound};
  if (const ir::Value limit = ir::limit_of(inst)) set_limit(a, limit, with_facts);
  return a;
}

// ---- loads ----------------------------------------------------------------------------------------------------------------

Emitter::V Emitter::emit_load(const ir::Inst& inst) {
  if ((inst.flags & ir::kVolatile) == 0) return emit_plain_load(inst);
  forget_memory();
  V loaded = emit_plain_load(inst);
  forget_memory();
  return loaded;
}

// Another thread may have written anything, so LLVM merges and moves no access across this place. Masked loads and gathers have
// no volatile form; this works for all, and is no instruction.
void Emitter::forget_memory() { b_.CreateFence(llvm::AtomicOrdering::SequentiallyConsistent, llvm::SyncScope::SingleThread); }

Emitter::V Emitter::emit_plain_load(const ir::Inst& inst) {
  const Access a = access_of(inst, element_type(inst.type));
  if (inst.rate != ir::Rate::kLane && !a.uniform()) return fail("a uniform load has a varying address", a.element);
  if (a.uniform()) return uniform_load(a);
  V in_bounds = lanes_in_bounds(a);
  const bool speculate = (inst.flags & ir::kSpeculate) != 0;
  V mask = in_bounds;
  if (!speculate && !exec_.full()) mask = in_bounds != nullptr ? exec_and(in_bounds) : exec_.lanes;
  return a.contiguous() ? contiguous_load(a, mask) : gather(a, mask);
}

// Out of bounds: read from 16 zero bytes instead, which needs no branch.
Emitter::V Emitter::uniform_load(const Access& a) {
  V address = first_address(a);
  if (V ok = uniform_in_bounds(a)) address = b_.CreateSelect(ok, address, zeros_address());
  return load_at(a.element, address, a.invariant);
}

// `mask`: lanes that may be read, null = all; the others give 0.
Emitter::V Emitter::contiguous_load(const Access& a, V mask) {
  llvm::Type* type = lane_type(a.element);
  V address = first_address(a);
  if (mask == nullptr) return load_at(type, address, a.invariant);
  const bool native = features_.scatters || (features_.masked_moves && a.size_bytes >= 4);  // AVX-512BW: any element
  if (!native) return contiguous_load_by_lane(a, mask);
  llvm::CallInst* load = b_.CreateMaskedLoad(type, b_.CreateIntToPtr(address, b_.getPtrTy()), llvm::Align(1), to_i1(mask),
                                             llvm::Constant::getNullValue(type));
  mark_invariant(load, a.invariant);
  return load;
}

// Without masked loads: all lanes at once when all are on, the usual case; else one by one.
Emitter::V Emitter::contiguous_load_by_lane(const Access& a, V mask) {
  llvm::Type* type = lane_type(a.element);
  V address = first_address(a);
  V slot = stack_slot(type, "lanes");
  V bits = mask_bits(mask);
  llvm::BasicBlock *all = block("load.all"), *some = block("load.some"), *done = block("load.done");
  b_.CreateCondBr(b_.CreateICmpEQ(bits, b_.getInt16(0xffff)), all, some);
  start(all);
  V whole = load_at(type, address, a.invariant);
  b_.CreateBr(done);
  start(some);
  b_.CreateStore(llvm::Constant::getNullValue(type), slot);
  for_each_lane(b_.CreateZExt(bits, b_.getInt32Ty()), [&](V lane) {
    V at = b_.CreateAdd(address, b_.CreateMul(lane, b_.getInt64(a.size_bytes)));
    slot_store(slot, load_at(a.element, at, a.invariant), lane);
  });
  V partial = b_.CreateLoad(type, slot);
  llvm::BasicBlock* some_end = b_.GetInsertBlock();
  b_.CreateBr(done);
  start(done);
  llvm::PHINode* result = b_.CreatePHI(type, 2);
  result->addIncoming(whole, all);
  result->addIncoming(partial, some_end);
  return result;
}

// ---- stores ---------------------------------------------------------------------------------------------------------------

void Emitter::emit_store(const ir::Inst& inst) {
  const ir::Value stored = inst.operand[2];
  const Access a = access_of(inst, element_type(kernel_.at(stored).type));
  const bool all_lanes = (inst.flags & ir::kAllLanes) != 0;
  // One value for one address: all active lanes write the same, and at least one is active here.
  if (a.uniform() && !is_lane(stored)) return uniform_store(a, scalar(stored));
  V in_bounds = lanes_in_bounds(a);
  V mask = in_bounds;
  if (!all_lanes && !exec_.full()) mask = in_bounds != nullptr ? exec_and(in_bounds) : exec_.lanes;
  if (a.contiguous()) {
    contiguous_store(a, vector(stored), mask);
  } else {
    scatter(a, vector(stored), mask);
  }
}

void Emitter::uniform_store(const Access& a, V value) {
  V ok = uniform_in_bounds(a);
  if (ok == nullptr) return store_at(value, first_address(a));
  llvm::BasicBlock *write = block("store"), *done = block("store.done");
  b_.CreateCondBr(ok, write, done);
  start(write);
  store_at(value, first_address(a));
  b_.CreateBr(done);
  start(done);
}

void Emitter::contiguous_store(const Access& a, V value, V mask) {
  V address = first_address(a);
  if (mask == nullptr) return store_at(value, address);
  const bool native = features_.scatters || (features_.masked_moves && a.size_bytes >= 4);
  if (native) {
    b_.CreateMaskedStore(value, b_.CreateIntToPtr(address, b_.getPtrTy()), llvm::Align(1), to_i1(mask));
    return;
  }
  // Lanes that are off must not be written, not even with their old value: another thread may be writing them.
  V bits = mask_bits(mask);
  llvm::BasicBlock *all = block("store.all"), *some = block("store.some"), *done = block("store.done");
  b_.CreateCondBr(b_.CreateICmpEQ(bits, b_.getInt16(0xffff)), all, some);
  start(all);
  store_at(value, address);
  b_.CreateBr(done);
  start(some);
  V slot = spill(value, "values");
  for_each_lane(b_.CreateZExt(bits, b_.getInt32Ty()), [&](V lane) {
    store_at(slot_load(slot, a.element, lane), b_.CreateAdd(address, b_.CreateMul(lane, b_.getInt64(a.size_bytes))));
  });
  b_.CreateBr(done);
  start(done);
}

// ---- single accesses ------------------------------------------------------------------------------------------------------

Emitter::V Emitter::first_address(const Access& a) { return b_.CreateAdd(a.base, b_.CreateZExt(a.offset, b_.getInt64Ty())); }

Emitter::V Emitter::load_at(llvm::Type* type, V address_i64, bool invariant) {
  llvm::LoadInst* load = b_.CreateAlignedLoad(type, b_.CreateIntToPtr(address_i64, b_.getPtrTy()), llvm::Align(1));
  mark_invariant(load, invariant);
  return load;
}

void Emitter::store_at(V value, V address_i64) {
  b_.CreateAlignedStore(value, b_.CreateIntToPtr(address_i64, b_.getPtrTy()), llvm::Align(1));
}

// Lets LLVM move the load across stores.
void Emitter::mark_invariant(llvm::Instruction* load, bool invariant) {
  if (invariant) load->setMetadata(llvm::LLVMContext::MD_invariant_load, llvm::MDNode::get(context_, {}));
}

Emitter::V Emitter::zeros_address() {
  if (zeros_ == nullptr) {
    llvm::Type* type = llvm::ArrayType::get(b_.getInt8Ty(), 16);
    zeros_ = new llvm::GlobalVariable(module_, type, true, llvm::GlobalValue::PrivateLinkage, llvm::Constant::getNullValue(type));
    zeros_->setAlignment(llvm::Align(16));
  }
  return b_.CreatePtrToInt(zeros_, b_.getInt64Ty());
}

}  // namespace pineda::jit
