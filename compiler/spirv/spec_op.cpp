// OpSpecConstantOp: the operations that SPIR-V 3.32.7 allows under the Shader capability, folded with the same definitions as the
// IR's (division by zero and shift counts as in compiler/ir/ops.inc).
#include <limits>

#include "compiler/spirv/module.h"

namespace pineda::spirv {
namespace {

int32_t as_signed(uint32_t v) { return static_cast<int32_t>(v); }

uint32_t signed_divide(uint32_t a, uint32_t b) {
  if (b == 0) return ~0u;
  if (b == ~0u) return 0u - a;  // INT_MIN / -1 wraps
  return static_cast<uint32_t>(as_signed(a) / as_signed(b));
}

uint32_t signed_remainder(uint32_t a, uint32_t b) {
  if (b == 0) return a;
  if (b == ~0u) return 0;
  return static_cast<uint32_t>(as_signed(a) % as_signed(b));
}

uint32_t signed_modulo(uint32_t a, uint32_t b) {
  const uint32_t r = signed_remainder(a, b);
  return r != 0 && as_signed(r ^ b) < 0 ? r + b : r;
}

std::optional<uint32_t> fold_unary(spv::Op op, uint32_t a) {
  switch (op) {
    case spv::OpSConvert:
    case spv::OpUConvert:
      return a;  // 32 bits to 32 bits
    case spv::OpSNegate:
      return 0u - a;
    case spv::OpNot:
      return ~a;
    case spv::OpLogicalNot:
      return a == 0;
    default:
      return std::nullopt;
  }
}

std::optional<uint32_t> fold_binary(spv::Op op, uint32_t a, uint32_t b) {
  switch (op) {
    case spv::OpIAdd:
      return a + b;
    case spv::OpISub:
      return a - b;
    case spv::OpIMul:
      return a * b;
    case spv::OpUDiv:
      return b == 0 ? ~0u : a / b;
    case spv::OpSDiv:
      return signed_divide(a, b);
    case spv::OpUMod:
      return b == 0 ? a : a % b;
    case spv::OpSRem:
      return signed_remainder(a, b);
    case spv::OpSMod:
      return signed_modulo(a, b);
    case spv::OpShiftRightLogical:
      return a >> (b & 31);
    case spv::OpShiftRightArithmetic:
      return static_cast<uint32_t>(as_signed(a) >> (b & 31));
    case spv::OpShiftLeftLogical:
      return a << (b & 31);
    case spv::OpBitwiseOr:
    case spv::OpLogicalOr:
      return a | b;
    case spv::OpBitwiseAnd:
    case spv::OpLogicalAnd:
      return a & b;
    case spv::OpBitwiseXor:
      return a ^ b;
    case spv::OpLogicalEqual:
    case spv::OpIEqual:
      return a == b;
    case spv::OpLogicalNotEqual:
    case spv::OpINotEqual:
      return a != b;
    case spv::OpULessThan:
      return a < b;
    case spv::OpULessThanEqual:
      return a <= b;
    case spv::OpUGreaterThan:
      return a > b;
    case spv::OpUGreaterThanEqual:
      return a >= b;
    case spv::OpSLessThan:
      return as_signed(a) < as_signed(b);
    case spv::OpSLessThanEqual:
      return as_signed(a) <= as_signed(b);
    case spv::OpSGreaterThan:
      return as_signed(a) > as_signed(b);
    case spv::OpSGreaterThanEqual:
      return as_signed(a) >= as_signed(b);
    default:
      return std::nullopt;
  }
}

struct Folder {
  const Module& m;
  const Instruction& inst;

  const Constant& constant(uint32_t word) const {
    const Constant* c = m.constant(inst.word(word));
    if (!c) inst.fail("operand " + std::to_string(word) + " is not a constant");
    return *c;
  }

  std::vector<uint32_t> scalars(uint32_t word) const {
    const Constant& c = constant(word);
    if (!c.scalars.empty()) return c.scalars;
    return std::vector<uint32_t>(m.flat_scalars(c.type).size(), 0);  // a null constant
  }

  // First scalar and type of the part that the literal indices from `word` on name.
  std::pair<uint64_t, uint32_t> part(uint32_t type_id, uint32_t word) const {
    uint64_t first = 0;
    for (uint32_t index : inst.from(word)) {
      const Type& t = m.type(type_id);
      const bool is_struct = t.kind == TypeKind::kStruct;
      if (t.is_scalar() || index >= (is_struct ? t.members.size() : t.count)) inst.fail("an index is out of range");
      type_id = is_struct ? t.members[index] : t.element;
      first += is_struct ? t.first_scalar[index] : index * m.type(type_id).scalar_count;
    }
    return {first, type_id};
  }

  std::vector<uint32_t> extract() const {
    const auto [first, type] = part(constant(4).type, 5);
    const std::vector<uint32_t> all = scalars(4);
    return {all.begin() + first, all.begin() + first + m.type(type).scalar_count};
  }

  std::vector<uint32_t> insert() const {
    const std::vector<uint32_t> object = scalars(4);
    std::vector<uint32_t> all = scalars(5);
    const auto [first, type] = part(constant(5).type, 6);
    if (object.size() != m.type(type).scalar_count) inst.fail("the object does not fit");
    std::copy(object.begin(), object.end(), all.begin() + first);
    return all;
  }

  std::vector<uint32_t> shuffle() const {
    std::vector<uint32_t> both = scalars(4);
    const std::vector<uint32_t> second = scalars(5);
    both.insert(both.end(), second.begin(), second.end());
    std::vector<uint32_t> out;
    for (uint32_t index : inst.from(6)) {
      if (index != ~0u && index >= both.size()) inst.fail("a component is out of range");
      out.push_back(index == ~0u ? 0 : both[index]);
    }
    return out;
  }

  std::vector<uint32_t> select() const {
    const std::vector<uint32_t> cond = scalars(4), a = scalars(5), b = scalars(6);
    if (a.size() != b.size() || (cond.size() != 1 && cond.size() != a.size())) inst.fail("operand sizes differ");
    std::vector<uint32_t> out;
    for (size_t i = 0; i < a.size(); ++i) out.push_back(cond[cond.size() == 1 ? 0 : i] ? a[i] : b[i]);
    return out;
  }

  std::vector<uint32_t> elementwise(spv::Op op) const {
    if (const Type& t = m.type(inst.word(1)); t.scalar == ir::Type::kF32) inst.fail("float arithmetic is not allowed here");
    const std::vector<uint32_t> a = scalars(4);
    std::vector<uint32_t> out;
    if (inst.size() == 5) {
      for (uint32_t v : a) {
        const auto r = fold_unary(op, v);
        if (!r) inst.fail(op_name(op) + " cannot be folded");
        out.push_back(*r);
      }
      return out;
    }
    const std::vector<uint32_t> b = scalars(5);
    if (a.size() != b.size() || inst.size() != 6) inst.fail("operand sizes differ");
    for (size_t i = 0; i < a.size(); ++i) {
      const auto r = fold_binary(op, a[i], b[i]);
      if (!r) inst.fail(op_name(op) + " cannot be folded");
      out.push_back(*r);
    }
    return out;
  }

  std::vector<uint32_t> run() const {
    const auto op = inst.word_as<spv::Op>(3);
    switch (op) {
      case spv::OpCompositeExtract:
        return extract();
      case spv::OpCompositeInsert:
        return insert();
      case spv::OpVectorShuffle:
        return shuffle();
      case spv::OpSelect:
        return select();
      default:
        return elementwise(op);
    }
  }
};

}  // namespace

Constant fold_spec_op(const Module& m, const Instruction& inst) {
  inst.word(4);  // every operation has an operand
  Constant c{.type = inst.word(1), .scalars = Folder{m, inst}.run()};
  const std::vector<ir::Type> wanted = m.flat_scalars(c.type);
  if (c.scalars.size() != wanted.size()) inst.fail("the result does not have its type's size");
  for (size_t i = 0; i < wanted.size(); ++i) {
    if (wanted[i] == ir::Type::kB1) c.scalars[i] = c.scalars[i] != 0;
  }
  return c;
}

}  // namespace pineda::spirv
