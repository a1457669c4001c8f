// Linear algebra on flattened matrices: component r of column c is scalar c * rows + r. Sums run left to right, so that fuse_fma
// sees one fixed shape everywhere.
#include "compiler/spirv/opcodes.h"

namespace pineda::spirv {
namespace {

using ir::Value;

struct Matrix {
  Values v;
  uint32_t rows = 0, columns = 0;
  std::span<const Value> column(uint32_t c) const { return std::span(v).subspan(size_t{c} * rows, rows); }
  Values row(uint32_t r) const {
    Values out;
    for (uint32_t c = 0; c < columns; ++c) out.push_back(v[size_t{c} * rows + r]);
    return out;
  }
};

Matrix matrix(Translator& t, const Instruction& inst, uint32_t word) {
  const Type& type = t.type_of(inst, word);
  if (type.kind != TypeKind::kMatrix) inst.fail("%" + std::to_string(inst.word(word)) + " is not a matrix");
  return {.v = t.values(inst, word), .rows = t.m.type(type.element).count, .columns = type.count};
}

// The float vector at `word`, with the component type of the other operand.
Values vector(Translator& t, const Instruction& inst, uint32_t word, size_t size) {
  Values v = t.floats(inst, word);
  if (t.b.type(v[0]) != t.component_of(t.type_of(inst, word == 3 ? 4 : 3))) inst.fail("the operands have different types");
  if (v.size() != size)
    inst.fail("%" + std::to_string(inst.word(word)) + " does not have " + std::to_string(size) + " components");
  return v;
}

void dot(Translator& t, const Instruction& inst) {
  const Values a = t.floats(inst, 3);
  t.define(inst, Values{t.dot(a, vector(t, inst, 4, a.size()))});
}

void times_scalar(Translator& t, const Instruction& inst) {
  Values v = t.type_of(inst, 3).kind == TypeKind::kMatrix ? matrix(t, inst, 3).v : t.floats(inst, 3);
  const Value s = t.scalar(inst, 4, t.b.type(v[0]));
  for (Value& x : v) x = t.fmul(x, s);
  t.define(inst, std::move(v));
}

Values product(Translator& t, const Matrix& m, std::span<const Value> v) {
  Values out;
  for (uint32_t r = 0; r < m.rows; ++r) out.push_back(t.dot(m.row(r), v));
  return out;
}

void matrix_times_vector(Translator& t, const Instruction& inst) {
  const Matrix m = matrix(t, inst, 3);
  t.define(inst, product(t, m, vector(t, inst, 4, m.columns)));
}

void vector_times_matrix(Translator& t, const Instruction& inst) {
  const Matrix m = matrix(t, inst, 4);
  const Values v = vector(t, inst, 3, m.rows);
  Values out;
  for (uint32_t c = 0; c < m.columns; ++c) out.push_back(t.dot(v, m.column(c)));
  t.define(inst, std::move(out));
}

void matrix_times_matrix(Translator& t, const Instruction& inst) {
  const Matrix a = matrix(t, inst, 3), c = matrix(t, inst, 4);
  if (a.columns != c.rows || t.b.type(a.v[0]) != t.b.type(c.v[0])) inst.fail("the matrices do not fit");
  Values out;
  for (uint32_t column = 0; column < c.columns; ++column) {
    const Values part = product(t, a, c.column(column));
    out.insert(out.end(), part.begin(), part.end());
  }
  t.define(inst, std::move(out));
}

void outer_product(Translator& t, const Instruction& inst) {
  const Values column = t.floats(inst, 3), row = t.floats(inst, 4);
  if (t.b.type(column[0]) != t.b.type(row[0])) inst.fail("the operands have different types");
  Values out;
  for (Value y : row) {
    for (Value x : column) out.push_back(t.fmul(x, y));
  }
  t.define(inst, std::move(out));
}

void transpose(Translator& t, const Instruction& inst) {
  const Matrix m = matrix(t, inst, 3);
  Values out;
  for (uint32_t r = 0; r < m.rows; ++r) {
    const Values row = m.row(r);
    out.insert(out.end(), row.begin(), row.end());
  }
  t.define(inst, std::move(out));
}

constexpr OpRow kRows[] = {
    PINEDA_SPIRV_ROW(Dot, 5, dot),
    PINEDA_SPIRV_ROW(VectorTimesScalar, 5, times_scalar),
    PINEDA_SPIRV_ROW(MatrixTimesScalar, 5, times_scalar),
    PINEDA_SPIRV_ROW(MatrixTimesVector, 5, matrix_times_vector),
    PINEDA_SPIRV_ROW(VectorTimesMatrix, 5, vector_times_matrix),
    PINEDA_SPIRV_ROW(MatrixTimesMatrix, 5, matrix_times_matrix),
    PINEDA_SPIRV_ROW(OuterProduct, 5, outer_product),
    PINEDA_SPIRV_ROW(Transpose, 4, transpose),
};

}  // namespace

std::span<const OpRow> matrix_rows() { return kRows; }

}  // namespace pineda::spirv
