// Atomics on 32- and 64-bit numbers in storage buffers, Workgroup memory and storage images. Scopes and semantics need nothing
// more: the IR's atomics are sequentially consistent, and plain aligned loads and stores are atomic on every target.
//
// Floats: in which order the invocations of several waves add is not determined, so their sum's last bits depend on it as on any
// other race of the application; within a wave lanes add in ascending order.
#include "compiler/spirv/opcodes.h"

namespace pineda::spirv {
namespace {

using ir::AtomicOp;
using ir::Type;
using ir::Value;

struct Target {
  Pointer pointer;
  Type type;  // of the number
  Type bits;  // the integer of its size, which the IR's atomics take
};

enum class Numbers : uint8_t { kIntegers, kFloats, kBoth };

bool has_atomics(Translator& t, const Pointer& p) {
  switch (p.storage) {
    case spv::StorageClassStorageBuffer:
    case spv::StorageClassPhysicalStorageBuffer:
    case spv::StorageClassWorkgroup:
    case spv::StorageClassImage:
      return true;
    case spv::StorageClassUniform:
      return t.is_writable(p);
    default:
      return false;
  }
}

Target target(Translator& t, const Instruction& inst, uint32_t word, Numbers numbers) {
  const Pointer p = t.pointer(inst, word);
  if (!has_atomics(t, p)) inst.fail("atomics need a storage buffer, a storage image or Workgroup memory");
  const auto& pointee = t.m.type(p.pointee);
  const bool is_int = pointee.kind == TypeKind::kInt, is_float = pointee.kind == TypeKind::kFloat;
  const uint32_t size_bytes = is_int || is_float ? ir::size_bytes(pointee.scalar) : 0;
  if (size_bytes != 4 && size_bytes != 8) inst.fail("atomics need a number of 32 or 64 bits");
  if (is_int && numbers == Numbers::kFloats) inst.fail("needs a float");
  if (is_float && numbers == Numbers::kIntegers) inst.fail("needs an integer");
  return {p, pointee.scalar, size_bytes == 4 ? Type::kI32 : Type::kI64};
}

// An operand of the target's type, as bits.
Value operand(Translator& t, const Instruction& inst, uint32_t word, const Target& target) {
  return t.b.bitcast(target.bits, t.scalar(inst, word, target.type));
}

void run(Translator& t, const Instruction& inst, const Target& target, AtomicOp op, Value value, Value comparand = {}) {
  // The waves of a workgroup run one after the other on one thread.
  const uint8_t flags = target.pointer.storage == spv::StorageClassWorkgroup ? ir::kPrivate : 0;
  const Value old = t.effect_value(
      target.bits, [&] { return t.b.atomic(op, t.atomic_address(inst, target.pointer), value, comparand, flags); });
  t.define(inst, Values{t.b.bitcast(target.type, old)});
}

template <AtomicOp kOp, Numbers kNumbers = Numbers::kIntegers>
void modify(Translator& t, const Instruction& inst) {
  const Target at = target(t, inst, 3, kNumbers);
  run(t, inst, at, kOp, operand(t, inst, 6, at));
}

template <int kAmount>
void step(Translator& t, const Instruction& inst) {
  const Target at = target(t, inst, 3, Numbers::kIntegers);
  run(t, inst, at, AtomicOp::kAdd,
      at.bits == Type::kI32 ? t.b.i32(static_cast<uint32_t>(kAmount)) : t.b.i64(uint64_t(int64_t{kAmount})));
}

void subtract(Translator& t, const Instruction& inst) {
  const Target at = target(t, inst, 3, Numbers::kIntegers);
  run(t, inst, at, AtomicOp::kAdd, t.b.isub(t.b.zero(at.bits), operand(t, inst, 6, at)));
}

void compare_exchange(Translator& t, const Instruction& inst) {
  const Target at = target(t, inst, 3, Numbers::kIntegers);
  run(t, inst, at, AtomicOp::kCompareExchange, operand(t, inst, 7, at), operand(t, inst, 8, at));
}

void atomic_load(Translator& t, const Instruction& inst) {
  const Target at = target(t, inst, 3, Numbers::kBoth);
  t.define(inst, Values{t.b.load(at.type, t.atomic_address(inst, at.pointer), ir::kVolatile)});
}

void atomic_store(Translator& t, const Instruction& inst) {
  const Target at = target(t, inst, 1, Numbers::kBoth);
  const Value value = t.scalar(inst, 4, at.type);
  t.effect([&] { t.b.store(t.atomic_address(inst, at.pointer), value); });
}

constexpr OpRow kRows[] = {
    PINEDA_SPIRV_ROW(AtomicLoad, 6, atomic_load),
    PINEDA_SPIRV_ROW(AtomicStore, 5, atomic_store),
    PINEDA_SPIRV_ROW(AtomicExchange, 7, modify<AtomicOp::kExchange, Numbers::kBoth>),
    PINEDA_SPIRV_ROW(AtomicCompareExchange, 9, compare_exchange),
    PINEDA_SPIRV_ROW(AtomicIIncrement, 6, step<1>),
    PINEDA_SPIRV_ROW(AtomicIDecrement, 6, step<-1>),
    PINEDA_SPIRV_ROW(AtomicIAdd, 7, modify<AtomicOp::kAdd>),
    PINEDA_SPIRV_ROW(AtomicISub, 7, subtract),
    PINEDA_SPIRV_ROW(AtomicSMin, 7, modify<AtomicOp::kSMin>),
    PINEDA_SPIRV_ROW(AtomicUMin, 7, modify<AtomicOp::kUMin>),
    PINEDA_SPIRV_ROW(AtomicSMax, 7, modify<AtomicOp::kSMax>),
    PINEDA_SPIRV_ROW(AtomicUMax, 7, modify<AtomicOp::kUMax>),
    PINEDA_SPIRV_ROW(AtomicAnd, 7, modify<AtomicOp::kAnd>),
    PINEDA_SPIRV_ROW(AtomicOr, 7, modify<AtomicOp::kOr>),
    PINEDA_SPIRV_ROW(AtomicXor, 7, modify<AtomicOp::kXor>),
    PINEDA_SPIRV_ROW(AtomicFAddEXT, 7, modify<AtomicOp::kFAdd, Numbers::kFloats>),
};

}  // namespace

std::span<const OpRow> atomic_rows() { return kRows; }

}  // namespace pineda::spirv
