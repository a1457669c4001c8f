// SPIR-V -> IR. The entry point is inlined, as straight IR, at the place where a kernel's Builder stands; a StageInterface
// answers what only the kernel knows (where inputs come from, how an image is sampled). So fetch, shader and blending are one
// kernel for the passes to optimise.
//
// Input is untrusted: any word sequence gives an error or IR that verify() accepts, never a crash or a read outside `words`.
#pragma once

#include <vulkan/vulkan_core.h>

#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "compiler/error.h"
#include "compiler/ir/builder.h"

namespace pineda::spirv {

struct SpecializationConstant {
  uint32_t id;                 // SpecId
  std::vector<uint8_t> bytes;  // 1, 2, 4 or 8
};

struct ShaderSource {
  std::span<const uint32_t> words;
  std::string entry_point;
  VkShaderStageFlagBits stage;
  std::span<const SpecializationConstant> specialization;
};

enum class BuiltIn : uint8_t {
  kPosition,
  kPointSize,
  kVertexIndex,
  kInstanceIndex,
  kBaseVertex,
  kBaseInstance,
  kDrawIndex,
  kFragCoord,
  kFrontFacing,
  kPointCoord,
  kPrimitiveId,
  kLayer,
  kViewportIndex,
  kSampleId,
  kSamplePosition,
  kSampleMask,
  kFragDepth,
  kFragStencilRef,
  kHelperInvocation,
  kNumWorkgroups,
  kWorkgroupId,
  kLocalInvocationId,
  kGlobalInvocationId,
  kLocalInvocationIndex,
  kViewIndex,
  kSubgroupSize,
  kSubgroupLocalInvocationId,
  kSubgroupId,
  kNumSubgroups,
  kSubgroupEqMask,
  kSubgroupGeMask,
  kSubgroupGtMask,
  kSubgroupLeMask,
  kSubgroupLtMask,
  kClipDistance,
  kCullDistance
};

enum class Interpolation : uint8_t { kPerspective, kNoPerspective, kFlat };
enum class InterpolationAt : uint8_t { kCenter, kCentroid, kSample };

// One scalar of a shader interface. Arrays, matrices and blocks are flattened to (location, component) by the translator.
struct InterfaceScalar {
  std::optional<BuiltIn> built_in;  // then component is its element and location is unused
  uint32_t location = 0;
  uint32_t component = 0;  // 0..3
  uint32_t index = 0;      // fragment outputs: 1 = second source of dual-source blending
  ir::Type type = ir::Type::kF32;
  Interpolation interpolation = Interpolation::kPerspective;
  InterpolationAt at = InterpolationAt::kCenter;
  bool operator==(const InterfaceScalar&) const = default;
};

struct BufferRef {
  ir::Value base;          // Ptr, draw rate unless the binding is indexed by a varying value
  ir::Value size_bytes;    // I32
  bool read_only = false;  // uniform buffers: loads are kInvariant
};

struct ImageRef {
  uint32_t set = 0, binding = 0;
  uint32_t array_index = 0;  // when it is constant
  ir::Value index;           // I32, otherwise; it may vary by lane, and may be out of range
  bool operator==(const ImageRef&) const = default;
};

enum class LodMode : uint8_t { kImplicit, kExplicit, kGradient, kFetch };

struct SampleRequest {
  ImageRef image;
  ImageRef sampler;                  // equal to image for a combined image sampler
  VkImageViewType view_type;         // what the shader declared
  ir::Type result = ir::Type::kF32;  // kF32 or kI32
  LodMode lod_mode = LodMode::kImplicit;
  std::array<ir::Value, 4> coord{};  // u, v, w/face.., then layer; I32 for kFetch; projective division already done
  ir::Value lod;                     // explicit LOD (F32) or fetch level (I32)
  ir::Value bias;                    // F32, kImplicit and kGradient
  ir::Value min_lod;                 // F32, the MinLod operand
  std::array<ir::Value, 3> ddx{}, ddy{};
  std::array<int32_t, 3> offset{};            // constant texel offset
  std::array<ir::Value, 3> dynamic_offset{};  // I32, of gathers: replaces `offset` where it is set
  ir::Value sample;                           // I32, fetches of multisampled images
  ir::Value depth_reference;                  // set: comparison sampling
  int32_t gather_component = -1;              // 0..3: gather
};

struct ImageQuery {
  // What the four values of the answer are:
  enum class Kind : uint8_t {
    kSize,    // I32 width, height, depth, array layers (a cube array counts faces; the translator divides)
    kLevels,  // I32 level count, -, -, -
    kLod,     // F32 level that would be accessed, LOD relative to the base level, -, -
    kSamples  // I32 sample count, -, -, -
  } kind;
  ImageRef image;
  ir::Value lod;                                      // kSize of a mipmapped image (I32); unset: level 0
  ImageRef sampler;                                   // kLod
  VkImageViewType view_type = VK_IMAGE_VIEW_TYPE_2D;  // what the shader declared
  std::array<ir::Value, 4> coord{};                   // kLod: u, v, w without the layer
};

struct ImageAccess {  // storage images
  ImageRef image;
  VkImageViewType view_type;
  VkFormat format;  // declared in the shader, or VK_FORMAT_UNDEFINED
  ir::Type component = ir::Type::kF32;
  bool is_signed = false;  // of integer components
  std::array<ir::Value, 4> coord{};
  ir::Value sample;  // I32, multisampled images
};

// Where in its pixel an input is evaluated (GLSL.std.450 InterpolateAt*): the centroid; sample number `sample` (I32); or `offset`
// (F32, px) from the centre.
struct InterpolationPlace {
  bool centroid = false;
  ir::Value sample;
  std::array<ir::Value, 2> offset{};
};

// Implemented by compiler/kernels. Every call appends to `b` at its current place; an unset Value or empty optional means
// "not supported here", and the translator turns it into an error that names the instruction.
class StageInterface {
 public:
  virtual ~StageInterface() = default;
  virtual ir::Value input(ir::Builder& b, const InterfaceScalar& in) = 0;
  // Fragment stage: a located input at another place of the pixel.
  virtual ir::Value input_at(ir::Builder&, const InterfaceScalar&, const InterpolationPlace&) { return {}; }
  // Called once for each output scalar when every invocation has left the entry point.
  virtual void output(ir::Builder& b, const InterfaceScalar& out, ir::Value value) = 0;
  // Buffer binding or push constants (set == kPushConstants). array_index is I32 and below the declared array length.
  static constexpr uint32_t kPushConstants = ~0u;
  virtual std::optional<BufferRef> buffer(ir::Builder& b, uint32_t set, uint32_t binding, ir::Value array_index) = 0;
  virtual std::optional<std::array<ir::Value, 4>> sample(ir::Builder& b, const SampleRequest& request) = 0;
  virtual std::optional<std::array<ir::Value, 4>> query(ir::Builder& b, const ImageQuery& query) = 0;
  virtual std::optional<std::array<ir::Value, 4>> image_load(ir::Builder& b, const ImageAccess& access) = 0;
  // Where a texel of a 32- or 64-bit format of one component is, for atomics (access.format is declared). The limit is 0 where
  // the coordinate is outside.
  virtual std::optional<ir::Address> image_texel(ir::Builder&, const ImageAccess&) { return std::nullopt; }
  virtual bool image_store(ir::Builder& b, const ImageAccess& access, std::span<const ir::Value> texel) = 0;
  // Fragment stage: B1, lanes whose effects count (covered and not yet discarded). Stores of the shader are guarded by it.
  // Unset for other stages.
  virtual ir::Value covered(ir::Builder& b) = 0;
  // PhysicalStorageBuffer: the table of AddressRanges (Ptr) and its length (I32). Unset: not supported here.
  virtual std::array<ir::Value, 2> address_ranges(ir::Builder&) { return {}; }
  // Compute: Ptr to the workgroup's shared memory (size_bytes from ModuleInfo).
  virtual ir::Value shared_memory(ir::Builder& b) = 0;
};

// What a fragment shader promises of the depth that it exports, compared with the interpolated one.
enum class DepthMode : uint8_t { kAny, kGreater, kLess, kUnchanged };  // kGreater: or equal ...

// What a pipeline must know before kernels are built.
struct ImageUse {
  ImageRef image, sampler;
  bool sampled = false;  // with a sampler (also fetch); otherwise storage
  VkImageViewType view_type;
  bool dynamic = false;  // an index of image or sampler is not constant
};

struct ModuleInfo {
  // In (location, component) order, built-ins first: inputs that the entry point's call tree uses; outputs that it declares,
  // built-in ones only when they are written.
  std::vector<InterfaceScalar> inputs, outputs;
  std::vector<ImageUse> images;
  std::array<uint32_t, 3> local_size{1, 1, 1};  // specialised
  uint32_t shared_memory_bytes = 0;
  bool uses_discard = false;   // OpKill, OpTerminateInvocation, OpDemoteToHelperInvocation
  bool writes_memory = false;  // storage buffers, images or atomics
  bool early_fragment_tests = false;
  bool writes_depth = false;
  DepthMode depth_mode = DepthMode::kAny;
  bool uses_derivatives = false;
  bool uses_barriers = false;
};

class Module;  // parsed and checked; immutable

struct ModuleDeleter {
  void operator()(Module*) const;
};
using ModulePtr = std::unique_ptr<Module, ModuleDeleter>;

// Parses, checks structure and capabilities, applies specialization.
Result<ModulePtr> parse(const ShaderSource& source);
const ModuleInfo& info(const Module& module);

struct Translation {
  ir::Value discarded;  // B1, lanes that OpKill (or demote) ended; unset when info().uses_discard is false
};

// Inlines the entry point at `b`. On error the kernel under construction must be thrown away.
Result<Translation> translate(const Module& module, ir::Builder& b, StageInterface& stage);

}  // namespace pineda::spirv
