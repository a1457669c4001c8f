#include "tools/vk/block_texture.h"

#include <vector>

namespace pineda::tools {
namespace {

VkFormat vulkan_format(BlockFormat format) {
  switch (format) {
    case BlockFormat::kBc1:
      return VK_FORMAT_BC1_RGB_UNORM_BLOCK;
    case BlockFormat::kBc7:
      return VK_FORMAT_BC7_UNORM_BLOCK;
    case BlockFormat::kEtc2:
      return VK_FORMAT_ETC2_R8G8B8_UNORM_BLOCK;
    default:
      return VK_FORMAT_ASTC_4x4_UNORM_BLOCK;
  }
}

}  // namespace

Image2D create_block_texture(VkContext& context, std::span<const Image> mip_levels, BlockFormat format) {
  std::vector<std::vector<uint8_t>> levels;
  std::vector<Image> decoded;
  for (const Image& level : mip_levels) {
    EncodedImage encoded = encode_blocks(format, level);
    levels.push_back(std::move(encoded.blocks));
    decoded.push_back(std::move(encoded.decoded));
  }
  const VkFormat blocks = vulkan_format(format);
  if (!context.samples(blocks)) return create_texture(context, decoded, VK_FORMAT_R8G8B8A8_UNORM);
  return create_texture(context, {mip_levels[0].width, mip_levels[0].height}, levels, blocks);
}

}  // namespace pineda::tools
