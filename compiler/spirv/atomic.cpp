// Atomics on 32-bit integers in storage buffers and Workgroup memory. Scopes and semantics need nothing more: the IR's atomics
// are sequentially consistent, and plain 32-bit loads and stores are atomic on every target.
#include "compiler/spirv/opcodes.h"

namespace pineda::spirv {
namespace {

using ir::AtomicOp;
using ir::Value;

Pointer atomic_pointer(Translator& t, const Instruction& inst, uint32_t word) {
  const Pointer p = t.pointer(inst, word);
  const bool memory = p.storage == spv::StorageClassStorageBuffer || p.storage == spv::StorageClassUniform ||
                      p.storage == spv::StorageClassWorkgroup;
  if (!memory) inst.fail("atomics need a storage buffer or Workgroup memory");
  if (t.m.type(p.pointee).kind != TypeKind::kInt) inst.fail("atomics need a 32-bit integer");
  if (p.storage == spv::StorageClassUniform && !t.is_writable(p)) inst.fail("uniform buffers cannot be written");
  return p;
}

void run(Translator& t, const Instruction& inst, AtomicOp op, Value value, Value comparand = {}) {
  const Pointer p = atomic_pointer(t, inst, 3);
  t.define(inst,
           Values{t.effect_value(ir::Type::kI32, [&] { return t.b.atomic(op, t.atomic_address(inst, p), value, comparand); })});
}

template <AtomicOp kOp>
void modify(Translator& t, const Instruction& inst) {
  run(t, inst, kOp, t.scalar(inst, 6, ir::Type::kI32));
}

template <uint32_t kAmount>
void step(Translator& t, const Instruction& inst) {
  run(t, inst, AtomicOp::kAdd, t.b.i32(kAmount));
}

void subtract(Translator& t, const Instruction& inst) {
  run(t, inst, AtomicOp::kAdd, t.b.isub(t.b.i32(0), t.scalar(inst, 6, ir::Type::kI32)));
}

void compare_exchange(Translator& t, const Instruction& inst) {
  run(t, inst, AtomicOp::kCompareExchange, t.scalar(inst, 7, ir::Type::kI32), t.scalar(inst, 8, ir::Type::kI32));
}

void atomic_load(Translator& t, const Instruction& inst) {
  const Pointer p = atomic_pointer(t, inst, 3);
  t.define(inst, Values{t.b.load(ir::Type::kI32, t.address(inst, p), ir::kVolatile)});
}

void atomic_store(Translator& t, const Instruction& inst) {
  const Pointer p = atomic_pointer(t, inst, 1);
  const Value value = t.scalar(inst, 4, ir::Type::kI32);
  t.effect([&] { t.b.store(t.address(inst, p), value); });
}

constexpr OpRow kRows[] = {
    PINEDA_SPIRV_ROW(AtomicLoad, 6, atomic_load),
    PINEDA_SPIRV_ROW(AtomicStore, 5, atomic_store),
    PINEDA_SPIRV_ROW(AtomicExchange, 7, modify<AtomicOp::kExchange>),
    PINEDA_SPIRV_ROW(AtomicCompareExchange, 9, compare_exchange),
    PINEDA_SPIRV_ROW(AtomicIIncrement, 6, step<1>),
    PINEDA_SPIRV_ROW(AtomicIDecrement, 6, step<~0u>),
    PINEDA_SPIRV_ROW(AtomicIAdd, 7, modify<AtomicOp::kAdd>),
    PINEDA_SPIRV_ROW(AtomicISub, 7, subtract),
    PINEDA_SPIRV_ROW(AtomicSMin, 7, modify<AtomicOp::kSMin>),
    PINEDA_SPIRV_ROW(AtomicUMin, 7, modify<AtomicOp::kUMin>),
    PINEDA_SPIRV_ROW(AtomicSMax, 7, modify<AtomicOp::kSMax>),
    PINEDA_SPIRV_ROW(AtomicUMax, 7, modify<AtomicOp::kUMax>),
    PINEDA_SPIRV_ROW(AtomicAnd, 7, modify<AtomicOp::kAnd>),
    PINEDA_SPIRV_ROW(AtomicOr, 7, modify<AtomicOp::kOr>),
    PINEDA_SPIRV_ROW(AtomicXor, 7, modify<AtomicOp::kXor>),
};

}  // namespace

std::span<const OpRow> atomic_rows() { return kRows; }

}  // namespace pineda::spirv
