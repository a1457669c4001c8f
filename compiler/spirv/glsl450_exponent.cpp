// GLSL.std.450: hyperbolic functions and those that take floats apart.
#include <limits>

#include "compiler/spirv/glsl450.h"

namespace pineda::spirv {
namespace {

using ir::Type;
using ir::Value;

template <typename Fn>
void map(Translator& t, const Instruction& inst, Fn fn) {
  glsl_map1<true>(t, inst, fn);
}

Value with_sign_of(Translator& t, Value magnitude, Value x) {
  return t.b.select(t.b.flt(x, t.b.f32(0)), t.b.fneg(magnitude), magnitude);
}

// Vulkan derives the precision of these from the formulas with exp and log below.
void sinh(Translator& t, const Instruction& inst) {
  map(t, inst, [&](Value x) { return t.fmul(t.fsub(t.b.fexp(x), t.b.fexp(t.b.fneg(x))), t.b.f32(0.5)); });
}
void cosh(Translator& t, const Instruction& inst) {
  map(t, inst, [&](Value x) { return t.fmul(t.fadd(t.b.fexp(x), t.b.fexp(t.b.fneg(x))), t.b.f32(0.5)); });
}
// (1 - e) / (1 + e) with e = exp(-2|x|): the same quotient, and no infinity divided by infinity for large x.
void tanh(Translator& t, const Instruction& inst) {
  map(t, inst, [&](Value x) {
    const Value e = t.b.fexp(t.fmul(t.b.f32(-2), t.b.fabs(x))), one = t.b.f32(1);
    return with_sign_of(t, t.b.fdiv(t.fsub(one, e), t.fadd(one, e)), x);
  });
}
void asinh(Translator& t, const Instruction& inst) {
  map(t, inst, [&](Value x) {
    const Value a = t.b.fabs(x);
    return with_sign_of(t, t.b.flog(t.fadd(a, t.b.fsqrt(t.fadd(t.fmul(a, a), t.b.f32(1))))), x);
  });
}
void acosh(Translator& t, const Instruction& inst) {
  map(t, inst, [&](Value x) { return t.b.flog(t.fadd(x, t.b.fsqrt(t.fsub(t.fmul(x, x), t.b.f32(1))))); });
}
void atanh(Translator& t, const Instruction& inst) {
  map(t, inst, [&](Value x) {
    const Value one = t.b.f32(1);
    return t.fmul(t.b.f32(0.5), t.b.flog(t.b.fdiv(t.fadd(one, x), t.fsub(one, x))));
  });
}

// 2^n for -126 <= n <= 127
Value power_of_two(Translator& t, Value n) { return t.b.bitcast(Type::kF32, t.b.shl(t.b.iadd(n, t.b.i32(127)), t.b.i32(23))); }

// x * 2^n, rounded once: n is brought into the range of one factor by exact steps of 2^127, or of 2^-102 which leaves 24 bits
// above the denormals, so that only the last multiplication can round.
Value scale(Translator& t, Value x, Value n) {
  for (int i = 0; i < 2; ++i) {
    const Value high = t.b.slt(t.b.i32(127), n), low = t.b.slt(n, t.b.i32(static_cast<uint32_t>(-126)));
    x = t.b.fmul(x, t.b.select(high, t.b.f32(0x1p127), t.b.select(low, t.b.f32(0x1p-102), t.b.f32(1))));
    n = t.b.isub(n, t.b.select(high, t.b.i32(127), t.b.select(low, t.b.i32(static_cast<uint32_t>(-102)), t.b.i32(0))));
  }
  n = t.b.smax(t.b.smin(n, t.b.i32(127)), t.b.i32(static_cast<uint32_t>(-126)));
  return t.b.fmul(x, power_of_two(t, n));
}

void ldexp(Translator& t, const Instruction& inst) {
  Values x = glsl_operand(t, inst, 0, true);
  const Values n = glsl_operand(t, inst, 1, false, x.size());
  for (size_t i = 0; i < x.size(); ++i) x[i] = scale(t, x[i], n[i]);
  t.define(inst, std::move(x));
}

struct Parts {
  Values first, second;  // fraction and whole part, or significand and exponent
};

// Zero, infinities and NaN come back as the significand with exponent 0.
Parts frexp_parts(Translator& t, const Instruction& inst) {
  Parts out;
  for (Value x : glsl_operand(t, inst, 0, true)) {
    const Value magnitude = t.b.fabs(x);
    const Value is_ordinary =
        t.b.and_(t.b.flt(t.b.f32(0), magnitude), t.b.flt(magnitude, t.b.f32(std::numeric_limits<double>::infinity())));
    const Value is_small = t.b.flt(magnitude, t.b.f32(0x1p-126));
    const Value normal = t.b.fmul(x, t.b.select(is_small, t.b.f32(0x1p24), t.b.f32(1)));
    const Value biased = t.b.and_(t.b.lshr(t.b.bitcast(Type::kI32, normal), t.b.i32(23)), t.b.i32(0xff));
    const Value exponent = t.b.isub(biased, t.b.i32(126));  // of `normal`, significand in [0.5, 1)
    const Value significand = scale(t, normal, t.b.isub(t.b.i32(0), exponent));
    out.first.push_back(t.b.select(is_ordinary, significand, x));
    const Value whole = t.b.isub(exponent, t.b.select(is_small, t.b.i32(24), t.b.i32(0)));
    out.second.push_back(t.b.select(is_ordinary, whole, t.b.i32(0)));
  }
  return out;
}

// Whole part and fraction both have the sign of x; the fraction of an infinity is zero.
Parts modf_parts(Translator& t, const Instruction& inst) {
  Parts out;
  for (Value x : glsl_operand(t, inst, 0, true)) {
    const Value whole = t.b.ftrunc(x);
    out.first.push_back(t.b.select(t.b.feq(whole, x), t.b.f32(0), t.fsub(x, whole)));
    out.second.push_back(whole);
  }
  return out;
}

template <Parts (*kParts)(Translator&, const Instruction&)>
void to_struct(Translator& t, const Instruction& inst) {
  Parts p = kParts(t, inst);
  p.first.insert(p.first.end(), p.second.begin(), p.second.end());
  t.define(inst, std::move(p.first));
}

template <Parts (*kParts)(Translator&, const Instruction&)>
void to_pointer(Translator& t, const Instruction& inst) {
  Parts p = kParts(t, inst);
  t.store(inst, t.pointer(inst, kFirstOperand + 1), p.second);
  t.define(inst, std::move(p.first));
}

constexpr ExtRow kRows[] = {
    PINEDA_GLSL_ROW(Sinh, 1, sinh),
    PINEDA_GLSL_ROW(Cosh, 1, cosh),
    PINEDA_GLSL_ROW(Tanh, 1, tanh),
    PINEDA_GLSL_ROW(Asinh, 1, asinh),
    PINEDA_GLSL_ROW(Acosh, 1, acosh),
    PINEDA_GLSL_ROW(Atanh, 1, atanh),
    PINEDA_GLSL_ROW(Ldexp, 2, ldexp),
    PINEDA_GLSL_ROW(Frexp, 2, to_pointer<frexp_parts>),
    PINEDA_GLSL_ROW(FrexpStruct, 1, to_struct<frexp_parts>),
    PINEDA_GLSL_ROW(Modf, 2, to_pointer<modf_parts>),
    PINEDA_GLSL_ROW(ModfStruct, 1, to_struct<modf_parts>),
};

}  // namespace

std::span<const ExtRow> glsl_exponent_rows() { return kRows; }

}  // namespace pineda::spirv
