// Sorts the triangles of a chunk by tile: a counting sort over the tiles that the chunk touches, so its cost follows the work,
// not the screen.
#pragma once

#include <cstdint>
#include <vector>

#include "raster/geometry_types.h"

namespace pineda::raster {

// Tiles of the framebuffer, row by row, layer by layer.
struct TileGrid {
  int32_t tile_px = 64;
  uint32_t shift = 6;  // log2(tile_px)
  uint32_t columns = 0, rows = 0, layers = 1;
  uint32_t samples = 1;  // of a pixel
  Rect area;             // pixels of the render area inside the framebuffer

  uint32_t per_layer() const { return columns * rows; }
  uint32_t count() const { return per_layer() * layers; }
  uint32_t layer(uint32_t tile) const { return layers == 1 ? 0 : tile / per_layer(); }
  int32_t x_px(uint32_t tile) const { return static_cast<int32_t>(tile % columns) * tile_px; }
  int32_t y_px(uint32_t tile) const { return static_cast<int32_t>(tile / columns % rows) * tile_px; }
  Rect rect(uint32_t tile) const {  // the tile's pixels in the render area
    const int32_t x = x_px(tile), y = y_px(tile);
    return intersect({x, y, x + tile_px, y + tile_px}, area);
  }
};

class Binner {
 public:
  void begin(const TileGrid& grid);
  // Where what follows goes. Without attachments all layers share their tiles: there is nothing to keep apart.
  void set_layer(uint32_t layer) { first_tile_ = layer < grid_->layers ? layer * grid_->per_layer() : 0; }
  // Bins a triangle whose covered pixels lie in `bounds` (not empty, inside the rectangle that its viewport may draw).
  void add(const Draw& draw, const Triangle& triangle, uint32_t index, const Rect& bounds, const Rect& rect);
  // The same for one whose only tile is known: its number in the layer. That it covers a single tile whole is not worth finding.
  void add_to_tile(const Draw& draw, uint32_t tile, uint32_t index) { push(draw, first_tile_ + tile, index, false); }
  const TileGrid& grid() const { return *grid_; }
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
  uint32_t first_tile_ = 0;  // of the layer
  std::vector<PerTile> tiles_;
  std::vector<uint32_t> touched_;
  PodBuffer<Pair> pairs_;
};

inline void Binner::push(const Draw& draw, uint32_t tile, uint32_t index, bool covers) {
  PerTile& t = tiles_[tile];
  if (t.count == 0) touched_.push_back(tile);
  ++t.count;
  if (covers && draw.can_cover && !t.blocks_cover) t.cover = t.count;
  t.blocks_cover |= draw.blocks_cover;
  pairs_.push_back({tile, index | (covers ? kEntryCovers : 0)});
}

}  // namespace pineda::raster
