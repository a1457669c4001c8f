// What a formula inherits: interval arithmetic in which each operation widens its result by the error that Vulkan allows it
// ("Precision and Operation of SPIR-V Instructions"). An operand is exact until an operation has touched it.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "tools/errors/functions.h"

namespace pineda::tools {

template <Width kWidth>
class Interval {
 public:
  Interval(double exact) : low_(exact), high_(exact) {}  // NOLINT: operands become intervals where formulas use them
  Interval(double low, double high) : low_(low), high_(high) {}

  double low() const { return low_; }
  double high() const { return high_; }
  // How far a result may be from `exact`; infinity when anything may come out.
  double error(double exact) const {
    if (!(std::isfinite(low_) && std::isfinite(high_))) return std::numeric_limits<double>::infinity();
    return std::max({high_ - exact, exact - low_, 0.0});
  }
  // What may overflow may become anything.
  Interval widened(double ulp) const {
    const Interval wide(low_ - ulp * ulp_of(low_, kWidth), high_ + ulp * ulp_of(high_, kWidth));
    const bool fits = wide.high_ <= largest_finite(kWidth) && wide.low_ >= -largest_finite(kWidth);
    return fits ? wide : anything();
  }
  Interval widened_by(double absolute) const { return {low_ - absolute, high_ + absolute}; }

  friend Interval operator-(const Interval& a) { return {-a.high_, -a.low_}; }
  friend Interval operator+(const Interval& a, const Interval& b) {
    return Interval(a.low_ + b.low_, a.high_ + b.high_).widened(0.5);
  }
  friend Interval operator-(const Interval& a, const Interval& b) { return a + -b; }
  friend Interval operator*(const Interval& a, const Interval& b) { return of_corners(a, b, std::multiplies<>()).widened(0.5); }
  friend Interval operator/(const Interval& a, const Interval& b) {  // 2.5 ULP
    if (b.low_ <= 0 && b.high_ >= 0) return anything();
    return of_corners(a, b, std::divides<>()).widened(2.5);
  }
  static Interval anything() {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    return {-kInfinity, kInfinity};
  }

  // Of a function that is monotonic on the interval.
  template <typename Fn>
  Interval of_ends(Fn&& fn) const {
    const double a = fn(low_), b = fn(high_);
    return std::isnan(a) || std::isnan(b) ? anything() : Interval(std::min(a, b), std::max(a, b));
  }
  template <typename Fn>
  static Interval of_corners(const Interval& a, const Interval& b, Fn&& fn) {
    const double corners[] = {fn(a.low_, b.low_), fn(a.low_, b.high_), fn(a.high_, b.low_), fn(a.high_, b.high_)};
    const auto [low, high] = std::minmax_element(std::begin(corners), std::end(corners));
    return std::ranges::any_of(corners, [](double c) { return std::isnan(c); }) ? anything() : Interval(*low, *high);
  }

 private:
  double low_, high_;
};

// ---- the functions of GLSL.std.450 on intervals -----------------------------------------------------------------------------

// 2 ULP; of what may be negative nothing is known.
template <Width kWidth>
Interval<kWidth> inverse_sqrt(const Interval<kWidth>& x) {
  if (x.low() <= 0) return Interval<kWidth>::anything();
  return x.of_ends([](double v) { return 1 / std::sqrt(v); }).widened(2);
}
// "Inherited from 1.0 / inversesqrt()": 2 and 2.5 ULP. What rounding has made negative may as well be zero.
template <Width kWidth>
Interval<kWidth> square_root(const Interval<kWidth>& x) {
  if (x.high() < 0) return Interval<kWidth>::anything();
  return x.of_ends([](double v) { return std::sqrt(std::max(v, 0.0)); }).widened(4.5);
}
template <Width kWidth>
Interval<kWidth> exponential(const Interval<kWidth>& x) {  // 3 + 2 |x| ULP; binary16: 1 + 2 |x|
  const double steps = (kWidth == Width::k16 ? 1 : 3) + 2 * std::max(std::fabs(x.low()), std::fabs(x.high()));
  return x.of_ends([](double v) { return std::exp(v); }).widened(steps);
}
template <Width kWidth>
Interval<kWidth> logarithm(const Interval<kWidth>& x) {  // 3 ULP; 2^-21 absolute in [0.5, 2] (binary16: 2^-7)
  if (x.low() <= 0) return Interval<kWidth>::anything();
  const auto exact = x.of_ends([](double v) { return std::log(v); });
  const bool inside = x.high() >= 0.5 && x.low() <= 2, outside = x.low() < 0.5 || x.high() > 2;
  const auto near_one = inside ? exact.widened_by(kWidth == Width::k16 ? 0x1p-7 : 0x1p-21) : exact;
  const auto far = outside ? exact.widened(3) : exact;
  return {std::min(near_one.low(), far.low()), std::max(near_one.high(), far.high())};
}
template <Width kWidth>
Interval<kWidth> arc_tangent(const Interval<kWidth>& y, const Interval<kWidth>& x) {       // 4096 ULP; binary16: 5 ULP
  if (x.low() <= 0 && y.low() <= 0 && y.high() >= 0) return Interval<kWidth>::anything();  // the cut, or the origin
  return Interval<kWidth>::of_corners(y, x, [](double a, double b) { return std::atan2(a, b); })
      .widened(kWidth == Width::k16 ? 5 : 4096);
}

}  // namespace pineda::tools
