// Depth bias by the specification's formula (Vulkan 1.3, "Depth Bias"):
//     o = m * depthBiasSlopeFactor + r * depthBiasConstantFactor, clamped by depthBiasClamp
// with m = max(|dz/dx|, |dz/dy|) and r the format's minimum resolvable difference.
#include "raster/depth_bias.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "raster/geometry_types.h"

namespace pineda::raster {
namespace {

// 2^-n of UNORM formats; of D32 2^(e - 23), e the exponent of the largest depth of the primitive.
double resolvable(VkFormat format, const std::array<float, 3>& z) {
  if (format == VK_FORMAT_D16_UNORM) return std::ldexp(1.0, -16);
  if (format != VK_FORMAT_D32_SFLOAT) return std::ldexp(1.0, -24);
  int exponent = 0;
  std::frexp(std::max({z[0], z[1], z[2]}), &exponent);  // in [1/2, 1)
  return std::ldexp(1.0, exponent - 1 - 23);
}

TEST(DepthBias, IsTheFormulaForEveryFormat) {
  std::mt19937 rng(3);
  const auto unit = [&] { return static_cast<double>(rng()) / 4294967296.0; };
  for (const VkFormat format :
       {VK_FORMAT_D16_UNORM, VK_FORMAT_X8_D24_UNORM_PACK32, VK_FORMAT_D24_UNORM_S8_UINT, VK_FORMAT_D32_SFLOAT}) {
    for (int round = 0; round < 2000; ++round) {
      int32_t x[3], y[3];
      std::array<float, 3> z;
      for (int k = 0; k < 3; ++k) {
        x[k] = static_cast<int32_t>(rng() % 65536);
        y[k] = static_cast<int32_t>(rng() % 65536);
        z[k] = static_cast<float>(unit() * (round % 3 == 0 ? 0.01 : 1));
      }
      const double x1 = (x[1] - x[0]) / 256.0, x2 = (x[2] - x[0]) / 256.0, y1 = (y[1] - y[0]) / 256.0, y2 = (y[2] - y[0]) / 256.0;
      const double area = x1 * y2 - y1 * x2;
      if (std::fabs(area) < 1) continue;
      // The plane through the three depths, by Cramer's rule.
      const double d1 = double{z[1]} - z[0], d2 = double{z[2]} - z[0];
      const double slope = std::max(std::fabs((d1 * y2 - d2 * y1) / area), std::fabs((x1 * d2 - x2 * d1) / area));
      DrawPacket packet;
      packet.depth_bias = true;
      packet.depth_bias_constant = static_cast<float>(std::floor(unit() * 4000 - 2000));
      packet.depth_bias_slope = static_cast<float>(unit() * 8 - 4);
      const double plain = slope * packet.depth_bias_slope + resolvable(format, z) * packet.depth_bias_constant;
      const double rounding = 0x1p-23 * (slope * 4 + std::fabs(plain)) + 1e-30;  // to binary32, once, and of the division
      for (const float clamp : {0.0f, 1e-4f, -1e-4f, 0.25f, -0.25f}) {
        packet.depth_bias_clamp = clamp;
        const double want = clamp > 0 ? std::min(plain, double{clamp}) : clamp < 0 ? std::max(plain, double{clamp}) : plain;
        ASSERT_NEAR(depth_bias(packet, format, x, y, z), want, rounding) << "format " << format << " clamp " << clamp;
      }
    }
  }
}

}  // namespace
}  // namespace pineda::raster
