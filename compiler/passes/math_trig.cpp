// sin, cos, tan and their inverses. Coefficients: tools/math/minimax.py, which states method and error.
#include "compiler/passes/lower_math.h"
#include "compiler/passes/math_parts.h"

namespace pineda::passes {
namespace {

using ir::Builder;
using ir::Op;
using ir::Type;
using ir::Value;

// sin x = x + x^3 p(x^2), cos x = 1 - x^2 / 2 + x^4 p(x^2) up to pi/4 + 0.01; errors 2^-32.5 and 2^-32.6
constexpr double kSin[] = {-0x1.555556p-3, 0x1.111172p-7, -0x1.a05676p-13, 0x1.7b42dep-19};
constexpr double kCos[] = {0x1.55554ap-5, -0x1.6c0c0ep-10, 0x1.99db66p-16};
// asin x = x + x^3 p(x^2) up to 1/2; error 2^-31.7
constexpr double kAsin[] = {0x1.55554cp-3, 0x1.3338a6p-4, 0x1.6ca91ep-5, 0x1.04bddcp-5, 0x1.d6ab24p-7, 0x1.3426eep-5};
// atan x = x + x^3 p(x^2) up to 1; error 2^-28.5
constexpr double kAtan[] = {-0x1.55553ep-2, 0x1.9991e6p-3,  -0x1.2420bcp-3, 0x1.c08fc6p-4,  -0x1.58167p-4,
                            0x1.da6124p-5,  -0x1.fdfc84p-6, 0x1.64bcccp-7,  -0x1.d484b4p-10};
// pi / 2 in three parts, 2 / pi
constexpr double kPio2[] = {0x1.921fb6p+0, -0x1.777a5cp-25, -0x1.ee59dap-50};
constexpr double kTwoOverPi = 0x1.45f306p-1;

// W. J. Cody and W. Waite, "Software Manual for the Elementary Functions", 1980: parts of pi/2, each product subtracted with one
// rounding; the first difference is exact. For |x| < kCodyWaiteLimit.
constexpr double kCodyWaiteLimit = 0x1p17;
Reduced reduce_small(Math& m, Value x, uint32_t parts) {
  const Math::Rounded n = m.round_sum(m.fma(x, m.f(kTwoOverPi), m.f(Math::kMagic)));
  Value r = x;
  for (uint32_t i = 0; i < parts; ++i) r = m.fma(n.value, m.f(-kPio2[i]), r);
  return {r, n.integer};
}

Reduced reduce_large(Math& m, Value x) {
  Builder& b = m.b;
  const Turns turns = quarter_turns(m, x, false);
  const Value part = b.convert(Op::kSToF, Type::kF32, turns.high);  // times pi/2 * 2^-64, in two parts
  const Value scaled = m.fma(part, m.f(kPio2[0] * 0x1p-64), m.mul(part, m.f(kPio2[1] * 0x1p-64)));
  const Value negative = m.sign_bit(x);
  const Value r = b.select(b.flt(b.fabs(x), m.inf()), scaled, m.nan());
  return {b.select(negative, b.fneg(r), r), b.select(negative, b.isub(b.i32(0), turns.quadrant), turns.quadrant)};
}

struct SinCos {
  Value sin, cos;
};
// Of x, whose reduced value is r.
SinCos sin_cos_of_reduced(Math& m, Value x, Value r) {
  const Value z = m.mul(r, r);
  const Value sin = m.b.select(m.b.feq(x, m.f(0)), x, m.fma(m.mul(r, z), m.poly(z, kSin), r));  // keeps -0
  // 1 - z/2 is formed with its rounding error, which the small terms take up.
  const Value half = m.mul(z, m.f(0.5));
  const Value high = m.sub(m.f(1), half);
  const Value low = m.sub(m.sub(m.f(1), high), half);
  return {sin, m.add(high, m.fma(m.mul(z, z), m.poly(z, kCos), low))};
}

// sin(x + turns * pi/2)
Value sin_turned(Builder& b, Value x, uint32_t turns) {
  Math m(b);
  const Reduced reduced = reduce_to_quadrant(m, x, 3);
  const SinCos value = sin_cos_of_reduced(m, x, reduced.r);
  const Value quadrant = b.iadd(reduced.quadrant, b.i32(turns));
  const Value magnitude = b.select(bit_set(b, quadrant, 1), value.cos, value.sin);
  return b.select(bit_set(b, quadrant, 2), b.fneg(magnitude), magnitude);
}

// atan of a in [0, 1]
Value atan_core(Math& m, Value a) {
  const Value z = m.mul(a, a);
  return m.fma(m.mul(a, z), m.poly(z, kAtan), a);
}

// pi/2 - x
Value from_pio2(Math& m, Value x) { return m.sub(m.f(kPio2[0]), m.sub(x, m.f(kPio2[1]))); }

// asin on [0, 1/2]: s + s z p(z), z = s^2
Value asin_core(Math& m, Value s, Value z) { return m.fma(m.mul(s, z), m.poly(z, kAsin), s); }

// asin|x| = asin_core(s) when |x| <= 1/2, else pi/2 - 2 asin_core(s), s = sqrt((1 - |x|) / 2)
struct HalfAngle {
  Value magnitude, is_large, core;
};
HalfAngle half_angle(Math& m, Value x) {
  Builder& b = m.b;
  const Value magnitude = b.fabs(x);
  const Value is_large = b.flt(m.f(0.5), magnitude);
  const Value z = b.select(is_large, m.mul(m.sub(m.f(1), magnitude), m.f(0.5)), m.mul(magnitude, magnitude));
  const Value s = b.select(is_large, b.fsqrt(z), magnitude);  // NaN when |x| > 1
  return {magnitude, is_large, asin_core(m, s, z)};
}

}  // namespace

Reduced reduce_to_quadrant(Math& m, Value x, uint32_t parts) {
  Builder& b = m.b;
  const Reduced small = reduce_small(m, x, parts);
  const Value is_large = b.not_(b.flt(b.fabs(x), m.f(kCodyWaiteLimit)));  // NaN too
  const std::vector<Value> chosen = b.if_else(
      is_large, {Type::kF32, Type::kI32},
      [&] {
        const Reduced large = reduce_large(m, x);
        return std::vector{large.r, large.quadrant};
      },
      [&] {
        return std::vector{small.r, small.quadrant};
      });
  return {chosen[0], chosen[1]};
}

// M. Payne and R. Hanek, "Radian Reduction for Trigonometric Functions", 1983: x = M * 2^E with a 24-bit M; of the product with
// the bits of 2 / pi those that stand for multiples of four turns of pi/2 are left out, which leaves 96 (wide: 128) bits to
// multiply.
Turns quarter_turns(Math& m, Value x, bool wide) {
  Builder& b = m.b;
  // 32 zero bits, then 2 / pi
  constexpr uint32_t kBits[] = {0,          0xa2f9836e, 0x4e441529, 0xfc2757d1, 0xf534ddc0,
                                0xdb629599, 0x3c439041, 0xfe5163ab, 0xdebbc561};
  const uint32_t products = wide ? 4 : 3;
  const Value bits = m.raw_bits(x);
  const Value exponent = b.and_(b.lshr(bits, b.i32(23)), b.i32(255));
  const Value mantissa = b.or_(b.and_(bits, b.i32(0x7fffff)), b.i32(0x800000));
  // First bit of the window: E - 2 bits of 2 / pi are skipped, E = exponent - 150; at least 22 of the table, since |x| >= 2^17.
  const Value skip = b.isub(exponent, b.i32(150 + 2 - 32));
  const Value first_word = b.lshr(skip, b.i32(5)), shift = b.and_(skip, b.i32(31));
  Value word[5];
  for (uint32_t w = 0; w <= products; ++w) {
    word[w] = b.i32(kBits[w]);
    for (uint32_t first = 1; first <= 4; ++first)
      word[w] = b.select(b.ieq(first_word, b.i32(first)), b.i32(kBits[first + w]), word[w]);
  }
  const auto extend = [&](Value v) { return b.convert(Op::kZExt, Type::kI64, v); };
  Value product[4];  // 24 x 32 bits; most significant first
  for (uint32_t w = 0; w < products; ++w) {
    // (word : next) << shift; the second shift count is 31 - shift after a shift by one, so that zero needs no care
    const Value next = b.lshr(b.lshr(word[w + 1], b.i32(1)), b.isub(b.i32(31), shift));
    product[w] = b.imul(extend(mantissa), extend(b.or_(b.shl(word[w], shift), next)));
  }
  const Value thirty_two = b.i64(32);
  Value third = product[2], low;
  if (wide) {
    third = b.iadd(third, b.lshr(product[3], thirty_two));
    low = b.or_(b.shl(third, thirty_two), b.and_(product[3], b.i64(0xffffffff)));
  }
  // The upper 64 bits: two of quadrant, the rest a fraction of pi/2.
  const Value middle = b.iadd(product[1], b.lshr(third, thirty_two));
  const Value top = b.iadd(b.shl(product[0], thirty_two), middle);
  Value fraction = b.shl(top, b.i64(2));  // signed: in [-1/2, 1/2) of pi/2, which moves the quadrant up by its sign bit
  if (wide) {
    fraction = b.or_(fraction, b.lshr(low, b.i64(62)));
    low = b.shl(low, b.i64(2));
  }
  const Value quadrant = b.iadd(b.lshr(top, b.i64(62)), b.lshr(fraction, b.i64(63)));
  return {b.convert(Op::kTrunc, Type::kI32, quadrant), fraction, low};
}

Value emit_sin(Builder& b, Value x) { return sin_turned(b, x, 0); }
Value emit_cos(Builder& b, Value x) { return sin_turned(b, x, 1); }

Value emit_tan(Builder& b, Value x) {
  Math m(b);
  const Reduced reduced = reduce_to_quadrant(m, x, 3);
  const SinCos value = sin_cos_of_reduced(m, x, reduced.r);
  const Value odd = bit_set(b, reduced.quadrant, 1);
  return b.fdiv(b.select(odd, value.cos, value.sin), b.select(odd, b.fneg(value.sin), value.cos));
}

Value emit_asin(Builder& b, Value x) {
  Math m(b);
  const HalfAngle h = half_angle(m, x);
  const Value result = b.select(h.is_large, from_pio2(m, m.mul(h.core, m.f(2))), h.core);
  return m.with_sign(m.sign_bit(x), result);
}

Value emit_acos(Builder& b, Value x) {
  Math m(b);
  const HalfAngle h = half_angle(m, x);
  const Value negative = m.sign_bit(x);
  const Value twice = m.mul(h.core, m.f(2));
  const Value large = b.select(negative, m.mul(from_pio2(m, h.core), m.f(2)), twice);  // pi - 2 core = 2 (pi/2 - core)
  return b.select(h.is_large, large, from_pio2(m, m.with_sign(negative, h.core)));
}

Value emit_atan(Builder& b, Value x) {
  Math m(b);
  const Value magnitude = b.fabs(x);
  const Value is_large = b.flt(m.f(1), magnitude);
  const Value core = atan_core(m, b.select(is_large, b.fdiv(m.f(1), magnitude), magnitude));
  return m.with_sign(m.sign_bit(x), b.select(is_large, from_pio2(m, core), core));
}

Value emit_atan2(Builder& b, Value y, Value x) {
  Math m(b);
  const Value ax = b.fabs(x), ay = b.fabs(y);
  const Value steep = b.flt(ax, ay);
  const Value small = b.fmin(ay, ax), large = b.fmax(ay, ax);  // a NaN y passes
  // 0 / 0 counts as 0, inf / inf as 1.
  const Value equal = b.select(b.feq(large, m.f(0)), m.f(0), m.f(1));
  const Value core = atan_core(m, b.select(b.feq(small, large), equal, b.fdiv(small, large)));
  const Value right = b.select(steep, from_pio2(m, core), core);  // angle for x >= 0
  // pi - right, from pi/2 so that the low part of pi is kept
  const Value left =
      b.select(steep, m.add(m.f(kPio2[0]), m.add(core, m.f(kPio2[1]))), m.sub(m.f(2 * kPio2[0]), m.sub(core, m.f(2 * kPio2[1]))));
  const Value angle = b.select(m.sign_bit(x), left, right);
  return b.select(b.fne(x, x), x, m.with_sign(m.sign_bit(y), angle));
}

}  // namespace pineda::passes
