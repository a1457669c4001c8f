#include "cts-subset/harness/resources.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "cts-subset/reference/formats.h"

namespace pineda::cts {
namespace {

constexpr VkImageUsageFlags kViewUsage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_STORAGE_BIT |
                                         VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT |
                                         VK_IMAGE_USAGE_INPUT_ATTACHMENT_BIT;

void create_view(Device& device, Image& image) {
  const ImageDesc& desc = image.desc;
  VkImageViewCreateInfo info{VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO};
  info.image = image.handle;
  info.viewType = desc.view_type;
  info.format = desc.format;
  info.components = desc.swizzle;
  info.subresourceRange = {desc.aspects ? desc.aspects : aspects_of(desc.format), 0, desc.levels, 0, desc.layers};
  image.view = make<VkImageView, vkDestroyImageView>(device, vkCreateImageView, info, "vkCreateImageView");
}

VkBufferImageCopy whole_level(const Image& image, uint32_t level, uint32_t layer, VkImageAspectFlags aspect) {
  VkBufferImageCopy copy{};
  copy.imageSubresource = {aspect ? aspect : aspects_of(image.desc.format), level, layer, 1};
  copy.imageExtent = image.level_extent(level);
  return copy;
}

VkDeviceSize level_bytes(const Image& image, uint32_t level, VkImageAspectFlags aspect) {
  const VkExtent3D extent = image.level_extent(level);
  const uint32_t bytes = aspect == VK_IMAGE_ASPECT_STENCIL_BIT ? 1 : texel_bytes(image.desc.format);
  return VkDeviceSize{extent.width} * extent.height * extent.depth * bytes;
}

}  // namespace

VkExtent3D Image::level_extent(uint32_t level) const {
  return {std::max(1u, desc.extent.width >> level), std::max(1u, desc.extent.height >> level),
          std::max(1u, desc.extent.depth >> level)};
}

VkImageAspectFlags aspects_of(VkFormat format) {
  switch (format) {
    case VK_FORMAT_D16_UNORM:
    case VK_FORMAT_X8_D24_UNORM_PACK32:
    case VK_FORMAT_D32_SFLOAT:
      return VK_IMAGE_ASPECT_DEPTH_BIT;
    case VK_FORMAT_S8_UINT:
      return VK_IMAGE_ASPECT_STENCIL_BIT;
    case VK_FORMAT_D16_UNORM_S8_UINT:
    case VK_FORMAT_D24_UNORM_S8_UINT:
    case VK_FORMAT_D32_SFLOAT_S8_UINT:
      return VK_IMAGE_ASPECT_DEPTH_BIT | VK_IMAGE_ASPECT_STENCIL_BIT;
    default:
      return VK_IMAGE_ASPECT_COLOR_BIT;
  }
}

uint32_t texel_bytes(VkFormat format) {
  switch (format) {
    case VK_FORMAT_S8_UINT:
      return 1;
    case VK_FORMAT_D16_UNORM:
    case VK_FORMAT_D16_UNORM_S8_UINT:
      return 2;
    case VK_FORMAT_X8_D24_UNORM_PACK32:
    case VK_FORMAT_D32_SFLOAT:
    case VK_FORMAT_D24_UNORM_S8_UINT:
    case VK_FORMAT_D32_SFLOAT_S8_UINT:
      return 4;
    default:
      return info_of(format).bytes;
  }
}

Buffer create_buffer(Device& device, VkDeviceSize size_bytes, VkBufferUsageFlags usage, uint8_t fill) {
  Buffer buffer;
  buffer.size_bytes = size_bytes;
  VkBufferCreateInfo info{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
  info.size = size_bytes;
  info.usage = usage;
  buffer.handle = make<VkBuffer, vkDestroyBuffer>(device, vkCreateBuffer, info, "vkCreateBuffer");
  VkMemoryRequirements requirements;
  vkGetBufferMemoryRequirements(device.handle(), buffer.handle, &requirements);
  VkMemoryAllocateInfo allocate{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO};
  allocate.allocationSize = requirements.size;
  allocate.memoryTypeIndex =
      device.memory_type(requirements.memoryTypeBits, VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT);
  buffer.memory = make<VkDeviceMemory, vkFreeMemory>(device, vkAllocateMemory, allocate, "vkAllocateMemory");
  check(vkBindBufferMemory(device.handle(), buffer.handle, buffer.memory, 0), "vkBindBufferMemory");
  void* mapped = nullptr;
  check(vkMapMemory(device.handle(), buffer.memory, 0, VK_WHOLE_SIZE, 0, &mapped), "vkMapMemory");
  buffer.mapped = static_cast<std::byte*>(mapped);
  std::memset(mapped, fill, size_bytes);
  return buffer;
}

Buffer create_buffer(Device& device, std::span<const std::byte> content, VkBufferUsageFlags usage) {
  Buffer buffer = create_buffer(device, std::max<size_t>(content.size(), 4), usage);
  std::memcpy(buffer.mapped, content.data(), content.size());
  return buffer;
}

Image create_image(Device& device, const ImageDesc& desc) {
  VkImageFormatProperties properties;
  const VkResult supported = vkGetPhysicalDeviceImageFormatProperties(device.physical(), desc.format, desc.type, desc.tiling,
                                                                      desc.usage, desc.flags, &properties);
  require(supported != VK_ERROR_FORMAT_NOT_SUPPORTED, "format, type, tiling or usage");
  check(supported, "vkGetPhysicalDeviceImageFormatProperties");
  require(properties.sampleCounts & desc.samples, "sample count");
  require(properties.maxArrayLayers >= desc.layers && properties.maxMipLevels >= desc.levels, "layers or levels");
  Image image;
  image.desc = desc;
  VkImageCreateInfo info{VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO};
  info.flags = desc.flags;
  info.imageType = desc.type;
  info.format = desc.format;
  info.extent = desc.extent;
  info.mipLevels = desc.levels;
  info.arrayLayers = desc.layers;
  info.samples = desc.samples;
  info.tiling = desc.tiling;
  info.usage = desc.usage;
  image.handle = make<VkImage, vkDestroyImage>(device, vkCreateImage, info, "vkCreateImage");
  VkMemoryRequirements requirements;
  vkGetImageMemoryRequirements(device.handle(), image.handle, &requirements);
  VkMemoryAllocateInfo allocate{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO};
  allocate.allocationSize = requirements.size;
  allocate.memoryTypeIndex = device.memory_type(requirements.memoryTypeBits, 0);
  image.memory = make<VkDeviceMemory, vkFreeMemory>(device, vkAllocateMemory, allocate, "vkAllocateMemory");
  check(vkBindImageMemory(device.handle(), image.handle, image.memory, 0), "vkBindImageMemory");
  if (desc.usage & kViewUsage) create_view(device, image);
  return image;
}

void upload(Device& device, const Image& image, std::span<const std::byte> texels, uint32_t level, uint32_t layer,
            VkImageLayout layout, VkImageAspectFlags aspect) {
  const Buffer staging = create_buffer(device, texels, VK_BUFFER_USAGE_TRANSFER_SRC_BIT);
  VkBufferImageCopy copy = whole_level(image, level, layer, aspect);
  device.run([&](VkCommandBuffer commands) {
    const bool first = level == 0 && layer == 0;
    transition(commands, image, first ? VK_IMAGE_LAYOUT_UNDEFINED : layout, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
    vkCmdCopyBufferToImage(commands, staging.handle, image.handle, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &copy);
    transition(commands, image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, layout);
  });
}

std::vector<std::byte> download(Device& device, const Image& image, VkImageLayout layout, uint32_t level, uint32_t layer,
                                VkImageAspectFlags aspect) {
  const Buffer staging = create_buffer(device, level_bytes(image, level, aspect), VK_BUFFER_USAGE_TRANSFER_DST_BIT);
  const VkBufferImageCopy copy = whole_level(image, level, layer, aspect);
  device.run([&](VkCommandBuffer commands) {
    transition(commands, image, layout, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
    vkCmdCopyImageToBuffer(commands, image.handle, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, staging.handle, 1, &copy);
    full_barrier(commands);
  });
  return {staging.mapped, staging.mapped + staging.size_bytes};
}

void full_barrier(VkCommandBuffer commands) {
  VkMemoryBarrier barrier{VK_STRUCTURE_TYPE_MEMORY_BARRIER};
  barrier.srcAccessMask = VK_ACCESS_MEMORY_WRITE_BIT;
  barrier.dstAccessMask = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT | VK_ACCESS_HOST_READ_BIT;
  vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT,
                       VK_PIPELINE_STAGE_ALL_COMMANDS_BIT | VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &barrier, 0, nullptr, 0, nullptr);
}

void transition(VkCommandBuffer commands, const Image& image, VkImageLayout from, VkImageLayout to) {
  VkImageMemoryBarrier barrier{VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER};
  barrier.srcAccessMask = VK_ACCESS_MEMORY_WRITE_BIT;
  barrier.dstAccessMask = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT;
  barrier.oldLayout = from;
  barrier.newLayout = to;
  barrier.srcQueueFamilyIndex = barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
  barrier.image = image.handle;
  barrier.subresourceRange = {aspects_of(image.desc.format), 0, VK_REMAINING_MIP_LEVELS, 0, VK_REMAINING_ARRAY_LAYERS};
  vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, 0, 0, nullptr, 0,
                       nullptr, 1, &barrier);
}

}  // namespace pineda::cts
