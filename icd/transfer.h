// Resolving regions of images and buffers to rows for raster::copy_rows and raster::fill_rows.
//
// Regions are counted in blocks of the image's format, which are texels for all but block-compressed formats.
#pragma once

#include <optional>

#include "base/format.h"
#include "icd/buffer.h"
#include "icd/image.h"
#include "raster/raster.h"

namespace pineda::icd {

// Rows of one side of a copy.
struct Rows {
  uint8_t* address;
  uint64_t row_pitch_bytes, slice_pitch_bytes;
};

// Layers of an image, or slices of a volume, as slices. With several samples, rows are sample 0's; sample s is s *
// sample_pitch_bytes further.
struct ImageRegion {
  const ImagePlane* plane;
  Rows rows;
  uint32_t columns, row_count, slices;  // blocks, rows of blocks, layers or slices
  uint32_t first_column, first_row;     // of the level
  uint64_t sample_pitch_bytes;
};

struct BlockExtent {
  uint32_t columns, rows, depth;
};
// Blocks that cover an extent of texels.
BlockExtent block_extent(const FormatInfo& format, const VkExtent3D& extent);

// `offset` in texels. Nothing when the region is not inside the image (invalid usage, which must not write elsewhere), begins
// inside a block, or the image has no memory. The plane is that of the subresource's aspect.
std::optional<ImageRegion> image_region(const Image& image, const VkImageSubresourceLayers& subresource, VkOffset3D offset,
                                        const BlockExtent& extent);

// Fills rect of an attachment's level and layer.
void fill_attachment(raster::ThreadPool& pool, const raster::Attachment& attachment, const VkRect2D& rect,
                     const VkClearValue& value);

}  // namespace pineda::icd
