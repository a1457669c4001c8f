// Pointers that are values: variable pointers and physical addresses (Translator, "pointers").
#include "base/abi.h"
#include "compiler/spirv/translator.h"

namespace pineda::spirv {

// kPointerScalars, or the address.
Values Translator::pointer_values(const Instruction& inst, uint32_t word) {
  const Pointer p = pointer(inst, word);
  if (p.component_stride_bytes != 0) inst.fail("a pointer into a row-major matrix cannot be a value");
  const ir::Address at = address(inst, p);
  const ir::Value base = b.bitcast(ir::Type::kI64, at.base);
  if (p.storage != spv::StorageClassPhysicalStorageBuffer) return {base, at.limit, at.offset};
  return {b.iadd(base, b.convert(ir::Op::kZExt, ir::Type::kI64, at.offset))};
}

Pointer Translator::pointer_from_values(const Instruction& inst, uint32_t word) {
  const uint32_t id = inst.word(word);
  const Type& type = m.type(m.type_of(id));
  if (type.kind != TypeKind::kPointer) inst.fail("%" + std::to_string(id) + " is not a pointer");
  Pointer p{.type = type.id, .pointee = type.element, .storage = type.storage, .index_alignment_bytes = 1};
  Values v;
  if (type.storage == spv::StorageClassPhysicalStorageBuffer) {
    Record* r = m.constant(id) ? nullptr : &record(inst, id);
    if (r && !r->resolved.empty() && is_open(r->resolved_region)) {
      v = r->resolved;
    } else {
      v = resolve_address(inst, values(inst, word)[0]);
      if (r) r->resolved = v, r->resolved_region = b.region();
    }
  } else {
    v = values(inst, word);
    v[0] = b.bitcast(ir::Type::kPtr, v[0]);
  }
  p.base = v[0];
  p.size_bytes = v[1];
  p.index = v[2];
  return p;
}

// Finds the range that holds the address by bisection: base, size and offset. An address outside of all gets the size zero, so
// that every access through it is out of bounds.
Values Translator::resolve_address(const Instruction& inst, ir::Value address) {
  const auto [table, count] = stage.address_ranges(b);
  if (!table) inst.fail("PhysicalStorageBuffer pointers are not available here");
  const ir::Value table_bytes = b.imul(count, b.i32(sizeof(AddressRange)));
  const auto field = [&](ir::Type type, ir::Value entry, size_t offset_bytes) {
    const ir::Value offset = b.iadd(b.imul(entry, b.i32(sizeof(AddressRange))), b.i32(static_cast<uint32_t>(offset_bytes)));
    return b.load(type, {.base = table, .offset = offset, .limit = table_bytes}, ir::kInvariant | ir::kSpeculate);
  };
  // The entry wanted is among `length` entries from `first` on; the addresses ascend.
  const auto out = b.loop({b.i32(0), count}, [&](std::span<const ir::Value> carried) {
    const ir::Value first = carried[0], length = carried[1];
    const ir::Value half = b.lshr(length, b.i32(1)), middle = b.iadd(first, half);
    const ir::Value is_above = b.ule(field(ir::Type::kI64, middle, offsetof(AddressRange, address)), address);
    const ir::Value rest = b.isub(length, half);
    return ir::Builder::LoopStep{b.ult(b.i32(1), rest), {b.select(is_above, middle, first), rest}};
  });
  const ir::Value start = field(ir::Type::kI64, out[0], offsetof(AddressRange, address));
  const ir::Value size = field(ir::Type::kI32, out[0], offsetof(AddressRange, size_bytes));
  const ir::Value offset = b.isub(address, start);  // wraps to a huge number for an address below
  const ir::Value inside = b.ult(offset, b.convert(ir::Op::kZExt, ir::Type::kI64, size));
  return {b.bitcast(ir::Type::kPtr, b.select(inside, start, address)), b.select(inside, size, b.i32(0)),
          b.select(inside, b.convert(ir::Op::kTrunc, ir::Type::kI32, offset), b.i32(0))};
}

}  // namespace pineda::spirv
