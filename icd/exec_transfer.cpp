// Execution of copies, clears and fills.
#include <algorithm>
#include <cstring>

#include "icd/device.h"
#include "icd/executor.h"
#include "icd/transfer.h"

namespace pineda::icd {
namespace {

void copy(raster::ThreadPool& pool, const Rows& to, const Rows& from, uint64_t row_bytes, uint64_t rows, uint64_t slices) {
  raster::copy_rows(pool, {.src = from.address,
                           .dst = to.address,
                           .row_bytes = row_bytes,
                           .rows = rows,
                           .slices = slices,
                           .src_row_pitch = from.row_pitch_bytes,
                           .dst_row_pitch = to.row_pitch_bytes,
                           .src_slice_pitch = from.slice_pitch_bytes,
                           .dst_slice_pitch = to.slice_pitch_bytes});
}

// The rows of a buffer that belong to a region of an image ("Buffer and Image Addressing"); nothing when they are not inside it.
std::optional<Rows> buffer_rows(const Buffer& buffer, const VkBufferImageCopy& region, const ImageRegion& image,
                                uint32_t texel_bytes) {
  const uint64_t row_length = region.bufferRowLength ? region.bufferRowLength : region.imageExtent.width;
  const uint64_t image_height = region.bufferImageHeight ? region.bufferImageHeight : region.imageExtent.height;
  const Rows rows{buffer.data() + region.bufferOffset, row_length * texel_bytes, row_length * image_height * texel_bytes};
  if (image.slices == 0 || image.height == 0) return rows;
  const uint64_t end_bytes = (image.slices - 1) * rows.slice_pitch_bytes + (image.height - 1) * rows.row_pitch_bytes +
                             uint64_t(image.width) * texel_bytes;
  if (!buffer.data() || buffer.clamp(region.bufferOffset, end_bytes) != end_bytes) return std::nullopt;
  return rows;
}

void fill_ranges(raster::ThreadPool& pool, const Image& image, std::span<const VkImageSubresourceRange> ranges,
                 const std::array<uint8_t, 16>& texel) {
  for (const VkImageSubresourceRange& range : ranges) {
    if (!image.data() || range.baseMipLevel >= image.level_count || range.baseArrayLayer >= image.layer_count) continue;
    const uint32_t levels = std::min(image.levels_of(range), image.level_count - range.baseMipLevel);
    const uint32_t layers = std::min(image.layers_of(range), image.layer_count - range.baseArrayLayer);
    for (uint32_t i = range.baseMipLevel; i < range.baseMipLevel + levels; ++i) {
      const LevelLayout& level = image.layout.level[i];
      const bool is_volume = image.type == VK_IMAGE_TYPE_3D;
      raster::fill_rows(pool, {.dst = image.subresource(i, range.baseArrayLayer),
                               .row_bytes = uint64_t(level.extent.width) * image.format.texel_bytes,
                               .rows = level.extent.height,
                               .slices = is_volume ? level.extent.depth : layers,
                               .row_pitch = level.row_pitch_bytes,
                               .slice_pitch = is_volume ? level.slice_pitch_bytes : image.layout.layer_pitch_bytes,
                               .pattern = texel,
                               .pattern_bytes = image.format.texel_bytes});
    }
  }
}

}  // namespace

void Executor::execute(const cmd::CopyBuffer& command) {
  if (!command.source->data() || !command.destination->data()) return;
  for (const VkBufferCopy& region : command.regions) {
    const uint64_t bytes =
        std::min(command.source->clamp(region.srcOffset, region.size), command.destination->clamp(region.dstOffset, region.size));
    const Rows from{command.source->data() + region.srcOffset, 0, 0};
    const Rows to{command.destination->data() + region.dstOffset, 0, 0};
    if (bytes > 0) copy(device_.pool, to, from, bytes, 1, 1);
  }
}

void Executor::execute(const cmd::CopyImage& command) {
  const uint32_t texel_bytes = command.source->format.texel_bytes;
  if (texel_bytes != command.destination->format.texel_bytes) return;
  for (const VkImageCopy& region : command.regions) {
    // Layers of one image may be slices of the other (VK_KHR_maintenance1): the extent's depth counts slices only.
    const auto resolve = [&](const Image& image, const VkImageSubresourceLayers& subresource, VkOffset3D offset) {
      VkExtent3D extent = region.extent;
      if (image.type != VK_IMAGE_TYPE_3D) extent.depth = 1;
      return image_region(image, subresource, offset, extent);
    };
    const auto from = resolve(*command.source, region.srcSubresource, region.srcOffset);
    const auto to = resolve(*command.destination, region.dstSubresource, region.dstOffset);
    if (!from || !to) continue;
    const uint32_t slices = std::min(from->slices, to->slices);
    copy(device_.pool, to->rows, from->rows, uint64_t(from->width) * texel_bytes, from->height, slices);
  }
}

void Executor::execute(const cmd::CopyBufferToImage& command) {
  const uint32_t texel_bytes = command.destination->format.texel_bytes;
  for (const VkBufferImageCopy& region : command.regions) {
    const auto to = image_region(*command.destination, region.imageSubresource, region.imageOffset, region.imageExtent);
    if (!to) continue;
    const auto from = buffer_rows(*command.source, region, *to, texel_bytes);
    if (from) copy(device_.pool, to->rows, *from, uint64_t(to->width) * texel_bytes, to->height, to->slices);
  }
}

void Executor::execute(const cmd::CopyImageToBuffer& command) {
  const uint32_t texel_bytes = command.source->format.texel_bytes;
  for (const VkBufferImageCopy& region : command.regions) {
    const auto from = image_region(*command.source, region.imageSubresource, region.imageOffset, region.imageExtent);
    if (!from) continue;
    const auto to = buffer_rows(*command.destination, region, *from, texel_bytes);
    if (to) copy(device_.pool, *to, from->rows, uint64_t(from->width) * texel_bytes, from->height, from->slices);
  }
}

void Executor::execute(const cmd::UpdateBuffer& command) {
  if (!command.destination->data()) return;
  std::memcpy(command.destination->data() + command.offset, command.bytes.data(),
              command.destination->clamp(command.offset, command.bytes.size()));
}

void Executor::execute(const cmd::FillBuffer& command) {
  if (!command.destination->data()) return;
  raster::FillRows fill{};
  fill.dst = command.destination->data() + command.offset;
  fill.row_bytes = command.destination->clamp(command.offset, command.size) / 4 * 4;  // VK_WHOLE_SIZE: rounded down to words
  fill.rows = fill.slices = 1;
  std::memcpy(fill.pattern.data(), &command.data, 4);
  fill.pattern_bytes = 4;
  if (fill.row_bytes > 0) raster::fill_rows(device_.pool, fill);
}

void Executor::execute(const cmd::ClearColorImage& command) {
  if (command.image->format.is_depth()) return;
  std::array<uint8_t, 16> texel{};
  pack_clear_color(command.image->format, command.color, texel.data());
  fill_ranges(device_.pool, *command.image, command.ranges, texel);
}

void Executor::execute(const cmd::ClearDepthStencilImage& command) {
  if (!command.image->format.is_depth()) return;
  std::array<uint8_t, 16> texel{};
  pack_depth(command.image->format, command.value.depth, texel.data());
  fill_ranges(device_.pool, *command.image, command.ranges, texel);
}

}  // namespace pineda::icd
