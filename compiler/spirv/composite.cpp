// Composites: since values are flat lists of scalars, these instructions only move them.
#include <algorithm>

#include "compiler/spirv/opcodes.h"

namespace pineda::spirv {
namespace {

using ir::Value;

struct Part {
  uint64_t first = 0;
  uint32_t type = 0;
};

// The part of a composite that literal indices name.
Part find_part(Translator& t, const Instruction& inst, uint32_t type_id, std::span<const uint32_t> indices) {
  Part part{.type = type_id};
  for (uint32_t index : indices) {
    const Type& type = t.m.type(part.type);
    const bool is_struct = type.kind == TypeKind::kStruct;
    if (type.is_scalar() || index >= (is_struct ? type.members.size() : type.count)) inst.fail("an index is out of range");
    part.type = is_struct ? type.members[index] : type.element;
    part.first += is_struct ? type.first_scalar[index] : index * t.m.type(part.type).scalar_count;
  }
  return part;
}

void composite_construct(Translator& t, const Instruction& inst) {
  Values out;
  for (uint32_t word = 3; word < inst.size(); ++word) {
    const Values part = t.values(inst, word);
    if (out.size() + part.size() > kMaxFlatScalars) inst.fail("the composite is too large");
    out.insert(out.end(), part.begin(), part.end());
  }
  t.define(inst, std::move(out));
}

void composite_extract(Translator& t, const Instruction& inst) {
  const Values all = t.values(inst, 3);
  const Part part = find_part(t, inst, t.type_of(inst, 3).id, inst.from(4));
  t.define(inst, Values(all.begin() + part.first, all.begin() + part.first + t.m.type(part.type).scalar_count));
}

void composite_insert(Translator& t, const Instruction& inst) {
  const Values object = t.values(inst, 3);
  Values all = t.values(inst, 4);
  const Part part = find_part(t, inst, t.type_of(inst, 4).id, inst.from(5));
  if (object.size() != t.m.type(part.type).scalar_count) inst.fail("the object does not fit");
  std::ranges::copy(object, all.begin() + part.first);
  t.define(inst, std::move(all));
}

void vector_shuffle(Translator& t, const Instruction& inst) {
  Values both = t.values(inst, 3);
  const Values second = t.values(inst, 4);
  if (t.type_of(inst, 3).kind != TypeKind::kVector || t.type_of(inst, 4).kind != TypeKind::kVector)
    inst.fail("needs two vectors");
  both.insert(both.end(), second.begin(), second.end());
  Values out;
  for (uint32_t index : inst.from(5)) {
    if (index != ~0u && index >= both.size()) inst.fail("a component is out of range");
    out.push_back(both[index == ~0u ? 0 : index]);  // ~0: undefined
  }
  t.define(inst, std::move(out));
}

// An index out of range gives an undefined value: here the last component, or no change.
void vector_extract_dynamic(Translator& t, const Instruction& inst) {
  const Values v = t.values(inst, 3);
  if (t.type_of(inst, 3).kind != TypeKind::kVector) inst.fail("needs a vector");
  const Value index = t.index(inst, 4);
  Value out = v.back();
  for (uint32_t i = static_cast<uint32_t>(v.size()) - 1; i-- > 0;) out = t.b.select(t.b.ieq(index, t.b.i32(i)), v[i], out);
  t.define(inst, Values{out});
}

void vector_insert_dynamic(Translator& t, const Instruction& inst) {
  Values v = t.values(inst, 3);
  if (t.type_of(inst, 3).kind != TypeKind::kVector) inst.fail("needs a vector");
  const Value component = t.scalar(inst, 4, t.b.type(v[0])), index = t.index(inst, 5);
  for (uint32_t i = 0; i < v.size(); ++i) v[i] = t.b.select(t.b.ieq(index, t.b.i32(i)), component, v[i]);
  t.define(inst, std::move(v));
}

void undef(Translator& t, const Instruction& inst) {
  Values out;
  for (ir::Type type : t.m.flat_scalars(inst.word(1))) out.push_back(t.b.zero(type));
  t.define(inst, std::move(out));
}

// Types that match logically flatten to the same list.
void copy_logical(Translator& t, const Instruction& inst) { t.define(inst, t.values(inst, 3)); }

constexpr OpRow kRows[] = {
    PINEDA_SPIRV_ROW(CompositeConstruct, 3, composite_construct),
    PINEDA_SPIRV_ROW(CompositeExtract, 4, composite_extract),
    PINEDA_SPIRV_ROW(CompositeInsert, 5, composite_insert),
    PINEDA_SPIRV_ROW(VectorShuffle, 5, vector_shuffle),
    PINEDA_SPIRV_ROW(VectorExtractDynamic, 5, vector_extract_dynamic),
    PINEDA_SPIRV_ROW(VectorInsertDynamic, 6, vector_insert_dynamic),
    PINEDA_SPIRV_ROW(Undef, 3, undef),
    PINEDA_SPIRV_ROW(CopyObject, 4, [](Translator& t, const Instruction& inst) { t.alias(inst, 3); }),
    PINEDA_SPIRV_ROW(CopyLogical, 4, copy_logical),
};

}  // namespace

std::span<const OpRow> composite_rows() { return kRows; }

}  // namespace pineda::spirv
