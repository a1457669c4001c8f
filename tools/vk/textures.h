// Textures of every dimension.
#pragma once

#include <functional>

#include "tools/vk/resources.h"

namespace pineda::tools {

struct TextureShape {
  VkImageViewType type = VK_IMAGE_VIEW_TYPE_2D;
  VkExtent3D extent{1, 1, 1};
  uint32_t levels = 1, layers = 1;
  VkFormat format = VK_FORMAT_R8G8B8A8_UNORM;  // of four bytes a texel
};

struct TexelPlace {
  uint32_t x, y, z, layer, level;
};

struct Texture {
  ImageHandle handle;
  MemoryHandle memory;
  ImageViewHandle view;
};

// Ready for sampling; `texel` gives the bits of each.
Texture create_texture(VkContext& context, const TextureShape& shape, const std::function<uint32_t(const TexelPlace&)>& texel);
SamplerHandle create_sampler(VkContext& context, VkSamplerCreateInfo info);  // its sType is filled in

}  // namespace pineda::tools
