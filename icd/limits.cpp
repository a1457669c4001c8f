// Every value is what the implementation does, not what would look good. Where one is below the specification's minimum, the
// thing itself is missing, and 0 or 1 says so.
#include "icd/limits.h"

#include "base/abi.h"
#include "base/sample_locations.h"
#include "raster/raster.h"

namespace pineda::icd {

constexpr VkPhysicalDeviceFeatures kFeatures = {
    .robustBufferAccess = VK_TRUE,   // each access is checked in the IR (ir.h, `limit` operand), whether enabled or not
    .fullDrawIndexUint32 = VK_TRUE,  // indices are never narrowed
    .imageCubeArray = VK_TRUE,
    .independentBlend = VK_TRUE,  // blend state is part of the kernel, for each attachment
    .sampleRateShading = VK_TRUE,
    .dualSrcBlend = VK_TRUE,
    .logicOp = VK_TRUE,
    .multiDrawIndirect = VK_TRUE,  // a loop in exec_draw.cpp
    .drawIndirectFirstInstance = VK_TRUE,
    .depthClamp = VK_TRUE,
    .depthBiasClamp = VK_TRUE,
    .fillModeNonSolid = VK_TRUE,
    .depthBounds = VK_TRUE,
    .wideLines = VK_TRUE,
    .largePoints = VK_TRUE,
    .alphaToOne = VK_TRUE,
    .multiViewport = VK_TRUE,           // chosen by the vertex shader: VK_EXT_shader_viewport_index_layer
    .samplerAnisotropy = VK_TRUE,       // probes along the longer axis (kernels/sample_lod.cpp)
    .textureCompressionETC2 = VK_TRUE,  // icd/decode.h
    .textureCompressionASTC_LDR = VK_TRUE,
    .textureCompressionBC = VK_TRUE,
    .occlusionQueryPrecise = VK_TRUE,  // every occlusion query counts samples
    .pipelineStatisticsQuery = VK_TRUE,
    .vertexPipelineStoresAndAtomics = VK_TRUE,
    .fragmentStoresAndAtomics = VK_TRUE,  // helper and uncovered lanes have no effects
    .shaderImageGatherExtended = VK_TRUE,
    .shaderStorageImageExtendedFormats = VK_TRUE,  // every plain format of the table
    .shaderStorageImageMultisample = VK_TRUE,
    .shaderStorageImageReadWithoutFormat = VK_TRUE,  // kernels/storage_image.cpp
    .shaderStorageImageWriteWithoutFormat = VK_TRUE,
    .shaderUniformBufferArrayDynamicIndexing = VK_TRUE,
    .shaderSampledImageArrayDynamicIndexing = VK_TRUE,  // kernels/sample_call.cpp
    .shaderStorageBufferArrayDynamicIndexing = VK_TRUE,
    .shaderStorageImageArrayDynamicIndexing = VK_TRUE,
    .shaderClipDistance = VK_TRUE,
    .shaderCullDistance = VK_TRUE,
    .shaderFloat64 = VK_TRUE,
    .shaderInt64 = VK_TRUE,
    .shaderInt16 = VK_TRUE,
    .shaderResourceMinLod = VK_TRUE,
    .variableMultisampleRate = VK_TRUE,  // exec_draw.cpp splits the subpass
    .inheritedQueries = VK_TRUE,         // the executor's queries are active across command buffers
};

constexpr VkPhysicalDeviceLimits kLimits = {
    .maxImageDimension1D = 16384,
    .maxImageDimension2D = 16384,
    .maxImageDimension3D = 2048,
    .maxImageDimensionCube = 16384,
    .maxImageArrayLayers = 2048,
    .maxTexelBufferElements = 1u << 27,
    .maxUniformBufferRange = 65536,
    .maxStorageBufferRange = 0xFFFFFFFFu,  // BufferDescriptor::size_bytes
    .maxPushConstantsSize = kMaxPushConstantBytes,
    .maxMemoryAllocationCount = 16384,  // each is one mapping; Linux allows 65530 a process
    .maxSamplerAllocationCount = 1u << 20,
    .bufferImageGranularity = 1,
    .sparseAddressSpaceSize = 0,
    .maxBoundDescriptorSets = kMaxSets,
    .maxPerStageDescriptorSamplers = 64,
    .maxPerStageDescriptorUniformBuffers = 200,
    .maxPerStageDescriptorStorageBuffers = 200,
    .maxPerStageDescriptorSampledImages = 200,
    .maxPerStageDescriptorStorageImages = 16,
    .maxPerStageDescriptorInputAttachments = 16,
    .maxPerStageResources = 1024,
    .maxDescriptorSetSamplers = 512,
    .maxDescriptorSetUniformBuffers = 1024,
    .maxDescriptorSetUniformBuffersDynamic = kMaxDynamicOffsets / 2,
    .maxDescriptorSetStorageBuffers = 1024,
    .maxDescriptorSetStorageBuffersDynamic = kMaxDynamicOffsets / 2,
    .maxDescriptorSetSampledImages = 1024,
    .maxDescriptorSetStorageImages = 128,
    .maxDescriptorSetInputAttachments = 128,
    .maxVertexInputAttributes = kMaxVertexAttributes,
    .maxVertexInputBindings = kMaxVertexBindings,
    .maxVertexInputAttributeOffset = 2047,
    .maxVertexInputBindingStride = 2048,
    .maxVertexOutputComponents = 128,
    .maxFragmentInputComponents = 128,
    .maxFragmentOutputAttachments = kMaxColorAttachments,
    .maxFragmentDualSrcAttachments = 1,
    .maxFragmentCombinedOutputResources = 216,
    .maxComputeSharedMemorySize = 65536,
    .maxComputeWorkGroupCount = {65535, 65535, 65535},
    .maxComputeWorkGroupInvocations = 1024,
    .maxComputeWorkGroupSize = {1024, 1024, 1024},
    .subPixelPrecisionBits = 8,
    .subTexelPrecisionBits = 8,
    .mipmapPrecisionBits = 8,
    .maxDrawIndexedIndexValue = 0xFFFFFFFFu,
    .maxDrawIndirectCount = 0xFFFFFFFFu,
    .maxSamplerLodBias = 16,
    .maxSamplerAnisotropy = 16,  // kernels::kMaxAnisotropy
    .maxViewports = kMaxViewports,
    .maxViewportDimensions = {16384, 16384},
    .viewportBoundsRange = {-32768, 32767},
    .viewportSubPixelBits = 8,  // viewports are floats; positions are snapped after the transform
    .minMemoryMapAlignment = 4096,
    .minTexelBufferOffsetAlignment = 16,
    .minUniformBufferOffsetAlignment = 16,
    .minStorageBufferOffsetAlignment = 16,
    .minTexelOffset = -8,
    .maxTexelOffset = 7,
    .minTexelGatherOffset = -32,
    .maxTexelGatherOffset = 31,
    .minInterpolationOffset = -0.5f,
    .maxInterpolationOffset = 0.4375f,
    .subPixelInterpolationOffsetBits = 4,
    .maxFramebufferWidth = 16384,
    .maxFramebufferHeight = 16384,
    .maxFramebufferLayers = 2048,
    .framebufferColorSampleCounts = kSampleCounts,
    .framebufferDepthSampleCounts = kSampleCounts,
    .framebufferStencilSampleCounts = kSampleCounts,
    .framebufferNoAttachmentsSampleCounts = kSampleCounts,
    .maxColorAttachments = kMaxColorAttachments,
    .sampledImageColorSampleCounts = kSampleCounts,
    .sampledImageIntegerSampleCounts = kSampleCounts,
    .sampledImageDepthSampleCounts = kSampleCounts,
    .sampledImageStencilSampleCounts = kSampleCounts,
    .storageImageSampleCounts = kSampleCounts,
    .maxSampleMaskWords = 1,
    .timestampComputeAndGraphics = VK_TRUE,
    .timestampPeriod = 1.0f,  // CLOCK_MONOTONIC, ns
    .maxClipDistances = kMaxClipDistances,
    .maxCullDistances = kMaxClipDistances,
    .maxCombinedClipAndCullDistances = kMaxClipDistances,
    .discreteQueuePriorities = 2,
    .pointSizeRange = {raster::kMinPointSize, raster::kMaxPointSize},
    .lineWidthRange = {1, raster::kMaxLineWidth},
    .pointSizeGranularity = 0x1p-7f,  // half of it is rounded to 1/256 px
    .lineWidthGranularity = 0x1p-7f,
    .strictLines = VK_TRUE,
    .standardSampleLocations = VK_TRUE,
    .optimalBufferCopyOffsetAlignment = 1,
    .optimalBufferCopyRowPitchAlignment = 1,
    .nonCoherentAtomSize = 1,
};

}  // namespace pineda::icd
