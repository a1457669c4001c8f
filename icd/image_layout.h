// Where the texels of an image's plane are. Both tilings are the same: rows, top to bottom; layer after layer, and within a layer
// level after level.
//
//     layer 0: | level 0: row 0, row 1, ... | level 1 | ... |    layer 1: | level 0 ...
//
// Rows start at multiples of kRowAlignment_bytes, so a tile's row of 16 texels of 4 bytes is one cache line. A volume's level is
// its slices, one after another; a multisampled image's level is its samples, likewise: all texels' sample 0, then sample 1.
// The rows of a block-compressed format are rows of blocks.
#pragma once

#include <array>
#include <optional>

#include "base/abi.h"
#include "icd/vulkan_api.h"

namespace pineda::icd {

inline constexpr uint32_t kRowAlignment_bytes = 64;

struct LevelLayout {
  VkExtent3D extent{};             // texels
  uint32_t columns = 0, rows = 0;  // blocks; for a format without blocks, texels
  uint32_t offset_bytes = 0;       // from the layer's start
  uint32_t row_pitch_bytes = 0;
  uint32_t slice_pitch_bytes = 0;  // between slices of a volume, or samples; otherwise the level's size: rows * row_pitch_bytes
};

struct ImageLayout {
  std::array<LevelLayout, kMaxMipLevels> level{};
  uint32_t layer_pitch_bytes = 0;
  uint32_t size_bytes = 0;  // all layers
};

struct LayoutRequest {
  VkExtent3D extent;  // of level 0, texels
  uint32_t level_count, layer_count, sample_count;
  uint32_t block_bytes, block_width, block_height;
};

// Nothing when the plane does not fit 32-bit offsets.
std::optional<ImageLayout> image_layout(const LayoutRequest& request);

}  // namespace pineda::icd
