// Constants, with specialization applied: afterwards a specialization constant is a constant.
#include <algorithm>
#include <cstring>

#include "compiler/spirv/module.h"

namespace pineda::spirv {
namespace {

// The value given for this constant's SpecId, or `fallback`. A bool is a VkBool32.
uint64_t specialised(const Module& m, const Instruction& inst, const Type& type, uint64_t fallback,
                     std::span<const SpecializationConstant> specialization) {
  const std::optional<uint32_t> spec_id = m.decorations_of(inst.word(2)).spec_id;
  if (!spec_id) return fallback;
  for (const SpecializationConstant& s : specialization) {
    if (s.id != *spec_id) continue;
    if (s.bytes.size() != type.natural_bytes) {
      inst.fail("the specialization of SpecId " + std::to_string(s.id) + " must have " + std::to_string(type.natural_bytes) +
                " bytes");
    }
    uint64_t bits = 0;
    std::memcpy(&bits, s.bytes.data(), s.bytes.size());
    return type.kind == TypeKind::kBool ? bits != 0 : bits;
  }
  return fallback;
}

// The literal of OpConstant: low word first; narrow numbers are sign- or zero-extended to a word (SPIR-V 2.2.1, "Literal").
uint64_t literal(const Instruction& inst, const Type& type) {
  const uint32_t size_bytes = ir::size_bytes(type.scalar);
  const uint64_t low = inst.word(3);
  if (size_bytes == 8) return low | uint64_t{inst.word(4)} << 32;
  return low & ((1ull << 8 * size_bytes) - 1);
}

Constant composite(const Module& m, const Instruction& inst, const Type& type) {
  Constant c{.type = type.id};
  for (uint32_t id : inst.from(3)) {
    const Constant* part = m.constant(id);
    if (!part) inst.fail("%" + std::to_string(id) + " is not a constant");
    const uint64_t count = m.type(part->type).scalar_count;
    if (c.scalars.size() + count > kMaxFlatScalars) inst.fail("the constant has more than 16384 scalars");
    if (part->scalars.empty())
      c.scalars.resize(c.scalars.size() + count, 0);
    else
      c.scalars.insert(c.scalars.end(), part->scalars.begin(), part->scalars.end());
  }
  return c;
}

// What the parts of a composite must be, in order.
void check_parts(const Module& m, const Instruction& inst, const Type& type) {
  const uint32_t parts = inst.size() - 3;
  const uint32_t wanted = type.kind == TypeKind::kStruct ? static_cast<uint32_t>(type.members.size()) : type.count;
  if (parts != wanted) inst.fail("has " + std::to_string(parts) + " parts instead of " + std::to_string(wanted));
  for (uint32_t i = 0; i < parts; ++i) {
    const Constant* part = m.constant(inst.word(3 + i));
    const uint32_t part_type = type.kind == TypeKind::kStruct ? type.members[i] : type.element;
    if (!part || part->type != part_type) inst.fail("part " + std::to_string(i) + " has the wrong type");
  }
}

}  // namespace

void declare_constant(Module& m, const Instruction& inst, std::span<const SpecializationConstant> specialization) {
  const Type& type = m.type(inst.word(1));
  if (!type.is_value) {
    if (inst.op() == spv::OpUndef || inst.op() == spv::OpConstantNull) return;  // an error only where it is used
    inst.fail("the type cannot be a constant");
  }
  Constant c{.type = type.id};
  switch (inst.op()) {
    case spv::OpConstantTrue:
    case spv::OpConstantFalse:
    case spv::OpSpecConstantTrue:
    case spv::OpSpecConstantFalse: {
      if (type.kind != TypeKind::kBool) inst.fail("the type is not bool");
      const bool value = inst.op() == spv::OpConstantTrue || inst.op() == spv::OpSpecConstantTrue;
      c.scalars = {specialised(m, inst, type, value, specialization)};
      break;
    }
    case spv::OpConstant:
    case spv::OpSpecConstant:
      if (type.kind != TypeKind::kInt && type.kind != TypeKind::kFloat) inst.fail("the type is not a number");
      c.scalars = {specialised(m, inst, type, literal(inst, type), specialization)};
      break;
    case spv::OpConstantComposite:
    case spv::OpSpecConstantComposite:
      check_parts(m, inst, type);
      c = composite(m, inst, type);
      break;
    case spv::OpConstantNull:
    case spv::OpUndef:
      break;
    case spv::OpSpecConstantOp:
      c = fold_spec_op(m, inst);
      break;
    default:
      inst.fail("this constant is not supported");
  }
  if (type.scalar_count > kMaxFlatScalars) inst.fail("the constant has more than 16384 scalars");
  c.is_spec = inst.op() >= spv::OpSpecConstantTrue && inst.op() <= spv::OpSpecConstantOp;
  m.constant_scalars += static_cast<uint32_t>(c.scalars.size());
  if (m.constant_scalars > kMaxConstantScalars) inst.fail("the module's constants have more than a million scalars");
  m.constants[inst.word(2)] = std::move(c);
}

}  // namespace pineda::spirv
