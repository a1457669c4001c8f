#include "icd/transfer.h"

#include <algorithm>

namespace pineda::icd {
namespace {

bool inside(int32_t offset, uint32_t size, uint32_t limit) { return offset >= 0 && uint64_t(offset) + size <= limit; }

}  // namespace

std::optional<ImageRegion> image_region(const Image& image, const VkImageSubresourceLayers& subresource, VkOffset3D offset,
                                        VkExtent3D extent) {
  if (!image.data() || subresource.mipLevel >= image.level_count) return std::nullopt;
  const LevelLayout& level = image.layout.level[subresource.mipLevel];
  if (!inside(offset.x, extent.width, level.extent.width) || !inside(offset.y, extent.height, level.extent.height) ||
      !inside(offset.z, extent.depth, level.extent.depth)) {
    return std::nullopt;
  }
  const bool is_volume = image.type == VK_IMAGE_TYPE_3D;
  const uint32_t layer_count = subresource.layerCount == VK_REMAINING_ARRAY_LAYERS
                                   ? image.layer_count - subresource.baseArrayLayer
                                   : subresource.layerCount;
  if (uint64_t(subresource.baseArrayLayer) + layer_count > image.layer_count) return std::nullopt;
  uint8_t* address = image.subresource(subresource.mipLevel, subresource.baseArrayLayer, static_cast<uint32_t>(offset.z));
  address += uint64_t(offset.y) * level.row_pitch_bytes + uint64_t(offset.x) * image.format.texel_bytes;
  const uint64_t slice_pitch = is_volume ? level.slice_pitch_bytes : image.layout.layer_pitch_bytes;
  return ImageRegion{
      {address, level.row_pitch_bytes, slice_pitch}, extent.width, extent.height, is_volume ? extent.depth : layer_count};
}

void fill_attachment(raster::ThreadPool& pool, const raster::Attachment& attachment, const VkRect2D& rect,
                     const VkClearValue& value) {
  const FormatInfo& format = *find_format(attachment.format);
  raster::FillRows fill{};
  if (format.is_depth()) {
    pack_depth(format, value.depthStencil.depth, fill.pattern.data());
  } else {
    pack_clear_color(format, value.color, fill.pattern.data());
  }
  fill.pattern_bytes = format.texel_bytes;
  fill.dst =
      attachment.address + uint64_t(rect.offset.y) * attachment.row_pitch_bytes + uint64_t(rect.offset.x) * format.texel_bytes;
  fill.row_bytes = uint64_t(rect.extent.width) * format.texel_bytes;
  fill.rows = rect.extent.height;
  fill.slices = 1;
  fill.row_pitch = attachment.row_pitch_bytes;
  raster::fill_rows(pool, fill);
}

}  // namespace pineda::icd
