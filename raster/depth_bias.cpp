#include "raster/depth_bias.h"

#include <algorithm>
#include <cmath>

#include "raster/geometry_types.h"

namespace pineda::raster {
namespace {

// "The minimum resolvable difference" r.
double resolvable_difference(VkFormat format, const std::array<float, 3>& z) {
  switch (format) {
    case VK_FORMAT_D16_UNORM:
    case VK_FORMAT_D16_UNORM_S8_UINT:
      return 0x1p-16;
    case VK_FORMAT_X8_D24_UNORM_PACK32:
    case VK_FORMAT_D24_UNORM_S8_UINT:
      return 0x1p-24;
    default: {  // 2^(e - n): e is the exponent of the primitive's largest depth, n the 23 bits of its mantissa
      const float largest = std::max({std::fabs(z[0]), std::fabs(z[1]), std::fabs(z[2])});
      return largest > 0 && std::isfinite(largest) ? std::ldexp(1.0, std::ilogb(largest) - 23) : 0;
    }
  }
}

}  // namespace

float depth_bias(const DrawPacket& packet, VkFormat format, const int32_t* x, const int32_t* y, std::array<float, 3> z) {
  const double dz1 = double{z[1]} - z[0], dz2 = double{z[2]} - z[0];
  const double x1 = x[1] - x[0], x2 = x[2] - x[0], y1 = y[1] - y[0], y2 = y[2] - y[0];
  const double per_px = kSubpixels / (x1 * y2 - y1 * x2);  // exact but for the division
  // The specification's approximation of the maximum slope: the larger of the two slopes' magnitudes.
  const double dzdx = std::fabs((dz1 * y2 - dz2 * y1) * per_px), dzdy = std::fabs((dz2 * x1 - dz1 * x2) * per_px);
  const double slope = dzdx > dzdy ? dzdx : dzdy;
  auto bias = static_cast<float>(slope * packet.depth_bias_slope + resolvable_difference(format, z) * packet.depth_bias_constant);
  if (packet.depth_bias_clamp > 0) bias = std::min(bias, packet.depth_bias_clamp);
  if (packet.depth_bias_clamp < 0) bias = std::max(bias, packet.depth_bias_clamp);
  return bias;
}

}  // namespace pineda::raster
