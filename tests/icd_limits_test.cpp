// What the driver says of itself: the specification's required limits and features, and who it is.
#include <algorithm>
#include <cstdlib>
#include <string>

#include "icd_client.h"
#include "tests/process.h"

namespace pineda::test {
namespace {

VkPhysicalDeviceProperties properties_of(Client& client) {
  VkPhysicalDeviceProperties out;
  VK(client, GetPhysicalDeviceProperties)(client.physical, &out);
  return out;
}

// Vulkan 1.1, "Required Limits", for a device without geometry and tessellation shaders and without sparse resources (their rows
// say 0 then). In the order of the table; a limit that a feature is needed for has that feature's column where the feature is
// there.
TEST(IcdLimits, AreAtLeastWhatTheSpecificationRequires) {
  Client client;
  const VkPhysicalDeviceLimits limits = properties_of(client).limits;
  VkPhysicalDeviceFeatures features;
  VK(client, GetPhysicalDeviceFeatures)(client.physical, &features);
  const auto at_least = [](const char* name, double value, double required) { EXPECT_GE(value, required) << name; };
  const auto at_most = [](const char* name, double value, double required) { EXPECT_LE(value, required) << name; };
#define MIN(name, required) at_least(#name, double(limits.name), double(required))
#define MAX(name, required) at_most(#name, double(limits.name), double(required))
  MIN(maxImageDimension1D, 4096);
  MIN(maxImageDimension2D, 4096);
  MIN(maxImageDimension3D, 256);
  MIN(maxImageDimensionCube, 4096);
  MIN(maxImageArrayLayers, 256);
  MIN(maxTexelBufferElements, 65536);
  MIN(maxUniformBufferRange, 16384);
  MIN(maxStorageBufferRange, 1u << 27);
  MIN(maxPushConstantsSize, 128);
  MIN(maxMemoryAllocationCount, 4096);
  MIN(maxSamplerAllocationCount, 4000);
  MAX(bufferImageGranularity, 131072);
  MIN(maxBoundDescriptorSets, 4);
  MIN(maxPerStageDescriptorSamplers, 16);
  MIN(maxPerStageDescriptorUniformBuffers, 12);
  MIN(maxPerStageDescriptorStorageBuffers, 4);
  MIN(maxPerStageDescriptorSampledImages, 16);
  MIN(maxPerStageDescriptorStorageImages, 4);
  MIN(maxPerStageDescriptorInputAttachments, 4);
  MIN(maxPerStageResources, 128);
  // n times the values per stage, n = 3 without geometry and tessellation shaders; "the full value" only where they are there.
  MIN(maxDescriptorSetSamplers, 3 * 16);
  MIN(maxDescriptorSetUniformBuffers, 3 * 12);
  MIN(maxDescriptorSetUniformBuffersDynamic, 8);
  MIN(maxDescriptorSetStorageBuffers, 3 * 4);
  MIN(maxDescriptorSetStorageBuffersDynamic, 4);
  MIN(maxDescriptorSetSampledImages, 3 * 16);
  MIN(maxDescriptorSetStorageImages, 3 * 4);
  MIN(maxDescriptorSetInputAttachments, 4);
  MIN(maxVertexInputAttributes, 16);
  MIN(maxVertexInputBindings, 16);
  MIN(maxVertexInputAttributeOffset, 2047);
  MIN(maxVertexInputBindingStride, 2048);
  MIN(maxVertexOutputComponents, 64);
  ASSERT_FALSE(features.tessellationShader || features.geometryShader) << "then their rows belong here";
  MIN(maxFragmentInputComponents, 64);
  MIN(maxFragmentOutputAttachments, 4);
  MIN(maxFragmentDualSrcAttachments, features.dualSrcBlend ? 1 : 0);
  MIN(maxFragmentCombinedOutputResources, 4);
  MIN(maxComputeSharedMemorySize, 16384);
  for (uint32_t i = 0; i < 3; ++i) MIN(maxComputeWorkGroupCount[i], 65535);
  MIN(maxComputeWorkGroupInvocations, 128);
  MIN(maxComputeWorkGroupSize[0], 128);
  MIN(maxComputeWorkGroupSize[1], 128);
  MIN(maxComputeWorkGroupSize[2], 64);
  MIN(subPixelPrecisionBits, 4);
  MIN(subTexelPrecisionBits, 4);
  MIN(mipmapPrecisionBits, 4);
  MIN(maxDrawIndexedIndexValue, features.fullDrawIndexUint32 ? 0xFFFFFFFFu : (1u << 24) - 1);
  MIN(maxDrawIndirectCount, features.multiDrawIndirect ? 65535 : 1);
  MIN(maxSamplerLodBias, 2);
  MIN(maxSamplerAnisotropy, features.samplerAnisotropy ? 16 : 1);
  MIN(maxViewports, features.multiViewport ? 16 : 1);
  for (uint32_t i = 0; i < 2; ++i) {
    MIN(maxViewportDimensions[i], 4096);
    MIN(maxViewportDimensions[i], i == 0 ? limits.maxFramebufferWidth : limits.maxFramebufferHeight);
    MAX(viewportBoundsRange[0], -2.0 * limits.maxViewportDimensions[i]);
    MIN(viewportBoundsRange[1], 2.0 * limits.maxViewportDimensions[i] - 1);
  }
  MIN(minMemoryMapAlignment, 64);
  MAX(minTexelBufferOffsetAlignment, 256);
  MAX(minUniformBufferOffsetAlignment, 256);
  MAX(minStorageBufferOffsetAlignment, 256);
  MAX(minTexelOffset, -8);
  MIN(maxTexelOffset, 7);
  if (features.shaderImageGatherExtended) {
    MAX(minTexelGatherOffset, -8);
    MIN(maxTexelGatherOffset, 7);
  }
  if (features.sampleRateShading) {
    MAX(minInterpolationOffset, -0.5);
    MIN(subPixelInterpolationOffsetBits, 4);
    MIN(maxInterpolationOffset, 0.5 - 1.0 / (1u << limits.subPixelInterpolationOffsetBits));
  }
  MIN(maxFramebufferWidth, 4096);
  MIN(maxFramebufferHeight, 4096);
  MIN(maxFramebufferLayers, 256);
  constexpr VkSampleCountFlags kOneAndFour = VK_SAMPLE_COUNT_1_BIT | VK_SAMPLE_COUNT_4_BIT;
  for (const VkSampleCountFlags counts :
       {limits.framebufferColorSampleCounts, limits.framebufferDepthSampleCounts, limits.framebufferStencilSampleCounts,
        limits.framebufferNoAttachmentsSampleCounts, limits.sampledImageColorSampleCounts, limits.sampledImageDepthSampleCounts,
        limits.sampledImageStencilSampleCounts}) {
    EXPECT_EQ(counts & kOneAndFour, kOneAndFour);
  }
  MIN(maxColorAttachments, 4);
  EXPECT_TRUE(limits.sampledImageIntegerSampleCounts & VK_SAMPLE_COUNT_1_BIT);
  EXPECT_TRUE(limits.storageImageSampleCounts & VK_SAMPLE_COUNT_1_BIT);
  if (features.shaderStorageImageMultisample) {
    EXPECT_EQ(limits.storageImageSampleCounts & kOneAndFour, kOneAndFour);
  }
  MIN(maxSampleMaskWords, 1);
  if (features.shaderClipDistance) MIN(maxClipDistances, 8);
  if (features.shaderCullDistance) MIN(maxCullDistances, 8);
  if (features.shaderCullDistance) MIN(maxCombinedClipAndCullDistances, 8);
  MIN(discreteQueuePriorities, 2);
  if (features.largePoints) {
    MAX(pointSizeRange[0], 1);
    MIN(pointSizeRange[1], 64.0 - limits.pointSizeGranularity);
    MAX(pointSizeGranularity, 1);
  }
  if (features.wideLines) {
    MAX(lineWidthRange[0], 1);
    MIN(lineWidthRange[1], 8.0 - limits.lineWidthGranularity);
    MAX(lineWidthGranularity, 1);
  }
  MAX(nonCoherentAtomSize, 256);
#undef MIN
#undef MAX
  for (const VkDeviceSize alignment :
       {VkDeviceSize(limits.minMemoryMapAlignment), limits.minTexelBufferOffsetAlignment, limits.minUniformBufferOffsetAlignment,
        limits.minStorageBufferOffsetAlignment, limits.bufferImageGranularity, limits.nonCoherentAtomSize}) {
    EXPECT_TRUE(alignment && (alignment & (alignment - 1)) == 0) << "a power of two";
  }
}

TEST(IcdLimits, OfVersion11AreAtLeastWhatTheSpecificationRequires) {
  Client client;
  VkPhysicalDeviceMaintenance3Properties maintenance3{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MAINTENANCE_3_PROPERTIES};
  VkPhysicalDeviceMultiviewProperties multiview{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MULTIVIEW_PROPERTIES, &maintenance3};
  VkPhysicalDeviceSubgroupProperties subgroup{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES, &multiview};
  VkPhysicalDeviceProperties2 properties{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &subgroup};
  VK(client, GetPhysicalDeviceProperties2)(client.physical, &properties);
  EXPECT_GE(multiview.maxMultiviewViewCount, 6u);
  EXPECT_GE(multiview.maxMultiviewInstanceIndex, (1u << 27) - 1);
  EXPECT_GE(maintenance3.maxPerSetDescriptors, 1024u);
  EXPECT_GE(maintenance3.maxMemoryAllocationSize, VkDeviceSize(1) << 30);
  EXPECT_GE(subgroup.subgroupSize, 1u);
  EXPECT_TRUE(subgroup.supportedStages & VK_SHADER_STAGE_COMPUTE_BIT);
  EXPECT_TRUE(subgroup.supportedOperations & VK_SUBGROUP_FEATURE_BASIC_BIT);
}

// "Feature Requirements" of 1.0 and 1.1.
TEST(IcdLimits, RequiredFeaturesAreThere) {
  Client client;
  VkPhysicalDeviceMultiviewFeatures multiview{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MULTIVIEW_FEATURES};
  VkPhysicalDeviceFeatures2 features{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, &multiview};
  VK(client, GetPhysicalDeviceFeatures2)(client.physical, &features);
  const VkPhysicalDeviceFeatures& core = features.features;
  EXPECT_TRUE(core.robustBufferAccess);
  EXPECT_TRUE(multiview.multiview);
  EXPECT_TRUE(core.textureCompressionETC2 || core.textureCompressionASTC_LDR || core.textureCompressionBC);
}

TEST(IcdLimits, MemoryTypesAreAsTheSpecificationOrdersThem) {
  Client client;
  VkPhysicalDeviceMemoryProperties memory;
  VK(client, GetPhysicalDeviceMemoryProperties)(client.physical, &memory);
  constexpr VkMemoryPropertyFlags kMapped = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
  bool mapped = false, local = false;
  for (uint32_t i = 0; i < memory.memoryTypeCount; ++i) {
    const VkMemoryPropertyFlags flags = memory.memoryTypes[i].propertyFlags;
    mapped |= (flags & kMapped) == kMapped;
    local |= (flags & VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT) != 0;
    EXPECT_LT(memory.memoryTypes[i].heapIndex, memory.memoryHeapCount);
    EXPECT_FALSE((flags & VK_MEMORY_PROPERTY_LAZILY_ALLOCATED_BIT) && (flags & VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT));
    for (uint32_t j = 0; j < i; ++j) {
      const VkMemoryPropertyFlags before = memory.memoryTypes[j].propertyFlags;
      EXPECT_FALSE(flags != before && (flags & before) == flags) << "a strict subset comes first";
    }
  }
  EXPECT_TRUE(mapped);
  EXPECT_TRUE(local);
}

struct Identity {
  VkPhysicalDeviceIDProperties id{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ID_PROPERTIES};
  VkPhysicalDeviceDriverProperties driver{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES, &id};
  VkPhysicalDeviceProperties2 properties{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &driver};

  explicit Identity(Client& client) { VK(client, GetPhysicalDeviceProperties2)(client.physical, &properties); }
  std::string text() const {
    std::string out;
    for (const uint8_t* uuid : {id.deviceUUID, id.driverUUID, properties.properties.pipelineCacheUUID}) {
      for (uint32_t i = 0; i < VK_UUID_SIZE; ++i)
        out += "0123456789abcdef"[uuid[i] >> 4], out += "0123456789abcdef"[uuid[i] & 15];
      out += ' ';
    }
    return out;
  }
};

TEST(IcdIdentity, IsToldHonestly) {
  Client client;
  const Identity identity(client);
  EXPECT_STREQ(identity.driver.driverName, "Pineda");
  const std::string info = identity.driver.driverInfo;
  EXPECT_NE(info.find("0.1.0"), std::string::npos) << info;
  const bool names_path = std::ranges::any_of(std::initializer_list<const char*>{"SSE4.2", "AVX2", "AVX-512", "evaluator"},
                                              [&](const char* path) { return info.find(path) != std::string::npos; });
  EXPECT_TRUE(names_path) << info;
  const VkConformanceVersion& version = identity.driver.conformanceVersion;
  EXPECT_EQ(version.major | version.minor | version.subminor | version.patch, 0) << "nothing was submitted";
  EXPECT_EQ(identity.properties.properties.deviceType, VK_PHYSICAL_DEVICE_TYPE_CPU);
  const std::string text = identity.text();
  EXPECT_NE(text.substr(0, 32), text.substr(33, 32));
  EXPECT_NE(text.substr(33, 32), text.substr(66, 32));
}

// Run by the test below in processes of their own.
TEST(IcdIdentityChild, DISABLED_Print) {
  Client client;
  printf("identity %s\n", Identity(client).text().c_str());
}

// The same in every process, whatever code path the environment chooses: the bits are the same too.
TEST(IcdIdentity, IsTheSameInEveryProcess) {
  Client client;
  const std::string own = Identity(client).text();
  for (const char* environment : {"PINEDA_ISA=sse42", "PINEDA_THREADS=1 PINEDA_MODE=f32"}) {
    const tests::ProcessResult result = tests::run_process(std::string(environment) + " " + tests::own_program() +
                                                           " --gtest_also_run_disabled_tests --gtest_filter=IcdIdentityChild.*");
    EXPECT_EQ(result.exit_status, 0);
    EXPECT_NE(result.output.find("identity " + own), std::string::npos) << result.output;
  }
}

}  // namespace
}  // namespace pineda::test
