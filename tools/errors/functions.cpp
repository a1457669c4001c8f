#include "tools/errors/functions.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>

#include "tools/errors/vector_math.h"

namespace pineda::tools {

namespace {

struct Format {
  int min_exponent, fraction_bits;
  double largest;
};
constexpr Format kFormats[] = {{-14, 10, 65504}, {-126, 23, 0x1.fffffep127}, {-1022, 52, std::numeric_limits<double>::max()}};

}  // namespace

double ulp_of(double exact, Width width) {
  const Format& format = kFormats[static_cast<size_t>(width)];
  const bool normal = exact != 0 && std::isfinite(exact);
  return std::ldexp(1.0,
                    (normal ? std::max(std::ilogb(exact), format.min_exponent) : format.min_exponent) - format.fraction_bits);
}

double smallest_normal(Width width) { return std::ldexp(1.0, kFormats[static_cast<size_t>(width)].min_exponent); }
double largest_finite(Width width) { return kFormats[static_cast<size_t>(width)].largest; }

namespace {

constexpr double kAnything = std::numeric_limits<double>::infinity();
constexpr double kHalfUlp = 0x1p-24;  // relative error of a correctly rounded operation, at most

template <double (*kFn)(double)>
double of_x(const Operands& in) {
  return kFn(in.x);
}

// ---- what Vulkan allows ---------------------------------------------------------------------------------------------------

template <int kHalves>  // kHalves / 2 ULP
double ulps(const Operands&, double exact) {
  return kHalves * 0.5 * ulp_of(exact);
}
double exactly(const Operands&, double) { return 0; }

double allowed_exp(const Operands& in, double exact) { return (3 + 2 * std::fabs(in.x)) * ulp_of(exact); }
// 3 ULP outside [0.5, 2], 2^-21 absolute inside.
double log_error(double x, double exact) { return x >= 0.5 && x <= 2 ? 0x1p-21 : 3 * ulp_of(exact); }
double allowed_log(const Operands& in, double exact) { return log_error(in.x, exact); }
bool in_circle(double x) { return std::fabs(x) <= std::numbers::pi; }
double allowed_sin(const Operands& in, double) { return in_circle(in.x) ? 0x1p-11 : kAnything; }
// sin(x) / cos(x), each off by 2^-11, and the division.
double allowed_tan(const Operands& in, double exact) {
  const double s = std::fabs(std::sin(in.x)), c = std::fabs(std::cos(in.x)) - 0x1p-11;
  if (!in_circle(in.x) || c <= 0) return kAnything;
  return (s + 0x1p-11) / c - std::fabs(exact) + 2.5 * ulp_of(exact);
}
// Error of sqrt(1 - x * x), by which asin and acos are atan2 of the two: x * x and the difference round, sqrt has 4.5 ULP.
double half_circle_error(double x) {
  const double square = 1 - x * x, lost = kHalfUlp * (x * x + square);
  const double root = std::sqrt(std::max(square, 0.0));
  return (root > 0 ? std::min(lost / root, std::sqrt(lost)) : std::sqrt(lost)) + 9 * kHalfUlp * root;
}
double allowed_asin(const Operands& in, double exact) {  // d atan2(x, s) = -x ds on the unit circle
  return 4096 * ulp_of(exact) + std::fabs(in.x) * half_circle_error(in.x);
}
double allowed_exp_at(double x) { return (3 + 2 * std::fabs(x)) * ulp_of(std::exp(x)); }
double allowed_sinh(const Operands& in, double exact) {  // (exp(x) - exp(-x)) * 0.5
  if (std::fabs(in.x) > 88.7) return kAnything;          // exp overflows first
  return 0.5 * (allowed_exp_at(in.x) + allowed_exp_at(-in.x)) + 0.5 * ulp_of(exact);
}
double allowed_tanh(const Operands& in, double exact) {  // sinh(x) / cosh(x)
  if (std::fabs(in.x) > 43) return std::fabs(in.x) > 88.7 ? kAnything : 8192 * ulp_of(exact);
  const double c = std::cosh(in.x);
  const double sinh_error = allowed_sinh(in, std::sinh(in.x)), cosh_error = allowed_sinh(in, c);
  return sinh_error / c + std::fabs(exact) * cosh_error / c + 2.5 * ulp_of(exact);
}
// log(a), a = x + root with an absolute error.
double allowed_log_of(double a, double a_error, double exact) {
  return a_error >= a ? kAnything : log_error(a, exact) + a_error / (a - a_error);
}
double allowed_asinh(const Operands& in, double exact) {  // log(x + sqrt(x * x + 1))
  if (std::fabs(in.x) > 0x1p63) return kAnything;
  const double root = std::hypot(in.x, 1), a = in.x < 0 ? 1 / (root - in.x) : in.x + root;
  return allowed_log_of(a, 12 * kHalfUlp * root + kHalfUlp * a, exact);
}
double allowed_acosh(const Operands& in, double exact) {  // log(x + sqrt(x * x - 1))
  if (in.x > 0x1p63) return kAnything;
  const double square = in.x * in.x - 1, root = std::sqrt(square), lost = kHalfUlp * (in.x * in.x + square);
  const double root_error = root > 0 ? std::min(lost / root, std::sqrt(lost)) : std::sqrt(lost);
  return allowed_log_of(in.x + root, root_error + 10 * kHalfUlp * (in.x + root), exact);
}
double allowed_atanh(const Operands& in, double exact) {  // log((1 + x) / (1 - x)) * 0.5
  const double q = (1 + in.x) / (1 - in.x);
  return 0.5 * allowed_log_of(q, 7 * kHalfUlp * q, 2 * exact) + 0.5 * ulp_of(exact);
}
double allowed_div(const Operands& in, double exact) {
  const double y = std::fabs(in.y);
  return y < 0x1p-126 || y > 0x1p126 ? kAnything : 2.5 * ulp_of(exact);
}
double allowed_mod(const Operands& in, double exact) {  // x - y * floor(x / y)
  const double q = in.x / in.y, q_error = 2.5 * ulp_of(q);
  if (allowed_div(in, q) == kAnything || std::fabs(q) > 0x1p125 || std::fabs(q) < 0x1p-126) return kAnything;
  const double steps = std::floor(q + q_error) - std::floor(q - q_error);  // floor may take either
  return steps * std::fabs(in.y) + 0.5 * ulp_of(in.y * std::floor(q)) + 0.5 * ulp_of(std::max(std::fabs(exact), std::fabs(in.y)));
}
double allowed_pow(const Operands& in, double exact) {  // exp2(y * log2(x))
  if (!(in.x > 0)) return kAnything;
  const double log = std::log2(in.x), product = in.y * log;
  const double product_error = std::fabs(in.y) * log_error(in.x, log) + 0.5 * ulp_of(product);
  return (3 + 2 * std::fabs(product)) * ulp_of(exact) + std::fabs(exact) * std::expm1(std::numbers::ln2 * product_error);
}
double allowed_fma(const Operands& in, double exact) {
  const double product = in.x * in.y;
  return std::fabs(product) > 0x1.fffffep127 ? kAnything : 0.5 * ulp_of(product) + 0.5 * ulp_of(exact);
}
double allowed_mix(const Operands& in, double exact) {  // x * (1 - a) + y * a
  const double left = in.x * (1 - in.z), right = in.y * in.z;
  return ulp_of(left) + 0.5 * ulp_of(right) + 0.5 * ulp_of(exact) + ulp_of(std::max(std::fabs(left), std::fabs(right)));
}
double allowed_dot(const Operands& in, double exact) {
  const double sum = std::fabs(in.x * in.y) + std::fabs(in.y * in.z) + std::fabs(in.z * in.x);
  return 3 * kHalfUlp * sum + 0.5 * ulp_of(exact);
}
double allowed_two_products(const Operands&, double exact, double a, double b) {
  return 0.5 * ulp_of(a) + 0.5 * ulp_of(b) + 0.5 * ulp_of(exact);
}
double allowed_cross(const Operands& in, double exact) { return allowed_two_products(in, exact, in.y * in.x, in.z * in.z); }
double allowed_determinant(const Operands& in, double exact) { return allowed_two_products(in, exact, in.x * in.x, in.y * in.z); }

// ---- exact functions that <cmath> does not have ---------------------------------------------------------------------------

double inverse_sqrt(double x) { return 1 / std::sqrt(x); }
double radians(double x) { return x * (std::numbers::pi / 180); }
double degrees(double x) { return x * (180 / std::numbers::pi); }
double fract(double x) { return x - std::floor(x); }
double sign(double x) { return x > 0 ? 1 : x < 0 ? -1 : 0; }
double fraction(double x) { return x - std::trunc(x); }
double significand(double x) {
  int exponent;
  return std::frexp(x, &exponent);
}
double exponent(double x) {
  int exponent = 0;
  if (std::isfinite(x)) static_cast<void>(std::frexp(x, &exponent));
  return exponent;
}
double clamped(double x, double low, double high) { return std::min(std::max(x, low), high); }
double smooth_step(double low, double high, double x) {
  const double t = clamped((x - low) / (high - low), 0, 1);
  return t * t * (3 - 2 * t);
}
int precise_rsqrt(mpfr_t out, const mpfr_t x, mpfr_rnd_t rounding) { return mpfr_rec_sqrt(out, x, rounding); }

// x * y + z, the product being exact, rounded to odd, so that rounding it again to binary32 is correct (Boldo and Melquiond,
// 2008).
double fused(const Operands& in) {
  const double p = in.x * in.y, sum = p + in.z, z_part = sum - p;
  const double lost = (p - (sum - z_part)) + (in.z - z_part);
  const auto bits = std::bit_cast<uint64_t>(sum);
  if (lost == 0 || !std::isfinite(sum) || bits & 1) return sum;
  return std::bit_cast<double>((lost > 0) == (sum > 0) ? bits + 1 : bits - 1);
}

// ---- the table ------------------------------------------------------------------------------------------------------------

constexpr const char* kCorrect = "correctly rounded";
constexpr const char* kCircle = "2^-11 absolute in [-π, π]";

const MeasuredFunction kFunctions[] = {
    {"sin", 0, 1, kCircle, 8000, of_x<std::sin>, allowed_sin, vector_sin, mpfr_sin},
    {"cos", 1, 1, kCircle, 8000, of_x<std::cos>, allowed_sin, vector_cos, mpfr_cos},
    {"tan", 2, 1, "from sin(x) / cos(x)", 2.5, of_x<std::tan>, allowed_tan, vector_tan, mpfr_tan},
    {"asin", 3, 1, "from atan2(x, sqrt(1 - x·x))", 4096, of_x<std::asin>, allowed_asin, vector_asin, mpfr_asin},
    {"acos", 4, 1, "from atan2(sqrt(1 - x·x), x)", 4096, of_x<std::acos>, allowed_asin, vector_acos, mpfr_acos},
    {"atan", 5, 1, "4096 ULP", 4096, of_x<std::atan>, ulps<8192>, vector_atan, mpfr_atan},
    {"sinh", 6, 1, "from (exp(x) - exp(-x)) · 0.5", 3, of_x<std::sinh>, allowed_sinh, vector_sinh, mpfr_sinh},
    {"cosh", 7, 1, "from (exp(x) + exp(-x)) · 0.5", 3, of_x<std::cosh>, allowed_sinh, vector_cosh, mpfr_cosh},
    {"tanh", 8, 1, "from sinh(x) / cosh(x)", 3, of_x<std::tanh>, allowed_tanh, vector_tanh, mpfr_tanh},
    {"asinh", 9, 1, "from log(x + sqrt(x·x + 1))", 3, of_x<std::asinh>, allowed_asinh, vector_asinh, mpfr_asinh},
    {"acosh", 10, 1, "from log(x + sqrt(x·x - 1))", 3, of_x<std::acosh>, allowed_acosh, vector_acosh, mpfr_acosh},
    {"atanh", 11, 1, "from log((1 + x) / (1 - x)) · 0.5", 2, of_x<std::atanh>, allowed_atanh, vector_atanh, mpfr_atanh},
    {"exp", 12, 1, "3 + 2·|x| ULP", 3, of_x<std::exp>, allowed_exp, vector_exp, mpfr_exp},
    {"exp2", 13, 1, "3 + 2·|x| ULP", 3, of_x<std::exp2>, allowed_exp, vector_exp2, mpfr_exp2},
    {"log", 14, 1, "3 ULP; 2^-21 absolute in [0.5, 2]", 3, of_x<std::log>, allowed_log, vector_log, mpfr_log},
    {"log2", 15, 1, "3 ULP; 2^-21 absolute in [0.5, 2]", 3, of_x<std::log2>, allowed_log, vector_log2, mpfr_log2},
    {"sqrt", 16, 1, "from 1 / inversesqrt(x)", 4.5, of_x<std::sqrt>, ulps<9>, nullptr, mpfr_sqrt},
    {"inversesqrt", 17, 1, "2 ULP", 2, of_x<inverse_sqrt>, ulps<4>, nullptr, precise_rsqrt},
    {"radians", 18, 1, "from x · π/180", 1.5, of_x<radians>, ulps<3>},
    {"degrees", 19, 1, "from x · 180/π", 1.5, of_x<degrees>, ulps<3>},
    {"fract", 20, 1, "from x - floor(x)", 0.5, of_x<fract>, ulps<1>},
    {"floor", 21, 1, kCorrect, 0, of_x<std::floor>, exactly},
    {"ceil", 22, 1, kCorrect, 0, of_x<std::ceil>, exactly},
    {"trunc", 23, 1, kCorrect, 0, of_x<std::trunc>, exactly},
    {"roundEven", 24, 1, kCorrect, 0, of_x<std::nearbyint>, exactly},
    {"sign", 25, 1, kCorrect, 0, of_x<sign>, exactly},
    {"modf", 26, 1, kCorrect, 0, of_x<fraction>, exactly},
    {"frexp significand", 27, 1, kCorrect, 0, of_x<significand>, exactly},
    {"frexp exponent", 28, 1, kCorrect, 0, of_x<exponent>, exactly},
    {"x + y", 32, 2, kCorrect, 0.5, [](const Operands& in) { return in.x + in.y; }, ulps<1>},
    {"x - y", 33, 2, kCorrect, 0.5, [](const Operands& in) { return in.x - in.y; }, ulps<1>},
    {"x * y", 34, 2, kCorrect, 0.5, [](const Operands& in) { return in.x * in.y; }, ulps<1>},
    {"x / y", 35, 2, "2.5 ULP", 2.5, [](const Operands& in) { return in.x / in.y; }, allowed_div},
    {"mod", 36, 2, "from x - y·floor(x / y)", 0.5,
     [](const Operands& in) {
       const double r = std::fmod(in.x, in.y);
       return r != 0 && (r < 0) != (in.y < 0) ? r + in.y : r;
     },
     allowed_mod, nullptr, nullptr, 128, true},
    {"pow", 37, 2, "from exp2(y · log2(x))", 3,
     [](const Operands& in) { return in.x < 0 ? std::numeric_limits<double>::quiet_NaN() : std::pow(in.x, in.y); }, allowed_pow},
    {"atan2", 38, 2, "4096 ULP", 4096, [](const Operands& in) { return std::atan2(in.x, in.y); }, ulps<8192>},
    {"ldexp", 39, 2, kCorrect, 0.5,
     [](const Operands& in) { return std::ldexp(in.x, static_cast<int>(clamped(in.y, -1e6, 1e6))); }, ulps<1>, nullptr, nullptr,
     8},
    {"min", 40, 2, kCorrect, 0, [](const Operands& in) { return std::fmin(in.x, in.y); }, exactly},
    {"max", 41, 2, kCorrect, 0, [](const Operands& in) { return std::fmax(in.x, in.y); }, exactly},
    {"step", 42, 2, kCorrect, 0, [](const Operands& in) { return in.y < in.x ? 0.0 : 1.0; }, exactly},
    {"length(vec2)", 43, 2, "from sqrt(dot(x, x))", 5.5, [](const Operands& in) { return std::hypot(in.x, in.y); }, ulps<11>,
     nullptr, nullptr, 40},
    {"normalize(vec2).x", 44, 2, "from x / length(x)", 8, [](const Operands& in) { return in.x / std::hypot(in.x, in.y); },
     ulps<16>, nullptr, nullptr, 40},
    {"fma", 64, 3, "from x·y + z", 0.5, fused, allowed_fma, nullptr, nullptr, 128, true},
    {"clamp", 65, 3, kCorrect, 0, [](const Operands& in) { return clamped(in.x, std::min(in.y, in.z), std::max(in.y, in.z)); },
     exactly},
    {"mix", 66, 3, "from x·(1 - a) + y·a", 0.5, [](const Operands& in) { return in.x * (1 - in.z) + in.y * in.z; }, allowed_mix,
     nullptr, nullptr, 25, true},
    {"smoothstep", 67, 3, "from t·t·(3 - 2·t)", 16,
     [](const Operands& in) { return smooth_step(std::min(in.x, in.y), std::max(in.x, in.y), in.z); }, ulps<32>, nullptr, nullptr,
     30},
    {"length(vec3)", 68, 3, "from sqrt(dot(x, x))", 6,
     [](const Operands& in) { return std::sqrt(in.x * in.x + in.y * in.y + in.z * in.z); }, ulps<12>, nullptr, nullptr, 40},
    {"dot(vec3)", 69, 3, "from products and sums", 0.5,
     [](const Operands& in) { return in.x * in.y + in.y * in.z + in.z * in.x; }, allowed_dot, nullptr, nullptr, 13, true},
    {"cross(vec3).x", 70, 3, "from products and a difference", 0.5, [](const Operands& in) { return in.y * in.x - in.z * in.z; },
     allowed_cross, nullptr, nullptr, 13, true},
    {"determinant(mat2)", 71, 3, "from products and a difference", 0.5,
     [](const Operands& in) { return in.x * in.x - in.y * in.z; }, allowed_determinant, nullptr, nullptr, 13, true},
};

}  // namespace

std::span<const MeasuredFunction> scalar_functions() { return kFunctions; }

std::span<const MeasuredFunction> measured_functions() {
  static const std::vector<MeasuredFunction> all = [] {
    std::vector<MeasuredFunction> out;
    for (const auto part : {scalar_functions(), compound_functions(), half_functions(), double_functions()}) {
      out.insert(out.end(), part.begin(), part.end());
    }
    return out;
  }();
  return all;
}

}  // namespace pineda::tools
