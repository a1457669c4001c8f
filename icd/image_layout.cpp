#include "icd/image_layout.h"

#include <algorithm>

namespace pineda::icd {

std::optional<ImageLayout> image_layout(VkExtent3D extent, uint32_t level_count, uint32_t layer_count, uint32_t texel_bytes) {
  constexpr uint64_t kMax = 0xFFFFFFFFu;
  ImageLayout layout;
  uint64_t layer_bytes = 0;
  for (uint32_t i = 0; i < level_count; ++i) {
    LevelLayout& level = layout.level[i];
    level.extent = {std::max(extent.width >> i, 1u), std::max(extent.height >> i, 1u), std::max(extent.depth >> i, 1u)};
    const uint64_t row =
        (uint64_t(level.extent.width) * texel_bytes + kRowAlignment_bytes - 1) / kRowAlignment_bytes * kRowAlignment_bytes;
    const uint64_t slice = row * level.extent.height;
    if (slice * level.extent.depth > kMax) return std::nullopt;  // each factor is at most 2^14, a texel 2^4: no overflow
    level.offset_bytes = static_cast<uint32_t>(layer_bytes);
    level.row_pitch_bytes = static_cast<uint32_t>(row);
    level.slice_pitch_bytes = static_cast<uint32_t>(slice);
    layer_bytes += slice * level.extent.depth;
    if (layer_bytes > kMax) return std::nullopt;
  }
  if (layer_bytes * layer_count > kMax) return std::nullopt;
  layout.layer_pitch_bytes = static_cast<uint32_t>(layer_bytes);
  layout.size_bytes = static_cast<uint32_t>(layer_bytes * layer_count);
  return layout;
}

}  // namespace pineda::icd
