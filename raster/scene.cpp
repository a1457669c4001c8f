#include "raster/scene.h"

#include <algorithm>

namespace pineda::raster {

void Scene::commit(const Chunk& chunk) {
  for (size_t i = 0; i < chunk.segments.size(); ++i) {
    const Segment& segment = chunk.segments[i];
    TileState& tile = tiles[segment.tile];
    uint32_t skip = 0;
    if (options.opaque && segment.cover != 0 && !tile.blocks_cover) {
      tile.segments.clear();
      tile.covered = true;
      skip = segment.cover - 1;
    }
    tile.segments.push_back({&chunk, segment.first + skip, segment.count - skip});
    tile.blocks_cover |= segment.blocks_cover;
  }
}

void Scene::clear_lists() {
  for (uint32_t i = 0; i < grid.count(); ++i) {
    tiles[i].segments.clear();
    tiles[i].covered = tiles[i].blocks_cover = false;
  }
}

bool Scene::fills_with_next(uint32_t t) const {
  if (!options.fast_clear || (t + 1) % grid.columns == 0 || tiles[t].in_memory || tiles[t + 1].in_memory) return false;
  return std::ranges::none_of(attachments, [](const PassAttachment& a) { return a.address && a.load; });
}

uint64_t Scene::fill_bytes_per_tile() const {
  uint64_t texel_bytes = 0;
  for (const PassAttachment& a : attachments) {
    if (a.address && a.store && !a.load) texel_bytes += uint64_t{a.texel_bytes} * samples();
    if (a.address && a.resolve.fn && !a.load) texel_bytes += a.texel_bytes;
  }
  return texel_bytes * static_cast<uint32_t>(grid.tile_px) * static_cast<uint32_t>(grid.tile_px);
}

}  // namespace pineda::raster
