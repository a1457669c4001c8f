// Kernels with barriers: the wave loop is split into phases (ir/wave_frame.h), each a loop over the workgroup's waves. What a
// later phase needs of a wave is in the wave's frame. An If or Loop that holds a barrier branches for the whole workgroup: on a
// scalar where its condition is the workgroup's, else on whether any lane of any wave wants to, with the waves' masks in their
// frames.
#include <algorithm>
#include <cstddef>

#include "base/abi.h"
#include "compiler/ir/walk.h"
#include "compiler/jit/emitter.h"

namespace pineda::jit {

using ir::Op;
using ir::Type;

// The construct whose region is being emitted: its last phase ends with what the Yield does.
struct Emitter::GroupTail {
  ir::Value owner;
  uint32_t side = 0;
};

void Emitter::emit_group(V prim_record) {
  V stride = b_.getInt64(kernel_.wave_stride_bytes);
  V first = b_.CreateZExt(load_field(prim_record, offsetof(PrimRecord, first_wave), b_.getInt32Ty()), b_.getInt64Ty());
  group_count_ = b_.CreateZExt(load_field(prim_record, offsetof(PrimRecord, wave_count), b_.getInt32Ty()), b_.getInt64Ty());
  group_waves_ = b_.CreateAdd(b_.CreatePtrToInt(function_->getArg(5), b_.getInt64Ty()), b_.CreateMul(first, stride));
  group_frames_ = load_at(b_.getInt64Ty(), b_.CreateAdd(thread_ptr_, b_.getInt64(offsetof(ThreadContext, wave_frames))), true);
  llvm::BasicBlock *run = block("group"), *done = block("group.done");
  b_.CreateCondBr(b_.CreateICmpEQ(group_count_, b_.getInt64(0)), done, run);
  start(run);
  emit_group_region(kernel_.wave, std::nullopt, nullptr);
  b_.CreateBr(done);
  start(done);
}

// `mask_offset`: where the waves' frames have their masks; unset: in the wave records.
void Emitter::emit_group_region(ir::RegionId region, std::optional<uint32_t> mask_offset, const GroupTail* tail) {
  std::vector<ir::Value> phase;
  const auto flush = [&] {
    if (!phase.empty()) emit_phase(phase, mask_offset, tail);
    phase.clear();
  };
  for (ir::Value v : kernel_.regions[region].insts) {
    if (!error_.empty()) return;
    const ir::Inst& inst = kernel_.at(v);
    if (inst.op == Op::kBarrier) {
      flush();
    } else if (ir::is_group_construct(inst, with_barriers_)) {
      phase.push_back(v);  // its condition and initial values are the end of this phase
      flush();
      inst.op == Op::kIf ? emit_group_if(v, mask_offset) : emit_group_loop(v, mask_offset);
    } else if (inst.op == Op::kLoopArg ||
               (inst.op == Op::kResult && ir::is_group_construct(kernel_.at(inst.operand[0]), with_barriers_))) {
      continue;  // the construct has set its value
    } else if (inst.rate <= ir::Rate::kPrim && inst.op != Op::kYield) {
      if (V value = emit(inst, v)) value_[v.id] = value;
    } else {
      phase.push_back(v);
    }
  }
  flush();
}

// for each wave with active lanes: load what earlier phases kept, run, keep
void Emitter::emit_phase(const std::vector<ir::Value>& insts, std::optional<uint32_t> mask_offset, const GroupTail* tail) {
  const ir::Value last = insts.back();
  const bool sets_masks = kernel_.at(last).op == Op::kYield ? tail != nullptr && any_lane_.contains(tail->owner.id)
                                                            : frame_.masks[last.id] != ir::WaveFrame::kNone;
  if (insts.size() == 1 && kernel_.at(last).op == Op::kYield && tail == nullptr) return;
  const bool is_group_if = kernel_.at(last).op == Op::kIf && ir::is_group_construct(kernel_.at(last), with_barriers_);
  if (insts.size() == 1 && is_group_if && !sets_masks) return;  // its condition is the workgroup's
  if (sets_masks && kernel_.at(last).op != Op::kYield) {
    llvm::IRBuilderBase::InsertPointGuard guard(b_);
    b_.SetInsertPoint(entry_->getTerminator());
    any_lane_[last.id] = b_.CreateAlloca(b_.getInt16Ty(), b_.getInt32(2), "any");
  }
  const ir::Value construct = kernel_.at(last).op == Op::kYield && tail != nullptr ? tail->owner : last;
  if (sets_masks && !(kernel_.at(last).op == Op::kYield && kernel_.at(construct).op == Op::kIf)) {
    for (uint64_t i = 0; i < 2; ++i)
      b_.CreateStore(b_.getInt16(0), b_.CreateConstGEP1_64(b_.getInt16Ty(), any_lane_[construct.id], i));
  }
  llvm::BasicBlock *before = b_.GetInsertBlock(), *body = block("phase"), *next = block("phase.next"),
                   *done = block("phase.done");
  b_.CreateBr(body);
  start(body);
  llvm::PHINode* remaining = b_.CreatePHI(b_.getInt64Ty(), 2, "remaining");
  llvm::PHINode* record = b_.CreatePHI(b_.getInt64Ty(), 2, "record");
  llvm::PHINode* frame = b_.CreatePHI(b_.getInt64Ty(), 2, "frame");
  remaining->addIncoming(group_count_, before);
  record->addIncoming(group_waves_, before);
  frame->addIncoming(group_frames_, before);
  wave_ptr_ = record;
  frame_ptr_ = frame;
  exec_ = {};
  if (sets_masks && kernel_.at(last).op != Op::kYield) {  // of waves that are skipped, too
    store_mask(frame_.masks[last.id], b_.getInt16(0));
    store_mask(frame_.masks[last.id] + 8, b_.getInt16(0));
  }
  if (mask_offset || !kernel_.full_waves) {
    V bits = mask_offset ? load_at(b_.getInt16Ty(), frame_address(*mask_offset), false)
                         : b_.CreateTrunc(load_at(b_.getInt32Ty(), wave_ptr_, false), b_.getInt16Ty());
    llvm::BasicBlock* run = block("phase.run");
    b_.CreateCondBr(b_.CreateICmpEQ(bits, b_.getInt16(0)), next, run);
    start(run);
    exec_.lanes = mask_from_bits(bits);
  }
  load_kept(insts);
  for (ir::Value v : insts) {
    if (error_.empty()) emit_in_phase(v, tail);
  }
  exec_ = {};
  b_.CreateBr(next);
  start(next);
  V less = b_.CreateSub(remaining, b_.getInt64(1));
  remaining->addIncoming(less, next);
  record->addIncoming(b_.CreateAdd(record, b_.getInt64(kernel_.wave_stride_bytes)), next);
  frame->addIncoming(b_.CreateAdd(frame, b_.getInt64(frame_.bytes)), next);
  b_.CreateCondBr(b_.CreateICmpEQ(less, b_.getInt64(0)), done, body);
  start(done);
}

void Emitter::emit_in_phase(ir::Value v, const GroupTail* tail) {
  const ir::Inst& inst = kernel_.at(v);
  if (ir::is_group_construct(inst, with_barriers_)) return enter_construct(v);
  if (inst.op == Op::kYield) {
    if (tail == nullptr) return;
    return kernel_.at(tail->owner).op == Op::kIf ? leave_side(*tail) : leave_turn(*tail);
  }
  if (V value = emit(inst, v)) value_[v.id] = shape(value, inst.rate == ir::Rate::kLane);
  if (inst.op != Op::kLocal && is_kept(v)) store_to_frame(v, value_[v.id], nullptr);
}

// ---- frames ---------------------------------------------------------------------------------------------------------------

Emitter::V Emitter::frame_address(uint32_t offset_bytes) { return b_.CreateAdd(frame_ptr_, b_.getInt64(offset_bytes)); }

// Values that this phase reads and another one computed; sources of the wave; the places of Locals.
void Emitter::load_kept(const std::vector<ir::Value>& insts) {
  std::vector<bool> here(kernel_.insts.size());
  for (ir::Value v : insts) here[v.id] = true;
  const auto use = [&](ir::Value v) {
    if (here[v.id]) return;
    here[v.id] = true;
    const ir::Inst& inst = kernel_.at(v);
    if (inst.op == Op::kLocal) {
      local_slot_[v.id] = b_.CreateIntToPtr(frame_address(frame_.offset[v.id]), b_.getPtrTy());
    } else if (ir::is_recomputed(inst.op)) {
      value_[v.id] = emit(inst, v);
      splat_[v.id] = nullptr;
    } else if (is_kept(v)) {
      value_[v.id] = load_from_frame(v);
      splat_[v.id] = nullptr;
    }
  };
  for (ir::Value v : insts) {
    const ir::Inst& inst = kernel_.at(v);
    if (inst.op == Op::kLocal) local_slot_[v.id] = b_.CreateIntToPtr(frame_address(frame_.offset[v.id]), b_.getPtrTy());
    ir::for_each_read(kernel_, v, use);
    if (ir::is_group_construct(inst, with_barriers_)) continue;
    for (uint32_t r = 0; r < ir::region_count(inst.op); ++r) {
      ir::for_each_inst(kernel_, inst.region[r], [&](ir::Value inner) { ir::for_each_read(kernel_, inner, use); });
    }
  }
}

Emitter::V Emitter::load_from_frame(ir::Value v) {
  const ir::Inst& inst = kernel_.at(v);
  V address = b_.CreateIntToPtr(frame_address(frame_.offset[v.id]), b_.getPtrTy());
  if (inst.type == Type::kB1) {
    if (is_lane(v)) return mask_from_bits(b_.CreateLoad(b_.getInt16Ty(), address));
    return b_.CreateICmpNE(b_.CreateLoad(b_.getInt8Ty(), address), b_.getInt8(0));
  }
  llvm::Type* type = value_type(inst.type, is_lane(v));
  return b_.CreateAlignedLoad(type, address, llvm::Align(8));
}

// `where`: a mask of the lanes to replace; null: all.
void Emitter::store_to_frame(ir::Value v, V value, V where) {
  V address = b_.CreateIntToPtr(frame_address(frame_.offset[v.id]), b_.getPtrTy());
  if (where != nullptr && is_lane(v)) value = b_.CreateSelect(to_i1(where), value, load_from_frame(v));
  if (kernel_.at(v).type == Type::kB1) {
    b_.CreateStore(is_lane(v) ? mask_bits(value) : b_.CreateZExt(value, b_.getInt8Ty()), address);
  } else {
    b_.CreateAlignedStore(value, address, llvm::Align(8));
  }
}

void Emitter::store_mask(uint32_t offset_bytes, V bits16) { store_at(bits16, frame_address(offset_bytes)); }

void Emitter::add_to_flag(V flag, V bits16) { b_.CreateStore(b_.CreateOr(b_.CreateLoad(b_.getInt16Ty(), flag), bits16), flag); }

// ---- if and loop ----------------------------------------------------------------------------------------------------------

// The end of the phase in front of an If or Loop: masks, initial values.
void Emitter::enter_construct(ir::Value v) {
  const ir::Inst& inst = kernel_.at(v);
  const uint32_t masks = frame_.masks[v.id];
  V active = b_.CreateTrunc(exec_bits(), b_.getInt16Ty());
  if (inst.op == Op::kIf) {
    if (masks == ir::WaveFrame::kNone) return;
    V then_bits = b_.CreateAnd(active, mask_bits(vector(inst.operand[0])));
    V else_bits = b_.CreateXor(active, then_bits);
    store_mask(masks, then_bits);
    store_mask(masks + 8, else_bits);
    add_to_flag(any_lane_[v.id], then_bits);
    add_to_flag(b_.CreateConstGEP1_64(b_.getInt16Ty(), any_lane_[v.id], 1), else_bits);
    return;
  }
  if (masks != ir::WaveFrame::kNone) store_mask(masks, active);
  const auto& init = kernel_.lists[inst.list];
  for (size_t k = 0; k < init.size(); ++k) {
    const ir::Value arg = kernel_.regions[inst.region[0]].insts[k];
    if (is_kept(arg)) store_to_frame(arg, get(init[k], is_lane(arg)), nullptr);
  }
}

// The end of the last phase of an If's side.
void Emitter::leave_side(const GroupTail& tail) {
  const auto& values = ir::yielded(kernel_, kernel_.at(tail.owner).region[tail.side]);
  for (ir::Value result : results_of(tail.owner)) {
    if (!is_kept(result)) continue;
    store_to_frame(result, get(values[kernel_.at(result).imm], is_lane(result)), exec_.lanes);
  }
}

// The end of the last phase of a Loop's turn. All values are read before any is stored: they may be one another's LoopArgs.
void Emitter::leave_turn(const GroupTail& tail) {
  const ir::Inst& loop = kernel_.at(tail.owner);
  const auto& values = ir::yielded(kernel_, loop.region[0]);
  const auto& args = kernel_.regions[loop.region[0]].insts;
  const bool divergent = frame_.masks[tail.owner.id] != ir::WaveFrame::kNone;
  struct Next {
    ir::Value place;
    V value;
  };
  std::vector<Next> next;
  for (ir::Value result : results_of(tail.owner)) {
    if (is_kept(result)) next.push_back({result, get(values[kernel_.at(result).imm + 1], is_lane(result))});
  }
  for (size_t k = 0; k + 1 < values.size(); ++k) {
    const bool done =
        std::ranges::any_of(next, [&](const Next& n) { return frame_.offset[n.place.id] == frame_.offset[args[k].id]; });
    if (is_kept(args[k]) && !done) next.push_back({args[k], get(values[k + 1], is_lane(args[k]))});
  }
  V stay = nullptr;
  if (divergent) stay = b_.CreateAnd(b_.CreateTrunc(exec_bits(), b_.getInt16Ty()), mask_bits(vector(values[0])));
  for (const Next& n : next) store_to_frame(n.place, n.value, divergent ? exec_.lanes : nullptr);
  if (!divergent) return;
  store_mask(frame_.masks[tail.owner.id], stay);
  add_to_flag(any_lane_[tail.owner.id], stay);
}

void Emitter::emit_group_if(ir::Value v, std::optional<uint32_t> mask_offset) {
  const ir::Inst& inst = kernel_.at(v);
  const uint32_t masks = frame_.masks[v.id];
  const bool varies = masks != ir::WaveFrame::kNone;
  std::vector<ir::Value> scalars;  // Results that are not in the frames
  for (ir::Value r : results_of(v)) {
    if (!is_kept(r)) scalars.push_back(r);
  }
  llvm::BasicBlock *sides[2] = {block("group.then"), block("group.else")}, *join = block("group.endif"), *ends[2];
  std::vector<V> values[2];
  const auto wanted = [&](uint64_t side) {
    V flag = b_.CreateConstGEP1_64(b_.getInt16Ty(), any_lane_[v.id], side);
    return b_.CreateICmpNE(b_.CreateLoad(b_.getInt16Ty(), flag), b_.getInt16(0));
  };
  llvm::BasicBlock* between = varies ? block("group.between") : nullptr;
  b_.CreateCondBr(varies ? wanted(0) : scalar(inst.operand[0]), sides[0], varies ? between : sides[1]);
  for (uint32_t side = 0; side < 2; ++side) {
    start(sides[side]);
    const GroupTail tail{v, side};
    const size_t known = facts_.size();
    if (side == 0) learn(inst.operand[0]);
    emit_group_region(inst.region[side], varies ? masks + 8 * side : mask_offset, &tail);
    facts_.resize(known);
    for (ir::Value r : scalars) values[side].push_back(scalar(ir::yielded(kernel_, inst.region[side])[kernel_.at(r).imm]));
    ends[side] = b_.GetInsertBlock();
    b_.CreateBr(varies && side == 0 ? between : join);
    if (!varies || side != 0) continue;
    start(between);
    b_.CreateCondBr(wanted(1), sides[1], join);
  }
  start(join);
  for (size_t k = 0; k < scalars.size(); ++k) {
    if (varies) return void(fail("the result of a divergent if is rated uniform", b_.getVoidTy()));
    llvm::PHINode* phi = b_.CreatePHI(values[0][k]->getType(), 2);
    for (int side = 0; side < 2; ++side) phi->addIncoming(values[side][k], ends[side]);
    value_[scalars[k].id] = phi;
  }
}

void Emitter::emit_group_loop(ir::Value v, std::optional<uint32_t> mask_offset) {
  const ir::Inst& inst = kernel_.at(v);
  const bool varies = frame_.masks[v.id] != ir::WaveFrame::kNone;
  const auto& init = kernel_.lists[inst.list];
  const auto& args = kernel_.regions[inst.region[0]].insts;
  const auto& values = ir::yielded(kernel_, inst.region[0]);
  for (size_t k = 0; k < init.size(); ++k) loop_of_arg_[args[k].id] = v;
  std::vector<V> first;
  for (size_t k = 0; k < init.size(); ++k) first.push_back(is_kept(args[k]) ? nullptr : scalar(init[k]));
  llvm::BasicBlock *before = b_.GetInsertBlock(), *body = block("group.loop"), *done = block("group.loop.done");
  b_.CreateBr(body);
  start(body);
  std::vector<llvm::PHINode*> phis(init.size());
  for (size_t k = 0; k < init.size(); ++k) {
    if (first[k] == nullptr) continue;
    value_[args[k].id] = phis[k] = b_.CreatePHI(first[k]->getType(), 2);
    phis[k]->addIncoming(first[k], before);
  }
  const GroupTail tail{v, 0};
  emit_group_region(inst.region[0], varies ? std::optional(frame_.masks[v.id]) : mask_offset, &tail);
  if (!error_.empty()) return;
  V repeat = varies ? b_.CreateICmpNE(b_.CreateLoad(b_.getInt16Ty(), any_lane_[v.id]), b_.getInt16(0)) : scalar(values[0]);
  for (size_t k = 0; k < init.size(); ++k) {
    if (phis[k] != nullptr) phis[k]->addIncoming(scalar(values[k + 1]), b_.GetInsertBlock());
  }
  for (ir::Value r : results_of(v)) {
    if (!is_kept(r)) value_[r.id] = scalar(values[kernel_.at(r).imm + 1]);
  }
  V stop = b_.CreateLoad(b_.getInt32Ty(), stop_ptr_, /*isVolatile=*/true);  // as in emit_loop
  b_.CreateCondBr(b_.CreateAnd(repeat, b_.CreateIsNull(stop)), body, done);
  start(done);
}

}  // namespace pineda::jit
