// info.*: what a device must report: limits at least as large as the specification's table, mandatory features of formats,
// rules for memory types, queue families and names.
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <functional>

#include "cts-subset/groups/groups.h"
#include "cts-subset/harness/case.h"
#include "cts-subset/harness/device.h"

namespace pineda::cts {
namespace {

// "Required Limits", Vulkan 1.0 core: what holds without any optional feature.
struct Limit {
  const char* name;
  double (*value)(const VkPhysicalDeviceLimits&);
  double bound;
  bool at_most = false;
};
#define PINEDA_CTS_LIMIT(member, ...)                                                                   \
  {                                                                                                     \
#member, [](const VkPhysicalDeviceLimits& l) { return static_cast<double>(l.member); }, __VA_ARGS__ \
  }
constexpr Limit kLimits[] = {
    PINEDA_CTS_LIMIT(maxImageDimension1D, 4096),
    PINEDA_CTS_LIMIT(maxImageDimension2D, 4096),
    PINEDA_CTS_LIMIT(maxImageDimension3D, 256),
    PINEDA_CTS_LIMIT(maxImageDimensionCube, 4096),
    PINEDA_CTS_LIMIT(maxImageArrayLayers, 256),
    PINEDA_CTS_LIMIT(maxTexelBufferElements, 65536),
    PINEDA_CTS_LIMIT(maxUniformBufferRange, 16384),
    PINEDA_CTS_LIMIT(maxStorageBufferRange, 134217728),
    PINEDA_CTS_LIMIT(maxPushConstantsSize, 128),
    PINEDA_CTS_LIMIT(maxMemoryAllocationCount, 4096),
    PINEDA_CTS_LIMIT(maxSamplerAllocationCount, 4000),
    PINEDA_CTS_LIMIT(bufferImageGranularity, 131072, true),
    PINEDA_CTS_LIMIT(maxBoundDescriptorSets, 4),
    PINEDA_CTS_LIMIT(maxPerStageDescriptorSamplers, 16),
    PINEDA_CTS_LIMIT(maxPerStageDescriptorUniformBuffers, 12),
    PINEDA_CTS_LIMIT(maxPerStageDescriptorStorageBuffers, 4),
    PINEDA_CTS_LIMIT(maxPerStageDescriptorSampledImages, 16),
    PINEDA_CTS_LIMIT(maxPerStageDescriptorStorageImages, 4),
    PINEDA_CTS_LIMIT(maxPerStageDescriptorInputAttachments, 4),
    PINEDA_CTS_LIMIT(maxPerStageResources, 44),  // 128, or the sum of the stage limits and 4 colour attachments
    PINEDA_CTS_LIMIT(maxDescriptorSetSamplers, 96),
    PINEDA_CTS_LIMIT(maxDescriptorSetUniformBuffers, 72),
    PINEDA_CTS_LIMIT(maxDescriptorSetUniformBuffersDynamic, 8),
    PINEDA_CTS_LIMIT(maxDescriptorSetStorageBuffers, 24),
    PINEDA_CTS_LIMIT(maxDescriptorSetStorageBuffersDynamic, 4),
    PINEDA_CTS_LIMIT(maxDescriptorSetSampledImages, 96),
    PINEDA_CTS_LIMIT(maxDescriptorSetStorageImages, 24),
    PINEDA_CTS_LIMIT(maxDescriptorSetInputAttachments, 4),
    PINEDA_CTS_LIMIT(maxVertexInputAttributes, 16),
    PINEDA_CTS_LIMIT(maxVertexInputBindings, 16),
    PINEDA_CTS_LIMIT(maxVertexInputAttributeOffset, 2047),
    PINEDA_CTS_LIMIT(maxVertexInputBindingStride, 2048),
    PINEDA_CTS_LIMIT(maxVertexOutputComponents, 64),
    PINEDA_CTS_LIMIT(maxFragmentInputComponents, 64),
    PINEDA_CTS_LIMIT(maxFragmentOutputAttachments, 4),
    PINEDA_CTS_LIMIT(maxFragmentCombinedOutputResources, 4),
    PINEDA_CTS_LIMIT(maxComputeSharedMemorySize, 16384),
    PINEDA_CTS_LIMIT(maxComputeWorkGroupCount[0], 65535),
    PINEDA_CTS_LIMIT(maxComputeWorkGroupCount[1], 65535),
    PINEDA_CTS_LIMIT(maxComputeWorkGroupCount[2], 65535),
    PINEDA_CTS_LIMIT(maxComputeWorkGroupInvocations, 128),
    PINEDA_CTS_LIMIT(maxComputeWorkGroupSize[0], 128),
    PINEDA_CTS_LIMIT(maxComputeWorkGroupSize[1], 128),
    PINEDA_CTS_LIMIT(maxComputeWorkGroupSize[2], 64),
    PINEDA_CTS_LIMIT(subPixelPrecisionBits, 4),
    PINEDA_CTS_LIMIT(subTexelPrecisionBits, 4),
    PINEDA_CTS_LIMIT(mipmapPrecisionBits, 4),
    PINEDA_CTS_LIMIT(maxDrawIndexedIndexValue, 16777215),
    PINEDA_CTS_LIMIT(maxDrawIndirectCount, 1),
    PINEDA_CTS_LIMIT(maxSamplerLodBias, 2),
    PINEDA_CTS_LIMIT(maxSamplerAnisotropy, 1),
    PINEDA_CTS_LIMIT(maxViewports, 1),
    PINEDA_CTS_LIMIT(maxViewportDimensions[0], 4096),
    PINEDA_CTS_LIMIT(maxViewportDimensions[1], 4096),
    PINEDA_CTS_LIMIT(viewportBoundsRange[0], -8192, true),
    PINEDA_CTS_LIMIT(viewportBoundsRange[1], 8191),
    PINEDA_CTS_LIMIT(minMemoryMapAlignment, 64),
    PINEDA_CTS_LIMIT(minTexelBufferOffsetAlignment, 256, true),
    PINEDA_CTS_LIMIT(minUniformBufferOffsetAlignment, 256, true),
    PINEDA_CTS_LIMIT(minStorageBufferOffsetAlignment, 256, true),
    PINEDA_CTS_LIMIT(minTexelOffset, -8, true),
    PINEDA_CTS_LIMIT(maxTexelOffset, 7),
    PINEDA_CTS_LIMIT(maxFramebufferWidth, 4096),
    PINEDA_CTS_LIMIT(maxFramebufferHeight, 4096),
    PINEDA_CTS_LIMIT(maxFramebufferLayers, 256),
    PINEDA_CTS_LIMIT(maxColorAttachments, 4),
    PINEDA_CTS_LIMIT(maxSampleMaskWords, 1),
    PINEDA_CTS_LIMIT(discreteQueuePriorities, 2),
    PINEDA_CTS_LIMIT(nonCoherentAtomSize, 256, true),
};
// What a feature raises.
struct FeatureLimit {
  Limit limit;
  VkBool32 VkPhysicalDeviceFeatures::*feature;
};
const FeatureLimit kFeatureLimits[] = {
    {PINEDA_CTS_LIMIT(maxDrawIndexedIndexValue, 4294967295.0), &VkPhysicalDeviceFeatures::fullDrawIndexUint32},
    {PINEDA_CTS_LIMIT(maxDrawIndirectCount, 65535), &VkPhysicalDeviceFeatures::multiDrawIndirect},
    {PINEDA_CTS_LIMIT(maxSamplerAnisotropy, 16), &VkPhysicalDeviceFeatures::samplerAnisotropy},
    {PINEDA_CTS_LIMIT(maxViewports, 16), &VkPhysicalDeviceFeatures::multiViewport},
    {PINEDA_CTS_LIMIT(maxClipDistances, 8), &VkPhysicalDeviceFeatures::shaderClipDistance},
    {PINEDA_CTS_LIMIT(maxCullDistances, 8), &VkPhysicalDeviceFeatures::shaderCullDistance},
    {PINEDA_CTS_LIMIT(maxFragmentDualSrcAttachments, 1), &VkPhysicalDeviceFeatures::dualSrcBlend},
    {PINEDA_CTS_LIMIT(minTexelGatherOffset, -8, true), &VkPhysicalDeviceFeatures::shaderImageGatherExtended},
    {PINEDA_CTS_LIMIT(maxTexelGatherOffset, 7), &VkPhysicalDeviceFeatures::shaderImageGatherExtended},
    {PINEDA_CTS_LIMIT(minInterpolationOffset, -0.5, true), &VkPhysicalDeviceFeatures::sampleRateShading},
    {PINEDA_CTS_LIMIT(maxInterpolationOffset, 0.4375), &VkPhysicalDeviceFeatures::sampleRateShading},
    {PINEDA_CTS_LIMIT(subPixelInterpolationOffsetBits, 4), &VkPhysicalDeviceFeatures::sampleRateShading},
    {PINEDA_CTS_LIMIT(pointSizeRange[1], 63), &VkPhysicalDeviceFeatures::largePoints},
    {PINEDA_CTS_LIMIT(lineWidthRange[1], 7), &VkPhysicalDeviceFeatures::wideLines},
};
#undef PINEDA_CTS_LIMIT

void check_limit(const Device& device, const Limit& limit) {
  const double value = limit.value(device.limits());
  expect(limit.at_most ? value <= limit.bound : value >= limit.bound,
         fmt::format("{} is {}, {} {} is required", limit.name, value, limit.at_most ? "at most" : "at least", limit.bound));
}

struct SampleCounts {
  const char* name;
  VkSampleCountFlags VkPhysicalDeviceLimits::*counts;
};
constexpr SampleCounts kSampleCounts[] = {
    {"framebufferColorSampleCounts", &VkPhysicalDeviceLimits::framebufferColorSampleCounts},
    {"framebufferDepthSampleCounts", &VkPhysicalDeviceLimits::framebufferDepthSampleCounts},
    {"framebufferStencilSampleCounts", &VkPhysicalDeviceLimits::framebufferStencilSampleCounts},
    {"framebufferNoAttachmentsSampleCounts", &VkPhysicalDeviceLimits::framebufferNoAttachmentsSampleCounts},
    {"sampledImageColorSampleCounts", &VkPhysicalDeviceLimits::sampledImageColorSampleCounts},
    {"sampledImageDepthSampleCounts", &VkPhysicalDeviceLimits::sampledImageDepthSampleCounts},
    {"sampledImageStencilSampleCounts", &VkPhysicalDeviceLimits::sampledImageStencilSampleCounts},
};

// "Required Format Support", optimal tiling and buffers, without the block-compressed families (one of which is required).
constexpr VkFormatFeatureFlags kTexture = VK_FORMAT_FEATURE_SAMPLED_IMAGE_BIT | VK_FORMAT_FEATURE_BLIT_SRC_BIT;
constexpr VkFormatFeatureFlags kLinear = kTexture | VK_FORMAT_FEATURE_SAMPLED_IMAGE_FILTER_LINEAR_BIT;
constexpr VkFormatFeatureFlags kColour = VK_FORMAT_FEATURE_COLOR_ATTACHMENT_BIT | VK_FORMAT_FEATURE_BLIT_DST_BIT;
constexpr VkFormatFeatureFlags kBlend = kColour | VK_FORMAT_FEATURE_COLOR_ATTACHMENT_BLEND_BIT;
constexpr VkFormatFeatureFlags kStorage = VK_FORMAT_FEATURE_STORAGE_IMAGE_BIT;
constexpr VkFormatFeatureFlags kAtomic = VK_FORMAT_FEATURE_STORAGE_IMAGE_ATOMIC_BIT;
constexpr VkFormatFeatureFlags kVertex = VK_FORMAT_FEATURE_VERTEX_BUFFER_BIT;
constexpr VkFormatFeatureFlags kUniformTexel = VK_FORMAT_FEATURE_UNIFORM_TEXEL_BUFFER_BIT;
constexpr VkFormatFeatureFlags kStorageTexel = VK_FORMAT_FEATURE_STORAGE_TEXEL_BUFFER_BIT;
constexpr VkFormatFeatureFlags kTexelAtomic = VK_FORMAT_FEATURE_STORAGE_TEXEL_BUFFER_ATOMIC_BIT;
struct FormatRule {
  VkFormat format;
  const char* name;
  VkFormatFeatureFlags image, buffer;
};
constexpr FormatRule kFormatRules[] = {
    {VK_FORMAT_B4G4R4A4_UNORM_PACK16, "B4G4R4A4_UNORM_PACK16", kLinear, 0},
    {VK_FORMAT_R5G6B5_UNORM_PACK16, "R5G6B5_UNORM_PACK16", kLinear | kBlend, 0},
    {VK_FORMAT_A1R5G5B5_UNORM_PACK16, "A1R5G5B5_UNORM_PACK16", kLinear | kBlend, 0},
    {VK_FORMAT_R8_UNORM, "R8_UNORM", kLinear | kBlend, kVertex | kUniformTexel},
    {VK_FORMAT_R8_SNORM, "R8_SNORM", kLinear, kVertex | kUniformTexel},
    {VK_FORMAT_R8_UINT, "R8_UINT", kTexture | kColour, kVertex | kUniformTexel},
    {VK_FORMAT_R8_SINT, "R8_SINT", kTexture | kColour, kVertex | kUniformTexel},
    {VK_FORMAT_R8G8_UNORM, "R8G8_UNORM", kLinear | kBlend, kVertex | kUniformTexel},
    {VK_FORMAT_R8G8_SNORM, "R8G8_SNORM", kLinear, kVertex | kUniformTexel},
    {VK_FORMAT_R8G8_UINT, "R8G8_UINT", kTexture | kColour, kVertex | kUniformTexel},
    {VK_FORMAT_R8G8_SINT, "R8G8_SINT", kTexture | kColour, kVertex | kUniformTexel},
    {VK_FORMAT_R8G8B8A8_UNORM, "R8G8B8A8_UNORM", kLinear | kBlend | kStorage, kVertex | kUniformTexel | kStorageTexel},
    {VK_FORMAT_R8G8B8A8_SNORM, "R8G8B8A8_SNORM", kLinear | kStorage, kVertex | kUniformTexel | kStorageTexel},
    {VK_FORMAT_R8G8B8A8_UINT, "R8G8B8A8_UINT", kTexture | kColour | kStorage, kVertex | kUniformTexel | kStorageTexel},
    {VK_FORMAT_R8G8B8A8_SINT, "R8G8B8A8_SINT", kTexture | kColour | kStorage, kVertex | kUniformTexel | kStorageTexel},
    {VK_FORMAT_R8G8B8A8_SRGB, "R8G8B8A8_SRGB", kLinear | kBlend, 0},
    {VK_FORMAT_B8G8R8A8_UNORM, "B8G8R8A8_UNORM", kLinear | kBlend, kVertex | kUniformTexel},
    {VK_FORMAT_B8G8R8A8_SRGB, "B8G8R8A8_SRGB", kLinear | kBlend, 0},
    {VK_FORMAT_A8B8G8R8_UNORM_PACK32, "A8B8G8R8_UNORM_PACK32", kLinear | kBlend, kVertex | kUniformTexel | kStorageTexel},
    {VK_FORMAT_A8B8G8R8_SNORM_PACK32, "A8B8G8R8_SNORM_PACK32", kLinear, kVertex | kUniformTexel | kStorageTexel},
    {VK_FORMAT_A8B8G8R8_UINT_PACK32, "A8B8G8R8_UINT_PACK32", kTexture | kColour, kVertex | kUniformTexel | kStorageTexel},
    {VK_FORMAT_A8B8G8R8_SINT_PACK32, "A8B8G8R8_SINT_PACK32", kTexture | kColour, kVertex | kUniformTexel | kStorageTexel},
    {VK_FORMAT_A8B8G8R8_SRGB_PACK32, "A8B8G8R8_SRGB_PACK32", kLinear | kBlend, 0},
    {VK_FORMAT_A2B10G10R10_UNORM_PACK32, "A2B10G10R10_UNORM_PACK32", kLinear | kBlend, kVertex | kUniformTexel},
    {VK_FORMAT_A2B10G10R10_UINT_PACK32, "A2B10G10R10_UINT_PACK32", kTexture | kColour, kUniformTexel},
    {VK_FORMAT_R16_UINT, "R16_UINT", kTexture | kColour, kVertex | kUniformTexel},
    {VK_FORMAT_R16_SINT, "R16_SINT", kTexture | kColour, kVertex | kUniformTexel},
    {VK_FORMAT_R16_SFLOAT, "R16_SFLOAT", kLinear | kBlend, kVertex | kUniformTexel},
    {VK_FORMAT_R16_UNORM, "R16_UNORM", 0, kVertex},
    {VK_FORMAT_R16_SNORM, "R16_SNORM", 0, kVertex},
    {VK_FORMAT_R16G16_UNORM, "R16G16_UNORM", 0, kVertex},
    {VK_FORMAT_R16G16_SNORM, "R16G16_SNORM", 0, kVertex},
    {VK_FORMAT_R16G16_UINT, "R16G16_UINT", kTexture | kColour, kVertex | kUniformTexel},
    {VK_FORMAT_R16G16_SINT, "R16G16_SINT", kTexture | kColour, kVertex | kUniformTexel},
    {VK_FORMAT_R16G16_SFLOAT, "R16G16_SFLOAT", kLinear | kBlend, kVertex | kUniformTexel},
    {VK_FORMAT_R16G16B16A16_UNORM, "R16G16B16A16_UNORM", 0, kVertex},
    {VK_FORMAT_R16G16B16A16_SNORM, "R16G16B16A16_SNORM", 0, kVertex},
    {VK_FORMAT_R16G16B16A16_UINT, "R16G16B16A16_UINT", kTexture | kColour | kStorage, kVertex | kUniformTexel | kStorageTexel},
    {VK_FORMAT_R16G16B16A16_SINT, "R16G16B16A16_SINT", kTexture | kColour | kStorage, kVertex | kUniformTexel | kStorageTexel},
    {VK_FORMAT_R16G16B16A16_SFLOAT, "R16G16B16A16_SFLOAT", kLinear | kBlend | kStorage, kVertex | kUniformTexel | kStorageTexel},
    {VK_FORMAT_R32_UINT, "R32_UINT", kTexture | kColour | kStorage | kAtomic,
     kVertex | kUniformTexel | kStorageTexel | kTexelAtomic},
    {VK_FORMAT_R32_SINT, "R32_SINT", kTexture | kColour | kStorage | kAtomic,
     kVertex | kUniformTexel | kStorageTexel | kTexelAtomic},
    {VK_FORMAT_R32_SFLOAT, "R32_SFLOAT", kTexture | kColour | kStorage, kVertex | kUniformTexel | kStorageTexel},
    {VK_FORMAT_R32G32_UINT, "R32G32_UINT", kTexture | kColour | kStorage, kVertex | kUniformTexel | kStorageTexel},
    {VK_FORMAT_R32G32_SINT, "R32G32_SINT", kTexture | kColour | kStorage, kVertex | kUniformTexel | kStorageTexel},
    {VK_FORMAT_R32G32_SFLOAT, "R32G32_SFLOAT", kTexture | kColour | kStorage, kVertex | kUniformTexel | kStorageTexel},
    {VK_FORMAT_R32G32B32_UINT, "R32G32B32_UINT", 0, kVertex},
    {VK_FORMAT_R32G32B32_SINT, "R32G32B32_SINT", 0, kVertex},
    {VK_FORMAT_R32G32B32_SFLOAT, "R32G32B32_SFLOAT", 0, kVertex},
    {VK_FORMAT_R32G32B32A32_UINT, "R32G32B32A32_UINT", kTexture | kColour | kStorage, kVertex | kUniformTexel | kStorageTexel},
    {VK_FORMAT_R32G32B32A32_SINT, "R32G32B32A32_SINT", kTexture | kColour | kStorage, kVertex | kUniformTexel | kStorageTexel},
    {VK_FORMAT_R32G32B32A32_SFLOAT, "R32G32B32A32_SFLOAT", kTexture | kColour | kStorage,
     kVertex | kUniformTexel | kStorageTexel},
    {VK_FORMAT_B10G11R11_UFLOAT_PACK32, "B10G11R11_UFLOAT_PACK32", kLinear, kUniformTexel},
    {VK_FORMAT_E5B9G9R9_UFLOAT_PACK32, "E5B9G9R9_UFLOAT_PACK32", kLinear, 0},
    {VK_FORMAT_D16_UNORM, "D16_UNORM", kTexture | VK_FORMAT_FEATURE_DEPTH_STENCIL_ATTACHMENT_BIT, 0},
    {VK_FORMAT_D32_SFLOAT, "D32_SFLOAT", kTexture, 0},
};

void check_format(const Device& device, const FormatRule& rule) {
  const VkFormatProperties got = device.format(rule.format);
  expect((got.optimalTilingFeatures & rule.image) == rule.image,
         fmt::format("optimal tiling lacks {:#x}", rule.image & ~got.optimalTilingFeatures));
  expect((got.bufferFeatures & rule.buffer) == rule.buffer, fmt::format("buffers lack {:#x}", rule.buffer & ~got.bufferFeatures));
}

// Whatever a format claims, an image that uses it must be possible, with the limits of every format.
void check_image_format(const Device& device, VkFormat format, VkImageType type) {
  const VkFormatFeatureFlags features = device.format(format).optimalTilingFeatures;
  require(features & VK_FORMAT_FEATURE_SAMPLED_IMAGE_BIT, "sampling this format");
  const bool depth = device.format(format).optimalTilingFeatures & VK_FORMAT_FEATURE_DEPTH_STENCIL_ATTACHMENT_BIT;
  VkImageFormatProperties got{};
  const VkResult result = vkGetPhysicalDeviceImageFormatProperties(device.physical(), format, type, VK_IMAGE_TILING_OPTIMAL,
                                                                   VK_IMAGE_USAGE_SAMPLED_BIT, 0, &got);
  require(!(depth && result == VK_ERROR_FORMAT_NOT_SUPPORTED && type != VK_IMAGE_TYPE_2D), "depth images of this type");
  check(result, "vkGetPhysicalDeviceImageFormatProperties");
  const VkPhysicalDeviceLimits& limits = device.limits();
  const uint32_t edge = type == VK_IMAGE_TYPE_1D   ? limits.maxImageDimension1D
                        : type == VK_IMAGE_TYPE_2D ? limits.maxImageDimension2D
                                                   : limits.maxImageDimension3D;
  expect(got.maxExtent.width >= edge, "maxExtent.width is below the device's limit");
  expect(type == VK_IMAGE_TYPE_1D ? got.maxExtent.height == 1 : got.maxExtent.height >= edge, "maxExtent.height");
  expect(type == VK_IMAGE_TYPE_3D ? got.maxExtent.depth >= edge : got.maxExtent.depth == 1, "maxExtent.depth");
  expect(got.maxMipLevels == 1u + static_cast<uint32_t>(std::bit_width(std::max(got.maxExtent.width, got.maxExtent.height)) - 1),
         fmt::format("maxMipLevels is {}", got.maxMipLevels));
  expect(type == VK_IMAGE_TYPE_3D ? got.maxArrayLayers == 1 : got.maxArrayLayers >= limits.maxImageArrayLayers, "maxArrayLayers");
  expect(got.sampleCounts & VK_SAMPLE_COUNT_1_BIT, "sampleCounts lacks 1");
  expect(got.maxResourceSize >= VkDeviceSize{1} << 31, "maxResourceSize is below 2^31");
}

void check_names(Device& device) {
  const VkPhysicalDeviceProperties& properties = device.caps().properties;
  expect(std::memchr(properties.deviceName, 0, sizeof(properties.deviceName)) && properties.deviceName[0], "deviceName");
  expect(VK_API_VERSION_MAJOR(properties.apiVersion) == 1, "apiVersion's major number is not 1");
  expect(std::ranges::any_of(properties.pipelineCacheUUID, [](uint8_t byte) { return byte != 0; }), "pipelineCacheUUID is zero");
}

void check_features(Device& device) {
  const VkPhysicalDeviceFeatures& features = device.caps().features;
  expect(features.robustBufferAccess, "robustBufferAccess is required");
  expect(features.textureCompressionBC || features.textureCompressionETC2 || features.textureCompressionASTC_LDR,
         "one of the block-compressed families is required");
}

// "Device Memory": a coherent host-visible type and a device-local one; types in the order that the search by flags needs.
void check_memory_types(Device& device) {
  const VkPhysicalDeviceMemoryProperties& memory = device.caps().memory;
  bool coherent = false, local = false;
  for (uint32_t i = 0; i < memory.memoryTypeCount; ++i) {
    const VkMemoryPropertyFlags flags = memory.memoryTypes[i].propertyFlags;
    expect(memory.memoryTypes[i].heapIndex < memory.memoryHeapCount, fmt::format("type {} names no heap", i));
    constexpr VkMemoryPropertyFlags kBoth = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    coherent |= (flags & kBoth) == kBoth;
    local |= (flags & VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT) != 0;
    expect(!(flags & VK_MEMORY_PROPERTY_LAZILY_ALLOCATED_BIT) || !(flags & VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT),
           fmt::format("type {} is lazily allocated and host-visible", i));
    for (uint32_t j = 0; j < i; ++j) {
      const VkMemoryPropertyFlags before = memory.memoryTypes[j].propertyFlags;
      const bool superset = (before & flags) == flags && before != flags;
      expect(!superset, fmt::format("type {} has a strict subset of type {}'s properties and comes later", i, j));
    }
  }
  expect(coherent && local, "no host-visible coherent type, or no device-local one");
}

void check_heaps(Device& device) {
  const VkPhysicalDeviceMemoryProperties& memory = device.caps().memory;
  bool local = false;
  for (uint32_t i = 0; i < memory.memoryHeapCount; ++i) {
    expect(memory.memoryHeaps[i].size > 0, fmt::format("heap {} is empty", i));
    local |= (memory.memoryHeaps[i].flags & VK_MEMORY_HEAP_DEVICE_LOCAL_BIT) != 0;
  }
  expect(local, "no device-local heap");
}

void check_queue_families(Device& device) {
  bool any = false;
  for (const VkQueueFamilyProperties& family : device.caps().queue_families) {
    expect(family.queueCount > 0, "a family without queues");
    any |= (family.queueFlags & (VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT)) == (VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT);
    expect(family.timestampValidBits == 0 || (family.timestampValidBits >= 36 && family.timestampValidBits <= 64),
           "timestampValidBits is neither 0 nor 36 to 64");
    if (family.queueFlags & (VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT)) {
      const VkExtent3D& granularity = family.minImageTransferGranularity;
      expect(granularity.width == 1 && granularity.height == 1 && granularity.depth == 1, "transfer granularity is not a texel");
    }
  }
  expect(any, "a device with a graphics family needs one with graphics and compute");
}

// Enumerations with too small an array say VK_INCOMPLETE and write no more than was asked for.
void check_incomplete(Device& device) {
  uint32_t count = 0;
  vkEnumerateDeviceExtensionProperties(device.physical(), nullptr, &count, nullptr);
  require(count > 1, "two extensions");
  std::vector<VkExtensionProperties> extensions(count);
  uint32_t fewer = 1;
  const VkResult result = vkEnumerateDeviceExtensionProperties(device.physical(), nullptr, &fewer, extensions.data());
  expect(result == VK_INCOMPLETE && fewer == 1, fmt::format("result {}, count {}", static_cast<int>(result), fewer));
  expect(extensions[1].extensionName[0] == 0, "wrote past the count");
}

}  // namespace

void register_info() {
  for (const Limit& limit : kLimits) {
    add_case("info.limits", limit.name, "42.1 Required Limits", [&limit](Device& device) { check_limit(device, limit); });
  }
  for (const FeatureLimit& row : kFeatureLimits) {
    add_case("info.limits", fmt::format("{}_with_its_feature", row.limit.name), "42.1 Required Limits", [&row](Device& device) {
      require(device.caps().features.*row.feature, "the feature");
      check_limit(device, row.limit);
    });
  }
  for (const SampleCounts& row : kSampleCounts) {
    add_case("info.limits", row.name, "42.1 Required Limits", [&row](Device& device) {
      constexpr VkSampleCountFlags kWanted = VK_SAMPLE_COUNT_1_BIT | VK_SAMPLE_COUNT_4_BIT;
      expect((device.limits().*row.counts & kWanted) == kWanted, "1 and 4 samples are required");
    });
  }
  static constexpr std::pair<VkImageType, const char*> kTypes[] = {
      {VK_IMAGE_TYPE_1D, "1d"}, {VK_IMAGE_TYPE_2D, "2d"}, {VK_IMAGE_TYPE_3D, "3d"}};
  for (const FormatRule& rule : kFormatRules) {
    add_case("info.formats", rule.name, "43.3 Required Format Support", [&rule](Device& device) { check_format(device, rule); });
    for (const auto& [type, name] : kTypes) {
      add_case("info.image_formats", fmt::format("{}_{}", rule.name, name), "43.2 Additional Image Capabilities",
               [&rule, type](Device& device) { check_image_format(device, rule.format, type); });
    }
  }
  add_case("info.device", "names_and_versions", "5.1 Physical Devices", check_names);
  add_case("info.device", "required_features", "41.1 Feature Requirements", check_features);
  add_case("info.device", "memory_types", "11.2.1 Device Memory Properties", check_memory_types);
  add_case("info.device", "memory_heaps", "11.2.1 Device Memory Properties", check_heaps);
  add_case("info.device", "queue_families", "5.1 Physical Devices", check_queue_families);
  add_case("info.device", "incomplete_enumeration", "3.7.3 Retrieving Results", check_incomplete);
}

}  // namespace pineda::cts
