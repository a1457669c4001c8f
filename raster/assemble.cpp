#include "raster/assemble.h"

#include "raster/index_reader.h"

namespace pineda::raster {

bool is_supported_topology(VkPrimitiveTopology topology) {
  return topology == VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST || topology == VK_PRIMITIVE_TOPOLOGY_TRIANGLE_STRIP ||
         topology == VK_PRIMITIVE_TOPOLOGY_TRIANGLE_FAN;
}

uint64_t primitive_count(VkPrimitiveTopology topology, uint64_t vertex_count) {
  if (topology == VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST) return vertex_count / 3;
  return vertex_count < 3 ? 0 : vertex_count - 2;
}

std::vector<std::array<uint32_t, 3>> restart_primitives(const DrawPacket& packet) {
  std::vector<std::array<uint32_t, 3>> primitives;
  const IndexReader reader(packet.index);
  uint32_t start = 0;  // of the current run of indices
  for (uint32_t i = 0; i <= packet.count; ++i) {
    const bool ends = i == packet.count || reader.read(uint64_t{packet.first} + i) == reader.restart_value();
    if (!ends) continue;
    const uint64_t count = primitive_count(packet.topology, i - start);
    for (uint32_t p = 0; p < count; ++p) {
      std::array<uint32_t, 3> v = primitive_vertices(packet.topology, p);
      for (uint32_t& position : v) position += start;
      primitives.push_back(v);
    }
    if (i == packet.count) break;
    start = i + 1;
  }
  return primitives;
}

}  // namespace pineda::raster
