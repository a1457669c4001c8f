// Input assembly: which vertices make primitive i of a draw (Vulkan 1.3, "Primitive Topologies"). Adjacent vertices are for
// geometry shaders only and are left out.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "raster/geometry_types.h"
#include "raster/raster.h"

namespace pineda::raster {

// What a topology's primitives are.
struct TopologyInfo {
  PrimitiveKind kind;
  bool is_list;         // no vertex belongs to two primitives
  uint8_t first, step;  // primitive i begins at vertex first + i * step
  uint8_t vertices;     // that the first primitive takes, adjacent ones included
};
const TopologyInfo* find_topology(VkPrimitiveTopology topology);  // null: not supported

constexpr uint32_t vertices_of(PrimitiveKind kind) { return static_cast<uint32_t>(kind) + 1; }

// Primitives that `vertex_count` vertices make when nothing restarts.
uint64_t primitive_count(const TopologyInfo& topology, uint64_t vertex_count);

// Positions (relative to the draw's first vertex or index) of primitive i: as many as its kind has. A triangle's provoking vertex
// comes first, in the winding of the topology; a line's vertices are in the order of the line.
std::array<uint32_t, 3> primitive_vertices(VkPrimitiveTopology topology, bool provoking_last, uint32_t i);

// The primitives of an indexed draw with primitive restart.
std::vector<RestartPrimitive> restart_primitives(const DrawPacket& packet);

}  // namespace pineda::raster
