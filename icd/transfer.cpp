#include "icd/transfer.h"

#include <algorithm>

namespace pineda::icd {
namespace {

bool inside(int32_t offset, uint32_t size, uint32_t limit) { return offset >= 0 && uint64_t(offset) + size <= limit; }

uint32_t blocks(uint32_t texels, uint32_t size) { return texels / size + (texels % size != 0); }

}  // namespace

BlockExtent block_extent(const FormatInfo& format, const VkExtent3D& extent) {
  return {blocks(extent.width, format.block_width), blocks(extent.height, format.block_height), extent.depth};
}

std::optional<ImageRegion> image_region(const Image& image, const VkImageSubresourceLayers& subresource, VkOffset3D offset,
                                        const BlockExtent& extent) {
  if (aspect_format(image.format.format, subresource.aspectMask) == VK_FORMAT_UNDEFINED) return std::nullopt;
  const ImagePlane& plane = image.plane(plane_of(image.format, subresource.aspectMask));
  if (!image.data() || subresource.mipLevel >= image.level_count) return std::nullopt;
  const LevelLayout& level = plane.layout.level[subresource.mipLevel];
  const int32_t block_width = plane.format->block_width, block_height = plane.format->block_height;
  if (offset.x % block_width != 0 || offset.y % block_height != 0) return std::nullopt;
  const int32_t column = offset.x / block_width, row = offset.y / block_height;
  if (!inside(column, extent.columns, level.columns) || !inside(row, extent.rows, level.rows) ||
      !inside(offset.z, extent.depth, level.extent.depth)) {
    return std::nullopt;
  }
  const bool is_volume = image.type == VK_IMAGE_TYPE_3D;
  if (subresource.baseArrayLayer > image.layer_count) return std::nullopt;
  const uint32_t layer_count = subresource.layerCount == VK_REMAINING_ARRAY_LAYERS
                                   ? image.layer_count - subresource.baseArrayLayer
                                   : subresource.layerCount;
  if (uint64_t(subresource.baseArrayLayer) + layer_count > image.layer_count) return std::nullopt;
  uint8_t* address = image.subresource(plane, subresource.mipLevel, subresource.baseArrayLayer, static_cast<uint32_t>(offset.z));
  address += uint64_t(row) * level.row_pitch_bytes + uint64_t(column) * plane.format->texel_bytes;
  const uint64_t slice_pitch = is_volume ? level.slice_pitch_bytes : plane.layout.layer_pitch_bytes;
  return ImageRegion{.plane = &plane,
                     .rows = {address, level.row_pitch_bytes, slice_pitch},
                     .columns = extent.columns,
                     .row_count = extent.rows,
                     .slices = is_volume ? extent.depth : layer_count,
                     .first_column = static_cast<uint32_t>(column),
                     .first_row = static_cast<uint32_t>(row),
                     .sample_pitch_bytes = level.slice_pitch_bytes};
}

void fill_attachment(raster::ThreadPool& pool, const raster::Attachment& attachment, const VkRect2D& rect,
                     const VkClearValue& value) {
  const FormatInfo& format = *find_format(attachment.format);
  raster::FillRows fill{};
  if (format.has_stencil()) {
    fill.pattern[0] = static_cast<uint8_t>(value.depthStencil.stencil);
  } else if (format.is_depth()) {
    pack_depth(format, value.depthStencil.depth, fill.pattern.data());
  } else {
    pack_clear_color(format, value.color, fill.pattern.data());
  }
  fill.pattern_bytes = format.texel_bytes;
  fill.dst =
      attachment.address + uint64_t(rect.offset.y) * attachment.row_pitch_bytes + uint64_t(rect.offset.x) * format.texel_bytes;
  fill.row_bytes = uint64_t(rect.extent.width) * format.texel_bytes;
  fill.rows = rect.extent.height;
  fill.slices = attachment.samples;
  fill.row_pitch = attachment.row_pitch_bytes;
  fill.slice_pitch = attachment.sample_pitch_bytes;
  raster::fill_rows(pool, fill);
}

}  // namespace pineda::icd
