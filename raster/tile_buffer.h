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
  size_t layer_pitch_bytes = 0;
  // with several samples
  size_t sample_pitch_bytes = 0;
  KernelHandle resolve;  // fn is null: no resolve
  uint8_t* resolve_address = nullptr;
  size_t resolve_row_pitch_bytes = 0, resolve_layer_pitch_bytes = 0;
};

struct TilePosition {
  int32_t x_px, y_px, size_px;
  Rect rect;  // the tile's pixels that exist: of the render area
  uint32_t layer = 0;
  uint32_t xy_px() const { return static_cast<uint32_t>(x_px) + (static_cast<uint32_t>(y_px) << 16); }
};

// One sample of every pixel of a tile. With N samples a block's samples lie side by side: `planes` is N, and `data` the sample's
// first block.
struct SamplePlane {
  uint8_t* data;
  uint32_t planes = 1;
};

// Memory at `address` -> tile buffer. Texels outside of `rect` become zero.
void load_tile(const PassAttachment& attachment, const uint8_t* address, const TilePosition& tile, SamplePlane to);
// Tile buffer -> memory at `address`, texels of `rect` only. Blocks b with equal[b] != 0 are taken from `equal_from`.
struct EqualBlocks {
  const uint8_t* equal = nullptr;  // null: none
  const uint8_t* equal_from = nullptr;
};
void store_tile(const PassAttachment& attachment, uint8_t* address, size_t row_pitch_bytes, const TilePosition& tile,
                SamplePlane from, const EqualBlocks& equal = {});
// Every texel of the sample becomes `texel`.
void clear_tile(uint32_t texel_bytes, const uint8_t* texel, int32_t size_px, SamplePlane to);
// Texels of `rect` (tile coordinates) become `texel`.
void fill_tile_rect(uint32_t texel_bytes, const uint8_t* texel, const Rect& rect, SamplePlane to);
// Fills texels of `rect` straight in memory at `address`; `stream`: past the caches (fill_pattern.h).
void fill_memory_rect(uint32_t texel_bytes, uint8_t* address, size_t row_pitch_bytes, const uint8_t* texel, const Rect& rect,
                      bool stream);

}  // namespace pineda::raster
