// The rasterizer's public interface: render passes, dispatches, transfers. It receives resolved pointers and kernels
// (base/abi.h), never objects whose lifetime an application controls, and knows neither LLVM nor Vulkan handles.
//
// A pass runs in two phases on the pool: geometry (batches of primitives -> vertex kernel -> clip, cull, setup -> bins), then
// tiles (each tile: load or clear, triangles in API order -> coverage -> fragment kernel, store). When the bins outgrow their
// budget the pass is flushed in between, which no bit shows because attachments keep their own precision in a tile.
#pragma once

#include <vulkan/vulkan_core.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "base/abi.h"
#include "raster/thread_pool.h"

namespace pineda::raster {

// ---- render passes --------------------------------------------------------------------------------------------------------

// One attachment's memory: level and layer are already chosen; texel (x, y) is at address + y * row_pitch_bytes + x * texel
// bytes.
struct Attachment {
  uint8_t* address = nullptr;  // null: unused
  uint32_t row_pitch_bytes = 0;
  VkFormat format = VK_FORMAT_UNDEFINED;
  VkAttachmentLoadOp load = VK_ATTACHMENT_LOAD_OP_LOAD;
  VkAttachmentStoreOp store = VK_ATTACHMENT_STORE_OP_STORE;
  VkClearValue clear{};
  uint32_t samples = 1;
  size_t layer_pitch_bytes = 0;  // from one layer's texels to the next's
  // With several samples a pixel:
  size_t sample_pitch_bytes = 0;  // from one sample's texels to the next's
  KernelHandle resolve;           // from the samples of a block to one texel (compiler::compile_resolve); null: no resolve
  uint8_t* resolve_address = nullptr;
  uint32_t resolve_row_pitch_bytes = 0;
  size_t resolve_layer_pitch_bytes = 0;
};

struct PassDesc {
  VkExtent2D extent{};     // of the framebuffer
  VkRect2D render_area{};  // clears, loads and stores stay inside it
  std::array<Attachment, kMaxColorAttachments> color{};
  uint32_t color_count = 0;
  Attachment depth, stencil;  // the aspects of a format with both are attachments of their own: aspect_format() in base/format.h
  uint32_t samples = 1;       // of every attachment
  uint32_t layers = 1;        // of every attachment; a vertex shader's gl_Layer chooses
};

struct IndexBuffer {
  const uint8_t* address = nullptr;  // of index 0; null: not indexed
  uint64_t size_bytes = 0;           // indices past the end read as 0
  VkIndexType type = VK_INDEX_TYPE_UINT16;
};

// Viewports and scissors when there are several; the first is also in the packet.
struct ViewportArray {
  uint32_t count = 0;
  std::array<VkViewport, kMaxViewports> viewport{};
  std::array<VkRect2D, kMaxViewports> scissor{};
};

inline constexpr float kMinPointSize = 1, kMaxPointSize = 1024;  // VkPhysicalDeviceLimits::pointSizeRange
inline constexpr float kMaxLineWidth = 256;                      // lineWidthRange

// VK_EXT_line_rasterization. kStrict is also what VkPhysicalDeviceLimits::strictLines promises.
enum class LineMode : uint8_t { kStrict, kBresenham, kSmooth };

struct LineState {
  LineMode mode = LineMode::kStrict;
  bool stippled = false;
  uint16_t stipple_pattern = 0xFFFF;
  uint32_t stipple_factor = 1;
  float width_px = 1;
};

// Of a test that runs after the shader: the depth that is tested, compared with the interpolated one.
enum class LateDepth : uint8_t { kAny, kNotLess, kNotGreater };

struct DrawPacket {
  // kernels
  KernelHandle vertex, fragment;
  uint32_t vertex_slots = 4;  // GraphicsKernels::vertex_slots
  VertexOutputs outputs;      // likewise
  bool early_depth = false, opaque = false, has_side_effects = false, per_sample = false;
  LateDepth late_depth = LateDepth::kAny;  // without early_depth
  const DrawContext* context = nullptr;    // must live until Pass::end returns
  // input assembly
  VkPrimitiveTopology topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
  bool primitive_restart = false;
  bool provoking_last = false;  // VK_EXT_provoking_vertex
  IndexBuffer index;
  uint32_t first = 0;         // firstVertex or firstIndex
  uint32_t count = 0;         // vertices or indices
  int32_t vertex_offset = 0;  // indexed draws
  uint32_t first_instance = 0, instance_count = 1;
  // rasterization
  VkViewport viewport{};
  VkRect2D scissor{};
  const ViewportArray* viewports = nullptr;  // null: one. Must live until Pass::end returns
  VkPolygonMode polygon_mode = VK_POLYGON_MODE_FILL;
  LineState line;
  VkCullModeFlags cull = VK_CULL_MODE_NONE;
  VkFrontFace front_face = VK_FRONT_FACE_COUNTER_CLOCKWISE;
  bool depth_clip = true;  // near and far planes clip; kernels clamp depths on their own (FragmentState::depth_clamp)
  bool depth_bias = false;
  float depth_bias_constant = 0, depth_bias_clamp = 0, depth_bias_slope = 0;
  // depth, for Hi-Z only: the kernel does the test itself
  bool depth_test = false, depth_write = false;
  VkCompareOp depth_compare = VK_COMPARE_OP_ALWAYS;
  bool depth_bounds_test = false, stencil_test = false;
  bool stencil_write = false;                       // some operation is not KEEP: what fails the depth test may leave a trace
  std::atomic<uint64_t>* samples_passed = nullptr;  // an active occlusion query's counter, which several threads add to
};

struct PassStatistics {
#define PINEDA_STATISTIC(name, text) uint64_t name = 0;
#include "raster/statistics.inc"
};

// The part of one draw, when Options::per_draw asks for it.
struct DrawStatistics {
  uint64_t vertices_shaded = 0, primitives_in = 0, triangles_clipped = 0, triangles_culled = 0, triangles_binned = 0;
  uint64_t blocks_shaded = 0;
};

// What one thread of the pool spent on the pass, when Options::timing asks for it.
struct ThreadTimes {
  uint64_t geometry_ns = 0, tiles_ns = 0;
};

struct Options;  // raster/options.h: what must not change a bit

class Pass {
 public:
  Pass(ThreadPool& pool, const PassDesc& desc);
  Pass(ThreadPool& pool, const PassDesc& desc, const Options& options);  // for tests; the other takes them from the environment
  ~Pass();
  Pass(Pass&&) noexcept;
  Pass& operator=(Pass&&) noexcept;
  // Appends a draw; geometry may start at once or later. The packet is copied, what it points to is not.
  void draw(const DrawPacket& packet);
  // vkCmdClearAttachments: rectangles of some layers of one attachment, in order with the draws: color_index, kDepth or kStencil.
  static constexpr uint32_t kDepth = ~0u, kStencil = ~0u - 1;
  void clear(uint32_t color_index, const VkClearValue& value, std::span<const VkRect2D> rects, uint32_t first_layer = 0,
             uint32_t layer_count = 1);
  // Before end(): another pass goes on with the attachments, so all are stored and none is resolved.
  void keep_in_memory();
  // Runs what is pending; attachments are in memory afterwards.
  PassStatistics end();
  // Whether end() may come later, beside that of other passes: the pass is short, so that one thread does it as fast as several,
  // and changes nothing but its attachments.
  bool may_wait() const;
  // Whether one of the passes has an attachment in memory that belongs to an attachment of the other.
  bool shares_memory(const Pass& other) const;
  // end() of passes of one pool that do not depend on each other, each on one thread.
  static void end_together(std::span<Pass* const> passes);
  const PassStatistics& statistics() const;  // what end() returns
  // After end(), if Options asked for them: each draw that was recorded; bin entries of each tile, row by row.
  std::vector<DrawStatistics> draw_statistics() const;
  std::vector<ThreadTimes> thread_times() const;  // of each thread
  struct HeatMap {
    uint32_t columns = 0, rows = 0;  // layers one below the other
    std::vector<uint64_t> entries;
  };
  HeatMap heat_map() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// ---- compute --------------------------------------------------------------------------------------------------------------

struct DispatchPacket {
  KernelHandle kernel;
  const DrawContext* context = nullptr;
  std::array<uint32_t, 3> base{}, count{};  // workgroups
  std::array<uint32_t, 3> local_size{1, 1, 1};
  uint32_t shared_memory_bytes = 0;
  uint64_t wave_frame_bytes = 0;  // compile.h
};
void dispatch(ThreadPool& pool, const DispatchPacket& packet);

// ---- transfers: bytes only ------------------------------------------------------------------------------------------------

// rows x row_bytes from src to dst, for each of `slices`. Source and destination do not overlap.
struct CopyRows {
  const uint8_t* src;
  uint8_t* dst;
  uint64_t row_bytes, rows, slices;
  uint64_t src_row_pitch, dst_row_pitch, src_slice_pitch, dst_slice_pitch;  // bytes
};
void copy_rows(ThreadPool& pool, const CopyRows& copy);

// Fills rows with a repeated pattern of 1 to 16 bytes.
struct FillRows {
  uint8_t* dst;
  uint64_t row_bytes, rows, slices, row_pitch, slice_pitch;
  std::array<uint8_t, 16> pattern;
  uint32_t pattern_bytes;
};
void fill_rows(ThreadPool& pool, const FillRows& fill);

}  // namespace pineda::raster
