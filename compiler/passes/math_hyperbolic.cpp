// Hyperbolic functions and their inverses in binary32. Near zero they are polynomials or go through ln(1 + u), so that no
// cancellation costs more than an ULP or two; Vulkan's formulas with exp and log would allow the whole significand to be lost
// there. Coefficients: tools/math/minimax.py.
#include <numbers>

#include "compiler/passes/lower_math.h"
#include "compiler/passes/math_parts.h"

namespace pineda::passes {
namespace {

using ir::Builder;
using ir::Op;
using ir::Type;
using ir::Value;

// sinh x = x + x^3 p(x^2) up to 1; error 2^-31.6
constexpr double kSinh[] = {0x1.555556p-3, 0x1.1110ep-7, 0x1.a022b8p-13, 0x1.756d3p-19};
// tanh x = x + x^3 p(x^2) up to 0.55; error 2^-29.7
constexpr double kTanh[] = {-0x1.55554ap-2, 0x1.110cfp-3, -0x1.b91f1p-5, 0x1.58eb7p-6, -0x1.994e28p-8};
constexpr double kTanhLimit = 0.55;

// From here on asinh x and acosh x are ln x + ln 2, and ln(1 + x) is ln x, to 2^-28.
constexpr double kLarge = 0x1p28;

Value odd_poly(Math& m, Value x, std::span<const double> c) {
  const Value z = m.mul(x, x);
  return m.fma(m.mul(x, z), m.poly(z, c), x);
}

// ln(1 + u) for u >= 0; infinity and NaN pass, negative u gives NaN.
Value log1p(Math& m, Value u) {
  Builder& b = m.b;
  const Value w = m.add(u, m.f(1));
  const LogParts parts = split(m, w);
  // What the sum lost: exact (Dekker's fast two-sum, the larger term first).
  const Value lost = b.select(b.flt(u, m.f(1)), m.sub(u, m.sub(w, m.f(1))), m.sub(m.f(1), m.sub(w, u)));
  const Value scale = m.power_of_two(b.isub(b.i32(0), b.smin(parts.exponent, b.i32(100))));
  const Value t = m.fma(lost, scale, parts.t);
  const Value sum = log_of_parts(m, b.convert(Op::kSToF, Type::kF32, parts.exponent), t);
  return b.select(m.is_positive_finite(w), sum, m.log_special(w));
}

// ln(1 + u), or ln(2 x) where x is large.
Value log1p_or_log_twice(Math& m, Value x, Value u) {
  Builder& b = m.b;
  const Value large = b.fle(m.f(kLarge), x);
  const Value log = log1p(m, b.select(large, x, u));
  return b.select(large, m.add(log, m.f(std::numbers::ln2)), log);
}

}  // namespace

Value emit_sinh(Builder& b, Value x) {
  Math m(b);
  const Value a = b.fabs(x);
  const Value half = exp_shifted(m, a, -1);  // e^a / 2, so that nothing overflows before the result does
  const Value large = m.sub(half, b.fdiv(m.f(0.25), half));
  return m.with_sign(m.sign_bit(x), b.select(b.flt(a, m.f(1)), odd_poly(m, a, kSinh), large));
}

Value emit_cosh(Builder& b, Value x) {
  Math m(b);
  const Value half = exp_shifted(m, b.fabs(x), -1);
  return m.add(half, b.fdiv(m.f(0.25), half));
}

// 1 - 2 / (e^2a + 1): the quotient is at most 1/2 of the result.
Value emit_tanh(Builder& b, Value x) {
  Math m(b);
  const Value a = b.fabs(x);
  const Value e = exp_shifted(m, m.add(a, a), 0);
  const Value large = m.sub(m.f(1), b.fdiv(m.f(2), m.add(e, m.f(1))));
  return m.with_sign(m.sign_bit(x), b.select(b.flt(a, m.f(kTanhLimit)), odd_poly(m, a, kTanh), large));
}

// ln(a + sqrt(a^2 + 1)) = ln(1 + a + a^2 / (1 + sqrt(1 + a^2)))
Value emit_asinh(Builder& b, Value x) {
  Math m(b);
  const Value a = b.fabs(x), square = m.mul(a, a);
  const Value u = m.add(a, b.fdiv(square, m.add(m.f(1), b.fsqrt(m.add(square, m.f(1))))));
  return m.with_sign(m.sign_bit(x), log1p_or_log_twice(m, a, u));
}

// ln(x + sqrt(x^2 - 1)) = ln(1 + t + sqrt(2 t + t^2)), t = x - 1
Value emit_acosh(Builder& b, Value x) {
  Math m(b);
  const Value t = m.sub(x, m.f(1));
  const Value log = log1p_or_log_twice(m, x, m.add(t, b.fsqrt(m.fma(t, t, m.add(t, t)))));
  return b.select(b.flt(x, m.f(1)), m.nan(), log);
}

// ln((1 + a) / (1 - a)) / 2 = ln(1 + 2 a / (1 - a)) / 2
Value emit_atanh(Builder& b, Value x) {
  Math m(b);
  const Value a = b.fabs(x);
  const Value log = log1p(m, b.fdiv(m.add(a, a), m.sub(m.f(1), a)));
  return m.with_sign(m.sign_bit(x), m.mul(log, m.f(0.5)));
}

}  // namespace pineda::passes
