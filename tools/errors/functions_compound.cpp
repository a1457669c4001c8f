// Vectors, matrices, conversions and packing in binary32. What Vulkan lets each inherit comes from its formula in intervals.
#include <bit>
#include <cmath>
#include <limits>

#include "tools/errors/interval.h"

namespace pineda::tools {
namespace {

using I = Interval<Width::k32>;

constexpr double kAnything = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// Operands are binary32 values, so their bits can be had back.
uint32_t bits_of(double x) { return std::bit_cast<uint32_t>(static_cast<float>(x)); }

double exactly(const Operands&, double) { return 0; }
template <int kHalves>
double ulps(const Operands&, double exact) {
  return kHalves * 0.5 * ulp_of(exact);
}
template <I (*kFormula)(const I&, const I&, const I&)>
double inherited(const Operands& in, double exact) {
  return kFormula(in.x, in.y, in.z).error(exact);
}

// ---- formulas -------------------------------------------------------------------------------------------------------------

I remainder(const I& x, const I& y, const I&) {  // x - y * trunc(x / y); trunc may take any integer in reach
  const I q = x / y;
  if (!(std::fabs(q.low()) < 0x1p125 && std::fabs(q.high()) < 0x1p125)) return I::anything();
  return x - y * I(std::trunc(q.low()), std::trunc(q.high()));
}
double allowed_remainder(const Operands& in, double exact) {
  const double y = std::fabs(in.y), q = std::fabs(in.x / in.y);
  if (!(y >= 0x1p-126 && y <= 0x1p126) || (q != 0 && q < 0x1p-126)) return kAnything;
  return remainder(in.x, in.y, 0).error(exact);
}
I distance3(const I& x, const I& y, const I& z) {  // sqrt(dot(d, d)), d = (x - y, y - z, z - x)
  const I a = x - y, b = y - z, c = z - x;
  return square_root(a * a + b * b + c * c);
}
I normalize3(const I& x, const I& y, const I& z) { return x * inverse_sqrt(x * x + y * y + z * z); }
I reflect2(const I& x, const I& y, const I& z) {  // of (x, y) at (y, z)
  const I dot = y * x + z * y;
  return x - I(2) * dot * y;
}
I dot2(const I& a, const I& b, const I& c, const I& d) { return a * b + c * d; }
I refract2(const I& x, const I& y, const I& eta) {  // of (x, y) at (y, eta) by eta
  const I dot = dot2(y, x, eta, y);
  const I k = I(1) - eta * eta * (I(1) - dot * dot);
  const I bent = eta * x - (eta * dot + square_root(k)) * y;
  if (k.high() < 0) return 0;
  if (k.low() >= 0) return bent;
  return {std::min(bent.low(), 0.0), std::max(bent.high(), 0.0)};
}
I forward2(const I& x, const I& y, const I& z) {  // N = (x, y), I = (y, z), Nref = (z, x)
  const I dot = dot2(z, y, x, z);
  return dot.high() < 0 ? x : dot.low() >= 0 ? -x : I(-std::fabs(x.low()), std::fabs(x.low()));
}
I matrix_vector(const I& x, const I& y, const I& z) { return x * y + z * z; }

double reflect_exact(const Operands& in) { return in.x - 2 * (in.y * in.x + in.z * in.y) * in.y; }
double refract_exact(const Operands& in) {
  const double eta = in.z, dot = in.y * in.x + in.z * in.y, k = 1 - eta * eta * (1 - dot * dot);
  return k < 0 ? 0 : eta * in.x - (eta * dot + std::sqrt(k)) * in.y;
}
double forward_exact(const Operands& in) { return in.z * in.y + in.x * in.z < 0 ? in.x : -in.x; }

// ---- determinants: Vulkan leaves their precision undefined ---------------------------------------------------------------

// Of an n x n matrix by the first column; `sum` gets the sum of the products' magnitudes, the permanent of the magnitudes.
template <int n>
double determinant(const double (&m)[n][n], double* sum) {
  if constexpr (n == 1) {
    *sum = std::fabs(m[0][0]);
    return m[0][0];
  } else {
    double total = 0;
    *sum = 0;
    for (int r = 0; r < n; ++r) {
      double minor[n - 1][n - 1], part = 0;
      for (int c = 1; c < n; ++c) {
        for (int k = 0; k < n - 1; ++k) minor[c - 1][k] = m[c][k + (k >= r)];
      }
      const double cofactor = determinant<n - 1>(minor, &part);
      total += (r % 2 ? -1 : 1) * m[0][r] * cofactor;
      *sum += std::fabs(m[0][r]) * part;
    }
    return total;
  }
}
struct Determinant {
  double value, error;  // n rounded products and n! - 1 sums of them, in whatever order
};
Determinant determinant2(const Operands& in) {
  const double m[2][2] = {{in.x, in.y}, {in.z, in.x}};
  double sum;
  const double value = determinant(m, &sum);
  return {value, 3 * 0x1p-24 * sum};
}
Determinant determinant3(const Operands& in) {
  const double m[3][3] = {{in.x, in.y, in.z}, {in.y, in.z, in.x}, {1, in.x, in.y}};
  double sum;
  const double value = determinant(m, &sum);
  return {value, 8 * 0x1p-24 * sum};
}
Determinant determinant4(const Operands& in) {
  const double m[4][4] = {{in.x, in.y, in.z, 1}, {in.y, in.z, in.x, 2}, {in.z, 1, in.y, in.x}, {1, in.x, 2, in.y}};
  double sum;
  const double value = determinant(m, &sum);
  return {value, 27 * 0x1p-24 * sum};
}
template <Determinant (*kFn)(const Operands&)>
double value_of(const Operands& in) {
  return kFn(in).value;
}
template <Determinant (*kFn)(const Operands&)>
double error_of(const Operands& in, double) {
  return kFn(in).error;
}
// Element [0][0] of an inverse: a cofactor over the determinant.
double quotient_error(double cofactor, double cofactor_error, const Determinant& d) {
  if (std::fabs(d.value) <= 2 * d.error) return kAnything;
  const double q = std::fabs(cofactor / d.value);
  return (cofactor_error + q * d.error) / (std::fabs(d.value) - d.error) + 5 * ulp_of(q);
}
double inverse2(const Operands& in) {
  const double d = determinant2(in).value;
  return d == 0 ? kNan : in.x / d;
}
double allowed_inverse2(const Operands& in, double) { return quotient_error(in.x, 0, determinant2(in)); }
double cofactor3(const Operands& in) { return in.z * in.y - in.x * in.x; }
double inverse3(const Operands& in) {
  const double d = determinant3(in).value;
  return d == 0 ? kNan : cofactor3(in) / d;
}
double allowed_inverse3(const Operands& in, double) {
  return quotient_error(cofactor3(in), 3 * 0x1p-24 * (std::fabs(in.z * in.y) + in.x * in.x), determinant3(in));
}

// ---- packing and conversions ----------------------------------------------------------------------------------------------

double clamped(double x, double low, double high) { return std::fmin(std::fmax(x, low), high); }
// round(clamp(x, low, 1) * scale): half a step for rounding, and what the product may be off by.
template <int kScale, int kLow>
double packed(const Operands& in) {
  return clamped(in.x, kLow, 1) * kScale;
}
template <int kScale>
double allowed_packed(const Operands&, double) {
  return 0.5 + kScale * 0x1p-24;
}
template <int kShift, int kBits>
double unpacked_unorm(const Operands& in) {
  constexpr uint32_t kMax = (1u << kBits) - 1;
  return static_cast<double>(bits_of(in.x) >> kShift & kMax) / kMax;
}
template <int kShift, int kBits>
double unpacked_snorm(const Operands& in) {
  const auto field = static_cast<int32_t>(bits_of(in.x) << (32 - kShift - kBits)) >> (32 - kBits);
  return std::fmax(static_cast<double>(field) / ((1 << (kBits - 1)) - 1), -1);
}
double half_value(const Operands& in) {
  const uint32_t bits = bits_of(in.x) >> 16, exponent = bits >> 10 & 31, fraction = bits & 1023;
  const double magnitude = exponent == 31  ? (fraction ? kNan : kAnything)
                           : exponent == 0 ? std::ldexp(fraction, -24)
                                           : std::ldexp(1024 + fraction, static_cast<int>(exponent) - 25);
  return bits & 0x8000 ? -magnitude : magnitude;
}
double same(const Operands& in) { return in.x; }
// Either neighbour in binary16; beyond its range anything between the largest and infinity, below it zero.
double allowed_half(const Operands& in, double) { return std::fabs(in.x) > 65504 ? kAnything : ulp_of(in.x, Width::k16); }
// "If Value is ... too small to be represented as a normalized 16-bit ..., the result is ... zero."
double allowed_quantized(const Operands& in, double exact) {
  return std::fabs(in.x) < 0x1p-14 ? std::fabs(in.x) : allowed_half(in, exact);
}
double from_int(const Operands& in) { return static_cast<int32_t>(bits_of(in.x)); }
double from_uint(const Operands& in) { return bits_of(in.x); }
double to_int(const Operands& in) { return std::trunc(in.x); }
double allowed_to_int(const Operands& in, double exact) {  // beyond the range of int the result is undefined
  return std::fabs(in.x) < 0x1p31 ? 0.5 * ulp_of(exact) : kAnything;
}
double allowed_to_uint(const Operands& in, double exact) { return in.x > -1 && in.x < 0x1p32 ? 0.5 * ulp_of(exact) : kAnything; }
double allowed_round(const Operands&, double exact) { return std::fabs(exact) < 0x1p23 ? 0.5 : 0; }

constexpr const char* kCorrect = "correctly rounded";
constexpr const char* kUndefined = "undefined; here the roundings of its products and sums";

const MeasuredFunction kFunctions[] = {
    {"abs", 29, 1, kCorrect, 0, [](const Operands& in) { return std::fabs(in.x); }, exactly},
    {"-x", 30, 1, kCorrect, 0, [](const Operands& in) { return -in.x; }, exactly},
    {"round", 31, 1, "an integer nearest to x", 0, same, allowed_round, nullptr, nullptr, 128, true},
    {"packUnorm4x8", 96, 1, "round(clamp(x, 0, 1) · 255)", 0, packed<255, 0>, allowed_packed<255>, nullptr, nullptr, 128, true},
    {"packSnorm4x8", 97, 1, "round(clamp(x, -1, 1) · 127)", 0, packed<127, -1>, allowed_packed<127>, nullptr, nullptr, 128, true},
    {"packUnorm2x16", 98, 1, "round(clamp(x, 0, 1) · 65535)", 0, packed<65535, 0>, allowed_packed<65535>, nullptr, nullptr, 128,
     true},
    {"packSnorm2x16", 99, 1, "round(clamp(x, -1, 1) · 32767)", 0, packed<32767, -1>, allowed_packed<32767>, nullptr, nullptr, 128,
     true},
    {"unpackUnorm4x8", 100, 1, "from f / 255", 2.5, unpacked_unorm<8, 8>, ulps<5>},
    {"unpackSnorm4x8", 101, 1, "from f / 127", 2.5, unpacked_snorm<16, 8>, ulps<5>},
    {"unpackUnorm2x16", 102, 1, "from f / 65535", 2.5, unpacked_unorm<0, 16>, ulps<5>},
    {"unpackSnorm2x16", 103, 1, "from f / 32767", 2.5, unpacked_snorm<16, 16>, ulps<5>},
    {"unpackHalf2x16", 104, 1, kCorrect, 0, half_value, exactly},
    {"packHalf2x16", 105, 1, "a neighbour in binary16", 0, same, allowed_half, nullptr, nullptr, 128, true},
    {"OpQuantizeToF16", 106, 1, "a neighbour in binary16, or 0", 0, same, allowed_quantized, nullptr, nullptr, 128, true},
    {"int to float", 107, 1, kCorrect, 0.5, from_int, ulps<1>},
    {"uint to float", 108, 1, kCorrect, 0.5, from_uint, ulps<1>},
    {"float to int", 109, 1, "x towards zero, in range", 0, to_int, allowed_to_int, nullptr, nullptr, 128, true},
    {"float to uint", 110, 1, "x towards zero, in range", 0, to_int, allowed_to_uint, nullptr, nullptr, 128, true},
    {"OpFRem", 45, 2, "from x - y·trunc(x / y)", 0.5, [](const Operands& in) { return std::fmod(in.x, in.y); }, allowed_remainder,
     nullptr, nullptr, 128, true},
    {"NMin", 46, 2, kCorrect, 0, [](const Operands& in) { return std::fmin(in.x, in.y); }, exactly},
    {"NMax", 47, 2, kCorrect, 0, [](const Operands& in) { return std::fmax(in.x, in.y); }, exactly},
    {"NClamp", 77, 3, kCorrect, 0, [](const Operands& in) { return clamped(in.x, std::min(in.y, in.z), std::max(in.y, in.z)); },
     exactly},
    {"distance(vec3)", 72, 3, "from length(x - y)", 0,
     [](const Operands& in) {
       const double a = in.x - in.y, b = in.y - in.z, c = in.z - in.x;
       return std::sqrt(a * a + b * b + c * c);
     },
     inherited<distance3>, nullptr, nullptr, 20},
    {"normalize(vec3).x", 73, 3, "from x · inversesqrt(dot(x, x))", 0,
     [](const Operands& in) { return in.x / std::sqrt(in.x * in.x + in.y * in.y + in.z * in.z); }, inherited<normalize3>, nullptr,
     nullptr, 40},
    {"faceforward(vec2).x", 74, 3, "from dot(Nref, I) < 0", 0, forward_exact, inherited<forward2>, nullptr, nullptr, 25, true},
    {"reflect(vec2).x", 75, 3, "from x - 2·dot(y, x)·y", 0, reflect_exact, inherited<reflect2>, nullptr, nullptr, 8, true},
    {"refract(vec2).x", 76, 3, "from its formula", 0, refract_exact, inherited<refract2>, nullptr, nullptr, 5, true},
    {"(mat2 · vec2).x", 78, 3, "from products and a sum", 0, [](const Operands& in) { return in.x * in.y + in.z * in.z; },
     inherited<matrix_vector>, nullptr, nullptr, 13, true},
    {"determinant(mat3)", 79, 3, kUndefined, 0, value_of<determinant3>, error_of<determinant3>, nullptr, nullptr, 8, true},
    {"determinant(mat4)", 80, 3, kUndefined, 0, value_of<determinant4>, error_of<determinant4>, nullptr, nullptr, 5, true},
    {"inverse(mat2)[0][0]", 81, 3, kUndefined, 0, inverse2, allowed_inverse2, nullptr, nullptr, 8, true},
    {"inverse(mat3)[0][0]", 82, 3, kUndefined, 0, inverse3, allowed_inverse3, nullptr, nullptr, 6, true},
};

}  // namespace

std::span<const MeasuredFunction> compound_functions() { return kFunctions; }

}  // namespace pineda::tools
