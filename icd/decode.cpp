#include "icd/decode.h"

#include <algorithm>
#include <cstring>

#include "base/block_codec.h"

namespace pineda::icd {
namespace {

// One row of blocks, cut off at the level's right and lower edge.
void decode_row(const FormatInfo& format, BlockDecoder decoder, const uint8_t* blocks, uint32_t count, uint8_t* texels,
                uint64_t row_pitch_bytes, uint32_t texel_bytes, uint32_t width, uint32_t height) {
  alignas(16) uint8_t decoded[kMaxBlockBytes];
  const uint32_t block_row_bytes = format.block_width * texel_bytes;
  for (uint32_t i = 0; i < count; ++i) {
    decoder(format, blocks + size_t(i) * format.texel_bytes, decoded);
    const uint32_t x = i * format.block_width;
    const size_t bytes = size_t(std::min<uint32_t>(format.block_width, width - x)) * texel_bytes;
    for (uint32_t y = 0; y < height; ++y) {
      std::memcpy(texels + y * row_pitch_bytes + size_t(x) * texel_bytes, decoded + y * block_row_bytes, bytes);
    }
  }
}

void decode_into(raster::ThreadPool& pool, const Image& image, const ImagePlane& copy,
                 const VkImageSubresourceLayers& subresource, const ImageRegion& written) {
  const FormatInfo& format = *find_format(copy.decodes);
  const BlockDecoder decoder = block_decoder(format);
  const uint32_t texel_bytes = copy.format->texel_bytes;
  const LevelLayout& level = copy.layout.level[subresource.mipLevel];
  const bool is_volume = image.type == VK_IMAGE_TYPE_3D;
  const uint64_t slice_pitch = is_volume ? level.slice_pitch_bytes : copy.layout.layer_pitch_bytes;
  // The region's first slice: `written` tells it as an address in plane 0.
  const uint8_t* plane_level = image.subresource(image.plane(0), subresource.mipLevel, subresource.baseArrayLayer);
  const uint64_t first_slice =
      is_volume ? static_cast<uint64_t>(written.rows.address - plane_level) / written.rows.slice_pitch_bytes : 0;
  uint8_t* to = image.subresource(copy, subresource.mipLevel, subresource.baseArrayLayer) + first_slice * slice_pitch;
  const uint32_t x = written.first_column * format.block_width;
  const uint64_t rows = uint64_t(written.row_count) * written.slices;
  constexpr uint64_t kBlocksWorthAThread = 256;
  pool.parallel_for(
      static_cast<uint32_t>(rows),
      [&](uint32_t index, uint32_t) {
        const uint32_t slice = index / written.row_count, row = index % written.row_count;
        const uint32_t y = (written.first_row + row) * format.block_height;
        decode_row(format, decoder,
                   written.rows.address + slice * written.rows.slice_pitch_bytes + row * written.rows.row_pitch_bytes,
                   written.columns, to + slice * slice_pitch + uint64_t(y) * level.row_pitch_bytes + uint64_t(x) * texel_bytes,
                   level.row_pitch_bytes, texel_bytes, level.extent.width - x,
                   std::min<uint32_t>(format.block_height, level.extent.height - y));
      },
      rows * written.columns >= kBlocksWorthAThread);
}

}  // namespace

void decode_region(raster::ThreadPool& pool, const Image& image, const VkImageSubresourceLayers& subresource,
                   const ImageRegion& written) {
  if (!image.format.is_compressed() || written.columns == 0 || written.row_count == 0 || written.slices == 0) return;
  for (uint32_t i = Image::kFirstDecoded; i < Image::kPlanes; ++i) {
    const ImagePlane& copy = image.plane(i);
    if (copy.format) decode_into(pool, image, copy, subresource, written);
  }
}

}  // namespace pineda::icd
