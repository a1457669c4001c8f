// What image.cpp and image_query.cpp share.
#pragma once

#include "compiler/spirv/opcodes.h"

namespace pineda::spirv {

using Texel = std::array<ir::Value, 4>;

VkImageViewType view_type(const ImageType& image);
uint32_t dimensions(const ImageType& image);                                 // coordinates of one layer; a cube's direction has 3
Opaque opaque_of(Translator& t, const Instruction& inst, const Pointer& p);  // what a pointer to an image or sampler points to
const ImageType& image_type(Translator& t, const Instruction& inst,
                            const Opaque& o);  // fails when it is no image

}  // namespace pineda::spirv
