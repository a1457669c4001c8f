// binary64. "The precision of double-precision instructions is at least that of single precision": what binary32 is allowed, in
// its own units, of which one is 2^29 ULP here. The truth is binary128.
#include <cmath>

#include "tools/errors/functions.h"

namespace pineda::tools {
namespace {

using Wide = __float128;

template <int kHalves>
double single_ulps(const Operands&, double exact) {
  return kHalves * 0.5 * 0x1p29 * ulp_of(exact, Width::k64);
}
double exactly(const Operands&, double) { return 0; }
// Formulas whose terms cancel: a share of the terms.
double share_of_terms(double terms) { return 4 * 0x1p-24 * terms; }
double allowed_fma(const Operands& in, double) { return share_of_terms(std::fabs(in.x * in.y) + std::fabs(in.z)); }
double allowed_mix(const Operands& in, double) {
  return share_of_terms(std::fabs(in.x) * (1 + std::fabs(in.z)) + std::fabs(in.y * in.z));
}
double allowed_dot(const Operands& in, double) { return share_of_terms(std::fabs(in.x * in.y) + std::fabs(in.y * in.z)); }
double allowed_mod(const Operands& in, double) {  // floor may take either neighbour
  return std::fabs(in.y) + share_of_terms(std::fabs(in.x) + std::fabs(in.y));
}

// One step of Newton from a result that is good to 2^-64.
Wide root(Wide x) {
  if (!(x > 0)) return static_cast<Wide>(std::sqrt(static_cast<double>(x)));
  const Wide r = sqrtl(static_cast<long double>(x));
  return (r + x / r) / 2;
}
Wide floor_mod(const Operands& in) {
  const double r = std::fmod(in.x, in.y);  // exact
  return r != 0 && (r < 0) != (in.y < 0) ? Wide(r) + in.y : Wide(r);
}

constexpr const char* kAsSingle = "as binary32's";
constexpr const char* kCorrect = "correctly rounded";

constexpr MeasuredFunction row(const char* name, uint32_t number, uint32_t operands, const char* demand, WideReference wide,
                               Allowed allowed, bool cancels = false, int exponent_limit = 300) {
  return {name, number, operands, demand, 0, nullptr, allowed, nullptr, nullptr, exponent_limit, cancels, Width::k64, wide};
}

const MeasuredFunction kFunctions[] = {
    row(
        "f64 sqrt", 192, 1, kAsSingle, [](const Operands& in) { return root(in.x); }, single_ulps<9>),
    row(
        "f64 inversesqrt", 193, 1, kAsSingle, [](const Operands& in) { return 1 / root(in.x); }, single_ulps<4>),
    row(
        "f64 fract", 194, 1, kAsSingle, [](const Operands& in) { return Wide(in.x) - std::floor(in.x); }, single_ulps<1>),
    row(
        "f64 floor", 195, 1, kCorrect, [](const Operands& in) { return Wide(std::floor(in.x)); }, exactly),
    row(
        "f64 roundEven", 196, 1, kCorrect, [](const Operands& in) { return Wide(std::nearbyint(in.x)); }, exactly),
    row(
        "f64 to f32 and back", 197, 1, "correctly rounded to binary32",
        [](const Operands& in) { return Wide(static_cast<float>(in.x)); }, exactly, false, 126),
    row(
        "f64 x + y", 208, 2, kAsSingle, [](const Operands& in) { return Wide(in.x) + in.y; }, single_ulps<1>),
    row(
        "f64 x - y", 209, 2, kAsSingle, [](const Operands& in) { return Wide(in.x) - in.y; }, single_ulps<1>),
    row(
        "f64 x * y", 210, 2, kAsSingle, [](const Operands& in) { return Wide(in.x) * in.y; }, single_ulps<1>),
    row(
        "f64 x / y", 211, 2, kAsSingle, [](const Operands& in) { return Wide(in.x) / in.y; }, single_ulps<5>),
    row("f64 mod", 212, 2, kAsSingle, floor_mod, allowed_mod, true, 30),
    row(
        "f64 length(vec2)", 213, 2, kAsSingle, [](const Operands& in) { return root(Wide(in.x) * in.x + Wide(in.y) * in.y); },
        single_ulps<11>),
    row(
        "f64 fma", 214, 3, kAsSingle, [](const Operands& in) { return Wide(in.x) * in.y + in.z; }, allowed_fma, true),
    row(
        "f64 mix", 215, 3, kAsSingle, [](const Operands& in) { return Wide(in.x) * (1 - Wide(in.z)) + Wide(in.y) * in.z; },
        allowed_mix, true),
    row(
        "f64 dot(vec2)", 216, 3, kAsSingle, [](const Operands& in) { return Wide(in.x) * in.y + Wide(in.y) * in.z; }, allowed_dot,
        true),
};

}  // namespace

std::span<const MeasuredFunction> double_functions() { return kFunctions; }

}  // namespace pineda::tools
