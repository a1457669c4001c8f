// The frame of a kernel (three loops, see base/abi.h) and the dispatch to the op families.
#include <algorithm>
#include <bit>

#include "base/half.h"
#include "compiler/ir/walk.h"
#include "compiler/jit/emitter.h"

namespace pineda::jit {

using ir::Op;
using ir::Type;

Features features_of(Isa isa) {
  switch (isa) {
    case Isa::kSse42:
      return {.vector_bits = 128};
    case Isa::kAvx2:
      return {.fma = true, .half = true, .gathers = true, .masked_moves = true, .vector_bits = 256};
    case Isa::kAvx512:
      return {.mask_registers = true,
              .fma = true,
              .half = true,
              .gathers = true,
              .masked_moves = true,
              .scatters = true,
              .vector_bits = 512};
  }
  return {};
}

namespace {

// Visible in profiles and debuggers. The prefix keeps a kernel's name from being one that means something to LLVM.
std::string symbol_name(const ir::Kernel& kernel) { return "pineda." + (kernel.name.empty() ? "kernel" : kernel.name); }

}  // namespace

Emitter::Emitter(llvm::Module& module, const ir::Kernel& kernel, Isa isa)
    : module_(module),
      context_(module.getContext()),
      kernel_(kernel),
      features_(features_of(isa)),
      b_(context_),
      value_(kernel.insts.size()),
      splat_(kernel.insts.size()),
      with_barriers_(ir::regions_with_barriers(kernel)),
      frame_(ir::wave_frame(kernel)) {
  for (ir::RegionId root : {kernel.draw, kernel.prim, kernel.wave}) {
    if (root == 0) continue;
    ir::for_each_inst(kernel, root, [&](ir::Value v) {
      const ir::Inst& inst = kernel.at(v);
      if (inst.op == Op::kResult) results_[inst.operand[0].id].push_back(v);
    });
  }
}

llvm::Function* Emitter::run(std::string* error) {
  // void (KernelHandle* self, draw, thread, prims, prim_count, waves)
  llvm::Type* ptr = b_.getPtrTy();
  auto* type = llvm::FunctionType::get(b_.getVoidTy(), {ptr, ptr, ptr, ptr, b_.getInt32Ty(), ptr}, false);
  function_ = llvm::Function::Create(type, llvm::Function::ExternalLinkage, symbol_name(kernel_), module_);
  function_->setDoesNotThrow();
  function_->setDSOLocal(true);
  emit_frame();
  if (error_.empty()) return function_;
  *error = error_;
  return nullptr;
}

// ---- frame ----------------------------------------------------------------------------------------------------------------

void Emitter::emit_frame() {
  entry_ = block("entry");
  llvm::BasicBlock* draw = block("draw");
  start(entry_);
  b_.CreateBr(draw);
  start(draw);
  draw_ptr_ = b_.CreatePtrToInt(function_->getArg(1), b_.getInt64Ty());
  thread_ptr_ = b_.CreatePtrToInt(function_->getArg(2), b_.getInt64Ty());
  create_locals();
  const bool has_loops = std::ranges::any_of(kernel_.insts, [](const ir::Inst& inst) { return inst.op == Op::kLoop; });
  if (has_loops) emit_stop_pointer();
  if (kernel_.draw != 0) emit_insts(kernel_.draw);
  emit_prim_loop();
  b_.CreateRetVoid();
}

// Where loops look whether they are to end (base/stop_word.h): the handle's word, or one of our own that stays 0.
void Emitter::emit_stop_pointer() {
  llvm::IRBuilderBase::InsertPointGuard guard(b_);
  b_.SetInsertPoint(entry_->getTerminator());  // an alloca anywhere else would grow the stack at run time
  V word = load_field(function_->getArg(0), offsetof(KernelHandle, self), b_.getPtrTy());
  llvm::AllocaInst* never = b_.CreateAlloca(b_.getInt32Ty(), nullptr, "never");
  b_.CreateStore(b_.getInt32(0), never);
  stop_ptr_ = b_.CreateSelect(b_.CreateIsNull(word), never, word, "stop");
}

// for (i = 0; i < prim_count; ++i)
void Emitter::emit_prim_loop() {
  V count = function_->getArg(4);
  llvm::BasicBlock *before = b_.GetInsertBlock(), *body = block("prim"), *done = block("done");
  b_.CreateCondBr(b_.CreateICmpEQ(count, b_.getInt32(0)), done, body);
  start(body);
  llvm::PHINode* index = b_.CreatePHI(b_.getInt32Ty(), 2);
  index->addIncoming(b_.getInt32(0), before);
  V record = b_.CreateGEP(b_.getInt8Ty(), function_->getArg(3),
                          b_.CreateMul(b_.CreateZExt(index, b_.getInt64Ty()), b_.getInt64(sizeof(PrimRecord))));
  prim_ptr_ = load_field(record, offsetof(PrimRecord, prim), b_.getInt64Ty());
  if (kernel_.prim != 0) emit_insts(kernel_.prim);
  if (has_barriers()) {
    emit_group(record);
  } else {
    emit_wave_loop(record);
  }
  V next = b_.CreateAdd(index, b_.getInt32(1));
  index->addIncoming(next, b_.GetInsertBlock());
  b_.CreateCondBr(b_.CreateICmpEQ(next, count), done, body);
  start(done);
}

// The pointer walks from the first wave's record to the end.
void Emitter::emit_wave_loop(V prim_record) {
  V stride = b_.getInt64(kernel_.wave_stride_bytes);
  V first = b_.CreateZExt(load_field(prim_record, offsetof(PrimRecord, first_wave), b_.getInt32Ty()), b_.getInt64Ty());
  V count = b_.CreateZExt(load_field(prim_record, offsetof(PrimRecord, wave_count), b_.getInt32Ty()), b_.getInt64Ty());
  V waves = b_.CreatePtrToInt(function_->getArg(5), b_.getInt64Ty());
  V begin = b_.CreateAdd(waves, b_.CreateMul(first, stride));
  llvm::BasicBlock *before = b_.GetInsertBlock(), *body = block("wave"), *next = block("wave.next"), *done = block("prim.next");
  b_.CreateCondBr(b_.CreateICmpEQ(count, b_.getInt64(0)), done, body);
  start(body);
  llvm::PHINode* remaining = b_.CreatePHI(b_.getInt64Ty(), 2, "remaining");
  llvm::PHINode* record = b_.CreatePHI(b_.getInt64Ty(), 2, "record");
  remaining->addIncoming(count, before);
  record->addIncoming(begin, before);
  wave_ptr_ = record;
  emit_wave(next);
  b_.CreateBr(next);
  start(next);
  V less = b_.CreateSub(remaining, b_.getInt64(1));
  remaining->addIncoming(less, next);
  record->addIncoming(b_.CreateAdd(record, stride), next);
  b_.CreateCondBr(b_.CreateICmpEQ(less, b_.getInt64(0)), done, body);
  start(done);
}

// Every kernel's wave record begins with its mask. Fragment waves always run all lanes (abi.h: exec_mask is 0xFFFF), as do those
// of most compute shaders, which is worth knowing: their stores and loads need no mask at the top level.
void Emitter::emit_wave(llvm::BasicBlock* skip) {
  exec_ = {};
  if (kernel_.kind != ir::KernelKind::kFragment && !kernel_.full_waves) {
    V bits = b_.CreateTrunc(load_at(b_.getInt32Ty(), wave_ptr_, false), b_.getInt16Ty());
    llvm::BasicBlock* run = block("run");
    b_.CreateCondBr(b_.CreateICmpEQ(bits, b_.getInt16(0)), skip, run);
    start(run);
    exec_.lanes = mask_from_bits(bits);
  }
  emit_insts(kernel_.wave);
  exec_ = {};
}

// ---- dispatch -------------------------------------------------------------------------------------------------------------

// LLVM's instruction selection and scheduling take more than linear time in the length of a block: 40,000 instructions in one
// took four times as long as 20,000 in two (pineda_fuzz scale).
void Emitter::split_long_block() {
  constexpr uint32_t kLongBlock = 1000;
  if (++insts_since_split_ < kLongBlock) return;
  insts_since_split_ = 0;
  llvm::BasicBlock* next = block("next");
  b_.CreateBr(next);
  start(next);
}

void Emitter::emit_insts(ir::RegionId region) {
  for (ir::Value v : kernel_.regions[region].insts) {
    if (!error_.empty()) return;
    split_long_block();
    const ir::Inst& inst = kernel_.at(v);
    if (V value = emit(inst, v)) value_[v.id] = shape(value, inst.rate == ir::Rate::kLane);
  }
}

// The value, or null for instructions that have none or set value_ themselves.
Emitter::V Emitter::emit(const ir::Inst& inst, ir::Value id) {
  switch (inst.op) {
    case Op::kLoad:
      return emit_load(inst);
    case Op::kStore:
      emit_store(inst);
      return nullptr;
    case Op::kAtomic:
      return emit_atomic(inst);
    case Op::kCall:
      emit_call(inst);
      return nullptr;
    case Op::kLocal:
      clear_local(id);
      return nullptr;
    case Op::kLocalLoad:
      return emit_local_load(inst);
    case Op::kLocalStore:
      emit_local_store(inst);
      return nullptr;
    case Op::kIf:
      emit_if(inst, id);
      return nullptr;
    case Op::kLoop:
      emit_loop(inst, id);
      return nullptr;
    case Op::kLoopArg:
    case Op::kYield:
    case Op::kResult:
      return nullptr;  // emit_loop and emit_if set their values
    case Op::kUnpackMask:
      return emit_unpack_mask(inst);
    case Op::kBallot:
      return emit_ballot(inst);
    case Op::kShuffle:
      return emit_shuffle(inst);
    case Op::kReduce:
      return emit_reduce(inst);
    case Op::kBarrier:
      return nullptr;  // emit_group_region splits the code there
    case Op::kQuadSwizzle:
      return emit_quad_swizzle(inst);
    case Op::kSelect:
      return select(get(inst.operand[0], is_lane(inst.operand[0])), arg(inst, 1), arg(inst, 2));
    case Op::kPtrAdd:
      return emit_ptr_add(inst);
    default:
      break;
  }
  if (inst.op >= Op::kConst && inst.op <= Op::kLane) return emit_source(inst);
  if (inst.op >= Op::kIAdd && inst.op <= Op::kSLe) return emit_int(inst);
  if (inst.op >= Op::kFAdd && inst.op <= Op::kFLe) return emit_float(inst);
  if (inst.op >= Op::kFToS && inst.op <= Op::kBitcast) return emit_convert(inst);
  return fail(std::string("the back end has no `") + ir::op_info(inst.op).name + "`: passes/lower_math replaces it",
              value_type(inst.type, inst.rate == ir::Rate::kLane));
}

Emitter::V Emitter::emit_source(const ir::Inst& inst) {
  switch (inst.op) {
    case Op::kConst:
      return emit_constant(inst);
    case Op::kDrawPtr:
      return draw_ptr_;
    case Op::kThreadPtr:
      return thread_ptr_;
    case Op::kPrimPtr:
      return prim_ptr_ != nullptr ? prim_ptr_ : fail("prim_ptr in the draw region", b_.getInt64Ty());
    case Op::kWavePtr:
      return wave_ptr_ != nullptr ? wave_ptr_ : fail("wave_ptr outside the wave region", b_.getInt64Ty());
    default:
      break;
  }
  std::vector<uint32_t> lanes(kLanes);
  for (uint32_t l = 0; l < kLanes; ++l) lanes[l] = l;
  return llvm::ConstantDataVector::get(context_, lanes);
}

Emitter::V Emitter::emit_constant(const ir::Inst& inst) {
  if (!ir::is_float(inst.type)) {
    return llvm::ConstantInt::get(element_type(inst.type), inst.imm);
  }
  const double value = std::bit_cast<double>(inst.imm);
  if (inst.type == Type::kF64) return llvm::ConstantFP::get(context_, llvm::APFloat(value));
  if (inst.type == Type::kF32) return llvm::ConstantFP::get(context_, llvm::APFloat(static_cast<float>(value)));
  return b_.getInt16(float_to_half(static_cast<float>(value)));
}

Emitter::V Emitter::emit_ptr_add(const ir::Inst& inst) {
  V base = arg(inst, 0), offset = arg(inst, 1);
  return b_.CreateAdd(base, b_.CreateZExt(offset, base->getType()));  // a no-op for i64
}

// handle->fn(handle, draw, thread, &one wave, 1, record)
void Emitter::emit_call(const ir::Inst& inst) {
  llvm::Type* ptr = b_.getPtrTy();
  V handle = b_.CreateIntToPtr(scalar(inst.operand[0]), ptr), record = b_.CreateIntToPtr(scalar(inst.operand[1]), ptr);
  if (one_wave_ == nullptr) {  // a PrimRecord: no primitive, waves [0, 1)
    llvm::Type* type = llvm::ArrayType::get(b_.getInt32Ty(), 4);
    llvm::Constant* words[4] = {b_.getInt32(0), b_.getInt32(0), b_.getInt32(0), b_.getInt32(1)};
    llvm::Constant* value = llvm::ConstantArray::get(llvm::cast<llvm::ArrayType>(type), words);
    one_wave_ = new llvm::GlobalVariable(module_, type, true, llvm::GlobalValue::PrivateLinkage, value);
    one_wave_->setAlignment(llvm::Align(8));
  }
  V fn = b_.CreateAlignedLoad(ptr, handle, llvm::Align(8));
  static_assert(offsetof(KernelHandle, fn) == 0 && sizeof(PrimRecord) == 16 && offsetof(PrimRecord, wave_count) == 12);
  b_.CreateCall(function_->getFunctionType(), fn,
                {handle, function_->getArg(1), function_->getArg(2), one_wave_, b_.getInt32(1), record});
}

Emitter::V Emitter::fail(const std::string& text, llvm::Type* type) {
  if (error_.empty()) error_ = "kernel " + kernel_.name + ": " + text;
  return type->isVoidTy() ? nullptr : llvm::Constant::getNullValue(type);
}

// ---- values ---------------------------------------------------------------------------------------------------------------

llvm::Type* Emitter::element_type(Type t) const {
  llvm::LLVMContext& c = context_;
  switch (t) {
    case Type::kVoid:
      return llvm::Type::getVoidTy(c);
    case Type::kB1:
      return llvm::Type::getInt1Ty(c);
    case Type::kI8:
      return llvm::Type::getInt8Ty(c);
    case Type::kI16:
    case Type::kF16:
      return llvm::Type::getInt16Ty(c);
    case Type::kI32:
      return llvm::Type::getInt32Ty(c);
    case Type::kI64:
    case Type::kPtr:
      return llvm::Type::getInt64Ty(c);
    case Type::kF32:
      return llvm::Type::getFloatTy(c);
    case Type::kF64:
      return llvm::Type::getDoubleTy(c);
  }
  return nullptr;
}

llvm::Type* Emitter::value_type(Type t, bool lane) const {
  if (!lane || t == Type::kVoid) return element_type(t);
  if (t == Type::kB1 && !features_.mask_registers) return lane_type(llvm::Type::getInt32Ty(context_));
  return lane_type(element_type(t));
}

Emitter::V Emitter::scalar(ir::Value v) {
  V value = value_[v.id];
  if (value != nullptr && !is_vector(value)) return value;
  return fail("instruction " + std::to_string(v.id) + " varies by lane where one value is needed (rates are wrong)",
              element_type(kernel_.at(v).type));
}

// A uniform value is broadcast where it is defined, once: outside the wave loop for draw and prim rate. Registers being few, such
// vectors are mostly spilled, and then a use costs a memory operand, where broadcasting at the use would cost a reload and a
// shuffle.
Emitter::V Emitter::vector(ir::Value v) {
  V value = value_[v.id];
  if (value == nullptr)
    return fail("instruction " + std::to_string(v.id) + " is used before it has a value", value_type(kernel_.at(v).type, true));
  if (is_vector(value)) return value;
  if (llvm::isa<llvm::Constant>(value)) return broadcast_value(value);
  V& splat = splat_[v.id];
  if (splat != nullptr) return splat;
  llvm::IRBuilderBase::InsertPointGuard guard(b_);
  if (auto* def = llvm::dyn_cast<llvm::Instruction>(value)) {
    llvm::BasicBlock* home = def->getParent();
    b_.SetInsertPoint(home, llvm::isa<llvm::PHINode>(def) ? home->getFirstNonPHIIt() : std::next(def->getIterator()));
  } else {
    b_.SetInsertPoint(entry_->getTerminator());
  }
  return splat = broadcast_value(value);
}

Emitter::V Emitter::broadcast_value(V scalar) {
  // An i1 goes to a mask register as it is. Not as a bitcast of its sign extension to i16: on an `or` of two such masks LLVM 19's
  // DAG combiner never ends.
  if (!scalar->getType()->isIntegerTy(1) || features_.mask_registers) return b_.CreateVectorSplat(kLanes, scalar);
  return b_.CreateVectorSplat(kLanes, b_.CreateSExt(scalar, b_.getInt32Ty()));
}

llvm::Type* Emitter::with_element(llvm::Type* like, llvm::Type* element) const {
  return like->isVectorTy() ? llvm::FixedVectorType::get(element, llvm::cast<llvm::FixedVectorType>(like)->getNumElements())
                            : element;
}

Emitter::V Emitter::int_const(llvm::Type* like, uint64_t bits) { return llvm::ConstantInt::get(like, bits); }
Emitter::V Emitter::float_const(llvm::Type* like, double value) { return llvm::ConstantFP::get(like, value); }

Emitter::V Emitter::load_field(V record, uint64_t offset_bytes, llvm::Type* type) {
  return b_.CreateAlignedLoad(type, b_.CreateConstGEP1_64(b_.getInt8Ty(), record, offset_bytes), llvm::Align(4));
}

llvm::BasicBlock* Emitter::block(const char* name) { return llvm::BasicBlock::Create(context_, name, function_); }

}  // namespace pineda::jit
