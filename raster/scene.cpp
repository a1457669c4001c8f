#include "raster/scene.h"

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

}  // namespace pineda::raster
