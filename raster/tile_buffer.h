// Attachments inside a tile: block-linear (base/abi.h) buffers, and their loads, clears and stores. Bytes only: nothing here
// interprets a texel.
#pragma once

#include <array>
#include <cstdint>

#include "raster/geometry_types.h"

namespace pineda::raster {

// One attachment of a pass.
struct PassAttachment {
  uint8_t* address = nullptr;  // null: unused
  size_t row_pitch_bytes = 0;
  uint32_t texel_bytes = 0;
  VkFormat format = VK_FORMAT_UNDEFINED;
  bool load = false;  // LOAD; otherwise the tile starts as clear_texel (zero for DONT_CARE: defined bits, whatever the tile size)
  bool store = false;
  std::array<uint8_t, 16> clear_texel{};
};

struct TilePosition {
  int32_t x_px, y_px, size_px;
  Rect rect;  // the tile's pixels that exist: of the render area
};

// Memory -> tile buffer. Texels outside of `rect` become zero.
void load_tile(const PassAttachment& attachment, const TilePosition& tile, uint8_t* buffer);
// Tile buffer -> memory, texels of `rect` only.
void store_tile(const PassAttachment& attachment, const TilePosition& tile, const uint8_t* buffer);
// Every texel of the tile buffer becomes `texel`.
void clear_tile(uint32_t texel_bytes, const uint8_t* texel, int32_t size_px, uint8_t* buffer);
// Texels of `rect` (tile coordinates) become `texel`.
void fill_tile_rect(uint32_t texel_bytes, const uint8_t* texel, const Rect& rect, uint8_t* buffer);
// Fills texels of `rect` straight in memory.
void fill_memory_rect(const PassAttachment& attachment, const uint8_t* texel, const Rect& rect);

}  // namespace pineda::raster
