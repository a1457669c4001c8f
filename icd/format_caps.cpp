#include "icd/format_caps.h"

#include <atomic>
#include <bit>
#include <cstdio>

#include "base/format.h"
#include "base/log.h"
#include "base/sample_locations.h"
#include "icd/limits.h"

namespace pineda::icd {
namespace {

// A resource is addressed by 32-bit byte offsets (MipLevel in base/abi.h).
constexpr VkDeviceSize kMaxImageBytes = 0xFFFFFFFFu;

// Formats of several colour planes: sampled through a conversion with implicit reconstruction, copied plane by plane.
constexpr VkFormatFeatureFlags kPlanarFeatures =
    VK_FORMAT_FEATURE_SAMPLED_IMAGE_BIT | VK_FORMAT_FEATURE_SAMPLED_IMAGE_FILTER_LINEAR_BIT |
    VK_FORMAT_FEATURE_SAMPLED_IMAGE_YCBCR_CONVERSION_LINEAR_FILTER_BIT | VK_FORMAT_FEATURE_MIDPOINT_CHROMA_SAMPLES_BIT |
    VK_FORMAT_FEATURE_COSITED_CHROMA_SAMPLES_BIT | VK_FORMAT_FEATURE_TRANSFER_SRC_BIT | VK_FORMAT_FEATURE_TRANSFER_DST_BIT;

VkFormatFeatureFlags image_features(const FormatInfo& format) {
  if (format.plane_count() > 1 && !format.is_depth_or_stencil()) return kPlanarFeatures;
  VkFormatFeatureFlags features = 0;
  if (format.uses & kUseSampled) features |= VK_FORMAT_FEATURE_SAMPLED_IMAGE_BIT;
  if (format.uses & kUseLinear) features |= VK_FORMAT_FEATURE_SAMPLED_IMAGE_FILTER_LINEAR_BIT;
  if ((format.uses & kUseLinear) && !format.is_integer()) features |= VK_FORMAT_FEATURE_SAMPLED_IMAGE_FILTER_MINMAX_BIT;
  if (format.uses & kUseColor) features |= VK_FORMAT_FEATURE_COLOR_ATTACHMENT_BIT;
  if (format.uses & kUseBlend) features |= VK_FORMAT_FEATURE_COLOR_ATTACHMENT_BLEND_BIT;
  if (format.uses & kUseDepth) features |= VK_FORMAT_FEATURE_DEPTH_STENCIL_ATTACHMENT_BIT;
  if (format.uses & kUseStorage) features |= VK_FORMAT_FEATURE_STORAGE_IMAGE_BIT;
  if (format.uses & kUseStorageAtomic) features |= VK_FORMAT_FEATURE_STORAGE_IMAGE_ATOMIC_BIT;
  if (features == 0) return 0;
  features |= VK_FORMAT_FEATURE_BLIT_SRC_BIT | VK_FORMAT_FEATURE_TRANSFER_SRC_BIT | VK_FORMAT_FEATURE_TRANSFER_DST_BIT;
  if (!format.is_compressed()) features |= VK_FORMAT_FEATURE_BLIT_DST_BIT;
  return features;
}

// Rows in both tilings. But a host could write blocks of an image of linear tiling behind the back of their decoded copy, and
// vkGetImageSubresourceLayout has no answer for two aspects in one.
VkFormatFeatureFlags image_features(const FormatInfo& format, VkImageTiling tiling) {
  const VkFormatFeatureFlags features = image_features(format);
  if (tiling == VK_IMAGE_TILING_OPTIMAL || (format.is_plain() && !format.is_depth_or_stencil())) return features;
  if (!format.is_compressed() && !format.is_depth_or_stencil()) return features;  // YCbCr: an aspect for each plane
  return 0;
}

constexpr VkImageUsageFlags kTransferUsage = VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT;

// Usage of Vulkan 1.0: none of the extensions here adds any. An application that sets another bit is wrong
// (VUID-VkImageCreateInfo-usage-parameter), but Mesa's Zink does for every texture (that of
// VK_EXT_attachment_feedback_loop_layout) and takes no for an answer that the format has no use at all. What a bit means that the
// driver does not know cannot be asked of it later, so it is told once and left out.
constexpr VkImageUsageFlags kKnownUsage = kTransferUsage | VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_STORAGE_BIT |
                                          VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT |
                                          VK_IMAGE_USAGE_TRANSIENT_ATTACHMENT_BIT | VK_IMAGE_USAGE_INPUT_ATTACHMENT_BIT;

VkImageUsageFlags known_usage(VkImageUsageFlags usage) {
  static std::atomic<bool> told{false};
  if ((usage & ~kKnownUsage) && !told.exchange(true)) {
    char text[120];
    std::snprintf(text, sizeof(text), "image usage 0x%x is of an extension that is not supported: ignored", usage & ~kKnownUsage);
    report(Severity::kWarning, text);
  }
  return usage & kKnownUsage;
}

bool usage_allowed(VkImageUsageFlags usage, VkFormatFeatureFlags features) {
  static constexpr struct {
    VkFormatFeatureFlags feature;
    VkImageUsageFlags usage;
  } kRows[] = {
      {VK_FORMAT_FEATURE_SAMPLED_IMAGE_BIT, VK_IMAGE_USAGE_SAMPLED_BIT},
      {VK_FORMAT_FEATURE_STORAGE_IMAGE_BIT, VK_IMAGE_USAGE_STORAGE_BIT},
      {VK_FORMAT_FEATURE_COLOR_ATTACHMENT_BIT,
       VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSIENT_ATTACHMENT_BIT | VK_IMAGE_USAGE_INPUT_ATTACHMENT_BIT},
      {VK_FORMAT_FEATURE_DEPTH_STENCIL_ATTACHMENT_BIT, VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT |
                                                           VK_IMAGE_USAGE_TRANSIENT_ATTACHMENT_BIT |
                                                           VK_IMAGE_USAGE_INPUT_ATTACHMENT_BIT},
  };
  VkImageUsageFlags allowed = kTransferUsage;
  for (const auto& row : kRows) {
    if (features & row.feature) allowed |= row.usage;
  }
  return (usage & ~allowed) == 0;
}

// What views of an image may be used for, when the image is created with VK_IMAGE_CREATE_EXTENDED_USAGE_BIT: by any format of its
// compatibility class. Blocks have none but themselves: no view writes them.
VkFormatFeatureFlags class_features(const FormatInfo& of, VkImageTiling tiling) {
  VkFormatFeatureFlags features = 0;
  for (const FormatInfo& format : all_formats()) {
    const bool compatible = format.is_plain() && !format.is_depth_or_stencil() && format.texel_bytes == of.texel_bytes;
    if (compatible) features |= image_features(format, tiling);
  }
  return of.is_plain() && !of.is_depth_or_stencil() ? features : 0;
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

namespace {

// "sampleCounts will be set to VK_SAMPLE_COUNT_1_BIT if" tiling, type, flags or format do not allow more.
VkSampleCountFlags sample_counts(const ImageQuery& query, VkFormatFeatureFlags features) {
  constexpr VkFormatFeatureFlags kAttachment =
      VK_FORMAT_FEATURE_COLOR_ATTACHMENT_BIT | VK_FORMAT_FEATURE_DEPTH_STENCIL_ATTACHMENT_BIT;
  const bool plain = query.tiling == VK_IMAGE_TILING_OPTIMAL && query.type == VK_IMAGE_TYPE_2D &&
                     !(query.flags & VK_IMAGE_CREATE_CUBE_COMPATIBLE_BIT);
  return plain && (features & kAttachment) ? kSampleCounts : 1;
}

}  // namespace

VkFormatProperties format_properties(VkFormat format) {
  const FormatInfo* info = find_format(format);
  if (!info) return {};
  VkFormatProperties properties{};
  properties.linearTilingFeatures = image_features(*info, VK_IMAGE_TILING_LINEAR);
  properties.optimalTilingFeatures = image_features(*info, VK_IMAGE_TILING_OPTIMAL);
  if (info->uses & kUseUniformTexel) properties.bufferFeatures |= VK_FORMAT_FEATURE_UNIFORM_TEXEL_BUFFER_BIT;
  if (info->uses & kUseStorageTexel) properties.bufferFeatures |= VK_FORMAT_FEATURE_STORAGE_TEXEL_BUFFER_BIT;
  if ((info->uses & kUseStorageTexel) && (info->uses & kUseStorageAtomic))
    properties.bufferFeatures |= VK_FORMAT_FEATURE_STORAGE_TEXEL_BUFFER_ATOMIC_BIT;
  if (info->uses & kUseVertex) properties.bufferFeatures |= VK_FORMAT_FEATURE_VERTEX_BUFFER_BIT;
  return properties;
}

VkResult image_format_properties(const ImageQuery& asked, VkImageFormatProperties* out) {
  *out = {};
  ImageQuery query = asked;
  query.usage = known_usage(asked.usage | asked.stencil_usage);  // features are those of both aspects
  const FormatInfo* info = find_format(query.format);
  if (!info) return VK_ERROR_FORMAT_NOT_SUPPORTED;
  if (query.tiling != VK_IMAGE_TILING_LINEAR && query.tiling != VK_IMAGE_TILING_OPTIMAL) return VK_ERROR_FORMAT_NOT_SUPPORTED;
  constexpr VkImageCreateFlags kFlags = VK_IMAGE_CREATE_CUBE_COMPATIBLE_BIT | VK_IMAGE_CREATE_MUTABLE_FORMAT_BIT |
                                        VK_IMAGE_CREATE_BLOCK_TEXEL_VIEW_COMPATIBLE_BIT |
                                        VK_IMAGE_CREATE_2D_ARRAY_COMPATIBLE_BIT | VK_IMAGE_CREATE_2D_VIEW_COMPATIBLE_BIT_EXT |
                                        VK_IMAGE_CREATE_EXTENDED_USAGE_BIT | VK_IMAGE_CREATE_ALIAS_BIT;
  if (query.flags & ~kFlags) return VK_ERROR_FORMAT_NOT_SUPPORTED;
  const bool cube = (query.flags & VK_IMAGE_CREATE_CUBE_COMPATIBLE_BIT) != 0;
  if (cube && query.type != VK_IMAGE_TYPE_2D) return VK_ERROR_FORMAT_NOT_SUPPORTED;
  VkFormatFeatureFlags features = image_features(*info, query.tiling);
  constexpr VkImageCreateFlags kExtended = VK_IMAGE_CREATE_MUTABLE_FORMAT_BIT | VK_IMAGE_CREATE_EXTENDED_USAGE_BIT;
  if (features && (query.flags & kExtended) == kExtended) features |= class_features(*info, query.tiling);
  if (features == 0 || !usage_allowed(query.usage, features)) return VK_ERROR_FORMAT_NOT_SUPPORTED;
  // Slices of volumes are colour attachments only.
  constexpr VkImageUsageFlags kVolumeUsage =
      kTransferUsage | VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_STORAGE_BIT | VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT;
  if (query.type == VK_IMAGE_TYPE_3D && (query.usage & ~kVolumeUsage)) return VK_ERROR_FORMAT_NOT_SUPPORTED;
  out->maxExtent = max_extent(query);
  out->maxMipLevels = std::bit_width(out->maxExtent.width);
  out->maxArrayLayers = query.type == VK_IMAGE_TYPE_3D ? 1 : kLimits.maxImageArrayLayers;
  out->sampleCounts = sample_counts(query, features);
  out->maxResourceSize = kMaxImageBytes;
  return VK_SUCCESS;
}

}  // namespace pineda::icd
