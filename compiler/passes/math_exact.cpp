// PINEDA_PRECISION=exact: exponential, logarithmic and hyperbolic functions in binary64, for operands that are binary32.
// Coefficients: tools/math/minimax.py.
#include "compiler/passes/lower_math.h"
#include "compiler/passes/math_parts.h"

namespace pineda::passes::exact {
namespace {

using ir::Builder;
using ir::Op;
using ir::Type;
using ir::Value;

// 2^x = 1 + x p(x) on [-0.5, 0.5]; error 2^-59.9
constexpr double kExp2[] = {0x1.62e42fefa39efp-1,  0x1.ebfbdff82c58ep-3,  0x1.c6b08d704a221p-5,  0x1.3b2ab6fba51dfp-7,
                            0x1.5d87fe785317cp-10, 0x1.430912f72a95bp-13, 0x1.ffcbfe73ebfb9p-17, 0x1.62c028496734ap-20,
                            0x1.b51e9af732948p-24, 0x1.e4b5d97d1c8f5p-28, 0x1.fcdeaa19b16b1p-32, 0x1.eacb3659160ecp-36,
                            -0x1.5e68558fed900p-36};
// e^x = 1 + x + x^2 p(x) on +-0.5 ln 2; error 2^-63.7
constexpr double kExp[] = {0x1.0000000000000p-1,  0x1.555555555555bp-3,  0x1.555555555553dp-5,  0x1.111111110ee12p-7,
                           0x1.6c16c16c22c16p-10, 0x1.a01a01b2e8297p-13, 0x1.a01a0163785c8p-16, 0x1.71ddf1637b5a2p-19,
                           0x1.27e56eff8dffcp-22, 0x1.af6a09ce1b7f8p-26, 0x1.1e8e6f572cf79p-29};
// ln((1 + s) / (1 - s)) = 2 s + s^3 p(s^2) up to s^2 = 0.02945; error 2^-67.3
constexpr double kLog[] = {0x1.5555555555555p-1, 0x1.9999999999c74p-2, 0x1.249249244f8dbp-2,
                           0x1.c71c72255c5f3p-3, 0x1.745cf285c66dep-3, 0x1.3b1c035f7a8c1p-3,
                           0x1.0ffb534117598p-3, 0x1.040d613202ff3p-3, 0x1.590bc09c3c0ecp-5};
// sinh x = x + x^3 p(x^2) up to 1; error 2^-63.3
constexpr double kSinh[] = {0x1.5555555555555p-3,  0x1.11111111111c0p-7,  0x1.a01a019ffb6eep-13,
                            0x1.71de3a7eb442ep-19, 0x1.ae6418e6b370cp-26, 0x1.6159e2dd54105p-33,
                            0x1.789e5602e75d2p-41, 0x1.ebb5622c1c5e9p-45, -0x1.a32569cbf64a8p-47};
// ln 2: the high part has 32 bits, so its product with an exponent is exact
constexpr double kLn2High = 0x1.62e42fee00000p-1, kLn2Low = 0x1.a39ef35793c76p-33, kLog2E = 0x1.71547652b82fep+0;

Value widen(Builder& b, Value x) { return b.convert(Op::kFConvert, Type::kF64, x); }

// 2^x, for any x: beyond binary32's range the result is far out of it, too.
Value exp2_64(Math64& m, Value x) {
  const Value clamped = m.b.fmax(m.b.fmin(x, m.f(400)), m.f(-400));
  const Math64::Rounded n = m.round(clamped);
  const Value f = m.sub(clamped, n.value);
  return m.mul(m.mul_add(f, m.poly(f, kExp2), m.f(1)), m.power_of_two(n.integer));
}

Value exp_64(Math64& m, Value x) {
  const Value clamped = m.b.fmax(m.b.fmin(x, m.f(300)), m.f(-300));
  const Math64::Rounded n = m.round(m.mul(clamped, m.f(kLog2E)));
  const Value r = m.sub(m.sub(clamped, m.mul(n.value, m.f(kLn2High))), m.mul(n.value, m.f(kLn2Low)));
  const Value p = m.mul_add(m.mul(r, r), m.poly(r, kExp), r);
  return m.mul(m.add(p, m.f(1)), m.power_of_two(n.integer));
}

// ln x = exponent * ln 2 + ln(1 + f), f in [sqrt(1/2) - 1, sqrt(2) - 1]; by s = f / (2 + f).
struct LogParts64 {
  Value exponent, f;  // F64
};
LogParts64 split_64(Math64& m, Value x) {
  Builder& b = m.b;
  const Value bits = m.raw_bits(x);
  const Value exponent = b.ashr(b.isub(bits, b.i64(0x3fe6a09e667f3bcd)), b.i64(52));  // bits of sqrt(1/2)
  const Value mantissa = m.from_bits(b.isub(bits, b.shl(exponent, b.i64(52))));
  const Value narrow = b.convert(Op::kTrunc, Type::kI32, exponent);
  return {b.convert(Op::kSToF, Type::kF64, narrow), m.sub(mantissa, m.f(1))};
}

Value log_of_one_plus(Math64& m, Value f) {
  const Value s = m.b.fdiv(f, m.add(f, m.f(2))), z = m.mul(s, s);
  return m.mul_add(m.mul(s, z), m.poly(z, kLog), m.add(s, s));
}

Value log_sum(Math64& m, const LogParts64& parts) {
  const Value low = m.mul_add(parts.exponent, m.f(kLn2Low), log_of_one_plus(m, parts.f));
  return m.mul_add(parts.exponent, m.f(kLn2High), low);
}

Value log2_64(Math64& m, Value x) {
  const LogParts64 parts = split_64(m, x);
  const Value sum = m.mul_add(log_of_one_plus(m, parts.f), m.f(kLog2E), parts.exponent);
  return m.b.select(m.is_positive_finite(x), sum, m.log_special(x));
}

Value log_64(Math64& m, Value x) { return m.b.select(m.is_positive_finite(x), log_sum(m, split_64(m, x)), m.log_special(x)); }

// ln(1 + u), u >= 0. Where 1 + u needs no scaling, f is u itself and not what the sum has left of it.
Value log1p_64(Math64& m, Value u) {
  Builder& b = m.b;
  const Value w = m.add(u, m.f(1));
  LogParts64 parts = split_64(m, w);
  parts.f = b.select(b.feq(parts.exponent, m.f(0)), u, parts.f);
  return b.select(m.is_positive_finite(w), log_sum(m, parts), m.log_special(w));
}

struct SinhCosh {
  Value sinh, cosh;  // of a >= 0
};
SinhCosh sinh_cosh(Math64& m, Value a) {
  const Value e = exp_64(m, a), inverse = m.b.fdiv(m.f(1), e), z = m.mul(a, a), half = m.f(0.5);
  const Value small = m.mul_add(m.mul(a, z), m.poly(z, kSinh), a);
  const Value large = m.mul(m.sub(e, inverse), half);
  return {m.b.select(m.b.flt(a, m.f(1)), small, large), m.mul(m.add(e, inverse), half)};
}

}  // namespace

Value emit_exp2(Builder& b, Value x) {
  Math64 m(b);
  return exp2_64(m, widen(b, x));
}

Value emit_exp(Builder& b, Value x) {
  Math64 m(b);
  return exp_64(m, widen(b, x));
}

Value emit_log2(Builder& b, Value x) {
  Math64 m(b);
  return log2_64(m, widen(b, x));
}

Value emit_log(Builder& b, Value x) {
  Math64 m(b);
  return log_64(m, widen(b, x));
}

Value emit_pow(Builder& b, Value x, Value y) {
  Math64 m(b);
  const Value power = exp2_64(m, m.mul(widen(b, y), log2_64(m, widen(b, x))));
  return b.select(b.or_(b.feq(y, b.f32(0)), b.feq(x, b.f32(1))), m.f(1), power);
}

Value emit_rsqrt(Builder& b, Value x) { return b.fdiv(b.fconst(Type::kF64, 1), b.fsqrt(widen(b, x))); }

Value emit_sinh(Builder& b, Value x) {
  Math64 m(b);
  const Value wide = widen(b, x);
  return m.with_sign(m.sign_bit(wide), sinh_cosh(m, b.fabs(wide)).sinh);
}

Value emit_cosh(Builder& b, Value x) {
  Math64 m(b);
  return sinh_cosh(m, b.fabs(widen(b, x))).cosh;
}

Value emit_tanh(Builder& b, Value x) {
  Math64 m(b);
  const Value wide = widen(b, x);
  const SinhCosh value = sinh_cosh(m, b.fmin(b.fabs(wide), m.f(40)));
  return m.with_sign(m.sign_bit(wide), b.fdiv(value.sinh, value.cosh));
}

// ln(1 + a + a^2 / (1 + sqrt(1 + a^2))); an infinity would be divided by itself, and ln(1 + inf) is what is left without the
// quotient.
Value emit_asinh(Builder& b, Value x) {
  Math64 m(b);
  const Value wide = widen(b, x), a = b.fabs(wide), square = m.mul(a, a);
  const Value quotient = b.fdiv(square, m.add(m.f(1), b.fsqrt(m.add(square, m.f(1)))));
  const Value u = b.select(b.flt(a, m.inf()), m.add(a, quotient), a);
  return m.with_sign(m.sign_bit(wide), log1p_64(m, u));
}

// ln(1 + t + sqrt(t (2 + t))), t = x - 1
Value emit_acosh(Builder& b, Value x) {
  Math64 m(b);
  const Value t = m.sub(widen(b, x), m.f(1));
  const Value log = log1p_64(m, m.add(t, b.fsqrt(m.mul(t, m.add(t, m.f(2))))));
  return b.select(b.flt(t, m.f(0)), m.nan(), log);
}

// ln(1 + 2 a / (1 - a)) / 2
Value emit_atanh(Builder& b, Value x) {
  Math64 m(b);
  const Value wide = widen(b, x), a = b.fabs(wide);
  const Value log = log1p_64(m, b.fdiv(m.add(a, a), m.sub(m.f(1), a)));
  return m.with_sign(m.sign_bit(wide), m.mul(log, m.f(0.5)));
}

}  // namespace pineda::passes::exact
