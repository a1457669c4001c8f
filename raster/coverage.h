// Which pixels of a tile a triangle covers: exact integer arithmetic, so neither tile size nor instruction set can show.
//
// An edge from vertex p to q has E(x, y) = (q.x - p.x) * (y - p.y) - (q.y - p.y) * (x - p.x), in fx8; a sample is inside when E
// >= 0 on top and left edges and E > 0, that is E - 1 >= 0, on the others (the triangle oriented so that its inside is positive).
// At pixel centres x = 256 X + 128, so E = 256 * (A X + B Y) + const and, with the floor taken exactly, E >= 0 <=> A X + B Y +
// floor(const / 256) >= 0.
//
// Why 32 bits are enough inside a tile: |A|, |B| <= 49154 * 256 < 2^23.59 (geometry_types.h). Over the pixels of a tile of at
// most 64 px the value varies by V = 63 * (|A| + |B|) < 2^30.57. An edge whose values over the whole tile have one sign is
// decided in 64 bits when the tile's edges are formed; any other has a value < 0 and a value >= 0 in the tile, so all its values
// at pixels of the tile are in (-2^31, 2^31), and every intermediate result is such a value or wraps and comes back. Forming the
// edges needs 64 bits, except for small triangles: within 64 px of each other and 128 px of the tile's first pixel, products stay
// below 2^14 * 2^15 and sums of two below 2^30 + 1.
#pragma once

#include <cstdint>

#include "raster/geometry_types.h"
#include "raster/options.h"

namespace pineda::raster {

// Value of edge k at pixel (X, Y) of the tile: c[k] + a[k] * X + b[k] * Y; the pixel is inside when all are >= 0.
struct TileEdges {
  alignas(16) int32_t a[4], b[4], c[4];  // the fourth is for parallelograms only
};

// Pixels that a record may cover: for pixel lines, all those between its ends.
Rect pixel_rect(const Triangle& record);

// Triangles this small, near the tile: every product of the edge functions is below 2^14 * 2^15.
inline constexpr int32_t kSmallFx8 = 64 * kSubpixels;

enum class TileCover { kNone, kPartial, kFull };

// `size_px` <= 64. kFull: all pixels of the tile are covered. Edges that hold on the whole tile come out as 0. Of pixel lines
// only the edges along the line are here; pixel_rect() has the ends.
TileCover make_tile_edges(const Triangle& triangle, int32_t tile_x_px, int32_t tile_y_px, int32_t size_px, TileEdges& edges);

// Blocks of a tile are numbered in Morton order: bit 2i of the number is bit i of the block's column, bit 2i + 1 of its row; 16
// consecutive blocks make a 16x16 px macro block.
inline constexpr uint32_t kMaxTilePx = 64;
inline constexpr uint32_t kMaxTileBlocks = kMaxTilePx / kBlockDim * (kMaxTilePx / kBlockDim);

// Columns and rows of blocks that may be covered, half open.
struct BlockRange {
  uint32_t x0, y0, x1, y1;
};

// Writes a wave for every block in `range` with a covered pixel to out, which has room for kMaxTileBlocks + 1; returns how many.
// `tile_xy_px` is the tile's position, x + (y << 16).
using CoverFn = uint32_t (*)(const TileEdges& edges, const BlockRange& range, uint32_t tile_xy_px, FragmentWave* out);

struct CoverageFunctions {
  CoverFn cover;                // three edges
  CoverFn cover_parallelogram;  // four
};
const CoverageFunctions& coverage_functions(Isa isa);

// Deposits the bits of a column into even, those of a row into odd places.
constexpr uint32_t morton(uint32_t x, uint32_t y) {
  const auto spread = [](uint32_t v) {
    v = (v | v << 2) & 0x33;
    return (v | v << 1) & 0x55;
  };
  return spread(x) | spread(y) << 1;
}

// Column (0) or row (1) of a block number below 256.
constexpr uint32_t morton_x(uint32_t m) {
  m &= 0x55;
  m = (m | m >> 1) & 0x33;
  return (m | m >> 2) & 0x0f;
}
constexpr uint32_t morton_y(uint32_t m) { return morton_x(m >> 1); }

// Lanes of the block at pixel (x, y) of the tile that lie in `rect` (tile coordinates).
uint32_t rect_lanes(const Rect& rect, int32_t x_px, int32_t y_px);

}  // namespace pineda::raster
