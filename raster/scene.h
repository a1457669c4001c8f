// What the phases of one pass share: the attachments, the tile grid and the tiles' lists.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "raster/binner.h"
#include "raster/options.h"
#include "raster/tile_buffer.h"

namespace pineda::raster {

// Entries of one chunk that a tile draws.
struct TileSegment {
  const Chunk* chunk;
  uint32_t first, count;  // in Chunk::entries
};

// One tile between two flushes, and whether its attachments have been in memory yet.
struct TileState {
  std::vector<TileSegment> segments;  // in API order
  bool covered = false;               // the first entry overwrites every colour of the tile
  bool blocks_cover = false;          // something in the list stays visible under a cover
  bool in_memory = false;             // an earlier flush stored it: load operations are over
};

struct Scene {
  Options options;
  TileGrid grid;
  // Colours by their number, then depth and stencil.
  static constexpr uint32_t kDepthSlot = kMaxColorAttachments, kStencilSlot = kDepthSlot + 1, kSlots = kStencilSlot + 1;
  std::array<PassAttachment, kSlots> attachments{};
  uint32_t color_count = 0;
  uint32_t layers = 1;           // of the framebuffer
  std::vector<TileState> tiles;  // grid.count() of them are in use
  bool streams_fills = false;    // what tiles without draws are filled with goes past the caches
  bool last_flush = true;        // DONT_CARE stores are left out only here: before, the tile comes back

  uint32_t samples() const { return grid.samples; }
  // Whether tile t and the one right of it, both without draws, are filled alike.
  bool fills_with_next(uint32_t t) const;
  // What filling a tile writes.
  uint64_t fill_bytes_per_tile() const;
  const PassAttachment& depth() const { return attachments[kDepthSlot]; }
  const PassAttachment& stencil() const { return attachments[kStencilSlot]; }

  // Appends a chunk's segments to the tiles' lists.
  void commit(const Chunk& chunk);
  void clear_lists();
};

}  // namespace pineda::raster
