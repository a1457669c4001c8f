// 16 triangles against one tile, for those whose vertices lie within 64 px of each other, which is what most of a mesh needs:
// edges and what the fragment kernel reads of a primitive; of the smallest also coverage and Hi-Z. A lane is a triangle; records
// become columns on the way in, and primitives rows on the way out. All in 32 bits, as coverage.h shows.
#pragma once

#include <cstdint>

#include "raster/coverage_samples.h"
#include "raster/geometry_types.h"
#include "raster/options.h"

namespace pineda::raster {

// What of its batch goes into a triangle's FragmentPrim.
struct alignas(64) SmallBatches {
  int32_t vertices[2][16];  // Batch::vertices, low and high half
  int32_t wave_bytes[16];   // of the vertex outputs of 16 vertices
  int32_t viewport[16], layer[16];

  void set(uint32_t lane, const Batch& batch) {
    const auto address = reinterpret_cast<uintptr_t>(batch.vertices);
    vertices[0][lane] = static_cast<int32_t>(address);
    vertices[1][lane] = static_cast<int32_t>(address >> 32);
    wave_bytes[lane] = static_cast<int32_t>(batch.draw->packet.vertex_slots * kVertexSlotBytes);
    viewport[lane] = static_cast<int32_t>(batch.viewport);
    layer[lane] = static_cast<int32_t>(batch.layer);
  }
  void repeat(uint32_t lane) {  // the one before
    for (int half = 0; half < 2; ++half) vertices[half][lane] = vertices[half][lane - 1];
    wave_bytes[lane] = wave_bytes[lane - 1];
    viewport[lane] = viewport[lane - 1];
    layer[lane] = layer[lane - 1];
  }
  void set_all(const Batch& batch);
};

// Bounds of the depths of a tile's blocks: HiZ::bounds().
struct SmallHiZ {
  float sign;             // -1 where the test asks for greater depths
  float ceiling;          // depth_ceiling() of the draw; of several, the least
  const float* farthest;  // of kMaxTileBlocks blocks
};

struct alignas(64) SmallGroup {
  // in
  const Triangle* triangles[16];
  SmallBatches batches;
  int32_t x_px, y_px, size_px;  // of the tile
  uint32_t samples;             // of a pixel; with several none is small
  const SmallHiZ* hi_z;         // null: nothing is hidden
  // out
  uint32_t near;                 // bit i: the vertices of record i, a triangle, are within 64 px; the rest says nothing of others
  TileEdges edges[16];           // of those that are near and not small, with one sample
  SampleEdges sample_edges[16];  // with several
  BlockRange blocks[16];         // that may be covered
  uint32_t small;                // bit i: near, and has at most 2x2 blocks in the tile
  uint32_t seen;                 // bit i: small, and some mask is not 0
  uint32_t hidden;               // blocks that hi_z took away
  int32_t masks[4][16];          // covered lanes of its blocks: first, right of it, below it, right and below
  int32_t xy_px[4][16];          // their framebuffer position, x + (y << 16)
  int32_t block[4][16];          // their numbers in the tile
  FragmentPrim prims[16];        // of those that are near, unless all are small and none is seen
  float least[16];               // with hi_z: no fragment is nearer (least_depth() of hi_z.h)
};

using SmallGroupFn = void (*)(SmallGroup& group);
SmallGroupFn small_group_function(Isa isa);

}  // namespace pineda::raster
