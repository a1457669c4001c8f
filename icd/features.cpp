#include "icd/features.h"

#include <cstring>
#include <span>

#include "icd/chain.h"
#include "icd/limits.h"

namespace pineda::icd {
namespace {

// What the driver does; a bit goes up together with a test that uses it.
// ---- Vulkan 1.1
constexpr VkPhysicalDevice16BitStorageFeatures k16BitStorage{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_16BIT_STORAGE_FEATURES,
                                                             .storageBuffer16BitAccess = VK_TRUE,
                                                             .uniformAndStorageBuffer16BitAccess = VK_TRUE,
                                                             .storagePushConstant16 = VK_TRUE,
                                                             .storageInputOutput16 = VK_TRUE};
constexpr VkPhysicalDeviceMultiviewFeatures kMultiview{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MULTIVIEW_FEATURES,
                                                       .multiview = VK_TRUE};
constexpr VkPhysicalDeviceVariablePointersFeatures kVariablePointers{
    .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VARIABLE_POINTERS_FEATURES,
    .variablePointersStorageBuffer = VK_TRUE,
    .variablePointers = VK_TRUE};
constexpr VkPhysicalDeviceProtectedMemoryFeatures kProtectedMemory{
    .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROTECTED_MEMORY_FEATURES};
constexpr VkPhysicalDeviceSamplerYcbcrConversionFeatures kSamplerYcbcrConversion{
    .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SAMPLER_YCBCR_CONVERSION_FEATURES, .samplerYcbcrConversion = VK_TRUE};
constexpr VkPhysicalDeviceShaderDrawParametersFeatures kShaderDrawParameters{
    .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SHADER_DRAW_PARAMETERS_FEATURES, .shaderDrawParameters = VK_TRUE};

// ---- extensions
constexpr VkPhysicalDeviceImagelessFramebufferFeatures kImagelessFramebuffer{
    .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_IMAGELESS_FRAMEBUFFER_FEATURES, .imagelessFramebuffer = VK_TRUE};
constexpr VkPhysicalDeviceTimelineSemaphoreFeatures kTimelineSemaphore{
    .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_TIMELINE_SEMAPHORE_FEATURES, .timelineSemaphore = VK_TRUE};
constexpr VkPhysicalDeviceHostQueryResetFeatures kHostQueryReset{
    .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_HOST_QUERY_RESET_FEATURES, .hostQueryReset = VK_TRUE};
constexpr VkPhysicalDeviceDescriptorIndexingFeatures kDescriptorIndexing{
    .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DESCRIPTOR_INDEXING_FEATURES,
    .shaderUniformTexelBufferArrayDynamicIndexing = VK_TRUE,
    .shaderStorageTexelBufferArrayDynamicIndexing = VK_TRUE,
    .shaderUniformBufferArrayNonUniformIndexing = VK_TRUE,
    .shaderSampledImageArrayNonUniformIndexing = VK_TRUE,
    .shaderStorageBufferArrayNonUniformIndexing = VK_TRUE,
    .shaderStorageImageArrayNonUniformIndexing = VK_TRUE,
    .shaderUniformTexelBufferArrayNonUniformIndexing = VK_TRUE,
    .shaderStorageTexelBufferArrayNonUniformIndexing = VK_TRUE,
    .descriptorBindingUniformBufferUpdateAfterBind = VK_TRUE,
    .descriptorBindingSampledImageUpdateAfterBind = VK_TRUE,
    .descriptorBindingStorageImageUpdateAfterBind = VK_TRUE,
    .descriptorBindingStorageBufferUpdateAfterBind = VK_TRUE,
    .descriptorBindingUniformTexelBufferUpdateAfterBind = VK_TRUE,
    .descriptorBindingStorageTexelBufferUpdateAfterBind = VK_TRUE,
    .descriptorBindingUpdateUnusedWhilePending = VK_TRUE,
    .descriptorBindingPartiallyBound = VK_TRUE,
    .descriptorBindingVariableDescriptorCount = VK_TRUE,
    .runtimeDescriptorArray = VK_TRUE};
constexpr VkPhysicalDeviceCustomBorderColorFeaturesEXT kCustomBorderColor{
    .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_CUSTOM_BORDER_COLOR_FEATURES_EXT,
    .customBorderColors = VK_TRUE,
    .customBorderColorWithoutFormat = VK_TRUE};
constexpr VkPhysicalDevice4444FormatsFeaturesEXT k4444Formats{
    .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_4444_FORMATS_FEATURES_EXT, .formatA4R4G4B4 = VK_TRUE, .formatA4B4G4R4 = VK_TRUE};
constexpr VkPhysicalDeviceDepthClipEnableFeaturesEXT kDepthClipEnable{
    .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DEPTH_CLIP_ENABLE_FEATURES_EXT, .depthClipEnable = VK_TRUE};
constexpr VkPhysicalDeviceFaultFeaturesEXT kDeviceFault{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FAULT_FEATURES_EXT,
                                                        .deviceFault = VK_TRUE};
constexpr VkPhysicalDeviceImage2DViewOf3DFeaturesEXT kImage2DViewOf3D{
    .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_IMAGE_2D_VIEW_OF_3D_FEATURES_EXT,
    .image2DViewOf3D = VK_TRUE,
    .sampler2DViewOf3D = VK_TRUE};
constexpr VkPhysicalDeviceIndexTypeUint8FeaturesEXT kIndexTypeUint8{
    .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_INDEX_TYPE_UINT8_FEATURES_EXT, .indexTypeUint8 = VK_TRUE};
constexpr VkPhysicalDeviceLineRasterizationFeaturesEXT kLineRasterization{
    .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_LINE_RASTERIZATION_FEATURES_EXT,
    .rectangularLines = VK_TRUE,
    .bresenhamLines = VK_TRUE,
    .smoothLines = VK_TRUE,
    .stippledRectangularLines = VK_TRUE,
    .stippledBresenhamLines = VK_TRUE,
    .stippledSmoothLines = VK_TRUE};
constexpr VkPhysicalDeviceProvokingVertexFeaturesEXT kProvokingVertex{
    .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROVOKING_VERTEX_FEATURES_EXT, .provokingVertexLast = VK_TRUE};

constexpr VkPhysicalDevice8BitStorageFeatures k8BitStorage{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_8BIT_STORAGE_FEATURES,
                                                           .storageBuffer8BitAccess = VK_TRUE,
                                                           .uniformAndStorageBuffer8BitAccess = VK_TRUE,
                                                           .storagePushConstant8 = VK_TRUE};
constexpr VkPhysicalDeviceShaderFloat16Int8Features kFloat16Int8{
    .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SHADER_FLOAT16_INT8_FEATURES, .shaderFloat16 = VK_TRUE, .shaderInt8 = VK_TRUE};
// Accesses need no alignment in the IR, so every layout is the same to it.
constexpr VkPhysicalDeviceScalarBlockLayoutFeatures kScalarBlockLayout{
    .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SCALAR_BLOCK_LAYOUT_FEATURES, .scalarBlockLayout = VK_TRUE};
constexpr VkPhysicalDeviceUniformBufferStandardLayoutFeatures kUniformStandardLayout{
    .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_UNIFORM_BUFFER_STANDARD_LAYOUT_FEATURES, .uniformBufferStandardLayout = VK_TRUE};

constexpr VkPhysicalDeviceBufferDeviceAddressFeatures kBufferDeviceAddress{
    .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_BUFFER_DEVICE_ADDRESS_FEATURES, .bufferDeviceAddress = VK_TRUE};
constexpr VkPhysicalDeviceShaderAtomicInt64Features kAtomicInt64{
    .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SHADER_ATOMIC_INT64_FEATURES,
    .shaderBufferInt64Atomics = VK_TRUE,
    .shaderSharedInt64Atomics = VK_TRUE};
constexpr VkPhysicalDeviceShaderAtomicFloatFeaturesEXT kAtomicFloat{
    .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SHADER_ATOMIC_FLOAT_FEATURES_EXT,
    .shaderBufferFloat32Atomics = VK_TRUE,
    .shaderBufferFloat32AtomicAdd = VK_TRUE,
    .shaderBufferFloat64Atomics = VK_TRUE,
    .shaderBufferFloat64AtomicAdd = VK_TRUE,
    .shaderSharedFloat32Atomics = VK_TRUE,
    .shaderSharedFloat32AtomicAdd = VK_TRUE,
    .shaderSharedFloat64Atomics = VK_TRUE,
    .shaderSharedFloat64AtomicAdd = VK_TRUE,
    .shaderImageFloat32Atomics = VK_TRUE,
    .shaderImageFloat32AtomicAdd = VK_TRUE};
constexpr VkPhysicalDeviceShaderIntegerDotProductFeatures kIntegerDotProduct{
    .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SHADER_INTEGER_DOT_PRODUCT_FEATURES, .shaderIntegerDotProduct = VK_TRUE};
constexpr VkPhysicalDeviceShaderSubgroupExtendedTypesFeatures kSubgroupExtendedTypes{
    .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SHADER_SUBGROUP_EXTENDED_TYPES_FEATURES, .shaderSubgroupExtendedTypes = VK_TRUE};
constexpr VkPhysicalDeviceShaderTerminateInvocationFeatures kTerminateInvocation{
    .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SHADER_TERMINATE_INVOCATION_FEATURES, .shaderTerminateInvocation = VK_TRUE};
constexpr VkPhysicalDeviceShaderDemoteToHelperInvocationFeatures kDemoteToHelperInvocation{
    .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SHADER_DEMOTE_TO_HELPER_INVOCATION_FEATURES,
    .shaderDemoteToHelperInvocation = VK_TRUE};
constexpr VkPhysicalDeviceVulkanMemoryModelFeatures kMemoryModel{
    .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_MEMORY_MODEL_FEATURES,
    .vulkanMemoryModel = VK_TRUE,
    .vulkanMemoryModelDeviceScope = VK_TRUE,
    .vulkanMemoryModelAvailabilityVisibilityChains = VK_TRUE};
constexpr VkPhysicalDeviceZeroInitializeWorkgroupMemoryFeatures kZeroInitializeWorkgroupMemory{
    .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ZERO_INITIALIZE_WORKGROUP_MEMORY_FEATURES,
    .shaderZeroInitializeWorkgroupMemory = VK_TRUE};

struct FeatureRow {
  VkStructureType type;
  std::span<const VkBool32> available;
};

// A feature structure is a header and then one VkBool32 after the other. `last` is its last member: what follows is padding,
// which in an application's structure holds anything.
template <typename Struct>
FeatureRow row(const Struct& values, const VkBool32& last) {
  const auto* first = reinterpret_cast<const VkBool32*>(reinterpret_cast<const VkBaseInStructure*>(&values) + 1);
  return {values.sType, {first, &last + 1}};
}

// The one table.
std::span<const FeatureRow> rows() {
  static const FeatureRow kRows[] = {
      row(k16BitStorage, k16BitStorage.storageInputOutput16),
      row(kMultiview, kMultiview.multiviewTessellationShader),
      row(kVariablePointers, kVariablePointers.variablePointers),
      row(kProtectedMemory, kProtectedMemory.protectedMemory),
      row(kSamplerYcbcrConversion, kSamplerYcbcrConversion.samplerYcbcrConversion),
      row(kShaderDrawParameters, kShaderDrawParameters.shaderDrawParameters),
      row(kImagelessFramebuffer, kImagelessFramebuffer.imagelessFramebuffer),
      row(kTimelineSemaphore, kTimelineSemaphore.timelineSemaphore),
      row(kHostQueryReset, kHostQueryReset.hostQueryReset),
      row(kDescriptorIndexing, kDescriptorIndexing.runtimeDescriptorArray),
      row(k4444Formats, k4444Formats.formatA4B4G4R4),
      row(kDepthClipEnable, kDepthClipEnable.depthClipEnable),
      row(kDeviceFault, kDeviceFault.deviceFaultVendorBinary),
      row(kImage2DViewOf3D, kImage2DViewOf3D.sampler2DViewOf3D),
      row(kIndexTypeUint8, kIndexTypeUint8.indexTypeUint8),
      row(kLineRasterization, kLineRasterization.stippledSmoothLines),
      row(kProvokingVertex, kProvokingVertex.transformFeedbackPreservesProvokingVertex),
      row(kCustomBorderColor, kCustomBorderColor.customBorderColorWithoutFormat),
      row(k8BitStorage, k8BitStorage.storagePushConstant8),
      row(kFloat16Int8, kFloat16Int8.shaderInt8),
      row(kScalarBlockLayout, kScalarBlockLayout.scalarBlockLayout),
      row(kUniformStandardLayout, kUniformStandardLayout.uniformBufferStandardLayout),
      row(kBufferDeviceAddress, kBufferDeviceAddress.bufferDeviceAddressMultiDevice),
      row(kAtomicInt64, kAtomicInt64.shaderSharedInt64Atomics),
      row(kAtomicFloat, kAtomicFloat.sparseImageFloat32AtomicAdd),
      row(kIntegerDotProduct, kIntegerDotProduct.shaderIntegerDotProduct),
      row(kSubgroupExtendedTypes, kSubgroupExtendedTypes.shaderSubgroupExtendedTypes),
      row(kTerminateInvocation, kTerminateInvocation.shaderTerminateInvocation),
      row(kDemoteToHelperInvocation, kDemoteToHelperInvocation.shaderDemoteToHelperInvocation),
      row(kMemoryModel, kMemoryModel.vulkanMemoryModelAvailabilityVisibilityChains),
      row(kZeroInitializeWorkgroupMemory, kZeroInitializeWorkgroupMemory.shaderZeroInitializeWorkgroupMemory),
  };
  return kRows;
}

const FeatureRow* find_row(int32_t type) {
  for (const FeatureRow& row : rows()) {
    if (row.type == type) return &row;
  }
  return nullptr;
}

bool available(const void* wanted, std::span<const VkBool32> have) {
  for (size_t i = 0; i < have.size(); ++i) {
    VkBool32 want;
    std::memcpy(&want, static_cast<const uint8_t*>(wanted) + i * sizeof(want), sizeof(want));
    if (want && !have[i]) return false;
  }
  return true;
}

}  // namespace

void fill_features(void* chain) {
  for (auto* next = static_cast<VkBaseOutStructure*>(chain); next; next = next->pNext) {
    if (const FeatureRow* row = find_row(type_number(next)))
      std::memcpy(next + 1, row->available.data(), row->available.size_bytes());
  }
}

bool features_available(const VkPhysicalDeviceFeatures& wanted) {
  VkBool32 have[sizeof(kFeatures) / sizeof(VkBool32)];
  std::memcpy(have, &kFeatures, sizeof(have));
  return available(&wanted, have);
}

bool features_available(const void* chain) {
  for (auto* next = static_cast<const VkBaseInStructure*>(chain); next; next = next->pNext) {
    if (type_number(next) == VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2) {
      if (!features_available(reinterpret_cast<const VkPhysicalDeviceFeatures2*>(next)->features)) return false;
    } else if (const FeatureRow* row = find_row(type_number(next))) {
      if (!available(next + 1, row->available)) return false;
    }
  }
  return true;
}

}  // namespace pineda::icd
