#include "raster/binner.h"

#include "raster/coverage_samples.h"
#include "raster/edge_list.h"

namespace pineda::raster {

void Binner::begin(const TileGrid& grid) {
  grid_ = &grid;
  first_tile_ = 0;
  if (tiles_.size() < grid.count()) tiles_.resize(grid.count());  // entries are always left in their initial state
  touched_.clear();
  pairs_.clear();
}

namespace {

// A smooth line covers the pixels that it touches at all: whether it can touch the tile.
TileCover smooth_cover(const TileGrid& grid, const Triangle& line, int32_t x_px, int32_t y_px) {
  const EdgeList edges(line);
  const int64_t size_fx8 = int64_t{grid.tile_px} * kSubpixels;
  for (int k = 0; k < edges.count; ++k) {
    const EdgeList::Edge& e = edges.edge[k];
    const int64_t x = int64_t{x_px} * kSubpixels - e.x0, y = int64_t{y_px} * kSubpixels - e.y0;
    if (e.a * x + e.b * y + (std::max(e.a, 0) + int64_t{std::max(e.b, 0)}) * size_fx8 < 0) return TileCover::kNone;
  }
  return TileCover::kPartial;
}

TileCover tile_cover(const TileGrid& grid, const Draw& draw, const Triangle& triangle, int32_t x_px, int32_t y_px) {
  if (draw.smooth) return smooth_cover(grid, triangle, x_px, y_px);
  if (grid.samples > 1) {
    SampleEdges edges;
    return make_sample_edges(triangle, x_px, y_px, grid.tile_px, grid.samples, edges);
  }
  TileEdges edges;
  return make_tile_edges(triangle, x_px, y_px, grid.tile_px, edges);
}

}  // namespace

void Binner::add(const Draw& draw, const Triangle& triangle, uint32_t index, const Rect& bounds, const Rect& rect) {
  const uint32_t shift = grid_->shift;
  const uint32_t x0 = static_cast<uint32_t>(bounds.x0) >> shift, x1 = static_cast<uint32_t>(bounds.x1 - 1) >> shift;
  const uint32_t y0 = static_cast<uint32_t>(bounds.y0) >> shift, y1 = static_cast<uint32_t>(bounds.y1 - 1) >> shift;
  if (x0 == x1 && y0 == y1) {
    add_to_tile(draw, y0 * grid_->columns + x0, index);
    return;
  }
  // One that is not larger than a tile covers none of several tiles whole; that it may miss one at a corner costs less than
  // asking.
  const bool is_small = bounds.x1 - bounds.x0 <= grid_->tile_px && bounds.y1 - bounds.y0 <= grid_->tile_px;
  for (uint32_t y = y0; y <= y1; ++y) {
    for (uint32_t x = x0; x <= x1; ++x) {
      if (is_small) {
        add_to_tile(draw, y * grid_->columns + x, index);
        continue;
      }
      const TileCover cover =
          tile_cover(*grid_, draw, triangle, static_cast<int32_t>(x << shift), static_cast<int32_t>(y << shift));
      if (cover == TileCover::kNone) continue;
      const uint32_t tile = first_tile_ + y * grid_->columns + x;
      push(draw, tile, index, cover == TileCover::kFull && rect.contains(grid_->rect(tile)));
    }
  }
}

void Binner::add_rect(const Draw& draw, uint32_t index, const Rect& bounds) {
  const uint32_t shift = grid_->shift;
  for (uint32_t y = static_cast<uint32_t>(bounds.y0) >> shift; y <= static_cast<uint32_t>(bounds.y1 - 1) >> shift; ++y) {
    for (uint32_t x = static_cast<uint32_t>(bounds.x0) >> shift; x <= static_cast<uint32_t>(bounds.x1 - 1) >> shift; ++x) {
      push(draw, first_tile_ + y * grid_->columns + x, index, false);
    }
  }
}

void Binner::finish(Chunk& chunk) {
  Segment* segments = chunk.segments.append(touched_.size());
  uint32_t first = 0;
  for (size_t i = 0; i < touched_.size(); ++i) {
    PerTile& t = tiles_[touched_[i]];
    segments[i] = {touched_[i], first, t.count, t.cover, t.blocks_cover};
    const uint32_t count = t.count;
    t.count = first;
    first += count;
  }
  uint32_t* entries = chunk.entries.append(pairs_.size());
  for (size_t i = 0; i < pairs_.size(); ++i) entries[tiles_[pairs_[i].tile].count++] = pairs_[i].entry;
  for (const uint32_t tile : touched_) tiles_[tile] = {};
  touched_.clear();
  pairs_.clear();
}

}  // namespace pineda::raster
