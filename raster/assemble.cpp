#include "raster/assemble.h"

#include "raster/index_reader.h"

namespace pineda::raster {

const TopologyInfo* find_topology(VkPrimitiveTopology topology) {
  using enum PrimitiveKind;
  static constexpr TopologyInfo kTopologies[] = {
      // kind, list, first, step, vertices; in the order of VkPrimitiveTopology
      {kPoint, true, 0, 1, 1},      // POINT_LIST
      {kLine, true, 0, 2, 2},       // LINE_LIST
      {kLine, false, 0, 1, 2},      // LINE_STRIP
      {kTriangle, true, 0, 3, 3},   // TRIANGLE_LIST
      {kTriangle, false, 0, 1, 3},  // TRIANGLE_STRIP
      {kTriangle, false, 0, 1, 3},  // TRIANGLE_FAN
      {kLine, true, 1, 4, 4},       // LINE_LIST_WITH_ADJACENCY
      {kLine, false, 1, 1, 4},      // LINE_STRIP_WITH_ADJACENCY
      {kTriangle, true, 0, 6, 6},   // TRIANGLE_LIST_WITH_ADJACENCY
      {kTriangle, false, 0, 2, 6},  // TRIANGLE_STRIP_WITH_ADJACENCY
  };
  static_assert(VK_PRIMITIVE_TOPOLOGY_POINT_LIST == 0 && VK_PRIMITIVE_TOPOLOGY_TRIANGLE_STRIP_WITH_ADJACENCY == 9);
  const auto i = static_cast<size_t>(topology);
  return i < std::size(kTopologies) ? &kTopologies[i] : nullptr;
}

uint64_t primitive_count(const TopologyInfo& topology, uint64_t vertex_count) {
  return vertex_count < topology.vertices ? 0 : (vertex_count - topology.vertices) / topology.step + 1;
}

std::array<uint32_t, 3> primitive_vertices(VkPrimitiveTopology topology, bool provoking_last, uint32_t i) {
  const TopologyInfo& info = *find_topology(topology);
  const uint32_t v = info.first + i * info.step;
  if (info.kind == PrimitiveKind::kPoint) return {v, v, v};
  if (info.kind == PrimitiveKind::kLine) return {v, v + 1, v};
  std::array<uint32_t, 3> t;
  const uint32_t odd = i % 2;
  switch (topology) {
    case VK_PRIMITIVE_TOPOLOGY_TRIANGLE_STRIP:
    case VK_PRIMITIVE_TOPOLOGY_TRIANGLE_STRIP_WITH_ADJACENCY:
      t = {v, v + (1 + odd) * info.step, v + (2 - odd) * info.step};
      // The provoking vertex is the first or the last of the three in the strip; an odd triangle's last is its second here.
      if (provoking_last) t = odd ? std::array{t[1], t[2], t[0]} : std::array{t[2], t[0], t[1]};
      return t;
    case VK_PRIMITIVE_TOPOLOGY_TRIANGLE_FAN:
      t = {v + 1, v + 2, 0};
      return provoking_last ? std::array{t[1], t[2], t[0]} : t;
    default: {
      const uint32_t between = info.vertices / 3;
      t = {v, v + between, v + 2 * between};
      return provoking_last ? std::array{t[2], t[0], t[1]} : t;
    }
  }
}

std::vector<RestartPrimitive> restart_primitives(const DrawPacket& packet) {
  std::vector<RestartPrimitive> primitives;
  const TopologyInfo& info = *find_topology(packet.topology);
  const IndexReader reader(packet.index);
  uint32_t start = 0;  // of the current run of indices
  for (uint32_t i = 0; i <= packet.count; ++i) {
    const bool ends = i == packet.count || reader.read(uint64_t{packet.first} + i) == reader.restart_value();
    if (!ends) continue;
    const uint64_t count = primitive_count(info, i - start);
    for (uint32_t p = 0; p < count; ++p) {
      std::array<uint32_t, 3> v = primitive_vertices(packet.topology, packet.provoking_last, p);
      for (uint32_t& position : v) position += start;
      primitives.push_back({v, p == 0});
    }
    if (i == packet.count) break;
    start = i + 1;
  }
  return primitives;
}

}  // namespace pineda::raster
