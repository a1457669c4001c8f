// Execution of copies, clears and fills.
#include <algorithm>
#include <cstring>

#include "icd/decode.h"
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
std::optional<Rows> buffer_rows(const Buffer& buffer, const VkBufferImageCopy& region, const ImageRegion& image) {
  const FormatInfo& format = *image.plane->format;
  VkExtent3D texels = region.imageExtent;
  if (region.bufferRowLength) texels.width = region.bufferRowLength;
  if (region.bufferImageHeight) texels.height = region.bufferImageHeight;
  const BlockExtent pitch = block_extent(format, texels);
  const uint64_t row_pitch = uint64_t(pitch.columns) * format.texel_bytes;
  const Rows rows{buffer.data() + region.bufferOffset, row_pitch, row_pitch * pitch.rows};
  if (image.slices == 0 || image.row_count == 0) return rows;
  const uint64_t end_bytes = (image.slices - 1) * rows.slice_pitch_bytes + (image.row_count - 1) * rows.row_pitch_bytes +
                             uint64_t(image.columns) * format.texel_bytes;
  if (!buffer.data() || buffer.clamp(region.bufferOffset, end_bytes) != end_bytes) return std::nullopt;
  return rows;
}

void copy_region(raster::ThreadPool& pool, const Rows& to, const Rows& from, const ImageRegion& region) {
  copy(pool, to, from, uint64_t(region.columns) * region.plane->format->texel_bytes, region.row_count, region.slices);
}

std::optional<ImageRegion> region_of(const Image& image, const VkBufferImageCopy& region) {
  if (image.sample_count != 1) return std::nullopt;  // invalid usage
  const VkFormat format = aspect_format(image.format.format, region.imageSubresource.aspectMask);
  if (format == VK_FORMAT_UNDEFINED) return std::nullopt;
  return image_region(image, region.imageSubresource, region.imageOffset, block_extent(*find_format(format), region.imageExtent));
}

void fill_range(raster::ThreadPool& pool, const Image& image, const ImagePlane& plane, const VkImageSubresourceRange& range,
                const std::array<uint8_t, 16>& texel) {
  if (!image.data() || range.baseMipLevel >= image.level_count || range.baseArrayLayer >= image.layer_count) return;
  const uint32_t levels = std::min(image.levels_of(range), image.level_count - range.baseMipLevel);
  const uint32_t layers = std::min(image.layers_of(range), image.layer_count - range.baseArrayLayer);
  for (uint32_t i = range.baseMipLevel; i < range.baseMipLevel + levels; ++i) {
    const LevelLayout& level = plane.layout.level[i];
    raster::FillRows fill{.dst = image.subresource(plane, i, range.baseArrayLayer),
                          .row_bytes = uint64_t(level.extent.width) * plane.format->texel_bytes,
                          .rows = level.extent.height,
                          .slices = uint64_t(level.extent.depth) * image.sample_count,
                          .row_pitch = level.row_pitch_bytes,
                          .slice_pitch = level.slice_pitch_bytes,
                          .pattern = texel,
                          .pattern_bytes = plane.format->texel_bytes};
    if (fill.slices == 1) {  // layers of single slices go at once
      fill.slices = layers;
      fill.slice_pitch = plane.layout.layer_pitch_bytes;
      raster::fill_rows(pool, fill);
      continue;
    }
    for (uint32_t layer = 0; layer < layers; ++layer) {
      raster::fill_rows(pool, fill);
      fill.dst += plane.layout.layer_pitch_bytes;
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
  const Image& source = *command.source;
  const Image& destination = *command.destination;
  if (source.sample_count != destination.sample_count) return;  // invalid usage
  for (const VkImageCopy& region : command.regions) {
    const VkFormat format = aspect_format(source.format.format, region.srcSubresource.aspectMask);
    if (format == VK_FORMAT_UNDEFINED) continue;
    // The extent counts texels of the source. Layers of one image may be slices of the other (VK_KHR_maintenance1): its depth
    // counts slices only.
    BlockExtent blocks = block_extent(*find_format(format), region.extent);
    const uint32_t depth = blocks.depth;
    blocks.depth = source.type == VK_IMAGE_TYPE_3D ? depth : 1;
    const auto from = image_region(source, region.srcSubresource, region.srcOffset, blocks);
    blocks.depth = destination.type == VK_IMAGE_TYPE_3D ? depth : 1;
    auto to = image_region(destination, region.dstSubresource, region.dstOffset, blocks);
    if (!from || !to || from->plane->format->texel_bytes != to->plane->format->texel_bytes) continue;
    to->slices = std::min(from->slices, to->slices);
    for (uint32_t sample = 0; sample < source.sample_count; ++sample) {
      Rows read = from->rows, write = to->rows;
      read.address += sample * from->sample_pitch_bytes;
      write.address += sample * to->sample_pitch_bytes;
      copy_region(device_.pool, write, read, *to);
    }
    decode_region(device_.pool, destination, region.dstSubresource, *to);
  }
}

void Executor::execute(const cmd::CopyBufferToImage& command) {
  for (const VkBufferImageCopy& region : command.regions) {
    const auto to = region_of(*command.destination, region);
    if (!to) continue;
    const auto from = buffer_rows(*command.source, region, *to);
    if (!from) continue;
    copy_region(device_.pool, to->rows, *from, *to);
    decode_region(device_.pool, *command.destination, region.imageSubresource, *to);
  }
}

void Executor::execute(const cmd::CopyImageToBuffer& command) {
  for (const VkBufferImageCopy& region : command.regions) {
    const auto from = region_of(*command.source, region);
    if (!from) continue;
    const auto to = buffer_rows(*command.destination, region, *from);
    if (to) copy_region(device_.pool, *to, from->rows, *from);
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
  const Image& image = *command.image;
  if (image.format.is_depth_or_stencil() || !image.format.is_plain()) return;  // invalid usage
  std::array<uint8_t, 16> texel{};
  pack_clear_color(image.format, command.color, texel.data());
  for (const VkImageSubresourceRange& range : command.ranges) fill_range(device_.pool, image, image.plane(0), range, texel);
}

void Executor::execute(const cmd::ClearDepthStencilImage& command) {
  const Image& image = *command.image;
  for (const VkImageSubresourceRange& range : command.ranges) {
    for (const VkImageAspectFlags aspect : {VK_IMAGE_ASPECT_DEPTH_BIT, VK_IMAGE_ASPECT_STENCIL_BIT}) {
      if (!(range.aspectMask & image.format.aspects & aspect)) continue;
      const ImagePlane& plane = image.plane(plane_of(image.format, aspect));
      std::array<uint8_t, 16> texel{static_cast<uint8_t>(command.value.stencil)};
      if (aspect == VK_IMAGE_ASPECT_DEPTH_BIT) pack_depth(*plane.format, command.value.depth, texel.data());
      fill_range(device_.pool, image, plane, range, texel);
    }
  }
}

}  // namespace pineda::icd
