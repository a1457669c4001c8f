// Input assembly: which vertices make primitive i of a draw (Vulkan 1.3, "Primitive Topologies"). The first vertex of each triple
// is the provoking vertex; the winding is the topology's.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "raster/raster.h"

namespace pineda::raster {

bool is_supported_topology(VkPrimitiveTopology topology);

// Primitives that `vertex_count` vertices make when nothing restarts.
uint64_t primitive_count(VkPrimitiveTopology topology, uint64_t vertex_count);

// Positions (relative to the draw's first vertex or index) of primitive i.
inline std::array<uint32_t, 3> primitive_vertices(VkPrimitiveTopology topology, uint32_t i) {
  switch (topology) {
    case VK_PRIMITIVE_TOPOLOGY_TRIANGLE_STRIP:
      return {i, i + 1 + i % 2, i + 2 - i % 2};
    case VK_PRIMITIVE_TOPOLOGY_TRIANGLE_FAN:
      return {i + 1, i + 2, 0};
    default:
      return {3 * i, 3 * i + 1, 3 * i + 2};
  }
}

// The primitives of an indexed draw with primitive restart.
std::vector<std::array<uint32_t, 3>> restart_primitives(const DrawPacket& packet);

}  // namespace pineda::raster
