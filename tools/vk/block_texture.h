// Compressed textures; where the driver lacks the format, what the blocks decode to.
#pragma once

#include <span>

#include "tools/block_encoder.h"
#include "tools/vk/resources.h"

namespace pineda::tools {

// Ready for sampling.
Image2D create_block_texture(VkContext& context, std::span<const Image> mip_levels, BlockFormat format);

}  // namespace pineda::tools
