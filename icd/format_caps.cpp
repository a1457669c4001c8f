#include "icd/format_caps.h"

#include <bit>

#include "base/format.h"
#include "icd/limits.h"

namespace pineda::icd {
namespace {

// A resource is addressed by 32-bit byte offsets (MipLevel in base/abi.h).
constexpr VkDeviceSize kMaxImageBytes = 0xFFFFFFFFu;

VkFormatFeatureFlags image_features(const FormatInfo& format) {
  VkFormatFeatureFlags features = 0;
  if (format.uses & kUseSampled) features |= VK_FORMAT_FEATURE_SAMPLED_IMAGE_BIT;
  if (format.uses & kUseLinear) features |= VK_FORMAT_FEATURE_SAMPLED_IMAGE_FILTER_LINEAR_BIT;
  if (format.uses & kUseColor) features |= VK_FORMAT_FEATURE_COLOR_ATTACHMENT_BIT;
  if (format.uses & kUseBlend) features |= VK_FORMAT_FEATURE_COLOR_ATTACHMENT_BLEND_BIT;
  if (format.uses & kUseDepth) features |= VK_FORMAT_FEATURE_DEPTH_STENCIL_ATTACHMENT_BIT;
  // exec_blit.cpp reads and writes every colour texel through the table, and copies depth texels.
  if (features != 0) features |= VK_FORMAT_FEATURE_BLIT_SRC_BIT | VK_FORMAT_FEATURE_BLIT_DST_BIT;
  return features;
}

bool usage_allowed(VkImageUsageFlags usage, VkFormatFeatureFlags features) {
  constexpr VkImageUsageFlags kTransfer = VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT;
  VkImageUsageFlags allowed = kTransfer;
  if (features & VK_FORMAT_FEATURE_SAMPLED_IMAGE_BIT) allowed |= VK_IMAGE_USAGE_SAMPLED_BIT;
  constexpr VkImageUsageFlags kTransient = VK_IMAGE_USAGE_TRANSIENT_ATTACHMENT_BIT | VK_IMAGE_USAGE_INPUT_ATTACHMENT_BIT;
  if (features & VK_FORMAT_FEATURE_COLOR_ATTACHMENT_BIT) allowed |= VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | kTransient;
  if (features & VK_FORMAT_FEATURE_DEPTH_STENCIL_ATTACHMENT_BIT)
    allowed |= VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT | kTransient;
  return (usage & ~allowed) == 0;
}

VkExtent3D max_extent(const ImageQuery& query) {
  switch (query.type) {
    case VK_IMAGE_TYPE_1D:
      return {kLimits.maxImageDimension1D, 1, 1};
    case VK_IMAGE_TYPE_3D:
      return {kLimits.maxImageDimension3D, kLimits.maxImageDimension3D, kLimits.maxImageDimension3D};
    default:
      return {kLimits.maxImageDimension2D, kLimits.maxImageDimension2D, 1};
  }
}

}  // namespace

VkFormatProperties format_properties(VkFormat format) {
  const FormatInfo* info = find_format(format);
  if (!info) return {};
  VkFormatProperties properties{};
  properties.linearTilingFeatures = properties.optimalTilingFeatures = image_features(*info);  // both tilings are rows
  if (info->uses & kUseVertex) properties.bufferFeatures |= VK_FORMAT_FEATURE_VERTEX_BUFFER_BIT;
  return properties;
}

VkResult image_format_properties(const ImageQuery& query, VkImageFormatProperties* out) {
  *out = {};
  const FormatInfo* info = find_format(query.format);
  if (!info) return VK_ERROR_FORMAT_NOT_SUPPORTED;
  if (query.tiling != VK_IMAGE_TILING_LINEAR && query.tiling != VK_IMAGE_TILING_OPTIMAL) return VK_ERROR_FORMAT_NOT_SUPPORTED;
  constexpr VkImageCreateFlags kFlags = VK_IMAGE_CREATE_MUTABLE_FORMAT_BIT | VK_IMAGE_CREATE_CUBE_COMPATIBLE_BIT;
  if (query.flags & ~kFlags) return VK_ERROR_FORMAT_NOT_SUPPORTED;
  const VkFormatFeatureFlags features = image_features(*info);
  if (features == 0 || !usage_allowed(query.usage, features)) return VK_ERROR_FORMAT_NOT_SUPPORTED;
  constexpr VkImageUsageFlags kTransfer = VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT;
  // Volumes are stored and copied; shaders cannot sample them yet.
  if (query.type == VK_IMAGE_TYPE_3D && (query.usage & ~kTransfer)) return VK_ERROR_FORMAT_NOT_SUPPORTED;
  out->maxExtent = max_extent(query);
  out->maxMipLevels = std::bit_width(out->maxExtent.width);
  out->maxArrayLayers = query.type == VK_IMAGE_TYPE_3D ? 1 : kLimits.maxImageArrayLayers;
  out->sampleCounts = VK_SAMPLE_COUNT_1_BIT;
  out->maxResourceSize = kMaxImageBytes;
  return VK_SUCCESS;
}

}  // namespace pineda::icd
