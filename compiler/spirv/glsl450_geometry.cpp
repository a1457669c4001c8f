// GLSL.std.450: vectors and matrices.
#include "compiler/spirv/glsl450.h"

namespace pineda::spirv {
namespace {

using ir::Value;

Value length_of(Translator& t, const Values& v) { return v.size() == 1 ? t.b.fabs(v[0]) : t.b.fsqrt(t.dot(v, v)); }

Values vector(Translator& t, const Instruction& inst, uint32_t n, size_t size = 0) {
  return glsl_operand(t, inst, n, true, size);
}

void length(Translator& t, const Instruction& inst) { t.define(inst, Values{length_of(t, vector(t, inst, 0))}); }

void distance(Translator& t, const Instruction& inst) {
  Values a = vector(t, inst, 0);
  const Values c = vector(t, inst, 1, a.size());
  for (size_t i = 0; i < a.size(); ++i) a[i] = t.fsub(a[i], c[i]);
  t.define(inst, Values{length_of(t, a)});
}

void cross(Translator& t, const Instruction& inst) {
  const Values a = vector(t, inst, 0, 3), c = vector(t, inst, 1, 3);
  Values out;
  for (uint32_t i = 0; i < 3; ++i) {
    const uint32_t j = (i + 1) % 3, k = (i + 2) % 3;
    out.push_back(t.fsub(t.fmul(a[j], c[k]), t.fmul(c[j], a[k])));
  }
  t.define(inst, std::move(out));
}

void normalize(Translator& t, const Instruction& inst) {
  Values v = vector(t, inst, 0);
  const Value inverse = t.b.fdiv(number(t, v[0], 1), length_of(t, v));
  for (Value& x : v) x = t.fmul(x, inverse);
  t.define(inst, std::move(v));
}

void face_forward(Translator& t, const Instruction& inst) {
  Values n = vector(t, inst, 0);
  const Values i = vector(t, inst, 1, n.size()), reference = vector(t, inst, 2, n.size());
  const Value keep = t.b.flt(t.dot(reference, i), number(t, n[0], 0));
  for (Value& x : n) x = t.b.select(keep, x, t.b.fneg(x));
  t.define(inst, std::move(n));
}

// I - 2 * dot(N, I) * N
void reflect(Translator& t, const Instruction& inst) {
  Values i = vector(t, inst, 0);
  const Values n = vector(t, inst, 1, i.size());
  const Value twice = t.fmul(number(t, n[0], 2), t.dot(n, i));
  for (size_t k = 0; k < i.size(); ++k) i[k] = t.fsub(i[k], t.fmul(twice, n[k]));
  t.define(inst, std::move(i));
}

// k = 1 - eta^2 (1 - dot(N, I)^2); zero when k < 0, else eta * I - (eta * dot(N, I) + sqrt(k)) * N
void refract(Translator& t, const Instruction& inst) {
  Values i = vector(t, inst, 0);
  const Values n = vector(t, inst, 1, i.size());
  const Value eta = t.scalar(inst, kFirstOperand + 2, t.b.type(n[0])), one = number(t, eta, 1), zero = number(t, eta, 0);
  const Value d = t.dot(n, i);
  const Value k = t.fsub(one, t.fmul(t.fmul(eta, eta), t.fsub(one, t.fmul(d, d))));
  const Value total_reflection = t.b.flt(k, zero);
  const Value along = t.fadd(t.fmul(eta, d), t.b.fsqrt(k));
  for (size_t c = 0; c < i.size(); ++c) {
    i[c] = t.b.select(total_reflection, zero, t.fsub(t.fmul(eta, i[c]), t.fmul(along, n[c])));
  }
  t.define(inst, std::move(i));
}

// ---- square matrices, v[c * n + r] ----

Values square_matrix(Translator& t, const Instruction& inst, uint32_t* n) {
  const Type& type = t.type_of(inst, kFirstOperand);
  if (type.kind != TypeKind::kMatrix || t.m.type(type.element).count != type.count)
    inst.fail("the operand is not a square matrix");
  *n = type.count;
  return t.values(inst, kFirstOperand);
}

// The determinant of what is left of an n x n matrix without one row and column; expands along the first column.
Value minor_of(Translator& t, const Values& m, uint32_t n, uint32_t without_column, uint32_t without_row);

Value determinant_of(Translator& t, const Values& m, uint32_t n) {
  if (n == 1) return m[0];
  if (n == 2) return t.fsub(t.fmul(m[0], m[3]), t.fmul(m[2], m[1]));
  Value sum;
  for (uint32_t r = 0; r < n; ++r) {
    const Value term = t.fmul(m[r], minor_of(t, m, n, 0, r));
    sum = !sum ? term : r % 2 ? t.fsub(sum, term) : t.fadd(sum, term);
  }
  return sum;
}

Value minor_of(Translator& t, const Values& m, uint32_t n, uint32_t without_column, uint32_t without_row) {
  Values rest;
  for (uint32_t c = 0; c < n; ++c) {
    for (uint32_t r = 0; r < n; ++r) {
      if (c != without_column && r != without_row) rest.push_back(m[c * n + r]);
    }
  }
  return determinant_of(t, rest, n - 1);
}

void determinant(Translator& t, const Instruction& inst) {
  uint32_t n = 0;
  const Values m = square_matrix(t, inst, &n);
  t.define(inst, Values{determinant_of(t, m, n)});
}

// The adjugate divided by the determinant, which is the first row of cofactors times the first column.
void matrix_inverse(Translator& t, const Instruction& inst) {
  uint32_t n = 0;
  const Values m = square_matrix(t, inst, &n);
  Values cofactors(size_t{n} * n);
  for (uint32_t c = 0; c < n; ++c) {
    for (uint32_t r = 0; r < n; ++r) {
      const Value v = minor_of(t, m, n, c, r);
      cofactors[c * n + r] = (c + r) % 2 ? t.b.fneg(v) : v;
    }
  }
  const Value inverse = t.b.fdiv(number(t, m[0], 1), t.dot(std::span(m).first(n), std::span(cofactors).first(n)));
  Values out;
  for (uint32_t c = 0; c < n; ++c) {
    for (uint32_t r = 0; r < n; ++r) out.push_back(t.fmul(cofactors[r * n + c], inverse));
  }
  t.define(inst, std::move(out));
}

constexpr ExtRow kRows[] = {
    PINEDA_GLSL_ROW(Length, 1, length),
    PINEDA_GLSL_ROW(Distance, 2, distance),
    PINEDA_GLSL_ROW(Cross, 2, cross),
    PINEDA_GLSL_ROW(Normalize, 1, normalize),
    PINEDA_GLSL_ROW(FaceForward, 3, face_forward),
    PINEDA_GLSL_ROW(Reflect, 2, reflect),
    PINEDA_GLSL_ROW(Refract, 3, refract),
    PINEDA_GLSL_ROW(Determinant, 1, determinant),
    PINEDA_GLSL_ROW(MatrixInverse, 1, matrix_inverse),
};

}  // namespace

std::span<const ExtRow> glsl_geometry_rows() { return kRows; }

}  // namespace pineda::spirv
