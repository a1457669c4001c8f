// binary16: operands and results are binary16 values (measured_half.comp). binary64 computes all of them exactly enough.
#include <cmath>
#include <limits>
#include <numbers>

#include "tools/errors/interval.h"

namespace pineda::tools {
namespace {

using I = Interval<Width::k16>;

constexpr double kAnything = std::numeric_limits<double>::infinity();

template <double (*kFn)(double)>
double of_x(const Operands& in) {
  return kFn(in.x);
}
template <int kHalves>
double ulps(const Operands&, double exact) {
  return kHalves * 0.5 * ulp_of(exact, Width::k16);
}
double exactly(const Operands&, double) { return 0; }
template <I (*kFormula)(const I&)>
double inherited(const Operands& in, double exact) {
  return kFormula(in.x).error(exact);
}
template <I (*kFormula)(const I&, const I&, const I&)>
double inherited(const Operands& in, double exact) {
  return kFormula(in.x, in.y, in.z).error(exact);
}

bool in_circle(double x) { return std::fabs(x) <= std::numbers::pi; }
double allowed_sin(const Operands& in, double) { return in_circle(in.x) ? 0x1p-7 : kAnything; }
double allowed_tan(const Operands& in, double exact) {
  if (!in_circle(in.x)) return kAnything;
  return (I(std::sin(in.x)).widened_by(0x1p-7) / I(std::cos(in.x)).widened_by(0x1p-7)).error(exact);
}
// exp2 and log2 have the bounds of exp and log.
double allowed_exp(const Operands& in, double exact) { return (1 + 2 * std::fabs(in.x)) * ulp_of(exact, Width::k16); }
double allowed_log(const Operands& in, double exact) { return in.x >= 0.5 && in.x <= 2 ? 0x1p-7 : 3 * ulp_of(exact, Width::k16); }
double allowed_div(const Operands& in, double exact) {
  const double y = std::fabs(in.y);
  return y < 0x1p-14 || y > 0x1p14 ? kAnything : 2.5 * ulp_of(exact, Width::k16);
}
I root_of_rest(const I& x) { return square_root(I(1) - x * x); }
I arc_sine(const I& x) { return arc_tangent(x, root_of_rest(x)); }
I arc_cosine(const I& x) { return arc_tangent(root_of_rest(x), x); }
I hyperbolic_sine(const I& x) { return (exponential(x) - exponential(-x)) * I(0.5); }
I hyperbolic_cosine(const I& x) { return (exponential(x) + exponential(-x)) * I(0.5); }
// An exponential that leaves binary16 takes everything with it.
template <I (*kFormula)(const I&)>
double within_exp(const Operands& in, double exact) {
  return std::fabs(in.x) > 11 ? kAnything : kFormula(in.x).error(exact);
}
I hyperbolic_tangent(const I& x) { return hyperbolic_sine(x) / hyperbolic_cosine(x); }
I area_sine(const I& x) { return logarithm(x + square_root(x * x + I(1))); }
I area_cosine(const I& x) { return logarithm(x + square_root(x * x - I(1))); }
I area_tangent(const I& x) { return logarithm((I(1) + x) / (I(1) - x)) * I(0.5); }
template <I (*kFormula)(const I&)>
double within_square(const Operands& in, double exact) {
  return std::fabs(in.x) > 255 ? kAnything : kFormula(in.x).error(exact);
}
I power(const I& x, const I& y, const I&) {  // exp2(y * log2(x))
  if (x.low() <= 0) return I::anything();
  const double log = std::log2(x.low());
  const bool near_one = x.low() >= 0.5 && x.low() <= 2;
  const I product = y * (near_one ? I(log).widened_by(0x1p-7) : I(log).widened(3));
  const double steps = 1 + 2 * std::max(std::fabs(product.low()), std::fabs(product.high()));
  return product.of_ends([](double v) { return std::exp2(v); }).widened(steps);
}
I floored_remainder(const I& x, const I& y, const I&) {
  const I q = x / y;
  return x - y * I(std::floor(q.low()), std::floor(q.high()));
}
double allowed_mod(const Operands& in, double exact) {
  const double y = std::fabs(in.y), q = std::fabs(in.x / in.y);
  if (y < 0x1p-14 || y > 0x1p14 || q > 32768 || (q != 0 && q < 0x1p-14)) return kAnything;
  return floored_remainder(in.x, in.y, 0).error(exact);
}
I length2(const I& x, const I& y, const I&) { return square_root(x * x + y * y); }
I dot2(const I& x, const I& y, const I& z) { return x * y + y * z; }
I multiply_add(const I& x, const I& y, const I& z) { return x * y + z; }
I blend(const I& x, const I& y, const I& a) { return x * (I(1) - a) + y * a; }

double inverse_root(double x) { return 1 / std::sqrt(x); }
double fraction(double x) { return x - std::floor(x); }
double floor_mod(const Operands& in) {
  const double r = std::fmod(in.x, in.y);
  return r != 0 && (r < 0) != (in.y < 0) ? r + in.y : r;
}

constexpr const char* kCorrect = "correctly rounded";
constexpr const char* kCircle = "2^-7 absolute in [-π, π]";

// The operands of a sample go through all 2^16 values of x.
constexpr MeasuredFunction one(const char* name, uint32_t number, const char* demand, Reference reference, Allowed allowed) {
  return {name, number, 1, demand, 0, reference, allowed, nullptr, nullptr, 128, false, Width::k16};
}
constexpr MeasuredFunction more(const char* name, uint32_t number, uint32_t operands, const char* demand, Reference reference,
                                Allowed allowed, bool cancels = false, int exponent_limit = 15) {
  return {name, number, operands, demand, 0, reference, allowed, nullptr, nullptr, exponent_limit, cancels, Width::k16};
}

const MeasuredFunction kFunctions[] = {
    one("f16 sin", 128, kCircle, of_x<std::sin>, allowed_sin),
    one("f16 cos", 129, kCircle, of_x<std::cos>, allowed_sin),
    one("f16 tan", 130, "from sin(x) / cos(x)", of_x<std::tan>, allowed_tan),
    one("f16 asin", 131, "from atan2(x, sqrt(1 - x·x))", of_x<std::asin>, inherited<arc_sine>),
    one("f16 acos", 132, "from atan2(sqrt(1 - x·x), x)", of_x<std::acos>, inherited<arc_cosine>),
    one("f16 atan", 133, "5 ULP", of_x<std::atan>, ulps<10>),
    one("f16 sinh", 134, "from (exp(x) - exp(-x)) · 0.5", of_x<std::sinh>, within_exp<hyperbolic_sine>),
    one("f16 cosh", 135, "from (exp(x) + exp(-x)) · 0.5", of_x<std::cosh>, within_exp<hyperbolic_cosine>),
    one("f16 tanh", 136, "from sinh(x) / cosh(x)", of_x<std::tanh>, within_exp<hyperbolic_tangent>),
    one("f16 asinh", 137, "from log(x + sqrt(x·x + 1))", of_x<std::asinh>, within_square<area_sine>),
    one("f16 acosh", 138, "from log(x + sqrt(x·x - 1))", of_x<std::acosh>, within_square<area_cosine>),
    one("f16 atanh", 139, "from log((1 + x) / (1 - x)) · 0.5", of_x<std::atanh>, inherited<area_tangent>),
    one("f16 exp", 140, "1 + 2·|x| ULP", of_x<std::exp>, allowed_exp),
    one("f16 exp2", 141, "1 + 2·|x| ULP", of_x<std::exp2>, allowed_exp),
    one("f16 log", 142, "3 ULP; 2^-7 absolute in [0.5, 2]", of_x<std::log>, allowed_log),
    one("f16 log2", 143, "3 ULP; 2^-7 absolute in [0.5, 2]", of_x<std::log2>, allowed_log),
    one("f16 sqrt", 144, "from 1 / inversesqrt(x)", of_x<std::sqrt>, ulps<9>),
    one("f16 inversesqrt", 145, "2 ULP", of_x<inverse_root>, ulps<4>),
    one("f16 fract", 146, kCorrect, of_x<fraction>, ulps<1>),
    one("f16 floor", 147, kCorrect, of_x<std::floor>, exactly),
    one("f16 roundEven", 148, kCorrect, of_x<std::nearbyint>, exactly),
    more(
        "f16 x + y", 160, 2, kCorrect, [](const Operands& in) { return in.x + in.y; }, ulps<1>),
    more(
        "f16 x - y", 161, 2, kCorrect, [](const Operands& in) { return in.x - in.y; }, ulps<1>),
    more(
        "f16 x * y", 162, 2, kCorrect, [](const Operands& in) { return in.x * in.y; }, ulps<1>),
    more(
        "f16 x / y", 163, 2, "2.5 ULP", [](const Operands& in) { return in.x / in.y; }, allowed_div),
    more("f16 mod", 164, 2, "from x - y·floor(x / y)", floor_mod, allowed_mod, true),
    more(
        "f16 pow", 165, 2, "from exp2(y · log2(x))",
        [](const Operands& in) { return in.x < 0 ? std::numeric_limits<double>::quiet_NaN() : std::pow(in.x, in.y); },
        inherited<power>),
    more(
        "f16 atan2", 166, 2, "5 ULP", [](const Operands& in) { return std::atan2(in.x, in.y); }, ulps<10>),
    more(
        "f16 min", 167, 2, kCorrect, [](const Operands& in) { return std::fmin(in.x, in.y); }, exactly),
    more(
        "f16 length(vec2)", 168, 2, "from sqrt(dot(x, x))", [](const Operands& in) { return std::hypot(in.x, in.y); },
        inherited<length2>, false, 6),
    more(
        "f16 dot(vec2)", 169, 3, "from products and a sum", [](const Operands& in) { return in.x * in.y + in.y * in.z; },
        inherited<dot2>, true, 6),
    more(
        "f16 fma", 170, 3, "from x·y + z", [](const Operands& in) { return in.x * in.y + in.z; }, inherited<multiply_add>, true,
        6),
    more(
        "f16 mix", 171, 3, "from x·(1 - a) + y·a", [](const Operands& in) { return in.x * (1 - in.z) + in.y * in.z; },
        inherited<blend>, true, 6),
};

}  // namespace

std::span<const MeasuredFunction> half_functions() { return kFunctions; }

}  // namespace pineda::tools
