// Execution of draws: state -> raster::DrawPacket.
#include <algorithm>

#include "icd/buffer.h"
#include "icd/device.h"
#include "icd/executor.h"
#include "icd/limits.h"
#include "icd/query_pool.h"
#include "icd/render_pass.h"

namespace pineda::icd {

bool Executor::flush_kernels() {
  kernels_ = pipeline_->kernels(graphics_.sets.data());
  if (!kernels_) device_.lose("a pipeline could not be compiled (its error was reported)");
  return kernels_ != nullptr;
}

// False when the pipeline was made for other attachments (invalid usage): its kernels would write texels of another size.
bool Executor::flush_packet() {
  const GraphicsState& state = pipeline_->state();
  const Subpass& subpass = begin_->render_pass->subpass(subpass_);
  bool compatible = state.fragment.color_count == subpass.color_count && state.depth_stencil_format == subpass.depth.format &&
                    (subpass.samples == 0 || subpass.samples == state.fragment.samples);
  for (uint32_t i = 0; compatible && i < subpass.color_count; ++i) {
    compatible = state.fragment.color[i].format == subpass.color[i].format;
  }
  if (!compatible && state.rasterizes) {
    device_.lose("a pipeline was used in a subpass whose attachments have other formats than its own render pass");
    return false;
  }
  // Without attachments each pipeline may have its own number of samples.
  if (state.rasterizes && pass_desc_.samples != state.fragment.samples) split_subpass(state.fragment.samples);
  const DrawContext* context = packet_.context;
  packet_ = {};
  packet_.context = context;
  packet_.vertex = kernels_->vertex->handle;
  packet_.fragment = kernels_->fragment->handle;
  packet_.vertex_slots = kernels_->vertex_slots;
  packet_.outputs = kernels_->outputs;
  packet_.early_depth = kernels_->early_depth;
  packet_.late_depth = kernels_->late_depth == spirv::DepthMode::kGreater ? raster::LateDepth::kNotLess
                       : kernels_->late_depth == spirv::DepthMode::kLess  ? raster::LateDepth::kNotGreater
                                                                          : raster::LateDepth::kAny;
  packet_.opaque = kernels_->opaque;
  packet_.has_side_effects = kernels_->has_side_effects;
  packet_.per_sample = kernels_->per_sample;
  packet_.topology = state.topology;
  packet_.primitive_restart = state.primitive_restart;
  packet_.provoking_last = state.provoking_last;
  packet_.viewport = dynamic_.viewports[0];
  packet_.scissor = dynamic_.scissors[0];
  if (state.viewport_count > 1 && kernels_->outputs.viewport_index != 0) {
    packet_.viewports = arena_.make(raster::ViewportArray{state.viewport_count, dynamic_.viewports, dynamic_.scissors});
  }
  packet_.polygon_mode = state.polygon_mode;
  packet_.line = state.line;
  // Written so that NaN becomes 1.
  packet_.line.width_px = dynamic_.line_width > 1 ? std::min(dynamic_.line_width, kLimits.lineWidthRange[1]) : 1;
  packet_.line.stipple_factor = std::clamp(dynamic_.stipple_factor, 1u, 256u);
  packet_.line.stipple_pattern = dynamic_.stipple_pattern;
  packet_.cull = state.cull;
  packet_.front_face = state.front_face;
  packet_.depth_clip = state.depth_clip;
  packet_.depth_bias = state.depth_bias;
  packet_.depth_bias_constant = dynamic_.depth_bias_constant;
  packet_.depth_bias_clamp = dynamic_.depth_bias_clamp;
  packet_.depth_bias_slope = dynamic_.depth_bias_slope;
  packet_.depth_test = state.fragment.depth.test_enable;
  packet_.depth_write = state.fragment.depth.write_enable;
  packet_.depth_compare = state.fragment.depth.compare;
  packet_.depth_bounds_test = state.fragment.depth.bounds_test;
  packet_.stencil_test = state.fragment.stencil.test_enable;
  packet_.stencil_write = state.fragment.stencil.writes();
  packet_.samples_passed = occlusion_.pool ? occlusion_.pool->counter(occlusion_.query) : nullptr;
  if (!state.rasterizes) discard_primitives();
  return true;
}

// rasterizerDiscardEnable: vertex shaders run, for their stores and for queries, and every primitive is outside the scissor.
void Executor::discard_primitives() {
  packet_.viewports = nullptr;
  packet_.viewport = {0, 0, 1, 1, 0, 1};
  packet_.scissor = {};
  packet_.has_side_effects = true;  // a draw with an empty scissor is left out otherwise
}

void Executor::flush_context(const DrawCall& call) {
  DrawContext& context = graphics_.context;
  const uint32_t first_vertex = call.index.address ? static_cast<uint32_t>(call.vertex_offset) : call.first;
  const bool same_draw = context.first_vertex == first_vertex && context.first_instance == call.first_instance &&
                         context.draw_index == call.draw_index;
  if (same_draw && !(dirty_ & kContext)) return;
  context.view_index = view_;
  context.first_vertex = first_vertex;
  context.first_instance = call.first_instance;
  context.draw_index = call.draw_index;
  std::ranges::copy(dynamic_.blend_constants, context.blend_constants);
  std::ranges::copy(dynamic_.stencil_reference, context.stencil_reference);
  std::ranges::copy(dynamic_.stencil_compare_mask, context.stencil_compare_mask);
  std::ranges::copy(dynamic_.stencil_write_mask, context.stencil_write_mask);
  std::ranges::copy(dynamic_.depth_bounds, context.depth_bounds);
  for (uint32_t i = 0; i < pipeline_->state().viewport_count; ++i) {
    const VkViewport& viewport = dynamic_.viewports[i];
    context.depth_range[i][0] = std::min(viewport.minDepth, viewport.maxDepth);
    context.depth_range[i][1] = std::max(viewport.minDepth, viewport.maxDepth);
  }
  context.count_samples = occlusion_.pool != nullptr;
  packet_.context = arena_.make(context);
}

// Brings packet and kernels up to date; false when nothing is to be drawn.
bool Executor::flush() {
  if (!pass_ || !pipeline_) return false;
  if (dirty_ & kKernels) {
    if (!flush_kernels()) return false;
    dirty_ = (dirty_ & ~uint32_t(kKernels)) | kPacket;
  }
  if (dirty_ & kPacket) {
    if (!flush_packet()) return false;
    dirty_ &= ~uint32_t(kPacket);
  }
  return true;
}

void Executor::draw(const DrawCall& call) {
  if (call.count == 0 || call.instance_count == 0 || !flush()) return;
  flush_context(call);
  dirty_ &= ~uint32_t(kContext);
  packet_.index = call.index;
  packet_.first = call.first;
  packet_.count = call.count;
  packet_.vertex_offset = call.vertex_offset;
  packet_.first_instance = call.first_instance;
  packet_.instance_count = call.instance_count;
  pass_->draw(packet_);
}

raster::IndexBuffer Executor::index_buffer() const {
  if (!index_.buffer || !index_.buffer->data()) return {};
  return {.address = index_.buffer->data() + index_.offset,
          .size_bytes = index_.buffer->clamp(index_.offset, VK_WHOLE_SIZE),
          .type = index_.type};
}

void Executor::execute(const cmd::Draw& c) {
  draw({.index = {},
        .first = c.first_vertex,
        .count = c.vertex_count,
        .vertex_offset = 0,
        .first_instance = c.first_instance,
        .instance_count = c.instance_count,
        .draw_index = 0});
}

void Executor::execute(const cmd::DrawIndexed& c) {
  const raster::IndexBuffer index = index_buffer();
  if (!index.address) return;
  draw({.index = index,
        .first = c.first_index,
        .count = c.index_count,
        .vertex_offset = c.vertex_offset,
        .first_instance = c.first_instance,
        .instance_count = c.instance_count,
        .draw_index = 0});
}

void Executor::execute(const cmd::DrawIndirect& c) {
  for (uint32_t i = 0; i < c.draw_count && !device_.lost(); ++i) {
    VkDrawIndirectCommand d;
    if (!c.buffer->read(c.offset + uint64_t(i) * c.stride, &d)) return;
    draw({.index = {},
          .first = d.firstVertex,
          .count = d.vertexCount,
          .vertex_offset = 0,
          .first_instance = d.firstInstance,
          .instance_count = d.instanceCount,
          .draw_index = i});
  }
}

void Executor::execute(const cmd::DrawIndexedIndirect& c) {
  const raster::IndexBuffer index = index_buffer();
  for (uint32_t i = 0; i < c.draw_count && index.address && !device_.lost(); ++i) {
    VkDrawIndexedIndirectCommand d;
    if (!c.buffer->read(c.offset + uint64_t(i) * c.stride, &d)) return;
    draw({.index = index,
          .first = d.firstIndex,
          .count = d.indexCount,
          .vertex_offset = d.vertexOffset,
          .first_instance = d.firstInstance,
          .instance_count = d.instanceCount,
          .draw_index = i});
  }
}

// A count past the buffer's end is none.
void Executor::execute(const cmd::DrawIndirectCountKHR& c) {
  uint32_t count;
  if (!c.count_buffer->read(c.count_offset, &count)) return;
  cmd::DrawIndirect draws = c.draws;
  draws.draw_count = std::min(draws.draw_count, count);
  execute(draws);
}

void Executor::execute(const cmd::DrawIndexedIndirectCountKHR& c) {
  uint32_t count;
  if (!c.count_buffer->read(c.count_offset, &count)) return;
  cmd::DrawIndexedIndirect draws = c.draws;
  draws.draw_count = std::min(draws.draw_count, count);
  execute(draws);
}

}  // namespace pineda::icd
