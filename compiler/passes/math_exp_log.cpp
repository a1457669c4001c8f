// exp2, exp, log2, log, pow. Coefficients: tools/math/minimax.py, which states method and error.
#include "compiler/passes/lower_math.h"
#include "compiler/passes/math_parts.h"

namespace pineda::passes {
namespace {

using ir::Builder;
using ir::Value;

// 2^x = 1 + x p(x) on [-0.5, 0.5]; error 2^-28.3
constexpr double kExp2[] = {0x1.62e43p-1, 0x1.ebfbdcp-3, 0x1.c6af7ap-5, 0x1.3b2dd2p-7, 0x1.5f095cp-10, 0x1.417bbp-13};
// e^x = 1 + x + x^2 p(x) on +-0.5 ln 2; error 2^-28.2
constexpr double kExp[] = {0x1.fffffcp-2, 0x1.55549p-3, 0x1.5558aep-5, 0x1.123b18p-7, 0x1.6a52d4p-10};
// log2(1 + t) = t / ln 2 + t^2 p(t) on [sqrt(1/2) - 1, sqrt(2) - 1]; error 2^-27.7
constexpr double kLog2[] = {-0x1.71547p-1, 0x1.ec7092p-2,  -0x1.715aeap-2, 0x1.277fdap-2, -0x1.eaaaeep-3,
                            0x1.a2b792p-3, -0x1.877f1cp-3, 0x1.7f5d42p-3,  -0x1.c6cc8cp-4};
// log2(1 + t) = t p(t) there; absolute error 2^-13.25
constexpr double kLog2Coarse[] = {0x1.71173ap+0, -0x1.7326a4p-1, 0x1.08f6f8p-1, -0x1.518a5cp-2};
// ln(1 + t) = t + t^2 p(t) there; error 2^-27.8
constexpr double kLog[] = {-0x1.fffff8p-2, 0x1.55555p-2,   -0x1.000432p-2, 0x1.99a3e2p-3, -0x1.54257ap-3,
                           0x1.227444p-3,  -0x1.0f49f6p-3, 0x1.08369cp-3,  -0x1.37a2ecp-4};
// log2(1 + t) = t (c0 + t (c1 + t (c2 + t p(t)))) there; error 2^-35.1
constexpr double kPow[] = {-0x1.715474p-2, 0x1.27769cp-2,  -0x1.ec7216p-3, 0x1.a62f4ep-3,  -0x1.713e12p-3,
                           0x1.45e2aap-3,  -0x1.25f76ep-3, 0x1.258554p-3,  -0x1.1f5454p-3, 0x1.3a8f18p-4};

// 1 / ln 2 and the next coefficients of the series, in two parts
struct Parts {
  double high, low;
};
constexpr Parts kLog2E{0x1.715476p+0, 0x1.4ae0cp-26};
constexpr Parts kPowHead[] = {kLog2E, {-0x1.715476p-1, -0x1.4ae0cp-27}, {0x1.ec709ep-2, -0x1.e2fe02p-29}};
Value to_float(Builder& b, Value i) { return b.convert(ir::Op::kSToF, ir::Type::kF32, i); }

// Unevaluated sum high + low.
struct Pair {
  Value high, low;
};

// a + (high, low), for |a| >= |high| or a == 0.
Pair add(Math& m, Value a, Value a_low, Pair p) {
  const Value sum = m.add(a, p.high);
  const Value rest = m.sub(p.high, m.sub(sum, a));
  return {sum, m.add(rest, a_low ? m.add(p.low, a_low) : p.low)};
}

Pair mul(Math& m, Value x, Pair p) {
  const Value product = m.mul(x, p.high);
  return {product, m.fma(x, p.low, m.fma(x, p.high, m.b.fneg(product)))};
}

// log2(x) to about 2^-31, for pow.
Pair log2_pair(Math& m, Value x) {
  const LogParts parts = split(m, x);
  const Value t = parts.t;
  Pair sum{m.mul(t, m.poly(t, kPow)), m.f(0)};
  for (int i = 2; i >= 0; --i) sum = mul(m, t, add(m, m.f(kPowHead[i].high), m.f(kPowHead[i].low), sum));
  return add(m, to_float(m.b, parts.exponent), {}, sum);
}

// 2^(high + low); |low| is far below |high|. high may be infinite or NaN; low is used where high is in range only.
Value exp2_pair(Math& m, Pair x) {
  Builder& b = m.b;
  // NaN passes both: fmin and fmax give their first operand.
  const Value clamped = b.fmax(b.fmin(x.high, m.f(129)), m.f(-152));
  const Math::Rounded n = m.round_sum(m.add(clamped, m.f(Math::kMagic)));
  Value f = m.sub(clamped, n.value);  // exact
  if (x.low) f = m.add(f, b.select(b.feq(clamped, x.high), x.low, m.f(0)));
  return m.scale(m.fma(f, m.poly(f, kExp2), m.f(1)), n.integer);
}

}  // namespace

Value emit_exp2(Builder& b, Value x) {
  Math m(b);
  return exp2_pair(m, {x, {}});
}

Value exp_shifted(Math& m, Value x, int shift) {
  Builder& b = m.b;
  const Value clamped = b.fmax(b.fmin(x, m.f(89.5)), m.f(-105));
  const Math::Rounded n = m.round_sum(m.fma(clamped, m.f(kLog2E.high), m.f(Math::kMagic)));
  const Value r = m.fma(n.value, m.f(-kLn2Low), m.fma(n.value, m.f(-kLn2High), clamped));
  const Value p = m.fma(m.mul(r, r), m.poly(r, kExp), r);
  const Value power = shift == 0 ? n.integer : b.iadd(n.integer, b.i32(static_cast<uint32_t>(shift)));
  return m.scale(m.add(p, m.f(1)), power);
}

LogParts split(Math& m, Value x) {
  Builder& b = m.b;
  const Value denormal = b.flt(x, m.f(0x1p-126));
  const Value bits = m.raw_bits(b.select(denormal, m.mul(x, m.f(0x1p23)), x));
  const Value exponent = b.ashr(b.isub(bits, b.i32(0x3f3504f3)), b.i32(23));  // bits of sqrt(1/2)
  const Value mantissa = m.from_bits(b.isub(bits, b.shl(exponent, b.i32(23))));
  return {b.select(denormal, b.isub(exponent, b.i32(23)), exponent), m.sub(mantissa, m.f(1))};
}

Value log_of_parts(Math& m, Value exponent, Value t) {
  const Value tail = m.fma(m.mul(t, t), m.poly(t, kLog), m.mul(exponent, m.f(kLn2Low)));
  return m.fma(exponent, m.f(kLn2High), m.add(t, tail));
}

Value emit_exp(Builder& b, Value x) {
  Math m(b);
  return exp_shifted(m, x, 0);
}

Value emit_log2(Builder& b, Value x) {
  Math m(b);
  const LogParts parts = split(m, x);
  const Value t = parts.t;
  const Value tail = m.fma(m.mul(t, t), m.poly(t, kLog2), m.mul(t, m.f(kLog2E.low)));
  const Value sum = m.add(to_float(b, parts.exponent), m.fma(t, m.f(kLog2E.high), tail));
  return b.select(m.is_positive_finite(x), sum, m.log_special(x));
}

// Infinity counts as 2^128.
Value emit_log2_coarse(Builder& b, Value x) {
  Math m{b};
  const Value bits = m.raw_bits(b.fmax(m.f(0x1p-126), x));
  const Value exponent = b.ashr(b.isub(bits, b.i32(0x3f3504f3)), b.i32(23));  // bits of sqrt(1/2)
  const Value t = m.sub(m.from_bits(b.isub(bits, b.shl(exponent, b.i32(23)))), m.f(1));
  return m.fma(t, m.poly(t, kLog2Coarse), b.convert(ir::Op::kSToF, ir::Type::kF32, exponent));
}

Value emit_log(Builder& b, Value x) {
  Math m(b);
  const LogParts parts = split(m, x);
  return b.select(m.is_positive_finite(x), log_of_parts(m, to_float(b, parts.exponent), parts.t), m.log_special(x));
}

Value emit_pow(Builder& b, Value x, Value y) {
  Math m(b);
  const Value ordinary = m.is_positive_finite(x);
  Pair log = log2_pair(m, x);
  log = {b.select(ordinary, log.high, m.log_special(x)), b.select(ordinary, log.low, m.f(0))};
  const Value power = exp2_pair(m, mul(m, y, log));
  const Value one = b.or_(b.feq(y, m.f(0)), b.feq(x, m.f(1)));
  return b.select(one, m.f(1), power);
}

Value emit_rsqrt(Builder& b, Value x) { return b.fdiv(b.f32(1), b.fsqrt(x)); }

}  // namespace pineda::passes
