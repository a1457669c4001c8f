// Buffers and images as cases need them: small, made afresh, filled and read back whole.
#pragma once

#include <vulkan/vulkan.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "cts-subset/harness/case.h"
#include "cts-subset/harness/device.h"
#include "tools/vk/handles.h"

namespace pineda::cts {

using tools::Owned;

// Calls a vkCreate* function and owns what it makes.
template <typename Handle, auto kDestroy, typename Create, typename Info>
Owned<Handle, kDestroy> make(const Device& device, Create create, const Info& info, const char* call) {
  Handle handle = VK_NULL_HANDLE;
  check(create(device.handle(), &info, nullptr, &handle), call);
  return {device.handle(), handle};
}

struct Buffer {
  Owned<VkDeviceMemory, vkFreeMemory> memory;
  Owned<VkBuffer, vkDestroyBuffer> handle;
  std::byte* mapped = nullptr;
  VkDeviceSize size_bytes = 0;

  template <typename T>
  std::span<T> as() const {
    return {reinterpret_cast<T*>(mapped), static_cast<size_t>(size_bytes) / sizeof(T)};
  }
};

constexpr VkBufferUsageFlags kAnyBuffer = VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT |
                                          VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT | VK_BUFFER_USAGE_STORAGE_BUFFER_BIT |
                                          VK_BUFFER_USAGE_INDEX_BUFFER_BIT | VK_BUFFER_USAGE_VERTEX_BUFFER_BIT |
                                          VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT;

// Mapped and coherent; filled with `fill` bytes.
Buffer create_buffer(Device& device, VkDeviceSize size_bytes, VkBufferUsageFlags usage = kAnyBuffer, uint8_t fill = 0);
Buffer create_buffer(Device& device, std::span<const std::byte> content, VkBufferUsageFlags usage = kAnyBuffer);
template <typename T>
Buffer create_buffer(Device& device, const std::vector<T>& content, VkBufferUsageFlags usage = kAnyBuffer) {
  return create_buffer(device, std::as_bytes(std::span(content)), usage);
}

struct ImageDesc {
  VkFormat format = VK_FORMAT_R8G8B8A8_UNORM;
  VkExtent3D extent{16, 16, 1};
  VkImageUsageFlags usage = VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT;
  VkImageType type = VK_IMAGE_TYPE_2D;
  VkImageViewType view_type = VK_IMAGE_VIEW_TYPE_2D;
  uint32_t levels = 1, layers = 1;
  VkSampleCountFlagBits samples = VK_SAMPLE_COUNT_1_BIT;
  VkImageCreateFlags flags = 0;
  VkImageAspectFlags aspects = 0;  // 0: from the format
  VkComponentMapping swizzle{};
  VkImageTiling tiling = VK_IMAGE_TILING_OPTIMAL;
};

struct Image {
  ImageDesc desc;
  Owned<VkDeviceMemory, vkFreeMemory> memory;
  Owned<VkImage, vkDestroyImage> handle;
  Owned<VkImageView, vkDestroyImageView> view;  // null when the usage allows none

  VkExtent3D level_extent(uint32_t level) const;
};

VkImageAspectFlags aspects_of(VkFormat format);
uint32_t texel_bytes(VkFormat format);  // of an uncompressed colour, depth or stencil format as buffers hold it (D24: 4)

// Throws NotSupported when vkGetPhysicalDeviceImageFormatProperties refuses the combination.
Image create_image(Device& device, const ImageDesc& desc);
// One level of one layer and one aspect, tightly packed. Level 0 of layer 0 comes first and discards what was there; the image
// ends in `layout`.
void upload(Device& device, const Image& image, std::span<const std::byte> texels, uint32_t level = 0, uint32_t layer = 0,
            VkImageLayout layout = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL, VkImageAspectFlags aspect = 0);
// From `layout`, which it leaves as TRANSFER_SRC_OPTIMAL; one aspect, tightly packed.
std::vector<std::byte> download(Device& device, const Image& image, VkImageLayout layout, uint32_t level = 0, uint32_t layer = 0,
                                VkImageAspectFlags aspect = 0);
template <typename T>
std::vector<T> download_as(Device& device, const Image& image, VkImageLayout layout, uint32_t level = 0, uint32_t layer = 0,
                           VkImageAspectFlags aspect = 0) {
  const std::vector<std::byte> bytes = download(device, image, layout, level, layer, aspect);
  const T* first = reinterpret_cast<const T*>(bytes.data());
  return {first, first + bytes.size() / sizeof(T)};
}

// Everything before, visible to everything after; the blunt barrier that keeps cases short.
void full_barrier(VkCommandBuffer commands);
void transition(VkCommandBuffer commands, const Image& image, VkImageLayout from, VkImageLayout to);

}  // namespace pineda::cts
