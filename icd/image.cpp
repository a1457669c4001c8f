#include "icd/image.h"

#include <bit>

#include "icd/api.h"
#include "icd/device.h"
#include "icd/device_memory.h"
#include "icd/format_caps.h"

namespace pineda::icd {

// The specification makes exceeding vkGetPhysicalDeviceImageFormatProperties invalid; being exact here keeps sizes within 32
// bits.
VkResult Image::check(Device&, const VkImageCreateInfo& info) {
  VkImageFormatProperties limits;
  const ImageQuery query{info.format, info.imageType, info.tiling, info.usage, info.flags};
  if (image_format_properties(query, &limits) != VK_SUCCESS) {
    return not_supported(
        "vkCreateImage: vkGetPhysicalDeviceImageFormatProperties refuses this format, type, usage or these flags");
  }
  const VkExtent3D& extent = info.extent;
  const bool fits = extent.width >= 1 && extent.height >= 1 && extent.depth >= 1 && extent.width <= limits.maxExtent.width &&
                    extent.height <= limits.maxExtent.height && extent.depth <= limits.maxExtent.depth;
  const uint32_t largest = std::max({extent.width, extent.height, extent.depth});
  const bool levels_fit = info.mipLevels >= 1 && info.mipLevels <= uint32_t(std::bit_width(largest));
  if (!fits || !levels_fit || info.arrayLayers < 1 || info.arrayLayers > limits.maxArrayLayers ||
      info.samples != VK_SAMPLE_COUNT_1_BIT) {
    return not_supported("vkCreateImage: extent, levels, layers or samples are beyond vkGetPhysicalDeviceImageFormatProperties");
  }
  const bool addressable = image_layout(extent, info.mipLevels, info.arrayLayers, texel_bytes(info.format)).has_value();
  return addressable ? VK_SUCCESS : VK_ERROR_OUT_OF_DEVICE_MEMORY;  // "exceeds maxResourceSize"
}

Image::Image(const Allocator& from, Device&, const VkImageCreateInfo& info)
    : Object(from),
      type(info.imageType),
      format(*find_format(info.format)),
      level_count(info.mipLevels),
      layer_count(info.arrayLayers),
      layout(*image_layout(info.extent, info.mipLevels, info.arrayLayers, format.texel_bytes)) {}

VkResult api::CreateImage(VkDevice device, const VkImageCreateInfo* info, const VkAllocationCallbacks* callbacks, VkImage* out) {
  return create_device_object<Image>(device, info, callbacks, out);
}

void api::DestroyImage(VkDevice device, VkImage image, const VkAllocationCallbacks* callbacks) {
  destroy_device_object(device, image, callbacks);
}

void api::GetImageMemoryRequirements(VkDevice, VkImage image, VkMemoryRequirements* out) {
  *out = {.size = from(image)->layout.size_bytes, .alignment = kResourceAlignment_bytes, .memoryTypeBits = 1};
}

void api::GetImageSparseMemoryRequirements(VkDevice, VkImage, uint32_t* count, VkSparseImageMemoryRequirements*) { *count = 0; }

VkResult api::BindImageMemory(VkDevice, VkImage image, VkDeviceMemory memory, VkDeviceSize offset) {
  from(image)->bind(from(memory)->data() + offset);
  return VK_SUCCESS;
}

void api::GetImageSubresourceLayout(VkDevice, VkImage handle, const VkImageSubresource* subresource, VkSubresourceLayout* out) {
  const Image& image = *from(handle);
  const LevelLayout& level = image.layout.level[subresource->mipLevel];
  *out = {.offset = uint64_t(subresource->arrayLayer) * image.layout.layer_pitch_bytes + level.offset_bytes,
          .size = uint64_t(level.slice_pitch_bytes) * level.extent.depth,
          .rowPitch = level.row_pitch_bytes,
          .arrayPitch = image.layout.layer_pitch_bytes,
          .depthPitch = level.slice_pitch_bytes};
}

}  // namespace pineda::icd
