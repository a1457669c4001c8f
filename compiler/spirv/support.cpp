// What this translator accepts: the one table of capabilities. Everything else is refused by name.
#include <algorithm>

#include "compiler/spirv/module.h"

namespace pineda::spirv {
namespace {

struct CapabilityRow {
  spv::Capability capability;
  const char* name;
  bool supported;
};

#define YES(name) \
  { spv::Capability##name, #name, true }
#define NO(name) \
  { spv::Capability##name, #name, false }
// NO rows exist for their names only.
constexpr CapabilityRow kCapabilities[] = {
    YES(Matrix),
    YES(Shader),
    YES(ImageQuery),
    YES(DerivativeControl),
    YES(Sampled1D),
    YES(Image1D),
    YES(SampledCubeArray),
    YES(ImageCubeArray),
    YES(ImageGatherExtended),
    YES(StorageImageExtendedFormats),
    YES(StorageImageReadWithoutFormat),
    YES(StorageImageWriteWithoutFormat),
    YES(DrawParameters),
    YES(DemoteToHelperInvocationEXT),
    YES(SampleRateShading),
    YES(InputAttachment),
    YES(InterpolationFunction),
    YES(StencilExportEXT),
    YES(ClipDistance),
    YES(CullDistance),
    YES(MultiViewport),
    YES(ShaderLayer),
    YES(ShaderViewportIndex),
    YES(ShaderViewportIndexLayerEXT),
    YES(UniformBufferArrayDynamicIndexing),
    YES(StorageBufferArrayDynamicIndexing),
    YES(UniformTexelBufferArrayNonUniformIndexing),
    YES(StorageTexelBufferArrayNonUniformIndexing),
    YES(VulkanMemoryModel),
    YES(VulkanMemoryModelDeviceScope),
    YES(Float16),
    YES(Float64),
    YES(Int64),
    YES(Int16),
    YES(Int8),
    YES(StorageBuffer16BitAccess),
    YES(UniformAndStorageBuffer16BitAccess),
    YES(StoragePushConstant16),
    YES(StorageInputOutput16),
    YES(MultiView),
    YES(DeviceGroup),
    YES(VariablePointersStorageBuffer),
    YES(VariablePointers),
    YES(StorageBuffer8BitAccess),
    YES(UniformAndStorageBuffer8BitAccess),
    YES(StoragePushConstant8),
    YES(DenormPreserve),
    YES(SignedZeroInfNanPreserve),
    YES(RoundingModeRTE),
    YES(ShaderNonUniform),
    YES(UniformBufferArrayNonUniformIndexing),
    YES(StorageBufferArrayNonUniformIndexing),
    YES(PhysicalStorageBufferAddresses),
    YES(DotProduct),
    YES(DotProductInputAll),
    YES(DotProductInput4x8Bit),
    YES(DotProductInput4x8BitPacked),
    YES(GroupNonUniform),
    YES(GroupNonUniformVote),
    YES(GroupNonUniformArithmetic),
    YES(GroupNonUniformBallot),
    YES(GroupNonUniformShuffle),
    YES(GroupNonUniformShuffleRelative),
    YES(GroupNonUniformClustered),
    YES(GroupNonUniformQuad),
    YES(GroupNonUniformRotateKHR),
    YES(SubgroupBallotKHR),
    YES(SubgroupVoteKHR),
    NO(Geometry),
    NO(Tessellation),
    NO(Addresses),
    NO(Linkage),
    NO(Kernel),
    NO(Int64Atomics),
    NO(TessellationPointSize),
    NO(GeometryPointSize),
    NO(StorageImageMultisample),
    YES(SampledImageArrayDynamicIndexing),
    YES(StorageImageArrayDynamicIndexing),
    NO(SampledRect),
    NO(ImageRect),
    NO(GenericPointer),
    NO(SparseResidency),
    YES(MinLod),
    NO(ImageMSArray),
    YES(SampledBuffer),
    YES(ImageBuffer),
    NO(TransformFeedback),
    NO(GeometryStreams),
    NO(UniformDecoration),
    NO(DenormFlushToZero),
    NO(RoundingModeRTZ),
    NO(RayQueryKHR),
    NO(RayTracingKHR),
    NO(MeshShadingEXT),
    NO(StencilExportEXT),
    YES(RuntimeDescriptorArray),
    NO(InputAttachmentArrayDynamicIndexing),
    YES(UniformTexelBufferArrayDynamicIndexing),
    YES(StorageTexelBufferArrayDynamicIndexing),
    YES(SampledImageArrayNonUniformIndexing),
    YES(StorageImageArrayNonUniformIndexing),
    NO(FragmentShaderSampleInterlockEXT),
    NO(FragmentShaderPixelInterlockEXT),
    NO(ShaderClockKHR),
    NO(AtomicFloat32AddEXT),
    NO(WorkgroupMemoryExplicitLayoutKHR),
    NO(FragmentBarycentricKHR),
};
#undef YES
#undef NO

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
  const auto* row = std::ranges::find(kCapabilities, capability, &CapabilityRow::capability);
  const std::string name = row == std::end(kCapabilities) ? std::to_string(capability) : row->name;
  if (row == std::end(kCapabilities) || !row->supported) inst.fail("capability " + name + " is not supported");
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
