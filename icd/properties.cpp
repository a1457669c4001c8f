#include "icd/properties.h"

#include <algorithm>
#include <cstring>
#include <string>

#include "base/abi.h"
#include "compiler/build_id.h"
#include "compiler/hash.h"
#include "icd/chain.h"
#include "icd/limits.h"
#include "icd/physical_device.h"
#include "icd/version.h"

namespace pineda::icd {
namespace {

template <size_t kSize>
void copy_text(char (&to)[kSize], const std::string& text) {
  std::memset(to, 0, kSize);
  std::memcpy(to, text.data(), std::min(text.size(), kSize - 1));
}

template <size_t kSize>
void copy_hash(uint8_t (&to)[kSize], const std::string& text) {
  const compiler::KernelHash hash = compiler::hash_bytes(text);
  static_assert(sizeof(hash) == kSize);
  std::memcpy(to, &hash, kSize);
}

// A device of software is what it computes: two builds are the same device when they agree on the golden images, whose hashes
// CMakeLists.txt hashes once more. It is equal in all processes of a machine, whatever their environment, as the bits do not
// depend on it. The driver is this build: its caches, and what it might share one day, are for itself alone.
void fill(VkPhysicalDeviceIDProperties& to) {
  copy_hash(to.deviceUUID, std::string("Pineda device ") + PINEDA_BIT_CONTRACT);
  copy_hash(to.driverUUID, "Pineda driver " + compiler::build_id());
  std::memset(to.deviceLUID, 0, sizeof(to.deviceLUID));
  to.deviceNodeMask = 0;
  to.deviceLUIDValid = VK_FALSE;
}

void fill(VkPhysicalDeviceSubgroupProperties& to) {
  to.subgroupSize = kLanes;
  to.supportedStages = VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT | VK_SHADER_STAGE_COMPUTE_BIT;
  to.supportedOperations = VK_SUBGROUP_FEATURE_BASIC_BIT | VK_SUBGROUP_FEATURE_VOTE_BIT | VK_SUBGROUP_FEATURE_ARITHMETIC_BIT |
                           VK_SUBGROUP_FEATURE_BALLOT_BIT | VK_SUBGROUP_FEATURE_SHUFFLE_BIT |
                           VK_SUBGROUP_FEATURE_SHUFFLE_RELATIVE_BIT | VK_SUBGROUP_FEATURE_CLUSTERED_BIT |
                           VK_SUBGROUP_FEATURE_QUAD_BIT;
  to.quadOperationsInAllStages = VK_FALSE;
}

// Points are discarded when their centre is outside the clip volume (raster/).
void fill(VkPhysicalDevicePointClippingProperties& to) { to.pointClippingBehavior = VK_POINT_CLIPPING_BEHAVIOR_ALL_CLIP_PLANES; }

void fill(VkPhysicalDeviceMultiviewProperties& to) {
  to.maxMultiviewViewCount = kMaxViews;
  to.maxMultiviewInstanceIndex = 0xFFFFFFFFu;  // instances are counted in 32 bits, and views need none of them
}

void fill(VkPhysicalDeviceProtectedMemoryProperties& to) { to.protectedNoFault = VK_FALSE; }

void fill(VkPhysicalDeviceMaintenance3Properties& to) {
  to.maxPerSetDescriptors = kMaxPerSetDescriptors;
  to.maxMemoryAllocationSize = memory_heap_bytes();
}

void fill(VkPhysicalDeviceDriverProperties& to) {
  to.driverID = VkDriverId(0);  // ids are registered with Khronos; this driver has none yet
  copy_text(to.driverName, "Pineda");
  copy_text(to.driverInfo, std::string(kDriverVersionText) + ", " + code_path_name());
  to.conformanceVersion = {0, 0, 0, 0};  // nothing has been submitted
}

void fill(VkPhysicalDeviceTimelineSemaphoreProperties& to) {
  to.maxTimelineSemaphoreValueDifference = ~uint64_t{0};  // all 64 bits are compared
}

void fill(VkPhysicalDeviceDescriptorIndexingProperties& to) {
  constexpr uint32_t kMany = kMaxUpdateAfterBindDescriptors;
  to.maxUpdateAfterBindDescriptorsInAllPools = 0xFFFFFFFFu;  // memory is the limit
  to.shaderUniformBufferArrayNonUniformIndexingNative = to.shaderSampledImageArrayNonUniformIndexingNative =
      to.shaderStorageBufferArrayNonUniformIndexingNative = to.shaderStorageImageArrayNonUniformIndexingNative = VK_TRUE;
  to.shaderInputAttachmentArrayNonUniformIndexingNative = VK_FALSE;
  to.robustBufferAccessUpdateAfterBind = VK_TRUE;
  to.quadDivergentImplicitLod = VK_FALSE;
  to.maxPerStageDescriptorUpdateAfterBindSamplers = to.maxPerStageDescriptorUpdateAfterBindUniformBuffers =
      to.maxPerStageDescriptorUpdateAfterBindStorageBuffers = to.maxPerStageDescriptorUpdateAfterBindSampledImages =
          to.maxPerStageDescriptorUpdateAfterBindStorageImages = to.maxPerStageUpdateAfterBindResources = kMany;
  to.maxPerStageDescriptorUpdateAfterBindInputAttachments = kLimits.maxPerStageDescriptorInputAttachments;
  to.maxDescriptorSetUpdateAfterBindSamplers = to.maxDescriptorSetUpdateAfterBindUniformBuffers =
      to.maxDescriptorSetUpdateAfterBindStorageBuffers = to.maxDescriptorSetUpdateAfterBindSampledImages =
          to.maxDescriptorSetUpdateAfterBindStorageImages = kMany;
  to.maxDescriptorSetUpdateAfterBindUniformBuffersDynamic = kLimits.maxDescriptorSetUniformBuffersDynamic;
  to.maxDescriptorSetUpdateAfterBindStorageBuffersDynamic = kLimits.maxDescriptorSetStorageBuffersDynamic;
  to.maxDescriptorSetUpdateAfterBindInputAttachments = kLimits.maxDescriptorSetInputAttachments;
}

// The IR's arithmetic is IEEE 754's at every width, whatever a shader asks for: denormals are kept and results rounded to nearest
// even. Execution modes that ask for something else are refused.
void fill(VkPhysicalDeviceFloatControlsProperties& to) {
  to.denormBehaviorIndependence = to.roundingModeIndependence = VK_SHADER_FLOAT_CONTROLS_INDEPENDENCE_ALL;
  to.shaderSignedZeroInfNanPreserveFloat16 = to.shaderSignedZeroInfNanPreserveFloat32 = to.shaderSignedZeroInfNanPreserveFloat64 =
      VK_TRUE;
  to.shaderDenormPreserveFloat16 = to.shaderDenormPreserveFloat32 = to.shaderDenormPreserveFloat64 = VK_TRUE;
  to.shaderDenormFlushToZeroFloat16 = to.shaderDenormFlushToZeroFloat32 = to.shaderDenormFlushToZeroFloat64 = VK_FALSE;
  to.shaderRoundingModeRTEFloat16 = to.shaderRoundingModeRTEFloat32 = to.shaderRoundingModeRTEFloat64 = VK_TRUE;
  to.shaderRoundingModeRTZFloat16 = to.shaderRoundingModeRTZFloat32 = to.shaderRoundingModeRTZFloat64 = VK_FALSE;
}

// None is faster than the multiplications and additions that it stands for (spirv/dot_product.cpp).
void fill(VkPhysicalDeviceShaderIntegerDotProductProperties& to) {
  auto* const next = to.pNext;
  to = {.sType = to.sType, .pNext = next};
}

// A colour is part of its sampler (sampler.cpp).
void fill(VkPhysicalDeviceCustomBorderColorPropertiesEXT& to) {
  to.maxCustomBorderColorSamplers = kLimits.maxSamplerAllocationCount;
}

// Every format is reduced component by component, after its conversion to numbers.
void fill(VkPhysicalDeviceSamplerFilterMinmaxProperties& to) {
  to.filterMinmaxSingleComponentFormats = VK_TRUE;
  to.filterMinmaxImageComponentMapping = VK_TRUE;
}

// Widths and positions are multiples of 1/256 px.
void fill(VkPhysicalDeviceLineRasterizationPropertiesEXT& to) { to.lineSubPixelPrecisionBits = kLimits.subPixelPrecisionBits; }

void fill(VkPhysicalDeviceProvokingVertexPropertiesEXT& to) {
  to.provokingVertexModePerPipeline = VK_TRUE;
  to.transformFeedbackPreservesTriangleFanProvokingVertex = VK_FALSE;  // no transform feedback
}

// What resolve.cpp has a kernel for; depth and stencil are resolved apart (render_pass.cpp).
void fill(VkPhysicalDeviceDepthStencilResolveProperties& to) {
  to.supportedDepthResolveModes =
      VK_RESOLVE_MODE_SAMPLE_ZERO_BIT | VK_RESOLVE_MODE_AVERAGE_BIT | VK_RESOLVE_MODE_MIN_BIT | VK_RESOLVE_MODE_MAX_BIT;
  to.supportedStencilResolveModes = VK_RESOLVE_MODE_SAMPLE_ZERO_BIT | VK_RESOLVE_MODE_MIN_BIT | VK_RESOLVE_MODE_MAX_BIT;
  to.independentResolveNone = to.independentResolve = VK_TRUE;
}

// The one table: structure type -> the function that fills it.
struct PropertyRow {
  VkStructureType type;
  void (*fill)(void* structure);
};

template <typename Struct>
constexpr PropertyRow row(VkStructureType type) {
  return {type, [](void* structure) { fill(*static_cast<Struct*>(structure)); }};
}

constexpr PropertyRow kRows[] = {
    // ---- Vulkan 1.1
    row<VkPhysicalDeviceIDProperties>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ID_PROPERTIES),
    row<VkPhysicalDeviceSubgroupProperties>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES),
    row<VkPhysicalDevicePointClippingProperties>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_POINT_CLIPPING_PROPERTIES),
    row<VkPhysicalDeviceMultiviewProperties>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MULTIVIEW_PROPERTIES),
    row<VkPhysicalDeviceProtectedMemoryProperties>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROTECTED_MEMORY_PROPERTIES),
    row<VkPhysicalDeviceMaintenance3Properties>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MAINTENANCE_3_PROPERTIES),
    // ---- extensions
    row<VkPhysicalDeviceDriverProperties>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES),
    row<VkPhysicalDeviceDescriptorIndexingProperties>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DESCRIPTOR_INDEXING_PROPERTIES),
    row<VkPhysicalDeviceFloatControlsProperties>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FLOAT_CONTROLS_PROPERTIES),
    row<VkPhysicalDeviceShaderIntegerDotProductProperties>(
        VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SHADER_INTEGER_DOT_PRODUCT_PROPERTIES),
    row<VkPhysicalDeviceCustomBorderColorPropertiesEXT>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_CUSTOM_BORDER_COLOR_PROPERTIES_EXT),
    row<VkPhysicalDeviceSamplerFilterMinmaxProperties>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SAMPLER_FILTER_MINMAX_PROPERTIES),
    row<VkPhysicalDeviceLineRasterizationPropertiesEXT>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_LINE_RASTERIZATION_PROPERTIES_EXT),
    row<VkPhysicalDeviceProvokingVertexPropertiesEXT>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROVOKING_VERTEX_PROPERTIES_EXT),
    row<VkPhysicalDeviceDepthStencilResolveProperties>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DEPTH_STENCIL_RESOLVE_PROPERTIES),
    row<VkPhysicalDeviceTimelineSemaphoreProperties>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_TIMELINE_SEMAPHORE_PROPERTIES),
};

}  // namespace

void fill_properties(void* chain) {
  for (auto* next = static_cast<VkBaseOutStructure*>(chain); next; next = next->pNext) {
    for (const PropertyRow& row : kRows) {
      if (row.type == type_number(next)) row.fill(next);
    }
  }
}

}  // namespace pineda::icd
