// Keeping the decoded copies of block-compressed images (icd/image.h) up to date.
#pragma once

#include "icd/transfer.h"

namespace pineda::icd {

// After a write of blocks: decodes the region into every decoded copy that the image has.
void decode_region(raster::ThreadPool& pool, const Image& image, const VkImageSubresourceLayers& subresource,
                   const ImageRegion& written);

}  // namespace pineda::icd
