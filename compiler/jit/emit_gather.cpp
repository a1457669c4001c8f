// Accesses where each lane has its own address.
#include "compiler/jit/emitter.h"

namespace pineda::jit {

Emitter::LaneAddresses Emitter::lane_addresses(const Access& a) {
  std::vector<uint32_t> lane_offset(kLanes);
  std::vector<uint64_t> lane_offset64(kLanes);
  for (uint32_t l = 0; l < kLanes; ++l) {
    lane_offset64[l] = uint64_t{l} * a.lane_stride_bytes;
    lane_offset[l] = static_cast<uint32_t>(lane_offset64[l]);
  }
  const bool stride_fits = lane_offset64[kLanes - 1] <= ~0u;
  if (!is_vector(a.base) && !is_vector(a.offset) && stride_fits) {
    return {.base = first_address(a),
            .offset = llvm::ConstantDataVector::get(context_, lane_offset),
            .small = lane_offset64[kLanes - 1] < kSmallOffset};
  }
  if (!is_vector(a.base) && is_vector(a.offset) && a.lane_stride_bytes == 0) {
    return {.base = a.base, .offset = a.offset, .small = a.small_offset};
  }
  const auto wide = [&](V x) {
    V in_lanes = is_vector(x) ? x : b_.CreateVectorSplat(kLanes, x);
    return b_.CreateZExt(in_lanes, lane_type(b_.getInt64Ty()));
  };
  V address = b_.CreateAdd(wide(a.base), wide(a.offset));
  return {.address = b_.CreateAdd(address, llvm::ConstantDataVector::get(context_, lane_offset64))};
}

// 32-bit gather instructions sign-extend their indices, and offsets are unsigned: unless the sign bit is known to be clear, 2^31
// moves from the offsets to the base. One XOR, where 64-bit indices would halve the lanes of each instruction.
Emitter::V Emitter::lane_pointers(const LaneAddresses& at) {
  if (at.address != nullptr) return b_.CreateIntToPtr(at.address, lane_type(b_.getPtrTy()));
  V base = at.base, offset = at.offset;
  constexpr uint64_t kSignedRange = uint64_t{1} << 31;
  if (!at.small) {
    base = b_.CreateAdd(base, b_.getInt64(kSignedRange));
    offset = b_.CreateXor(offset, int_const(offset->getType(), kSignedRange));
  }
  V index = b_.CreateSExt(offset, lane_type(b_.getInt64Ty()));
  return b_.CreateGEP(b_.getInt8Ty(), b_.CreateIntToPtr(base, b_.getPtrTy()), index);
}

// ---- loads ----------------------------------------------------------------------------------------------------------------

// `mask`: lanes that may be read, null = all; lanes that are off give 0.
Emitter::V Emitter::gather(const Access& a, V mask) {
  const LaneAddresses at = lane_addresses(a);
  if (!features_.gathers) return mask == nullptr ? gather_scalar(a, at) : gather_scalar_masked(a, at, mask);
  if (a.size_bytes < 4) return gather_narrow(a, at, mask);
  return gather_native(a.element, at, mask, a.invariant);
}

Emitter::V Emitter::gather_native(llvm::Type* element, const LaneAddresses& at, V mask, bool invariant) {
  llvm::Type* type = lane_type(element);
  V lanes = to_i1(mask != nullptr ? mask : full_mask());
  llvm::CallInst* load =
      b_.CreateMaskedGather(type, lane_pointers(at), llvm::Align(1), lanes, llvm::Constant::getNullValue(type));
  mark_invariant(load, invariant);
  return load;
}

// 8- and 16-bit elements: gathers a 32-bit word that holds the element and shifts. The word must touch no page that the element
// does not touch. Aligned words do that; so does the word two bytes down from a 16-bit element that itself crosses a word border
// (address & 3 == 3):
//     back = address & 3, but 2 instead of 3 for 16 bits;  element = word[address - back] >> 8 * back
// To keep `offset - back` from wrapping, the base is aligned down and its low bits join the offset. (Only a base that is not a
// multiple of 4 and an offset within 3 bytes of 4 GiB could wrap then, and an offset that large fails its limit:
// BufferDescriptor::size_bytes.)
Emitter::V Emitter::gather_narrow(const Access& a, const LaneAddresses& at, V mask) {
  llvm::Type* i32 = lane_type(b_.getInt32Ty());
  const auto bytes_back = [&](V low) {
    V back = b_.CreateAnd(low, int_const(i32, 3));
    return a.size_bytes == 1 ? back : b_.CreateSub(back, b_.CreateAnd(back, b_.CreateLShr(back, int_const(i32, 1))));
  };
  LaneAddresses word;
  V back;
  if (at.address != nullptr) {
    back = bytes_back(b_.CreateTrunc(at.address, i32));
    word.address = b_.CreateSub(at.address, b_.CreateZExt(back, at.address->getType()));
  } else {
    V misaligned = b_.CreateAnd(b_.CreateTrunc(at.base, b_.getInt32Ty()), b_.getInt32(3));
    V offset = b_.CreateAdd(at.offset, b_.CreateVectorSplat(kLanes, misaligned));
    back = bytes_back(offset);
    word.base = b_.CreateAnd(at.base, b_.getInt64(~uint64_t{3}));
    word.offset = b_.CreateSub(offset, back);
    word.small = at.small;
  }
  V words = gather_native(b_.getInt32Ty(), word, mask, a.invariant);
  V element = b_.CreateLShr(words, b_.CreateShl(back, int_const(i32, 3)));
  return b_.CreateTrunc(element, lane_type(a.element));
}

// Sixteen loads, for an ISA without gathers.
Emitter::V Emitter::gather_scalar(const Access& a, const LaneAddresses& at) {
  V result = llvm::PoisonValue::get(lane_type(a.element));  // every element is inserted
  for (uint32_t l = 0; l < kLanes; ++l) {
    V address = at.address != nullptr
                    ? b_.CreateExtractElement(at.address, l)
                    : b_.CreateAdd(at.base, b_.CreateZExt(b_.CreateExtractElement(at.offset, l), b_.getInt64Ty()));
    result = b_.CreateInsertElement(result, load_at(a.element, address, a.invariant), l);
  }
  return result;
}

// The same with some lanes off. Sixteen branches would cost more than the loads, so lanes that are off read something harmless:
// with 64-bit addresses the zero constant; with a limit the base itself, which is readable if any lane passed its limit, else the
// zero constant. Only what is neither goes lane by lane.
Emitter::V Emitter::gather_scalar_masked(const Access& a, const LaneAddresses& at, V mask) {
  llvm::Type* type = lane_type(a.element);
  LaneAddresses safe = at;
  if (at.address != nullptr) {
    safe.address = b_.CreateSelect(to_i1(mask), at.address, b_.CreateVectorSplat(kLanes, zeros_address()));
  } else if (a.limit != nullptr || a.base_readable) {
    safe.offset = b_.CreateSelect(to_i1(mask), at.offset, int_const(at.offset->getType(), 0));
    if (!a.base_readable) safe.base = b_.CreateSelect(any(mask), at.base, zeros_address());
  } else {
    V slot = stack_slot(type, "gathered"), offsets = spill(at.offset, "offsets");
    b_.CreateStore(llvm::Constant::getNullValue(type), slot);
    for_each_lane(b_.CreateZExt(mask_bits(mask), b_.getInt32Ty()), [&](V lane) {
      V offset = b_.CreateZExt(slot_load(offsets, b_.getInt32Ty(), lane), b_.getInt64Ty());
      slot_store(slot, load_at(a.element, b_.CreateAdd(at.base, offset), a.invariant), lane);
    });
    return b_.CreateLoad(type, slot);
  }
  return b_.CreateSelect(to_i1(mask), gather_scalar(a, safe), llvm::Constant::getNullValue(type));
}

// ---- stores ---------------------------------------------------------------------------------------------------------------

// In lane order: of two lanes with one address the higher wins (llvm.masked.scatter and vpscatterdd guarantee it too).
void Emitter::scatter(const Access& a, V value, V mask) {
  const LaneAddresses at = lane_addresses(a);
  if (features_.scatters && a.size_bytes >= 4) {
    b_.CreateMaskedScatter(value, lane_pointers(at), llvm::Align(1), to_i1(mask != nullptr ? mask : full_mask()));
    return;
  }
  const LaneSlots slots = spill_addresses(at);
  V values = spill(value, "values");
  V bits = mask != nullptr ? b_.CreateZExt(mask_bits(mask), b_.getInt32Ty()) : b_.getInt32((1u << kLanes) - 1);
  for_each_lane(bits, [&](V lane) { store_at(slot_load(values, a.element, lane), slot_address(slots, lane)); });
}

// ---- one lane at a time -----------------------------------------------------------------------------------------------------

Emitter::LaneSlots Emitter::spill_addresses(const LaneAddresses& at) {
  if (at.address != nullptr) return {.addresses = spill(at.address, "addresses")};
  return {.base = at.base, .offsets = spill(at.offset, "offsets")};
}

Emitter::V Emitter::slot_address(const LaneSlots& slots, V lane_i64) {
  if (slots.addresses != nullptr) return slot_load(slots.addresses, b_.getInt64Ty(), lane_i64);
  return b_.CreateAdd(slots.base, b_.CreateZExt(slot_load(slots.offsets, b_.getInt32Ty(), lane_i64), b_.getInt64Ty()));
}

// for (m = bits; m != 0; m &= m - 1) body(index of the lowest bit of m)
void Emitter::for_each_lane(V bits_i32, const std::function<void(V lane_i64)>& body) {
  llvm::BasicBlock *before = b_.GetInsertBlock(), *loop = block("lane"), *done = block("lanes.done");
  b_.CreateCondBr(b_.CreateICmpEQ(bits_i32, b_.getInt32(0)), done, loop);
  start(loop);
  llvm::PHINode* left = b_.CreatePHI(b_.getInt32Ty(), 2);
  left->addIncoming(bits_i32, before);
  V lane = b_.CreateBinaryIntrinsic(llvm::Intrinsic::cttz, left, b_.getTrue());
  body(b_.CreateZExt(lane, b_.getInt64Ty()));
  V rest = b_.CreateAnd(left, b_.CreateSub(left, b_.getInt32(1)));
  left->addIncoming(rest, b_.GetInsertBlock());
  b_.CreateCondBr(b_.CreateICmpEQ(rest, b_.getInt32(0)), done, loop);
  start(done);
}

// One slot for each type and role: their uses never overlap.
Emitter::V Emitter::stack_slot(llvm::Type* type, const char* role) {
  V& slot = slots_[{type, role}];
  if (slot != nullptr) return slot;
  llvm::IRBuilderBase::InsertPointGuard guard(b_);
  b_.SetInsertPoint(entry_->getTerminator());
  llvm::AllocaInst* made = b_.CreateAlloca(type, nullptr, role);
  made->setAlignment(llvm::Align(64));
  return slot = made;
}

Emitter::V Emitter::spill(V vector, const char* role) {
  V slot = stack_slot(vector->getType(), role);
  b_.CreateStore(vector, slot);
  return slot;
}

Emitter::V Emitter::slot_load(V slot, llvm::Type* element, V lane_i64) {
  return b_.CreateLoad(element, b_.CreateGEP(element, slot, lane_i64));
}

void Emitter::slot_store(V slot, V value, V lane_i64) { b_.CreateStore(value, b_.CreateGEP(value->getType(), slot, lane_i64)); }

}  // namespace pineda::jit
