#include "raster/scene.h"

namespace pineda::raster {

void Scene::commit(Chunk& chunk) {
  for (size_t i = 0; i < chunk.segments.size(); ++i) {
    Segment& segment = chunk.segments[i];
    TileState& tile = tiles[segment.tile];
    if (options.opaque && segment.cover != 0 && !tile.blocks_cover) {
      tile.head = tile.tail = &segment;
      tile.skip = segment.cover - 1;
      tile.covered = true;
    } else if (tile.head == nullptr) {
      tile.head = tile.tail = &segment;
    } else {
      tile.tail->next = &segment;
      tile.tail = &segment;
    }
    tile.blocks_cover |= segment.blocks_cover;
  }
}

void Scene::clear_lists() {
  for (TileState& tile : tiles) {
    tile.head = tile.tail = nullptr;
    tile.skip = 0;
    tile.covered = tile.blocks_cover = false;
  }
}

}  // namespace pineda::raster
