// The vertex side of a batch: indices are deduplicated, 16-lane waves go through the vertex kernel, and the clip coordinates
// become window coordinates and clip codes (transform.h).
#pragma once

#include <array>
#include <cstdint>

#include "raster/geometry_types.h"
#include "raster/index_reader.h"
#include "raster/transform.h"

namespace pineda::raster {

// Assembles and shades batches; one per thread.
class VertexBatch {
 public:
  // Shades and transforms (to the first viewport) the vertices of `count` primitives from `first` on (numbered through the
  // instances) and fills prims with indices of vertices of the batch. count <= kBatchPrims. Returns the number of vertices.
  uint32_t shade(const Draw& draw, uint64_t first, uint32_t count, Chunk& chunk, ThreadContext& context, TransformFn transform);

  const float* vertices() const { return vertices_; }
  uint32_t vertex_count() const { return vertex_count_; }
  const WindowVertices& window() const { return window_; }
  const BatchPrims& prims() const { return prims_; }
  // Vertices of primitive i: as many as its kind has.
  std::array<uint16_t, 3> prim(uint32_t i) const { return {prims_.vertex[0][i], prims_.vertex[1][i], prims_.vertex[2][i]}; }

 private:
  // Post-transform cache: direct mapped, so that a mesh with local indices never collides with itself and a collision only costs
  // another run of the shader.
  static constexpr uint32_t kCacheSize = 1024;

  void assemble(const Draw& draw, uint64_t first, uint32_t count);
  void assemble_run(const Draw& draw, uint32_t instance, uint64_t first, uint32_t count, uint32_t out);
  void assemble_indexed_list(const Draw& draw, const IndexReader& reader, uint32_t instance, uint64_t first, uint32_t count,
                             uint32_t out);
  uint16_t add_vertex(uint32_t index, uint32_t instance);
  uint16_t find_or_add(uint32_t index, uint32_t instance);
  void next_generation();

  WindowVertices window_;
  VertexWave waves_[kBatchWaves];
  BatchPrims prims_{};
  uint32_t indices_[kBatchVertices];
  uint64_t cache_[kCacheSize] = {};  // from the high end: 32 bits of index, 16 of generation, 16 of vertex: compared in one word
  uint16_t generation_ = 0;
  uint32_t vertex_count_ = 0;
  float* vertices_ = nullptr;
};

}  // namespace pineda::raster
