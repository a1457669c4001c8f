#include "tools/image_metrics.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "tools/error.h"

namespace pineda::tools {
namespace {

void require_same_size(const Image& a, const Image& b) {
  if (a.width != b.width || a.height != b.height || a.rgba.size() != b.rgba.size()) {
    fail("pictures of different sizes: {}x{} and {}x{}", a.width, a.height, b.width, b.height);
  }
}

uint32_t pixel_difference(const uint8_t* a, const uint8_t* b) {
  int largest = 0;
  for (int channel = 0; channel < 4; ++channel) largest = std::max(largest, std::abs(a[channel] - b[channel]));
  return static_cast<uint32_t>(largest);
}

std::array<uint8_t, 3> difference_colour(uint32_t difference) {
  if (difference == 0) return {12, 14, 20};
  if (difference == 1) return {45, 92, 214};
  if (difference <= 2) return {32, 178, 138};
  if (difference <= 8) return {236, 200, 52};
  if (difference <= 32) return {240, 96, 48};
  return {255, 238, 232};
}

}  // namespace

std::string percent_text(double share) {
  if (share == 1) return "100 %";
  return fmt::format("{:.4f} %", std::floor(share * 1e6) / 1e4);
}

ImageMetrics measure(const Image& a, const Image& b) {
  require_same_size(a, b);
  ImageMetrics metrics{.pixel_count = uint64_t{a.width} * a.height};
  uint64_t differing_count = 0, squares = 0;
  for (size_t i = 0; i < a.rgba.size(); i += 4) {
    const uint32_t difference = pixel_difference(&a.rgba[i], &b.rgba[i]);
    metrics.largest_difference = std::max(metrics.largest_difference, difference);
    differing_count += difference != 0;
    metrics.beyond_one_count += difference > 1;
    for (size_t channel = i; channel < i + 4; ++channel) {
      const int64_t delta = int64_t{a.rgba[channel]} - b.rgba[channel];
      squares += static_cast<uint64_t>(delta * delta);
    }
  }
  const double pixels = static_cast<double>(metrics.pixel_count);
  metrics.rmse = std::sqrt(static_cast<double>(squares) / (4 * pixels));
  metrics.psnr_db = squares == 0 ? std::numeric_limits<double>::infinity() : 20 * std::log10(255 / metrics.rmse);
  metrics.differing_share = static_cast<double>(differing_count) / pixels;
  metrics.within_one_share = 1 - static_cast<double>(metrics.beyond_one_count) / pixels;
  return metrics;
}

Image difference_map(const Image& a, const Image& b) {
  require_same_size(a, b);
  Image map{.width = a.width, .height = a.height, .rgba = std::vector<uint8_t>(a.rgba.size(), 255)};
  for (size_t i = 0; i < a.rgba.size(); i += 4) {
    const std::array<uint8_t, 3> colour = difference_colour(pixel_difference(&a.rgba[i], &b.rgba[i]));
    std::copy(colour.begin(), colour.end(), map.rgba.begin() + static_cast<ptrdiff_t>(i));
  }
  return map;
}

}  // namespace pineda::tools
