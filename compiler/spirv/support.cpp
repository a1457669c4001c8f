// What this translator accepts: the one table of capabilities. Everything else is refused by name.
#include <algorithm>

#include "compiler/spirv/module.h"

namespace pineda::spirv {
namespace {

// The capabilities that shaders may declare.
constexpr spv::Capability kSupported[] = {
    spv::CapabilityMatrix,
    spv::CapabilityShader,
    spv::CapabilityImageQuery,
    spv::CapabilityDerivativeControl,
    spv::CapabilitySampled1D,
    spv::CapabilityImage1D,
    spv::CapabilitySampledCubeArray,
    spv::CapabilityImageCubeArray,
    spv::CapabilityImageGatherExtended,
    spv::CapabilityStorageImageExtendedFormats,
    spv::CapabilityStorageImageReadWithoutFormat,
    spv::CapabilityStorageImageWriteWithoutFormat,
    spv::CapabilityDrawParameters,
    spv::CapabilityDemoteToHelperInvocationEXT,
    spv::CapabilitySampleRateShading,
    spv::CapabilityInputAttachment,
    spv::CapabilityInterpolationFunction,
    spv::CapabilityStencilExportEXT,
    spv::CapabilityClipDistance,
    spv::CapabilityCullDistance,
    spv::CapabilityMultiViewport,
    spv::CapabilityShaderLayer,
    spv::CapabilityShaderViewportIndex,
    spv::CapabilityShaderViewportIndexLayerEXT,
    spv::CapabilityUniformBufferArrayDynamicIndexing,
    spv::CapabilityStorageBufferArrayDynamicIndexing,
    spv::CapabilityUniformTexelBufferArrayNonUniformIndexing,
    spv::CapabilityStorageTexelBufferArrayNonUniformIndexing,
    spv::CapabilityVulkanMemoryModel,
    spv::CapabilityVulkanMemoryModelDeviceScope,
    spv::CapabilityFloat16,
    spv::CapabilityFloat64,
    spv::CapabilityInt64,
    spv::CapabilityInt16,
    spv::CapabilityInt8,
    spv::CapabilityStorageBuffer16BitAccess,
    spv::CapabilityUniformAndStorageBuffer16BitAccess,
    spv::CapabilityStoragePushConstant16,
    spv::CapabilityStorageInputOutput16,
    spv::CapabilityMultiView,
    spv::CapabilityDeviceGroup,
    spv::CapabilityVariablePointersStorageBuffer,
    spv::CapabilityVariablePointers,
    spv::CapabilityStorageBuffer8BitAccess,
    spv::CapabilityUniformAndStorageBuffer8BitAccess,
    spv::CapabilityStoragePushConstant8,
    spv::CapabilityDenormPreserve,
    spv::CapabilitySignedZeroInfNanPreserve,
    spv::CapabilityRoundingModeRTE,
    spv::CapabilityShaderNonUniform,
    spv::CapabilityUniformBufferArrayNonUniformIndexing,
    spv::CapabilityStorageBufferArrayNonUniformIndexing,
    spv::CapabilityPhysicalStorageBufferAddresses,
    spv::CapabilityDotProduct,
    spv::CapabilityDotProductInputAll,
    spv::CapabilityDotProductInput4x8Bit,
    spv::CapabilityDotProductInput4x8BitPacked,
    spv::CapabilityGroupNonUniform,
    spv::CapabilityGroupNonUniformVote,
    spv::CapabilityGroupNonUniformArithmetic,
    spv::CapabilityGroupNonUniformBallot,
    spv::CapabilityGroupNonUniformShuffle,
    spv::CapabilityGroupNonUniformShuffleRelative,
    spv::CapabilityGroupNonUniformClustered,
    spv::CapabilityGroupNonUniformQuad,
    spv::CapabilityGroupNonUniformRotateKHR,
    spv::CapabilitySubgroupBallotKHR,
    spv::CapabilitySubgroupVoteKHR,
    spv::CapabilityInt64Atomics,
    spv::CapabilitySampledImageArrayDynamicIndexing,
    spv::CapabilityStorageImageArrayDynamicIndexing,
    spv::CapabilityMinLod,
    spv::CapabilityStorageImageMultisample,
    spv::CapabilityImageMSArray,
    spv::CapabilitySampledBuffer,
    spv::CapabilityImageBuffer,
    spv::CapabilityRuntimeDescriptorArray,
    spv::CapabilityUniformTexelBufferArrayDynamicIndexing,
    spv::CapabilityStorageTexelBufferArrayDynamicIndexing,
    spv::CapabilitySampledImageArrayNonUniformIndexing,
    spv::CapabilityStorageImageArrayNonUniformIndexing,
    spv::CapabilityAtomicFloat32AddEXT,
    spv::CapabilityAtomicFloat64AddEXT,
};

struct CapabilityName {
  uint32_t value;
  const char* name;
};
constexpr CapabilityName kNames[] = {
#define PINEDA_SPIRV_OP(value, name, capabilities)
#define PINEDA_SPIRV_CAPABILITY(value, name) {value, name},
#include "compiler/spirv/names.inc"
#undef PINEDA_SPIRV_OP
#undef PINEDA_SPIRV_CAPABILITY
};

std::string name_of(uint32_t capability) {
  const auto* found = std::ranges::find(kNames, capability, &CapabilityName::value);
  return found != std::end(kNames) ? found->name : std::to_string(capability);
}

}  // namespace

void check_support(Module& m, const Instruction& inst) {
  if (inst.op() == spv::OpMemoryModel) {
    if (inst.word(1) != spv::AddressingModelLogical && inst.word(1) != spv::AddressingModelPhysicalStorageBuffer64) {
      inst.fail("only the Logical and PhysicalStorageBuffer64 addressing models are supported");
    }
    if (inst.word(2) != spv::MemoryModelGLSL450 && inst.word(2) != spv::MemoryModelVulkan) {
      inst.fail("only the GLSL450 and Vulkan memory models are supported");
    }
    return;
  }
  const auto capability = inst.word_as<spv::Capability>(1);
  if (std::ranges::find(kSupported, capability) == std::end(kSupported)) {
    inst.fail("capability " + name_of(inst.word(1)) + " is not supported");
  }
  m.variable_pointers |=
      capability == spv::CapabilityVariablePointers || capability == spv::CapabilityVariablePointersStorageBuffer;
}

void check_execution_mode(const Instruction& inst) {
  switch (inst.word_as<spv::ExecutionMode>(2)) {
    case spv::ExecutionModeOriginUpperLeft:
    case spv::ExecutionModeEarlyFragmentTests:
    case spv::ExecutionModeDepthReplacing:
    case spv::ExecutionModeDepthGreater:
    case spv::ExecutionModeDepthLess:
    case spv::ExecutionModeDepthUnchanged:
    case spv::ExecutionModeStencilRefReplacingEXT:
    case spv::ExecutionModeLocalSize:
    case spv::ExecutionModeLocalSizeId:
      return;
    case spv::ExecutionModeDenormPreserve:  // what the IR does anyway
    case spv::ExecutionModeSignedZeroInfNanPreserve:
    case spv::ExecutionModeRoundingModeRTE:
      return;
    case spv::ExecutionModeDenormFlushToZero:
    case spv::ExecutionModeRoundingModeRTZ:
      inst.fail("denormals are always kept and results rounded to nearest even");
    default:
      inst.fail("execution mode " + std::to_string(inst.word(2)) + " is not supported");
  }
}

}  // namespace pineda::spirv
