#include "icd/image_layout.h"

#include <algorithm>

namespace pineda::icd {

std::optional<ImageLayout> image_layout(const LayoutRequest& request) {
  constexpr uint64_t kMax = 0xFFFFFFFFu;
  const auto blocks = [](uint32_t texels, uint32_t size) { return (texels + size - 1) / size; };
  const auto level_size = [](uint32_t texels, uint32_t level) { return std::max(texels >> level, 1u); };
  ImageLayout layout;
  uint64_t layer_bytes = 0;
  for (uint32_t i = 0; i < request.level_count; ++i) {
    LevelLayout& level = layout.level[i];
    level.extent = {level_size(request.extent.width, i), level_size(request.extent.height, i),
                    level_size(request.extent.depth, i)};
    level.columns = blocks(level.extent.width, request.block_width);
    level.rows = blocks(level.extent.height, request.block_height);
    const uint64_t row =
        (uint64_t(level.columns) * request.block_bytes + kRowAlignment_bytes - 1) / kRowAlignment_bytes * kRowAlignment_bytes;
    const uint64_t slice = row * level.rows;
    const uint64_t slices = uint64_t(level.extent.depth) * request.sample_count;
    if (slice * slices > kMax) return std::nullopt;  // each factor is at most 2^14, a block 2^4: no overflow
    level.offset_bytes = static_cast<uint32_t>(layer_bytes);
    level.row_pitch_bytes = static_cast<uint32_t>(row);
    level.slice_pitch_bytes = static_cast<uint32_t>(slice);
    layer_bytes += slice * slices;
    if (layer_bytes > kMax) return std::nullopt;
  }
  if (layer_bytes * request.layer_count > kMax) return std::nullopt;
  layout.layer_pitch_bytes = static_cast<uint32_t>(layer_bytes);
  layout.size_bytes = static_cast<uint32_t>(layer_bytes * request.layer_count);
  return layout;
}

}  // namespace pineda::icd
