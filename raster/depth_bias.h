// Depth bias of a polygon (Vulkan 1.3, "Depth Bias").
#pragma once

#include <array>
#include <cstdint>

#include "raster/raster.h"

namespace pineda::raster {

// x and y: window coordinates of a triangle; area_fx16: (x1 - x0) * (y2 - y0) - (y1 - y0) * (x2 - x0), not 0. z: in [0, 1] or
// beyond.
float depth_bias(const DrawPacket& packet, VkFormat format, double area_fx16, const int32_t* x_fx8, const int32_t* y_fx8,
                 std::array<float, 3> z);

}  // namespace pineda::raster
