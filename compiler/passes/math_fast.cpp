// PINEDA_PRECISION=fast: what Vulkan demands, with room ("Precision and Operation of SPIR-V Instructions"):
//     exp2, exp 3 + 2|x| ULP    log2, log 3 ULP, 2^-21 absolute in [0.5, 2]    sin, cos 2^-11 absolute in [-pi, pi]
//     atan, atan2 4096 ULP      asin, acos by way of atan2                     pow as exp2(y log2 x)
// Denormal operands and results may become zero. Coefficients: tools/math/minimax.py.
#include "compiler/passes/lower_math.h"
#include "compiler/passes/math_parts.h"

namespace pineda::passes::fast {
namespace {

using ir::Builder;
using ir::Op;
using ir::Type;
using ir::Value;

// 2^x = 1 + x p(x) on [-0.5, 0.5]; error 2^-23.3
constexpr double kExp2[] = {0x1.62e42ap-1, 0x1.ebf9cp-3, 0x1.c6b6c4p-5, 0x1.3ce966p-7, 0x1.5be266p-10};
// log2(1 + t) = t p(t) on [sqrt(1/2) - 1, sqrt(2) - 1]; error 2^-25
constexpr double kLog2[] = {0x1.715476p+0,  -0x1.715472p-1, 0x1.ec736ap-2,  -0x1.715b72p-2, 0x1.26dc9ap-2,
                            -0x1.e98276p-3, 0x1.b95eccp-3,  -0x1.a77a7ap-3, 0x1.018098p-3};
// sin x = x + x^3 p(x^2), cos x = 1 - x^2 / 2 + x^4 p(x^2) up to pi/4 + 0.01; errors 2^-18.9 and 2^-23.4
constexpr double kSin[] = {-0x1.55434p-3, 0x1.0b59a6p-7};
constexpr double kCos[] = {0x1.5548f8p-5, -0x1.65a04ep-10};
// asin x = x + x^3 p(x^2) up to 1/2; error 2^-19.1
constexpr double kAsin[] = {0x1.559bf2p-3, 0x1.267e98p-4, 0x1.069c3ap-4};
// atan x = x + x^3 p(x^2) up to 1; error 2^-17.6
constexpr double kAtan[] = {-0x1.55153p-2, 0x1.91c658p-3, -0x1.f5c43ap-4, 0x1.e14c0cp-5, -0x1.c9002p-7};

constexpr double kLog2E = 0x1.715476p+0, kLn2 = 0x1.62e43p-1, kPio2 = 0x1.921fb6p+0, kPi = 0x1.921fb6p+1;

Value odd_poly(Math& m, Value x, std::span<const double> c) {
  const Value z = m.mul(x, x);
  return m.fma(m.mul(x, z), m.poly(z, c), x);
}

struct SinCos {
  Value sin, cos, quadrant;
};
SinCos sin_cos(Math& m, Value x) {
  const Reduced reduced = reduce_to_quadrant(m, x, 2);
  const Value z = m.mul(reduced.r, reduced.r);
  const Value cos = m.fma(z, m.fma(z, m.poly(z, kCos), m.f(-0.5)), m.f(1));
  const Value sin = m.b.select(m.b.feq(x, m.f(0)), x, odd_poly(m, reduced.r, kSin));  // keeps -0
  return {sin, cos, reduced.quadrant};
}

Value sin_turned(Builder& b, Value x, uint32_t turns) {
  Math m(b);
  const SinCos value = sin_cos(m, x);
  const Value quadrant = b.iadd(value.quadrant, b.i32(turns));
  return m.with_sign(bit_set(b, quadrant, 2), b.select(bit_set(b, quadrant, 1), value.cos, value.sin));
}

}  // namespace

// The exponent goes into the bits by one addition, which holds where the result is normal.
Value emit_exp2(Builder& b, Value x) {
  Math m(b);
  const Value clamped = b.fmin(x, m.f(128));  // 2^128 has the bits of infinity
  const Value sum = m.add(clamped, m.f(Math::kMagic));
  const Value f = m.sub(clamped, m.sub(sum, m.f(Math::kMagic)));
  const Value p = m.fma(f, m.poly(f, kExp2), m.f(1));
  static_assert((Math::kMagicBits << 23) == 0);
  const Value power = m.from_bits(b.iadd(m.raw_bits(p), b.shl(m.raw_bits(sum), b.i32(23))));
  return b.select(m.is_nan(x), x, b.select(b.flt(x, m.f(-126)), m.f(0), power));
}

Value emit_exp(Builder& b, Value x) {
  Math m(b);
  return emit_exp2(b, m.mul(x, m.f(kLog2E)));
}

Value emit_log2(Builder& b, Value x) {
  Math m(b);
  const Value bits = m.raw_bits(x);
  const Value exponent = b.ashr(b.isub(bits, b.i32(0x3f3504f3)), b.i32(23));  // bits of sqrt(1/2)
  const Value t = m.sub(m.from_bits(b.isub(bits, b.shl(exponent, b.i32(23)))), m.f(1));
  const Value sum = m.fma(t, m.poly(t, kLog2), b.convert(Op::kSToF, Type::kF32, exponent));
  const Value is_normal = b.and_(b.fle(m.f(0x1p-126), x), b.flt(x, m.inf()));
  const Value small = b.select(b.fle(m.f(0), x), b.fneg(m.inf()), m.nan());
  return b.select(is_normal, sum, b.select(b.flt(x, m.f(1)), small, x));
}

Value emit_log(Builder& b, Value x) {
  Math m(b);
  return m.mul(emit_log2(b, x), m.f(kLn2));
}

Value emit_pow(Builder& b, Value x, Value y) {
  Math m(b);
  const Value power = emit_exp2(b, m.mul(y, emit_log2(b, x)));
  return b.select(b.or_(b.feq(y, m.f(0)), b.feq(x, m.f(1))), m.f(1), power);
}

Value emit_sin(Builder& b, Value x) { return sin_turned(b, x, 0); }
Value emit_cos(Builder& b, Value x) { return sin_turned(b, x, 1); }

Value emit_tan(Builder& b, Value x) {
  Math m(b);
  const SinCos value = sin_cos(m, x);
  const Value odd = bit_set(b, value.quadrant, 1);
  return b.fdiv(b.select(odd, value.cos, value.sin), b.select(odd, b.fneg(value.sin), value.cos));
}

Value emit_asin(Builder& b, Value x) {
  Math m(b);
  const Value a = b.fabs(x), large = b.flt(m.f(0.5), a);
  const Value s = b.select(large, b.fsqrt(m.fma(a, m.f(-0.5), m.f(0.5))), a);
  const Value core = odd_poly(m, s, kAsin);
  return m.with_sign(m.sign_bit(x), b.select(large, m.fma(core, m.f(-2), m.f(kPio2)), core));
}

Value emit_acos(Builder& b, Value x) {
  Math m(b);
  const Value a = b.fabs(x), large = b.flt(m.f(0.5), a), negative = m.sign_bit(x);
  const Value s = b.select(large, b.fsqrt(m.fma(a, m.f(-0.5), m.f(0.5))), a);
  const Value core = odd_poly(m, s, kAsin);
  const Value twice = m.add(core, core);
  const Value far = b.select(negative, m.sub(m.f(kPi), twice), twice);
  return b.select(large, far, m.sub(m.f(kPio2), m.with_sign(negative, core)));
}

Value emit_atan(Builder& b, Value x) {
  Math m(b);
  const Value a = b.fabs(x), large = b.flt(m.f(1), a);
  const Value core = odd_poly(m, b.select(large, b.fdiv(m.f(1), a), a), kAtan);
  return m.with_sign(m.sign_bit(x), b.select(large, m.sub(m.f(kPio2), core), core));
}

Value emit_atan2(Builder& b, Value y, Value x) {
  Math m(b);
  const Value ax = b.fabs(x), ay = b.fabs(y), steep = b.flt(ax, ay);
  const Value small = b.fmin(ay, ax), large = b.fmax(ay, ax);  // a NaN y passes
  // 0 / 0 counts as 0, inf / inf as 1.
  const Value equal = b.select(b.feq(large, m.f(0)), m.f(0), m.f(1));
  const Value core = odd_poly(m, b.select(b.feq(small, large), equal, b.fdiv(small, large)), kAtan);
  const Value right = b.select(steep, m.sub(m.f(kPio2), core), core);
  const Value angle = b.select(m.sign_bit(x), m.sub(m.f(kPi), right), right);
  return b.select(m.is_nan(x), x, m.with_sign(m.sign_bit(y), angle));
}

}  // namespace pineda::passes::fast
