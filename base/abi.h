// The structs that JIT-compiled kernels, the evaluator, the rasterizer and the driver share.
//
// Everything here is plain data with a fixed layout: kernels address the fields by byte offset (offsetof), so the order of
// members is an interface. No Vulkan handles, no LLVM, no ownership: every pointer is borrowed for the duration of the call.
//
// A kernel is one function that runs three nested loops:
//
//     draw-rate code                      once per call
//     for each PrimRecord p:              a triangle (fragment), a batch (vertex), a workgroup (compute)
//         primitive-rate code             scalar registers
//         for each wave of p:             16 lanes
//             wave- and lane-rate code
//
// Lanes of a fragment wave cover a 4x4 block as four 2x2 quads in Z order; a tile buffer stores a block in this order, so one
// 32-bit attachment block is 64 contiguous bytes (8- and 16-bit texels: 16 or 32 bytes; 64- and 128-bit texels: 2 or 4 planes of
// 64 bytes, plane w holding the w-th 32-bit word of each lane's texel):
//
//        x 0  1  2  3
//     y 0  0  1  4  5        quad q = lane >> 2,  x = (lane & 1) + 2 * (q & 1)
//       1  2  3  6  7                             y = ((lane >> 1) & 1) + 2 * (q >> 1)
//       2  8  9 12 13
//       3 10 11 14 15
#pragma once

#include <cstddef>
#include <cstdint>

namespace pineda {

inline constexpr uint32_t kLanes = 16;  // lanes per wave = subgroupSize, on every ISA
inline constexpr uint32_t kMaxSets = 8;
inline constexpr uint32_t kMaxDynamicOffsets = 32;
inline constexpr uint32_t kMaxPushConstantBytes = 256;
inline constexpr uint32_t kMaxVertexBindings = 32;
inline constexpr uint32_t kMaxVertexAttributes = 32;
inline constexpr uint32_t kMaxColorAttachments = 8;
inline constexpr uint32_t kMaxViewports = 16;
inline constexpr uint32_t kMaxClipDistances = 8;          // clip and cull distances together
inline constexpr uint32_t kMaxMipLevels = 15;             // 16384 px
inline constexpr uint32_t kVertexSlotBytes = kLanes * 4;  // one f32/i32 component of 16 vertices
inline constexpr uint32_t kBlockDim = 4;                  // a fragment wave covers kBlockDim x kBlockDim pixels

// ---- kernels --------------------------------------------------------------------------------------------------------------

// One entry of the middle loop. The waves of this entry are records [first_wave, first_wave + wave_count) of the wave array.
struct PrimRecord {
  const void* prim;  // FragmentPrim, WorkgroupRecord, or null for vertex kernels
  uint32_t first_wave;
  uint32_t wave_count;
};
static_assert(sizeof(PrimRecord) == 16);

struct KernelHandle;

// Thread-safe: a kernel has no state of its own. `thread` points to a ThreadContext that only this thread uses.
using KernelFn = void (*)(const KernelHandle* self, const void* draw, void* thread, const PrimRecord* prims, uint32_t prim_count,
                          const void* waves);

// How raster and icd hold a kernel, whether machine code or the evaluator runs it. Lives as long as its pipeline.
struct KernelHandle {
  KernelFn fn = nullptr;
  const void* self = nullptr;  // the evaluator's eval::Program; unused by machine code

  void operator()(const void* draw, void* thread, const PrimRecord* prims, uint32_t prim_count, const void* waves) const {
    fn(this, draw, thread, prims, prim_count, waves);
  }
};

// ---- descriptors ----------------------------------------------------------------------------------------------------------

// Uniform and storage buffers, with or without dynamic offset. A null buffer has size_bytes == 0.
struct BufferDescriptor {
  uint64_t address;
  uint32_t size_bytes;  // the range that the shader may touch; larger ranges are clamped to 4 GiB - 1
  uint32_t reserved;
};
static_assert(sizeof(BufferDescriptor) == 16);

struct MipLevel {
  uint32_t offset_bytes;  // from ImageDescriptor::address, of layer 0
  uint32_t row_pitch_bytes;
};

// Sampled, storage and combined images (with the sampler's data words behind the image's). What selects code (format, filter,
// address modes) is in compiler/compile.h's TextureState and never read by a kernel; what is only data is here.
struct ImageDescriptor {
  uint64_t address;               // of the view's first level and layer
  uint32_t size_bytes;            // bytes that may be read from address on; 0 for a null image (reads give zero)
  uint32_t width, height, depth;  // of the view's first level, texels; depth of a multisampled image: its samples
  uint32_t level_count, layer_count;
  uint32_t layer_pitch_bytes;
  uint32_t state_id;  // of the view's half of compiler::TextureState, for SampleCall; 0: never written, or null
  uint32_t format;    // VkFormat of the texels, for storage images that a shader declares without one
  uint32_t reserved;
  MipLevel levels[kMaxMipLevels + 1];  // relative to the view's base level
  // sampler words; unused for storage images
  float lod_bias, min_lod, max_lod, max_anisotropy;
  float border[4];
  uint32_t sampler_state_id;
  uint32_t sampler_reserved[3];
};
static_assert(offsetof(ImageDescriptor, levels) == 48 && sizeof(ImageDescriptor) == 48 + 16 * 8 + 48);

// A separate sampler, laid out like the tail of ImageDescriptor.
struct SamplerDescriptor {
  float lod_bias, min_lod, max_lod, max_anisotropy;
  float border[4];
  uint32_t state_id;  // of the sampler's half of compiler::TextureState; 0: never written, or null
  uint32_t reserved[3];
};
static_assert(offsetof(ImageDescriptor, sampler_state_id) - offsetof(ImageDescriptor, lod_bias) ==
              offsetof(SamplerDescriptor, state_id));

// ---- sampling of what is not known when the kernel is compiled --------------------------------------------------------------
// A kernel that was not specialised for its textures fills in the record of its thread and calls DrawContext::sample on it
// (ir::Op::kCall). That finds the function for the state of each lane's descriptors, compiles it if it is the first to ask
// (compiler/sample_functions.h), and calls it on the same record: the function is a kernel too, and the record is its wave.

enum SampleRow : uint32_t {  // rows of SampleCall::argument
  kRowCoord = 0,             // u, v, w and layer; I32 for fetches
  kRowLod = 4,               // bias, explicit LOD (F32) or level (I32)
  kRowDdx = 5,
  kRowDdy = 8,
  kRowReference = 11,
  kRowOffset = 12,  // I32, texels
  kRowMinLod = 15,
  kRowSample = 16,  // I32
  kSampleRows = 17
};

struct SampleCall {
  uint32_t mask;  // active lanes; other lanes' arguments are unspecified, their results stay as they were
  uint32_t reserved;
  uint64_t signature;                          // which operation (kernels::SampleSignature)
  uint64_t image, sampler;                     // ImageDescriptor and sampler words of this call, set by whoever splits it
  alignas(64) uint64_t image_of_lane[kLanes];  // as the caller asks
  alignas(64) uint64_t sampler_of_lane[kLanes];
  alignas(64) uint32_t argument[kSampleRows][kLanes];
  alignas(64) uint32_t result[4][kLanes];
};

// ---- the draw-rate block --------------------------------------------------------------------------------------------------

struct VertexBufferBinding {
  uint64_t address;
  uint32_t size_bytes;  // bytes from address to the buffer's end; reads past it give zero (robustBufferAccess)
  uint32_t reserved;
};

// Memory that was allocated for device addresses, at most 4 GiB - 1: a larger allocation has several, each up to where 32-bit
// offsets reach.
struct AddressRange {
  uint64_t address;
  uint32_t size_bytes;
  uint32_t reserved;
};
static_assert(sizeof(AddressRange) == 16);

// Bound state of one draw or dispatch; read-only while kernels run.
struct DrawContext {
  const void* sets[kMaxSets];                    // descriptor memory of each bound set
  uint32_t dynamic_offsets[kMaxDynamicOffsets];  // bytes, indexed by DescriptorBinding::dynamic_index
  uint8_t push_constants[kMaxPushConstantBytes];
  VertexBufferBinding vertex_buffers[kMaxVertexBindings];
  float blend_constants[4];
  uint32_t first_vertex, first_instance, draw_index;  // gl_BaseVertex (vertexOffset as two's complement), gl_BaseInstance
  uint32_t count_samples;  // 1: an occlusion query is active, and fragment kernels add to ThreadContext::samples_passed
  uint32_t stencil_reference[2], stencil_compare_mask[2], stencil_write_mask[2];  // front, back
  float depth_bounds[2];
  float depth_range[kMaxViewports][2];  // the lower and the upper end of each viewport's depths: what depth clamp clamps to
  uint32_t workgroup_count[3];
  uint32_t view_index;                 // gl_ViewIndex of this run over the draw
  const AddressRange* address_ranges;  // what PhysicalStorageBuffer pointers may reach; addresses ascend
  uint32_t address_range_count, reserved;
  const float* srgb_decode;  // base/srgb.h: set_srgb_tables fills both
  const uint32_t* srgb_encode;
  const KernelHandle* sample;  // samples by descriptor: wave records are SampleCalls
};
static_assert(sizeof(DrawContext) % 8 == 0);

// Per-thread pointers that a kernel writes through. With N samples a pixel, a block is N blocks in memory, one for each sample.
struct ThreadContext {
  uint8_t* color[kMaxColorAttachments];  // tile buffers: sample s of block b of attachment a is at color[a] + (b * N + s) * 16 *
                                         // bytes per texel, in the attachment's own format (lane order above)
  uint8_t* depth;                        // formats with both aspects keep them apart: here X8_D24 or D32,
  uint8_t* stencil;                      // here S8
  uint64_t samples_passed;               // occlusion counter
  uint8_t* equal_samples;  // N > 1: one byte a block; 1: the samples of each colour are equal, and only sample 0 is in its buffer
  uint8_t* wave_frames;    // compute kernels with barriers: what each wave keeps across them, compile.h's wave_frame_bytes a
                           // wave; aligned to 64 bytes
  SampleCall sample_call;  // scratch
};

// ---- vertex kernels -------------------------------------------------------------------------------------------------------

// 16 vertices. The kernel stores component slot s of lane l at out + s * kVertexSlotBytes + l * 4. Slots 0..3 are
// gl_Position's clip coordinates; the pipeline's varyings follow in the order of compile.h's VaryingSlot list.
struct VertexWave {
  uint32_t mask;  // bit l: lane l holds a vertex; other lanes run nothing
  uint32_t reserved;
  float* out;
  uint32_t vertex_index[kLanes];    // gl_VertexIndex (vertexOffset included)
  uint32_t instance_index[kLanes];  // gl_InstanceIndex (firstInstance included)
};
static_assert(sizeof(VertexWave) == 144);

// Slots of the built-in outputs that geometry reads; 0 where the shader writes none. Distances lie in consecutive slots.
struct VertexOutputs {
  uint16_t point_size = 0;
  uint16_t layer = 0, viewport_index = 0;  // I32
  uint16_t clip_distance = 0, clip_count = 0;
  uint16_t cull_distance = 0, cull_count = 0;
};

// ---- fragment kernels -----------------------------------------------------------------------------------------------------

// What a fragment kernel knows of its triangle. Screen-space barycentrics are linear in the pixel and relative to vertex 0:
//     l1(x, y) = l1_dx * (x - x0) + l1_dy * (y - y0)        l2 likewise;   l0 = 1 - l1 - l2
//     z        = z0 + l1 * dz1 + l2 * dz2                   (depth range applied, bias included)
//     1/w      = iw0 + l1 * (iw1 - iw0) + l2 * (iw2 - iw0)
//     b0       = l0 * iw0 * w, b2 = l2 * iw2 * w            perspective-correct
//     attribute = a1 + b0 * (a0 - a1) + b2 * (a2 - a1)
// and where all iw are equal, with b1 = l1 * iw1 * w, or l for b when noperspective,
//     attribute = a0 + b1 * (a1 - a0) + b2 * (a2 - a0)
// Where iw differ much, vertex 0 is the farthest and vertex 1 the nearest (raster/triangle_record.h).
// x - x0 is exact in f32: both are multiples of 1/256 px below 2^15.
//
// A line is the case l2 = 0 or vertex 2 = vertex 0: l1 goes along it from 0 to 1. A point's vertices are all the same, and l1, l2
// are gl_PointCoord.
struct FragmentPrim {
  float x0_px, y0_px;
  float l1_dx, l1_dy, l2_dx, l2_dy;  // 1/px
  float z0, dz1, dz2;
  float iw0, iw1, iw2;     // 1/w of each vertex
  const float* vertex[3];  // slot 0 of the vertex (lane offset applied); slot s is s * kVertexSlotBytes further.
                           // Flat inputs read the provoking vertex: vertex[0] + flat_offset_bytes.
  uint32_t front_facing;   // 0 or 1
  uint32_t primitive_id;
  uint32_t layer, viewport_index;
  uint32_t reserved;
  int32_t flat_offset_bytes;  // from vertex[0] to the provoking vertex; mostly 0
};
static_assert(sizeof(FragmentPrim) == 96);

// One 4x4 block. All 16 lanes execute (uncovered ones as helpers); only covered ones have effects.
struct FragmentWave {
  uint32_t exec_mask;    // 0xFFFF
  uint32_t coverage;     // bit l: lane l is covered
  uint16_t x_px, y_px;   // framebuffer position of the block's top left pixel
  uint32_t block_index;  // of the block in the tile buffers; for kernels that run for each sample, b * N + s
};
static_assert(sizeof(FragmentWave) == 16);

// The same with N > 1 samples a pixel, for kernels that run once for each pixel.
struct FragmentSampleWave {
  FragmentWave wave;         // a lane is covered when one of its samples is
  uint16_t samples[kLanes];  // bit s: sample s of the lane is covered
};
static_assert(sizeof(FragmentSampleWave) == 48);

// ---- compute kernels ------------------------------------------------------------------------------------------------------

struct WorkgroupRecord {
  uint32_t id[3];
  uint32_t reserved;
  void* shared_memory;
};

struct ComputeWave {
  uint32_t mask;
  uint32_t first_invocation;  // gl_LocalInvocationIndex of lane 0
};
static_assert(sizeof(ComputeWave) == 8);

}  // namespace pineda
