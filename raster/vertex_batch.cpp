#include "raster/vertex_batch.h"

#include <algorithm>
#include <cstring>

#include "raster/assemble.h"

namespace pineda::raster {
inline uint16_t VertexBatch::add_vertex(uint32_t index, uint32_t instance) {
  const uint32_t vertex = vertex_count_++;
  VertexWave& wave = waves_[vertex / kLanes];
  wave.vertex_index[vertex % kLanes] = index;
  wave.instance_index[vertex % kLanes] = instance;
  return static_cast<uint16_t>(vertex);
}

inline uint16_t VertexBatch::find_or_add(uint32_t index, uint32_t instance) {
  uint64_t& entry = cache_[index % kCacheSize];
  const uint64_t key = uint64_t{index} << 32 | uint64_t{generation_} << 16;
  if (entry >> 16 == key >> 16) return static_cast<uint16_t>(entry);
  const uint16_t vertex = add_vertex(index, instance);
  entry = key | vertex;
  return vertex;
}

// Forgets all vertices: another batch or another instance begins.
void VertexBatch::next_generation() {
  if (++generation_ == 0) {
    std::ranges::fill(cache_, 0);
    generation_ = 1;
  }
}

void VertexBatch::assemble_indexed_list(const Draw& draw, const IndexReader& reader, uint32_t instance, uint64_t first,
                                        uint32_t count, uint32_t out) {
  const uint8_t* words = reader.words(uint64_t{draw.packet.first} + first * 3, count * 3, indices_);
  const auto offset = static_cast<uint32_t>(draw.packet.vertex_offset);
  for (uint32_t i = 0; i < count; ++i) {
#pragma GCC unroll 3
    for (uint32_t k = 0; k < 3; ++k) {
      uint32_t index;
      std::memcpy(&index, words + (size_t{3} * i + k) * sizeof index, sizeof index);
      prims_.vertex[k][out + i] = find_or_add(index + offset, instance);
    }
  }
}

// Primitives [first, first + count) of one instance, into prims_ from `out` on.
void VertexBatch::assemble_run(const Draw& draw, uint32_t instance, uint64_t first, uint32_t count, uint32_t out) {
  const DrawPacket& packet = draw.packet;
  const IndexReader reader(packet.index);
  const bool list = find_topology(packet.topology)->is_list;
  if (packet.topology == VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST && reader.indexed() && draw.restart_prims.empty() &&
      !packet.provoking_last) {
    assemble_indexed_list(draw, reader, instance, first, count, out);
    return;
  }
  const uint32_t n = vertices_of(draw.kind);
  for (uint32_t i = 0; i < count; ++i) {
    const auto p = static_cast<uint32_t>(first + i);
    const std::array<uint32_t, 3> v =
        draw.restart_prims.empty() ? primitive_vertices(packet.topology, packet.provoking_last, p) : draw.restart_prims[p].vertex;
    for (uint32_t k = 0; k < n; ++k) {
      if (reader.indexed()) {
        const uint32_t index = reader.read(uint64_t{packet.first} + v[k]) + static_cast<uint32_t>(packet.vertex_offset);
        prims_.vertex[k][out + i] = find_or_add(index, instance);
      } else {
        const uint32_t index = packet.first + v[k];
        prims_.vertex[k][out + i] = list ? add_vertex(index, instance) : find_or_add(index, instance);
      }
    }
  }
}

void VertexBatch::assemble(const Draw& draw, uint64_t first, uint32_t count) {
  vertex_count_ = 0;
  for (uint32_t done = 0; done < count;) {
    const uint64_t in_draw = first + done;
    const uint64_t in_instance = in_draw % draw.prims_per_instance;
    const auto n = static_cast<uint32_t>(std::min<uint64_t>(count - done, draw.prims_per_instance - in_instance));
    const uint32_t instance = draw.packet.first_instance + static_cast<uint32_t>(in_draw / draw.prims_per_instance);
    next_generation();
    assemble_run(draw, instance, in_instance, n, done);
    done += n;
  }
}

uint32_t VertexBatch::shade(const Draw& draw, uint64_t first, uint32_t count, Chunk& chunk, ThreadContext& context,
                            TransformFn transform) {
  assemble(draw, first, count);
  const uint32_t wave_count = (vertex_count_ + kLanes - 1) / kLanes;
  const size_t wave_floats = size_t{draw.packet.vertex_slots} * kLanes;
  vertices_ = static_cast<float*>(chunk.vertices.allocate(wave_count * wave_floats * sizeof(float)));
  for (uint32_t i = 0; i < wave_count; ++i) {
    VertexWave& wave = waves_[i];
    const uint32_t lanes = std::min(kLanes, vertex_count_ - i * kLanes);
    wave.mask = (1u << lanes) - 1;
    wave.reserved = 0;
    wave.out = vertices_ + i * wave_floats;
    for (uint32_t lane = lanes; lane < kLanes;
         ++lane) {  // lanes without a vertex repeat the first, so that they read nothing new
      wave.vertex_index[lane] = wave.vertex_index[0];
      wave.instance_index[lane] = wave.instance_index[0];
    }
  }
  const PrimRecord record{nullptr, 0, wave_count};
  draw.packet.vertex(draw.packet.context, &context, &record, 1, waves_);
  for (uint32_t i = 0; i < wave_count; ++i)
    transform(draw.viewport, draw.packet.outputs, vertices_ + i * wave_floats, window_, i * kLanes);
  return vertex_count_;
}

}  // namespace pineda::raster
