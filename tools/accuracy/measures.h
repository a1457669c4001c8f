// Errors of a picture of floats against a truth in double precision, and which of several ways to draw it are dominated.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "tools/accuracy/reference.h"

namespace pineda::tools {

// Distances in units in the last place of binary32: 0, up to 1, 2, 4 ... 2^16, beyond.
inline constexpr size_t kUlpBins = 19;
std::string ulp_bin_text(size_t bin);

struct PictureError {
  double largest = 0, rmse = 0;  // over red, green and blue; 1 is the range of a colour
  double largest_ulp = 0;
  std::array<uint64_t, kUlpBins> ulp_histogram{};  // of components
  double skipped_share = 0;                        // pixels left out
};

// `floats`: four a pixel. Pixels with `skip` are left out (empty: none are). A unit in the last place is that of the true value,
// but at least that of 2^-8: a colour's distance from black is not what an ULP of a number near zero measures.
PictureError measure_error(std::span<const float> floats, const std::vector<glm::dvec4>& truth, const std::vector<bool>& skip);

double distance_ulp(double value, double truth, double smallest_truth = 0);  // in units in the last place of binary32

struct CostPoint {
  double time_ms, error;
};
// Whether another point is at least as good in both and better by more than the timing noise (5 %) in one.
std::vector<bool> dominated(std::span<const CostPoint> points);

}  // namespace pineda::tools
