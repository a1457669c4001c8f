// The compiler's public interface: SPIR-V and pipeline state in, kernels out. Knows no Vulkan handle and no LLVM; tools and
// fuzzers need no device.
//
// Order of work for a graphics pipeline: spirv::parse each stage -> kernels/ build vertex and fragment kernel (the fragment
// kernel first: it tells which varyings are read) -> passes/ -> jit/ or eval/, as PINEDA_MODE says.
//
// Threads: every function may be called from several threads at once; the same kernel (by its IR's hash) is compiled once.
#pragma once

#include <vulkan/vulkan_core.h>

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/abi.h"
#include "compiler/error.h"
#include "compiler/ir/ir.h"
#include "compiler/spirv/translate.h"

namespace pineda::compiler {

// ---- pipeline layout ------------------------------------------------------------------------------------------------------

struct DescriptorBinding {
  uint32_t set, binding;
  VkDescriptorType type;
  uint32_t count;
  uint32_t offset_bytes;   // in the set's memory, of array element 0
  uint32_t stride_bytes;   // between array elements: sizeof(BufferDescriptor) or sizeof(ImageDescriptor) ...
  uint32_t dynamic_index;  // of element 0 in DrawContext::dynamic_offsets, for *_DYNAMIC types
};

struct PipelineLayout {
  std::vector<DescriptorBinding> bindings;
  uint32_t push_constant_bytes = 0;
};

// ---- state that selects code ----------------------------------------------------------------------------------------------
// Only what changes the code is here. Viewport, scissor, blend constants, stencil masks and references are data (DrawContext).

struct VertexAttribute {
  uint32_t location, binding;
  VkFormat format;
  uint32_t offset_bytes;
  bool operator==(const VertexAttribute&) const = default;
};

struct VertexBinding {
  uint32_t binding, stride_bytes;
  VkVertexInputRate rate;
  bool operator==(const VertexBinding&) const = default;
};

struct VertexState {
  std::vector<VertexAttribute> attributes;
  std::vector<VertexBinding> bindings;
};

struct BlendState {                       // of one colour attachment
  VkFormat format = VK_FORMAT_UNDEFINED;  // UNDEFINED: unused attachment
  bool blend_enable = false;
  VkBlendFactor src_color = VK_BLEND_FACTOR_ONE, dst_color = VK_BLEND_FACTOR_ZERO;
  VkBlendOp color_op = VK_BLEND_OP_ADD;
  VkBlendFactor src_alpha = VK_BLEND_FACTOR_ONE, dst_alpha = VK_BLEND_FACTOR_ZERO;
  VkBlendOp alpha_op = VK_BLEND_OP_ADD;
  VkColorComponentFlags write_mask = 0xf;
};

struct DepthState {
  VkFormat format = VK_FORMAT_UNDEFINED;  // of the attachment's depth aspect: see aspect_format() in base/format.h
  bool test_enable = false, write_enable = false;
  VkCompareOp compare = VK_COMPARE_OP_ALWAYS;
  bool bounds_test = false;
  bool unrestricted = false;  // VK_EXT_depth_range_unrestricted: depths of float formats are not clamped to [0, 1]
};

struct StencilFace {  // masks and reference are in the DrawContext
  VkStencilOp fail = VK_STENCIL_OP_KEEP, pass = VK_STENCIL_OP_KEEP, depth_fail = VK_STENCIL_OP_KEEP;
  VkCompareOp compare = VK_COMPARE_OP_ALWAYS;
  bool operator==(const StencilFace&) const = default;
};

struct StencilState {  // the attachment is S8_UINT, or the stencil aspect of a format with both
  bool test_enable = false;
  StencilFace front, back;
  bool writes() const {
    const auto keeps = [](const StencilFace& f) {
      return f.fail == VK_STENCIL_OP_KEEP && f.pass == VK_STENCIL_OP_KEEP && f.depth_fail == VK_STENCIL_OP_KEEP;
    };
    return test_enable && !(keeps(front) && keeps(back));
  }
};

struct FragmentState {
  std::array<BlendState, kMaxColorAttachments> color{};
  uint32_t color_count = 0;
  std::optional<VkLogicOp> logic_op;
  DepthState depth;
  StencilState stencil;
  bool depth_clamp = false;
  uint32_t samples = 1;           // of a pixel: 1, 2, 4, 8 or 16
  bool equal_samples = true;      // keep the colours of a block once while its samples are equal
  uint32_t sample_mask = 0xFFFF;  // bit s: sample s may be written
  bool sample_shading = false;    // the shader runs for each sample; otherwise it decides itself (SampleId ...)
  bool alpha_to_coverage = false, alpha_to_one = false;
  // Lines whose alpha is multiplied by the part of the pixel that they cover: waves are FragmentSampleWaves, with this part in
  // 1/65535 in place of masks of samples, and all samples of a pixel are covered.
  bool smooth_lines = false;
};

// A VkSamplerYcbcrConversion.
struct YcbcrState {
  VkFormat format = VK_FORMAT_UNDEFINED;  // of two or three planes
  VkSamplerYcbcrModelConversion model = VK_SAMPLER_YCBCR_MODEL_CONVERSION_RGB_IDENTITY;
  VkSamplerYcbcrRange range = VK_SAMPLER_YCBCR_RANGE_ITU_FULL;
  std::array<VkChromaLocation, 2> chroma_offset{};
  VkFilter chroma_filter = VK_FILTER_NEAREST;
  std::array<uint8_t, 4> swizzle{0, 1, 2, 3};  // as in TextureState; before the model's conversion
  bool operator==(const YcbcrState&) const = default;
};

// What is bound to one image use: code depends on it, so a pipeline that samples is compiled when a draw first shows it.
struct TextureState {
  VkFormat format = VK_FORMAT_UNDEFINED;
  VkImageViewType view_type = VK_IMAGE_VIEW_TYPE_2D;
  std::array<uint8_t, 4> swizzle{0, 1, 2, 3};  // source component of each result; 4 = zero, 5 = one
  bool single_level = false;                   // the view has one level: no LOD is computed
  VkFilter mag_filter = VK_FILTER_NEAREST, min_filter = VK_FILTER_NEAREST;
  VkSamplerMipmapMode mipmap_mode = VK_SAMPLER_MIPMAP_MODE_NEAREST;
  std::array<VkSamplerAddressMode, 3> address{};
  VkBorderColor border = VK_BORDER_COLOR_FLOAT_TRANSPARENT_BLACK;  // value in the descriptor; here for int/float
  bool unnormalized = false;
  bool anisotropy = false;  // more than one probe; how many at most is in the descriptor
  VkSamplerReductionMode reduction = VK_SAMPLER_REDUCTION_MODE_WEIGHTED_AVERAGE;
  bool compare_enable = false;
  VkCompareOp compare = VK_COMPARE_OP_NEVER;
  std::optional<YcbcrState> ycbcr;  // the sampler's; `format` is then that of the first plane
  bool operator==(const TextureState&) const = default;
};

struct TextureUse {  // key: which descriptor, what is bound
  spirv::ImageRef image, sampler;
  TextureState state;
  bool operator==(const TextureUse&) const = default;
};

// ---- kernels --------------------------------------------------------------------------------------------------------------

// Executable code and what it was made from. Shared between pipelines; constant once finish() has succeeded.
class Kernel {
 public:
  virtual ~Kernel() = default;
  // Runs the back end unless it has run: `handle` is valid afterwards. Thread-safe; who comes second waits for the first and gets
  // the same answer.
  virtual Result<void> finish() = 0;
  // The same for a helper thread: returns at once when another thread is at it.
  virtual void finish_unless_begun() = 0;
  KernelHandle handle;
  ir::Kernel ir;  // after all passes: what the handle runs
};
using KernelPtr = std::shared_ptr<Kernel>;

// Who has other threads run back ends: is given each kernel whose back end has not run, as soon as it exists, and should have
// Kernel::finish_unless_begun called. Kernel::finish is then for whoever runs the kernel to call, before it does.
using CodeGenerator = std::function<void(const KernelPtr& kernel)>;

struct VaryingSlot {  // a component that the fragment kernel reads from the vertex record
  uint32_t location, component;
  bool operator==(const VaryingSlot&) const = default;
};

class CodeStore;  // code_store.h

struct GraphicsSource {
  const spirv::Module* vertex = nullptr;
  const spirv::Module* fragment = nullptr;  // null: depth only
  const PipelineLayout* layout = nullptr;
  VertexState vertex_input;
  FragmentState state;
  bool draws_points = false;                 // point lists, or polygon mode POINT: the point size matters
  std::span<const TextureUse> textures;      // of both stages; every spirv::ImageUse that samples must have one
  std::string name;                          // for dumps
  CodeStore* store = nullptr;                // asked before a kernel is compiled, told afterwards
  const CodeGenerator* generator = nullptr;  // null: kernels are finished when they are returned
};

struct GraphicsKernels {
  KernelPtr vertex;
  KernelPtr fragment;         // never null: without a fragment shader it tests and writes depth
  uint32_t vertex_slots = 4;  // components per vertex record: 4 (position) + varyings + outputs
  VertexOutputs outputs;
  bool early_depth = true;  // the test runs before the shader, so raster may reject by Hi-Z
  // Of late tests: how the depth that is tested compares with the interpolated one, which the kernel makes sure of.
  spirv::DepthMode late_depth = spirv::DepthMode::kAny;
  bool reads_color = false;       // some attachment's old value matters (blend or partial write mask)
  bool opaque = false;            // a fully covered block replaces every attachment's value, nothing can discard
  bool has_side_effects = false;  // storage writes: nothing may be left out
  bool per_sample = false;        // with several samples: the kernel takes a FragmentWave for each sample
};

struct ComputeSource {
  const spirv::Module* module = nullptr;
  const PipelineLayout* layout = nullptr;
  std::span<const TextureUse> textures;
  std::string name;
  CodeStore* store = nullptr;
  const CodeGenerator* generator = nullptr;
};

struct ComputeKernel {
  KernelPtr kernel;
  std::array<uint32_t, 3> local_size{};
  uint32_t shared_memory_bytes = 0;
  uint64_t wave_frame_bytes = 0;  // of ThreadContext::wave_frames, for each wave of a workgroup
};

Result<GraphicsKernels> compile_graphics(const GraphicsSource& source);
Result<ComputeKernel> compile_compute(const ComputeSource& source);

// From several samples a pixel to one (raster::Attachment::resolve): `format` is a plain colour, depth or stencil format.
Result<KernelPtr> compile_resolve(VkFormat format, uint32_t samples, VkResolveModeFlagBits mode);

// Runs passes and back end on a finished kernel (tests, internal kernels).
Result<KernelPtr> compile_kernel(ir::Kernel kernel);

// PINEDA_MODE=check, so far: kernel calls that ran both ways, bytes they stored, and those of them in which machine code and
// evaluator differed. Each call that differs is reported as well.
struct CheckStatistics {
  uint64_t calls, bytes, differing_bytes;
};
CheckStatistics check_statistics();

}  // namespace pineda::compiler
