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
    NO(Geometry),
    NO(Tessellation),
    NO(Addresses),
    NO(Linkage),
    NO(Kernel),
    NO(Float16),
    NO(Float64),
    NO(Int64),
    NO(Int64Atomics),
    NO(Int16),
    NO(Int8),
    NO(TessellationPointSize),
    NO(GeometryPointSize),
    NO(StorageImageMultisample),
    YES(SampledImageArrayDynamicIndexing),
    YES(StorageImageArrayDynamicIndexing),
    NO(SampledRect),
    NO(ImageRect),
    NO(GenericPointer),
    NO(InputAttachment),
    NO(SparseResidency),
    YES(MinLod),
    NO(ImageMSArray),
    YES(SampledBuffer),
    YES(ImageBuffer),
    NO(InterpolationFunction),
    NO(TransformFeedback),
    NO(GeometryStreams),
    NO(GroupNonUniform),
    NO(GroupNonUniformVote),
    NO(GroupNonUniformArithmetic),
    NO(GroupNonUniformBallot),
    NO(GroupNonUniformShuffle),
    NO(GroupNonUniformShuffleRelative),
    NO(GroupNonUniformClustered),
    NO(GroupNonUniformQuad),
    NO(UniformDecoration),
    NO(SubgroupBallotKHR),
    NO(SubgroupVoteKHR),
    NO(StorageBuffer16BitAccess),
    NO(UniformAndStorageBuffer16BitAccess),
    NO(StoragePushConstant16),
    NO(StorageInputOutput16),
    NO(DeviceGroup),
    NO(MultiView),
    NO(VariablePointersStorageBuffer),
    NO(VariablePointers),
    NO(StorageBuffer8BitAccess),
    NO(UniformAndStorageBuffer8BitAccess),
    NO(StoragePushConstant8),
    NO(DenormPreserve),
    NO(DenormFlushToZero),
    NO(SignedZeroInfNanPreserve),
    NO(RoundingModeRTE),
    NO(RoundingModeRTZ),
    NO(RayQueryKHR),
    NO(RayTracingKHR),
    NO(MeshShadingEXT),
    NO(StencilExportEXT),
    YES(ShaderNonUniform),
    YES(RuntimeDescriptorArray),
    NO(InputAttachmentArrayDynamicIndexing),
    YES(UniformTexelBufferArrayDynamicIndexing),
    YES(StorageTexelBufferArrayDynamicIndexing),
    YES(UniformBufferArrayNonUniformIndexing),
    YES(SampledImageArrayNonUniformIndexing),
    YES(StorageBufferArrayNonUniformIndexing),
    YES(StorageImageArrayNonUniformIndexing),
    NO(PhysicalStorageBufferAddresses),
    NO(FragmentShaderSampleInterlockEXT),
    NO(FragmentShaderPixelInterlockEXT),
    NO(ShaderClockKHR),
    NO(AtomicFloat32AddEXT),
    NO(DotProduct),
    NO(DotProductInputAll),
    NO(DotProductInput4x8Bit),
    NO(DotProductInput4x8BitPacked),
    NO(WorkgroupMemoryExplicitLayoutKHR),
    NO(FragmentBarycentricKHR),
    NO(ShaderViewportIndexLayerEXT),
};
#undef YES
#undef NO

}  // namespace

void check_support(const Instruction& inst) {
  if (inst.op() == spv::OpMemoryModel) {
    if (inst.word(1) != spv::AddressingModelLogical) inst.fail("only the Logical addressing model is supported");
    if (inst.word(2) != spv::MemoryModelGLSL450 && inst.word(2) != spv::MemoryModelVulkan) {
      inst.fail("only the GLSL450 and Vulkan memory models are supported");
    }
    return;
  }
  const auto capability = inst.word_as<spv::Capability>(1);
  const auto* row = std::ranges::find(kCapabilities, capability, &CapabilityRow::capability);
  const std::string name = row == std::end(kCapabilities) ? std::to_string(capability) : row->name;
  if (row == std::end(kCapabilities) || !row->supported) inst.fail("capability " + name + " is not supported");
}

void check_execution_mode(const Instruction& inst) {
  switch (inst.word_as<spv::ExecutionMode>(2)) {
    case spv::ExecutionModeOriginUpperLeft:
    case spv::ExecutionModeEarlyFragmentTests:
    case spv::ExecutionModeDepthReplacing:
    case spv::ExecutionModeDepthGreater:
    case spv::ExecutionModeDepthLess:
    case spv::ExecutionModeDepthUnchanged:
    case spv::ExecutionModeLocalSize:
    case spv::ExecutionModeLocalSizeId:
      return;
    default:
      inst.fail("execution mode " + std::to_string(inst.word(2)) + " is not supported");
  }
}

}  // namespace pineda::spirv
