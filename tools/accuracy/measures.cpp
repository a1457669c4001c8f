#include "tools/accuracy/measures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace pineda::tools {
namespace {

constexpr double kSmallestTruth = 1.0 / 256;

size_t ulp_bin(double distance) {
  if (distance == 0) return 0;
  for (size_t bin = 1; bin + 1 < kUlpBins; ++bin) {
    if (distance <= std::ldexp(1.0, static_cast<int>(bin) - 1)) return bin;
  }
  return kUlpBins - 1;
}

}  // namespace

std::string ulp_bin_text(size_t bin) {
  if (bin == 0) return "0";
  if (bin + 1 == kUlpBins) return fmt::format("> {}", 1u << (kUlpBins - 3));
  return fmt::format("≤ {}", 1u << (bin - 1));
}

double distance_ulp(double value, double truth, double smallest_truth) {
  constexpr int kMantissaBits = 24, kLeastExponent = -149;
  // A truth that binary32 cannot hold is at least half a unit away from everything; what counts is the distance from the nearest
  // number, which a correctly rounded result has.
  if (value == static_cast<double>(static_cast<float>(truth))) return 0;
  int exponent = 0;
  std::frexp(std::max(std::abs(truth), smallest_truth), &exponent);
  const double ulp = std::ldexp(1.0, std::max(exponent - kMantissaBits, kLeastExponent));
  return std::abs(value - truth) / ulp;
}

PictureError measure_error(std::span<const float> floats, const std::vector<glm::dvec4>& truth, const std::vector<bool>& skip) {
  PictureError error;
  double squares = 0;
  size_t skipped = 0;
  for (size_t pixel = 0; pixel < truth.size(); ++pixel) {
    if (!skip.empty() && skip[pixel]) {
      ++skipped;
      continue;
    }
    for (int channel = 0; channel < 3; ++channel) {
      const double value = floats[4 * pixel + static_cast<size_t>(channel)], wanted = truth[pixel][channel];
      const double difference = std::abs(value - wanted), ulp = distance_ulp(value, wanted, kSmallestTruth);
      error.largest = std::max(error.largest, difference);
      error.largest_ulp = std::max(error.largest_ulp, ulp);
      squares += difference * difference;
      ++error.ulp_histogram[ulp_bin(ulp)];
    }
  }
  const size_t counted = truth.size() - skipped;
  if (counted) error.rmse = std::sqrt(squares / (3.0 * static_cast<double>(counted)));
  error.skipped_share = static_cast<double>(skipped) / static_cast<double>(truth.size());
  return error;
}

std::vector<bool> dominated(std::span<const CostPoint> points) {
  constexpr double kNoise = 0.95;
  std::vector<bool> result;
  for (const CostPoint& point : points) {
    result.push_back(std::ranges::any_of(points, [&](const CostPoint& other) {
      return other.time_ms <= point.time_ms && other.error <= point.error &&
             (other.time_ms < kNoise * point.time_ms || other.error < kNoise * point.error);
    }));
  }
  return result;
}

}  // namespace pineda::tools
