// Resolving regions of images and buffers to rows for raster::copy_rows and raster::fill_rows.
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

// Layers of an image, or slices of a volume, as slices.
struct ImageRegion {
  Rows rows;
  uint32_t width, height, slices;  // texels, rows, layers or slices
};

// Nothing when the region is not inside the image (invalid usage, which must not write elsewhere) or the image has no memory.
std::optional<ImageRegion> image_region(const Image& image, const VkImageSubresourceLayers& subresource, VkOffset3D offset,
                                        VkExtent3D extent);

// Fills rect of an attachment's level and layer.
void fill_attachment(raster::ThreadPool& pool, const raster::Attachment& attachment, const VkRect2D& rect,
                     const VkClearValue& value);

}  // namespace pineda::icd
