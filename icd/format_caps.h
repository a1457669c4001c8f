// What can be done with a format, derived from the table of formats (base/formats.inc).
#pragma once

#include "icd/vulkan_api.h"

namespace pineda::icd {

// Zeros for an unsupported format.
VkFormatProperties format_properties(VkFormat format);

struct ImageQuery {
  VkFormat format;
  VkImageType type;
  VkImageTiling tiling;
  VkImageUsageFlags usage;
  VkImageCreateFlags flags;
  VkImageUsageFlags stencil_usage = 0;  // VkImageStencilUsageCreateInfo: beside `usage`
};

// VK_ERROR_FORMAT_NOT_SUPPORTED when no such image can be made.
VkResult image_format_properties(const ImageQuery& query, VkImageFormatProperties* out);

}  // namespace pineda::icd
