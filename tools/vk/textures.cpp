#include "tools/vk/textures.h"

#include <algorithm>

namespace pineda::tools {
namespace {

VkExtent3D level_extent(const TextureShape& shape, uint32_t level) {
  const auto size = [&](uint32_t texels) { return std::max(texels >> level, 1u); };
  return {size(shape.extent.width), size(shape.extent.height), size(shape.extent.depth)};
}

VkImageAspectFlags aspect(const TextureShape& shape) {
  return shape.format == VK_FORMAT_D32_SFLOAT ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT;
}

void move_layout(VkCommandBuffer commands, VkImage image, const TextureShape& shape, VkImageLayout from, VkImageLayout to) {
  const VkImageMemoryBarrier barrier{.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER,
                                     .srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT,
                                     .dstAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT | VK_ACCESS_SHADER_READ_BIT,
                                     .oldLayout = from,
                                     .newLayout = to,
                                     .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
                                     .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
                                     .image = image,
                                     .subresourceRange = {aspect(shape), 0, shape.levels, 0, shape.layers}};
  vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT,
                       VK_PIPELINE_STAGE_TRANSFER_BIT | VK_PIPELINE_STAGE_FRAGMENT_SHADER_BIT, 0, 0, nullptr, 0, nullptr, 1,
                       &barrier);
}

void upload(VkContext& context, VkImage image, const TextureShape& shape,
            const std::function<uint32_t(const TexelPlace&)>& texel) {
  std::vector<uint32_t> texels;
  std::vector<VkBufferImageCopy> copies;
  for (uint32_t level = 0; level < shape.levels; ++level) {
    const VkExtent3D extent = level_extent(shape, level);
    copies.push_back(
        {.bufferOffset = 4 * texels.size(), .imageSubresource = {aspect(shape), level, 0, shape.layers}, .imageExtent = extent});
    for (uint32_t layer = 0; layer < shape.layers; ++layer) {
      for (uint32_t z = 0; z < extent.depth; ++z) {
        for (uint32_t y = 0; y < extent.height; ++y) {
          for (uint32_t x = 0; x < extent.width; ++x) texels.push_back(texel({x, y, z, layer, level}));
        }
      }
    }
  }
  const Buffer staging = create_buffer(context, texels, VK_BUFFER_USAGE_TRANSFER_SRC_BIT);
  context.run_once([&](VkCommandBuffer commands) {
    move_layout(commands, image, shape, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
    vkCmdCopyBufferToImage(commands, staging.handle, image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                           static_cast<uint32_t>(copies.size()), copies.data());
    move_layout(commands, image, shape, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
  });
}

}  // namespace

Texture create_texture(VkContext& context, const TextureShape& shape, const std::function<uint32_t(const TexelPlace&)>& texel) {
  const bool cube = shape.type == VK_IMAGE_VIEW_TYPE_CUBE;
  const VkImageCreateInfo info{.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
                               .flags = cube ? VkImageCreateFlags(VK_IMAGE_CREATE_CUBE_COMPATIBLE_BIT) : 0,
                               .imageType = shape.type == VK_IMAGE_VIEW_TYPE_3D ? VK_IMAGE_TYPE_3D : VK_IMAGE_TYPE_2D,
                               .format = shape.format,
                               .extent = shape.extent,
                               .mipLevels = shape.levels,
                               .arrayLayers = shape.layers,
                               .samples = VK_SAMPLE_COUNT_1_BIT,
                               .tiling = VK_IMAGE_TILING_OPTIMAL,
                               .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT};
  VkImage handle = VK_NULL_HANDLE;
  check(vkCreateImage(context.device(), &info, nullptr, &handle), "vkCreateImage");
  Texture out{.handle = {context.device(), handle}, .memory = {}, .view = {}};
  VkMemoryRequirements requirements;
  vkGetImageMemoryRequirements(context.device(), handle, &requirements);
  out.memory = allocate(context, requirements, 0);
  check(vkBindImageMemory(context.device(), handle, out.memory, 0), "vkBindImageMemory");
  upload(context, handle, shape, texel);
  const VkImageViewCreateInfo view_info{.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
                                        .image = handle,
                                        .viewType = shape.type,
                                        .format = shape.format,
                                        .subresourceRange = {aspect(shape), 0, shape.levels, 0, shape.layers}};
  VkImageView view = VK_NULL_HANDLE;
  check(vkCreateImageView(context.device(), &view_info, nullptr, &view), "vkCreateImageView");
  out.view = {context.device(), view};
  return out;
}

SamplerHandle create_sampler(VkContext& context, VkSamplerCreateInfo info) {
  info.sType = VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO;
  VkSampler sampler = VK_NULL_HANDLE;
  check(vkCreateSampler(context.device(), &info, nullptr, &sampler), "vkCreateSampler");
  return {context.device(), sampler};
}

}  // namespace pineda::tools
