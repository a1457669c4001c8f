// Recorded commands: plain data in the command buffer's arena, each behind a header, in one list.
//
//     header | cmd::BindPipeline -> header | cmd::Draw -> ...
//
// Handles are resolved when a command is recorded; arrays lie in the same arena.
#pragma once

#include <cstdint>
#include <span>

#include "icd/graphics_state.h"
#include "icd/object.h"

namespace pineda::icd {

class GraphicsPipeline;
class ComputePipeline;

namespace cmd {

struct BindPipeline {
  const GraphicsPipeline* graphics;  // one of the two
  const ComputePipeline* compute;
};
struct SetViewport {
  uint32_t first;
  std::span<const VkViewport> viewports;
};
struct SetScissor {
  uint32_t first;
  std::span<const VkRect2D> scissors;
};
struct SetLineWidth {
  float width;
};
struct SetLineStippleEXT {
  uint32_t factor;
  uint16_t pattern;
};
struct SetDepthBias {
  float constant, clamp, slope;
};
struct SetBlendConstants {
  std::array<float, 4> constants;
};
struct SetDepthBounds {
  std::array<float, 2> bounds;
};
struct SetStencilCompareMask {
  VkStencilFaceFlags faces;
  uint32_t value;
};
struct SetStencilWriteMask {
  VkStencilFaceFlags faces;
  uint32_t value;
};
struct SetStencilReference {
  VkStencilFaceFlags faces;
  uint32_t value;
};
struct BindDescriptorSets {
  VkPipelineBindPoint bind_point;
  uint32_t first_set;
  uint32_t dynamic_base;  // of first_set in DrawContext::dynamic_offsets
  std::span<const VkDescriptorSet> sets;
  std::span<const uint32_t> dynamic_offsets;
};
struct BindIndexBuffer {
  const Buffer* buffer;
  VkDeviceSize offset;
  VkIndexType type;
};
struct BindVertexBuffers {
  uint32_t first_binding;
  std::span<const VkBuffer> buffers;
  std::span<const VkDeviceSize> offsets;
};
struct PushConstants {
  uint32_t offset;
  std::span<const uint8_t> bytes;
};
struct Draw {
  uint32_t vertex_count, instance_count, first_vertex, first_instance;
};
struct DrawIndexed {
  uint32_t index_count, instance_count, first_index;
  int32_t vertex_offset;
  uint32_t first_instance;
};
struct DrawIndirect {
  const Buffer* buffer;
  VkDeviceSize offset;
  uint32_t draw_count, stride;
};
struct DrawIndexedIndirect {
  const Buffer* buffer;
  VkDeviceSize offset;
  uint32_t draw_count, stride;
};
struct DrawIndirectCountKHR {
  DrawIndirect draws;  // at most draws.draw_count
  const Buffer* count_buffer;
  VkDeviceSize count_offset;
};
struct DrawIndexedIndirectCountKHR {
  DrawIndexedIndirect draws;
  const Buffer* count_buffer;
  VkDeviceSize count_offset;
};
struct Dispatch {
  std::array<uint32_t, 3> count;
};
struct DispatchBase {
  std::array<uint32_t, 3> base, count;
};
struct DispatchIndirect {
  const Buffer* buffer;
  VkDeviceSize offset;
};
struct CopyBuffer {
  const Buffer *source, *destination;
  std::span<const VkBufferCopy> regions;
};
struct CopyImage {
  const Image *source, *destination;
  std::span<const VkImageCopy> regions;
};
struct BlitImage {
  const Image *source, *destination;
  std::span<const VkImageBlit> regions;
  VkFilter filter;
};
struct ResolveImage {
  const Image *source, *destination;
  std::span<const VkImageResolve> regions;
};
struct CopyBufferToImage {
  const Buffer* source;
  const Image* destination;
  std::span<const VkBufferImageCopy> regions;
};
struct CopyImageToBuffer {
  const Image* source;
  const Buffer* destination;
  std::span<const VkBufferImageCopy> regions;
};
struct UpdateBuffer {
  const Buffer* destination;
  VkDeviceSize offset;
  std::span<const uint8_t> bytes;
};
struct FillBuffer {
  const Buffer* destination;
  VkDeviceSize offset, size;
  uint32_t data;
};
struct ClearColorImage {
  const Image* image;
  VkClearColorValue color;
  std::span<const VkImageSubresourceRange> ranges;
};
struct ClearDepthStencilImage {
  const Image* image;
  VkClearDepthStencilValue value;
  std::span<const VkImageSubresourceRange> ranges;
};
struct ClearAttachments {
  std::span<const VkClearAttachment> attachments;
  std::span<const VkClearRect> rects;
};
struct SetEvent {
  Event* event;
};
struct ResetEvent {
  Event* event;
};
struct WaitEvents {
  std::span<const VkEvent> events;
};
struct ResetQueryPool {
  QueryPool* pool;
  uint32_t first, count;
};
struct WriteTimestamp {
  QueryPool* pool;
  uint32_t query;
};
struct BeginQuery {
  QueryPool* pool;
  uint32_t query;
};
struct EndQuery {
  QueryPool* pool;
  uint32_t query;
};
struct PipelineBarrier {
  VkPipelineStageFlags source_stages;
};
struct CopyQueryPoolResults {
  const QueryPool* pool;
  uint32_t first, count;
  const Buffer* destination;
  VkDeviceSize offset, stride;
  VkQueryResultFlags flags;
};
struct BeginRenderPass {
  const RenderPass* render_pass;
  std::span<const ImageView* const> views;  // the framebuffer's, or what came with the command (imageless framebuffers)
  VkExtent2D extent;
  uint32_t layer_count;
  VkRect2D area;
  std::span<const VkClearValue> clear_values;

  const ImageView& view(uint32_t index) const { return *views[index]; }
};
struct NextSubpass {};
struct EndRenderPass {};
struct LabelText {
  const char* name;
  float color[4];
};
struct BeginDebugUtilsLabelEXT {
  LabelText label;
};
struct EndDebugUtilsLabelEXT {};
struct InsertDebugUtilsLabelEXT {
  LabelText label;
};
struct ExecuteCommands {
  std::span<const VkCommandBuffer> command_buffers;
};

}  // namespace cmd

enum class CommandType : uint32_t {
#define PINEDA_COMMAND(name) k##name,
#include "icd/commands.inc"
};

template <typename Command>
struct CommandTypeOf;
#define PINEDA_COMMAND(name)                                   \
  template <>                                                  \
  struct CommandTypeOf<cmd::name> {                            \
    static constexpr CommandType kType = CommandType::k##name; \
  };
#include "icd/commands.inc"

struct CommandHeader {
  const CommandHeader* next = nullptr;
  CommandType type;
};

template <typename Command>
struct CommandNode : CommandHeader {
  Command command;
};

}  // namespace pineda::icd
