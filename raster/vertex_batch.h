// The vertex side of a batch: indices are deduplicated, 16-lane waves go through the vertex kernel, and the clip coordinates
// become window coordinates and clip codes.
#pragma once

#include <array>
#include <cstdint>

#include "raster/geometry_types.h"
#include "raster/index_reader.h"

namespace pineda::raster {

inline constexpr uint32_t kBatchPrims = 512;
inline constexpr uint32_t kBatchVertices = 3 * kBatchPrims;
inline constexpr uint32_t kBatchWaves = kBatchVertices / kLanes;

// A set bit: outside of this plane. Bits from kClipDistances on: a clip distance below 0; behind them the same for cull
// distances.
enum ClipCode : uint16_t {
  kClipNear = 1,
  kClipFar = 2,
  kClipW = 4,
  kClipLeft = 8,
  kClipRight = 16,
  kClipTop = 32,
  kClipBottom = 64,
  kClipDrop = 128,  // not finite, or too far away for fixed point: primitives with such a vertex are dropped
  kClipDistances = 256
};

// The smallest w that is not clipped away: its reciprocal is still finite.
inline constexpr float kMinW = 0x1p-126f;

// Window coordinates of the vertices of a batch.
struct WindowVertices {
  alignas(64) int32_t x_fx8[kBatchVertices];
  alignas(64) int32_t y_fx8[kBatchVertices];
  alignas(64) float z[kBatchVertices];
  alignas(64) float iw[kBatchVertices];
  alignas(64) uint16_t code[kBatchVertices];
};

// Transforms a wave of 16 vertices: clip coordinates are slots 0 to 3 at `wave`; results go to elements [first, first + 16). Only
// elements whose code has only cull distances are meaningful.
void transform_wave(const ViewportTransform& viewport, const VertexOutputs& outputs, const float* wave, WindowVertices& out,
                    uint32_t first);

// Assembles and shades batches; one per thread.
class VertexBatch {
 public:
  // Shades and transforms (to the first viewport) the vertices of `count` primitives from `first` on (numbered through the
  // instances) and fills prims with indices of vertices of the batch. count <= kBatchPrims. Returns the number of vertices.
  uint32_t shade(const Draw& draw, uint64_t first, uint32_t count, Chunk& chunk, ThreadContext& context);

  const float* vertices() const { return vertices_; }
  uint32_t vertex_count() const { return vertex_count_; }
  const WindowVertices& window() const { return window_; }
  // Vertices of primitive i: as many as its kind has.
  const std::array<uint16_t, 3>& prim(uint32_t i) const { return prims_[i]; }

 private:
  // Post-transform cache: direct mapped, so that a mesh with local indices never collides with itself and a collision only costs
  // another run of the shader.
  static constexpr uint32_t kCacheSize = 1024;
  struct CacheEntry {
    uint32_t index;
    uint16_t generation, vertex;
  };

  void assemble(const Draw& draw, uint64_t first, uint32_t count);
  void assemble_run(const Draw& draw, uint32_t instance, uint64_t first, uint32_t count, uint32_t out);
  void assemble_indexed_list(const Draw& draw, const IndexReader& reader, uint32_t instance, uint64_t first, uint32_t count,
                             uint32_t out);
  uint16_t add_vertex(uint32_t index, uint32_t instance);
  uint16_t find_or_add(uint32_t index, uint32_t instance);
  void next_generation();

  WindowVertices window_;
  VertexWave waves_[kBatchWaves];
  std::array<uint16_t, 3> prims_[kBatchPrims];
  uint32_t indices_[kBatchVertices];
  CacheEntry cache_[kCacheSize] = {};
  uint16_t generation_ = 0;
  uint32_t vertex_count_ = 0;
  float* vertices_ = nullptr;
};

}  // namespace pineda::raster
