// PINEDA_PRECISION=exact: sin, cos, tan and their inverses in binary64, for operands that are binary32. Coefficients:
// tools/math/minimax.py.
#include <numbers>

#include "compiler/passes/lower_math.h"
#include "compiler/passes/math_parts.h"

namespace pineda::passes::exact {
namespace {

using ir::Builder;
using ir::Op;
using ir::Type;
using ir::Value;

// sin x = x + x^3 p(x^2), cos x = 1 - x^2 / 2 + x^4 p(x^2) up to pi/4 + 0.01; errors 2^-63.2 and 2^-68.9
constexpr double kSin[] = {-0x1.5555555555555p-3,  0x1.111111111106cp-7,  -0x1.a01a019fff51bp-13, 0x1.71de3a3574c3cp-19,
                           -0x1.ae642f40534c3p-26, 0x1.610bec980632ap-33, -0x1.a135896000e92p-41};
constexpr double kCos[] = {0x1.5555555555555p-5,  -0x1.6c16c16c16b35p-10, 0x1.a01a019ffdf76p-16, -0x1.27e4fb5bf6dbap-22,
                           0x1.1eed720ae0e27p-29, -0x1.9377a93ed3d0dp-37, 0x1.9f5c8e1d07447p-45};
// asin x = x + x^3 p(x^2) up to 1/2; error 2^-59.9
constexpr double kAsin[] = {0x1.5555555555577p-3, 0x1.333333332e133p-4, 0x1.6db6db72124e5p-5, 0x1.f1c71a94fc8ebp-6,
                            0x1.6e8bdedf357f0p-6, 0x1.1c49f06eada71p-6, 0x1.ca1f8be504963p-7, 0x1.7585950a3aa36p-7,
                            0x1.613c5446045dcp-7, 0x1.e5f861837fa03p-9, 0x1.639bb935a9bcbp-6, -0x1.57fcab0ba6b83p-6,
                            0x1.0b468cd927085p-5};
// atan x = x + x^3 p(x^2) up to tan(pi/8); error 2^-59.4
constexpr double kAtan[] = {-0x1.555555555553cp-2, 0x1.9999999995674p-3, -0x1.24924922a2063p-3, 0x1.c71c70e1dfe76p-4,
                            -0x1.745cf8691854cp-4, 0x1.3b11115d1c423p-4, -0x1.10eb62a1947e7p-4, 0x1.df0a89a526d8bp-5,
                            -0x1.9cbdbb30d6d46p-5, 0x1.37a12eed0b87bp-5, -0x1.24f92a3463870p-6};
// pi/2 in parts of 33, 33 and 53 bits: the first two times a quadrant below 2^20 are exact
constexpr double kPio2Parts[] = {0x1.921fb54400000p+0, 0x1.0b4611a600000p-34, 0x1.3198a2e037073p-69};
constexpr double kTwoOverPi = 0x1.45f306dc9c883p-1;
constexpr double kPio2 = std::numbers::pi / 2, kPi = std::numbers::pi;
constexpr double kTanPi8 = 0x1.a827999fcef32p-2;

Value widen(Builder& b, Value x) { return b.convert(Op::kFConvert, Type::kF64, x); }

Value odd_poly(Math64& m, Value x, std::span<const double> c) {
  const Value z = m.mul(x, x);
  return m.mul_add(m.mul(x, z), m.poly(z, c), x);
}

struct Reduced64 {
  Value r, quadrant;  // F64, I32
};
Reduced64 reduce_64(Math64& m, Value x) {
  Builder& b = m.b;
  Math m32(b);
  const Value wide = widen(b, x);
  const Math64::Rounded n = m.round(m.mul(wide, m.f(kTwoOverPi)));
  Value small = wide;
  for (const double part : kPio2Parts) small = m.sub(small, m.mul(n.value, m.f(part)));
  const Value is_large = b.not_(b.flt(b.fabs(x), b.f32(0x1p20)));  // NaN too
  const std::vector<Value> chosen = b.if_else(
      is_large, {Type::kF64, Type::kI32},
      [&] {
        const Turns turns = quarter_turns(m32, x, true);
        const Value high = m.mul(b.convert(Op::kSToF, Type::kF64, turns.high), m.f(0x1p-64));
        const Value low = m.mul(b.convert(Op::kUToF, Type::kF64, turns.low), m.f(0x1p-128));
        const Value r = b.select(b.flt(b.fabs(wide), m.inf()), m.mul(m.add(high, low), m.f(kPio2)), m.nan());
        const Value negative = m32.sign_bit(x);
        return std::vector{m.with_sign(negative, r), b.select(negative, b.isub(b.i32(0), turns.quadrant), turns.quadrant)};
      },
      [&] {
        return std::vector{small, b.convert(Op::kTrunc, Type::kI32, n.integer)};
      });
  return {chosen[0], chosen[1]};
}

struct SinCos {
  Value sin, cos, quadrant;
};
SinCos sin_cos(Math64& m, Value x) {
  const Reduced64 reduced = reduce_64(m, x);
  const Value z = m.mul(reduced.r, reduced.r);
  const Value half = m.mul(z, m.f(0.5)), high = m.sub(m.f(1), half);
  const Value low = m.sub(m.sub(m.f(1), high), half);  // the rounding error of `high`
  const Value cos = m.add(high, m.mul_add(m.mul(z, z), m.poly(z, kCos), low));
  const Value sin = odd_poly(m, reduced.r, kSin);
  return {m.b.select(m.b.feq(reduced.r, m.f(0)), reduced.r, sin), cos, reduced.quadrant};  // keeps -0
}

Value sin_turned(Builder& b, Value x, uint32_t turns) {
  Math64 m(b);
  const SinCos value = sin_cos(m, x);
  const Value quadrant = b.iadd(value.quadrant, b.i32(turns));
  return m.with_sign(bit_set(b, quadrant, 2), b.select(bit_set(b, quadrant, 1), value.cos, value.sin));
}

// asin(s), s = |x| up to 1/2 and sqrt((1 - |x|) / 2) above
struct HalfAngle {
  Value is_large, core;
};
HalfAngle half_angle(Math64& m, Value magnitude) {
  const Value is_large = m.b.flt(m.f(0.5), magnitude);
  const Value s = m.b.fsqrt(m.mul(m.sub(m.f(1), magnitude), m.f(0.5)));  // NaN when |x| > 1
  return {is_large, odd_poly(m, m.b.select(is_large, s, magnitude), kAsin)};
}

// atan(numerator / denominator) for 0 <= numerator <= denominator, of binary32 precision. Above tan(pi/8) it is pi/4 +
// atan((n - d) / (n + d)), where difference and sum are exact, being within a factor of four.
Value atan_of_quotient(Math64& m, Value numerator, Value denominator) {
  Builder& b = m.b;
  const Value is_large = b.flt(m.mul(denominator, m.f(kTanPi8)), numerator);
  const Value n = b.select(is_large, m.sub(numerator, denominator), numerator);
  const Value d = b.select(is_large, m.add(numerator, denominator), denominator);
  const Value core = odd_poly(m, b.fdiv(n, d), kAtan);
  return b.select(is_large, m.add(core, m.f(kPio2 / 2)), core);
}

}  // namespace

Value emit_sin(Builder& b, Value x) { return sin_turned(b, x, 0); }
Value emit_cos(Builder& b, Value x) { return sin_turned(b, x, 1); }

Value emit_tan(Builder& b, Value x) {
  Math64 m(b);
  const SinCos value = sin_cos(m, x);
  const Value odd = bit_set(b, value.quadrant, 1);
  return b.fdiv(b.select(odd, value.cos, value.sin), b.select(odd, b.fneg(value.sin), value.cos));
}

Value emit_asin(Builder& b, Value x) {
  Math64 m(b);
  const Value wide = widen(b, x);
  const HalfAngle h = half_angle(m, b.fabs(wide));
  const Value large = m.sub(m.f(kPio2), m.add(h.core, h.core));
  return m.with_sign(m.sign_bit(wide), b.select(h.is_large, large, h.core));
}

Value emit_acos(Builder& b, Value x) {
  Math64 m(b);
  const Value wide = widen(b, x), negative = m.sign_bit(wide);
  const HalfAngle h = half_angle(m, b.fabs(wide));
  const Value twice = m.add(h.core, h.core);
  const Value large = b.select(negative, m.sub(m.f(kPi), twice), twice);
  return b.select(h.is_large, large, m.sub(m.f(kPio2), m.with_sign(negative, h.core)));
}

Value emit_atan(Builder& b, Value x) {
  Math64 m(b);
  const Value wide = widen(b, x), a = b.fabs(wide), one = m.f(1);
  const Value is_large = b.flt(one, a);
  const Value angle = atan_of_quotient(m, b.select(is_large, one, a), b.select(is_large, a, one));
  return m.with_sign(m.sign_bit(wide), b.select(is_large, m.sub(m.f(kPio2), angle), angle));
}

Value emit_atan2(Builder& b, Value y, Value x) {
  Math64 m(b);
  const Value wide_x = widen(b, x), wide_y = widen(b, y), ax = b.fabs(wide_x), ay = b.fabs(wide_y);
  const Value steep = b.flt(ax, ay), small = b.fmin(ay, ax), large = b.fmax(ay, ax);  // a NaN y passes
  // 0 / 0 counts as 0 / 1, inf / inf as 1 / 1.
  const Value same = b.feq(small, large);
  const Value n = b.select(same, b.select(b.feq(large, m.f(0)), m.f(0), m.f(1)), small);
  const Value core = atan_of_quotient(m, n, b.select(same, m.f(1), large));
  const Value right = b.select(steep, m.sub(m.f(kPio2), core), core);  // angle for x >= 0
  const Value angle = b.select(m.sign_bit(wide_x), m.sub(m.f(kPi), right), right);
  return b.select(m.is_nan(wide_x), wide_x, m.with_sign(m.sign_bit(wide_y), angle));
}

}  // namespace pineda::passes::exact
