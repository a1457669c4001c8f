// Distances between a float and the real number that it should be.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

namespace pineda::cts {

inline float as_float(uint32_t bits) { return std::bit_cast<float>(bits); }
inline uint32_t as_bits(float value) { return std::bit_cast<uint32_t>(value); }

// The distance of neighbouring floats at |exact|; the smallest normal's below that (denormals may be flushed).
inline double ulp32(double exact) {
  int exponent = 0;
  if (exact == 0 || !std::isfinite(exact)) return std::ldexp(1.0, -149);
  std::frexp(exact, &exponent);
  return std::ldexp(1.0, std::max(exponent - 24, -149));
}

struct Tolerance {
  double ulp = 1;  // "correctly rounded" leaves the rounding mode open: less than one
  double absolute = 0;
};

// Whether `got` is an answer that the tolerance allows. Results below the normal range may be flushed to zero of either sign;
// beyond the largest float, infinity and the largest float are both allowed; a NaN must be NaN.
inline bool near_enough(float got, double exact, const Tolerance& tolerance) {
  if (std::isnan(exact)) return std::isnan(got);
  if (std::isnan(got)) return false;
  constexpr double kMax = std::numeric_limits<float>::max();
  const double allowed = tolerance.ulp * ulp32(exact) + tolerance.absolute;
  if (std::abs(exact) + allowed > kMax) {
    if (std::isinf(got)) return std::signbit(got) == std::signbit(exact) || allowed > std::abs(exact);
    if (std::isinf(exact)) return false;
  }
  if (std::isinf(got)) return false;
  if (std::abs(exact) - allowed < std::numeric_limits<float>::min() && got == 0) return true;
  return std::abs(static_cast<double>(got) - exact) <= allowed;
}

}  // namespace pineda::cts
