// Sorts the triangles of a chunk by tile: a counting sort over the tiles that the chunk touches, so its cost follows the work,
// not the screen.
#pragma once

#include <cstdint>
#include <vector>

#include "raster/geometry_types.h"

namespace pineda::raster {

// Tiles of the framebuffer, row by row.
struct TileGrid {
  int32_t tile_px = 64;
  uint32_t shift = 6;  // log2(tile_px)
  uint32_t columns = 0, rows = 0;
  uint32_t samples = 1;  // of a pixel
  Rect area;             // pixels of the render area inside the framebuffer

  uint32_t count() const { return columns * rows; }
  Rect rect(uint32_t tile) const {  // the tile's pixels in the render area
    const auto x = static_cast<int32_t>(tile % columns) * tile_px, y = static_cast<int32_t>(tile / columns) * tile_px;
    return intersect({x, y, x + tile_px, y + tile_px}, area);
  }
};

class Binner {
 public:
  void begin(const TileGrid& grid);
  // Bins a triangle whose covered pixels lie in `bounds` (not empty, inside the rectangle that its viewport may draw).
  void add(const Draw& draw, const Triangle& triangle, uint32_t index, const Rect& bounds, const Rect& rect);
  // Bins a rectangle (a clear).
  void add_rect(const Draw& draw, uint32_t index, const Rect& bounds);
  // Writes the chunk's entries and segments; ready for the next chunk.
  void finish(Chunk& chunk);
  size_t entry_count() const { return pairs_.size(); }

 private:
  struct PerTile {
    uint32_t count = 0;  // entries so far; in finish(), where the next one goes
    uint32_t cover = 0;
    bool blocks_cover = false;
  };
  struct Pair {
    uint32_t tile, entry;
  };
  void push(const Draw& draw, uint32_t tile, uint32_t index, bool covers);

  const TileGrid* grid_ = nullptr;
  std::vector<PerTile> tiles_;
  std::vector<uint32_t> touched_;
  PodBuffer<Pair> pairs_;
};

}  // namespace pineda::raster
