// Depth bias of a polygon (Vulkan 1.3, "Depth Bias").
#pragma once

#include <array>
#include <cstdint>

#include "raster/raster.h"

namespace pineda::raster {

// x, y, z: window coordinates of a triangle whose area is not 0.
float depth_bias(const DrawPacket& packet, VkFormat format, const int32_t* x_fx8, const int32_t* y_fx8, std::array<float, 3> z);

}  // namespace pineda::raster
