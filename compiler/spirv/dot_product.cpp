// Integer dot products (SPV_KHR_integer_dot_product). Components are extended to the result's width; sums wrap, but for the last
// addition of the *AccSat forms.
#include "compiler/spirv/opcodes.h"

namespace pineda::spirv {
namespace {

using ir::Op;
using ir::Type;
using ir::Value;

Value resize(Translator& t, Value v, Type to, bool is_signed) {
  if (t.b.type(v) == to) return v;
  if (ir::size_bytes(to) < ir::size_bytes(t.b.type(v))) return t.b.convert(Op::kTrunc, to, v);
  return t.b.convert(is_signed ? Op::kSExt : Op::kZExt, to, v);
}

// A vector, or four 8-bit components packed in a 32-bit scalar, the first one lowest.
Values components(Translator& t, const Instruction& inst, uint32_t word, bool is_packed) {
  const Values v = t.integers(inst, word);
  if (!is_packed) {
    if (v.size() < 2) inst.fail("a scalar operand needs a packed vector format");
    return v;
  }
  if (v.size() != 1 || t.b.type(v[0]) != Type::kI32) inst.fail("a packed operand must be a 32-bit integer");
  Values out;
  for (uint32_t i = 0; i < 4; ++i) out.push_back(t.b.convert(Op::kTrunc, Type::kI8, t.b.lshr(v[0], t.b.i32(8 * i))));
  return out;
}

Value saturating_add(Translator& t, Value a, Value c, bool is_signed) {
  const Type type = t.b.type(a);
  const Value sum = t.b.iadd(a, c);
  if (!is_signed) return t.b.select(t.b.ult(sum, a), t.b.constant(type, ~0ull), sum);
  const uint64_t sign = 1ull << (8 * ir::size_bytes(type) - 1);
  const Value zero = t.b.zero(type);
  const Value overflows = t.b.slt(t.b.and_(t.b.xor_(a, sum), t.b.xor_(c, sum)), zero);
  const Value limit = t.b.select(t.b.slt(c, zero), t.b.constant(type, sign), t.b.constant(type, sign - 1));
  return t.b.select(overflows, limit, sum);
}

template <bool kFirstSigned, bool kSecondSigned, bool kAccumulates>
void dot(Translator& t, const Instruction& inst) {
  constexpr uint32_t kFormat = kAccumulates ? 6 : 5;  // the word of the optional packed vector format
  const bool is_packed = inst.size() > kFormat;
  if (is_packed && inst.word(kFormat) != spv::PackedVectorFormatPackedVectorFormat4x8Bit) inst.fail("unknown vector format");
  const Values a = components(t, inst, 3, is_packed), c = components(t, inst, 4, is_packed);
  if (a.size() != c.size() || t.b.type(a[0]) != t.b.type(c[0])) inst.fail("the operands have different types");
  const pineda::spirv::Type& result = t.result_type(inst);
  if (result.kind != TypeKind::kInt || ir::size_bytes(result.scalar) < ir::size_bytes(t.b.type(a[0]))) {
    inst.fail("the result must be an integer at least as wide as the components");
  }
  Value sum;
  for (size_t i = 0; i < a.size(); ++i) {
    const Value product = t.b.imul(resize(t, a[i], result.scalar, kFirstSigned), resize(t, c[i], result.scalar, kSecondSigned));
    sum = sum ? t.b.iadd(sum, product) : product;
  }
  if (kAccumulates) sum = saturating_add(t, sum, t.scalar(inst, 5, result.scalar), kFirstSigned);
  t.define(inst, Values{sum});
}

constexpr OpRow kRows[] = {
    PINEDA_SPIRV_ROW(SDot, 5, dot<true, true, false>),        PINEDA_SPIRV_ROW(UDot, 5, dot<false, false, false>),
    PINEDA_SPIRV_ROW(SUDot, 5, dot<true, false, false>),      PINEDA_SPIRV_ROW(SDotAccSat, 6, dot<true, true, true>),
    PINEDA_SPIRV_ROW(UDotAccSat, 6, dot<false, false, true>), PINEDA_SPIRV_ROW(SUDotAccSat, 6, dot<true, false, true>),
};

}  // namespace

std::span<const OpRow> dot_product_rows() { return kRows; }

}  // namespace pineda::spirv
