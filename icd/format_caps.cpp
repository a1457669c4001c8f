#include "icd/format_caps.h"

#include <bit>

#include "base/format.h"
#include "icd/limits.h"

namespace pineda::icd {
namespace {

// A resource is addressed by 32-bit byte offsets (MipLevel in base/abi.h).
constexpr VkDeviceSize kMaxImageBytes = 0xFFFFFFFFu;

// What a shader can declare for a storage image under the Shader capability alone ("Image Format" in the SPIR-V specification);
// kernels pack and unpack every format of the table.
bool is_storage_format(VkFormat format) {
  switch (format) {
    case VK_FORMAT_R8G8B8A8_UNORM:
    case VK_FORMAT_R8G8B8A8_SNORM:
    case VK_FORMAT_R8G8B8A8_UINT:
    case VK_FORMAT_R8G8B8A8_SINT:
    case VK_FORMAT_R16G16B16A16_UINT:
    case VK_FORMAT_R16G16B16A16_SINT:
    case VK_FORMAT_R16G16B16A16_SFLOAT:
    case VK_FORMAT_R32_UINT:
    case VK_FORMAT_R32_SINT:
    case VK_FORMAT_R32_SFLOAT:
    case VK_FORMAT_R32G32B32A32_UINT:
    case VK_FORMAT_R32G32B32A32_SINT:
    case VK_FORMAT_R32G32B32A32_SFLOAT:
      return true;
    default:
      return false;
  }
}

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
  if (is_storage_format(format.format)) features |= VK_FORMAT_FEATURE_STORAGE_IMAGE_BIT;
  if (features == 0) return 0;
  // exec_blit.cpp reads and writes every colour texel through the table, and copies depth texels.
  return features | VK_FORMAT_FEATURE_BLIT_SRC_BIT | VK_FORMAT_FEATURE_BLIT_DST_BIT | VK_FORMAT_FEATURE_TRANSFER_SRC_BIT |
         VK_FORMAT_FEATURE_TRANSFER_DST_BIT;
}

constexpr VkImageUsageFlags kTransferUsage = VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT;

// Without VK_IMAGE_USAGE_INPUT_ATTACHMENT_BIT: vkCreateRenderPass refuses input attachments.
bool usage_allowed(VkImageUsageFlags usage, VkFormatFeatureFlags features) {
  static constexpr struct {
    VkFormatFeatureFlags feature;
    VkImageUsageFlags usage;
  } kRows[] = {
      {VK_FORMAT_FEATURE_SAMPLED_IMAGE_BIT, VK_IMAGE_USAGE_SAMPLED_BIT},
      {VK_FORMAT_FEATURE_STORAGE_IMAGE_BIT, VK_IMAGE_USAGE_STORAGE_BIT},
      {VK_FORMAT_FEATURE_COLOR_ATTACHMENT_BIT, VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSIENT_ATTACHMENT_BIT},
      {VK_FORMAT_FEATURE_DEPTH_STENCIL_ATTACHMENT_BIT,
       VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSIENT_ATTACHMENT_BIT},
  };
  VkImageUsageFlags allowed = kTransferUsage;
  for (const auto& row : kRows) {
    if (features & row.feature) allowed |= row.usage;
  }
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
  if (info->is_plain() && !info->is_depth() && (info->uses & kUseSampled)) {
    properties.bufferFeatures |= VK_FORMAT_FEATURE_UNIFORM_TEXEL_BUFFER_BIT;
    if (is_storage_format(format)) properties.bufferFeatures |= VK_FORMAT_FEATURE_STORAGE_TEXEL_BUFFER_BIT;
  }
  if (info->uses & kUseVertex) properties.bufferFeatures |= VK_FORMAT_FEATURE_VERTEX_BUFFER_BIT;
  return properties;
}

VkResult image_format_properties(const ImageQuery& query, VkImageFormatProperties* out) {
  *out = {};
  const FormatInfo* info = find_format(query.format);
  if (!info) return VK_ERROR_FORMAT_NOT_SUPPORTED;
  if (query.tiling != VK_IMAGE_TILING_LINEAR && query.tiling != VK_IMAGE_TILING_OPTIMAL) return VK_ERROR_FORMAT_NOT_SUPPORTED;
  constexpr VkImageCreateFlags kFlags = VK_IMAGE_CREATE_CUBE_COMPATIBLE_BIT | VK_IMAGE_CREATE_MUTABLE_FORMAT_BIT | VK_IMAGE_CREATE_2D_ARRAY_COMPATIBLE_BIT |
                                        VK_IMAGE_CREATE_EXTENDED_USAGE_BIT | VK_IMAGE_CREATE_ALIAS_BIT;
  if (query.flags & ~kFlags) return VK_ERROR_FORMAT_NOT_SUPPORTED;
  const bool cube = (query.flags & VK_IMAGE_CREATE_CUBE_COMPATIBLE_BIT) != 0;
  if (cube && query.type != VK_IMAGE_TYPE_2D) return VK_ERROR_FORMAT_NOT_SUPPORTED;
  const VkFormatFeatureFlags features = image_features(*info);
  if (features == 0 || !usage_allowed(query.usage, features)) return VK_ERROR_FORMAT_NOT_SUPPORTED;
  // Volumes are stored, copied and sampled.
  constexpr VkImageUsageFlags kVolumeUsage = kTransferUsage | VK_IMAGE_USAGE_SAMPLED_BIT;
  if (query.type == VK_IMAGE_TYPE_3D && (query.usage & ~kVolumeUsage)) return VK_ERROR_FORMAT_NOT_SUPPORTED;
  out->maxExtent = max_extent(query);
  out->maxMipLevels = std::bit_width(out->maxExtent.width);
  out->maxArrayLayers = query.type == VK_IMAGE_TYPE_3D ? 1 : kLimits.maxImageArrayLayers;
  out->sampleCounts = VK_SAMPLE_COUNT_1_BIT;
  out->maxResourceSize = kMaxImageBytes;
  return VK_SUCCESS;
}

}  // namespace pineda::icd
