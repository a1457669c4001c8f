// Execution of binds and dynamic state: they change the current state and say what depends on it.
#include <algorithm>
#include <cstring>

#include "icd/buffer.h"
#include "icd/compute_pipeline.h"
#include "icd/descriptor_set.h"
#include "icd/device.h"
#include "icd/executor.h"

namespace pineda::icd {
namespace {

void set_faces(std::array<uint32_t, 2>& to, VkStencilFaceFlags faces, uint32_t value) {
  if (faces & VK_STENCIL_FACE_FRONT_BIT) to[0] = value;
  if (faces & VK_STENCIL_FACE_BACK_BIT) to[1] = value;
}

}  // namespace

void Executor::execute(const cmd::BindPipeline& command) {
  if (command.compute) {
    compute_pipeline_ = command.compute;
    compute_kernel_ = nullptr;
    return;
  }
  pipeline_ = command.graphics;
  apply_static_state(pipeline_->state(), dynamic_);
  dirty_ |= kAll;
}

void Executor::execute(const cmd::SetViewport& command) {
  std::ranges::copy(command.viewports, dynamic_.viewports.begin() + command.first);
  dirty_ |= kPacket | kContext;  // the context holds the depth range
}

void Executor::execute(const cmd::SetScissor& command) {
  std::ranges::copy(command.scissors, dynamic_.scissors.begin() + command.first);
  dirty_ |= kPacket;
}

void Executor::execute(const cmd::SetLineWidth& command) {
  dynamic_.line_width = command.width;
  dirty_ |= kPacket;
}

void Executor::execute(const cmd::SetLineStippleEXT& command) {
  dynamic_.stipple_factor = command.factor;
  dynamic_.stipple_pattern = command.pattern;
  dirty_ |= kPacket;
}

void Executor::execute(const cmd::SetDepthBias& command) {
  dynamic_.depth_bias_constant = command.constant;
  dynamic_.depth_bias_clamp = command.clamp;
  dynamic_.depth_bias_slope = command.slope;
  dirty_ |= kPacket;
}

void Executor::execute(const cmd::SetBlendConstants& command) {
  dynamic_.blend_constants = command.constants;
  dirty_ |= kContext;
}

void Executor::execute(const cmd::SetDepthBounds& command) {
  dynamic_.depth_bounds = command.bounds;
  dirty_ |= kContext;
}

void Executor::execute(const cmd::SetStencilCompareMask& command) {
  set_faces(dynamic_.stencil_compare_mask, command.faces, command.value);
  dirty_ |= kContext;
}

void Executor::execute(const cmd::SetStencilWriteMask& command) {
  set_faces(dynamic_.stencil_write_mask, command.faces, command.value);
  dirty_ |= kContext;
}

void Executor::execute(const cmd::SetStencilReference& command) {
  set_faces(dynamic_.stencil_reference, command.faces, command.value);
  dirty_ |= kContext;
}

void Executor::execute(const cmd::BindDescriptorSets& command) {
  const bool is_graphics = command.bind_point == VK_PIPELINE_BIND_POINT_GRAPHICS;
  BindPoint& to = is_graphics ? graphics_ : compute_;
  for (size_t i = 0; i < command.sets.size(); ++i) {
    const DescriptorSet* set = from(command.sets[i]);
    to.sets[command.first_set + i] = set;
    to.context.sets[command.first_set + i] = set ? set->memory() : device_.unbound_set.memory();
  }
  const size_t room = kMaxDynamicOffsets - std::min(command.dynamic_base, kMaxDynamicOffsets);
  std::copy_n(command.dynamic_offsets.data(), std::min(room, command.dynamic_offsets.size()),
              to.context.dynamic_offsets + command.dynamic_base);
  if (is_graphics) {
    dirty_ |= kContext;
    if (pipeline_ && pipeline_->samples()) dirty_ |= kKernels;
  } else if (compute_pipeline_ && compute_pipeline_->samples()) {
    compute_kernel_ = nullptr;
  }
}

void Executor::execute(const cmd::BindIndexBuffer& command) { index_ = command; }

void Executor::execute(const cmd::BindVertexBuffers& command) {
  for (size_t i = 0; i < command.buffers.size(); ++i) {
    const Buffer* buffer = from(command.buffers[i]);
    const BufferDescriptor range = buffer ? buffer->descriptor(command.offsets[i], VK_WHOLE_SIZE) : BufferDescriptor{};
    graphics_.context.vertex_buffers[command.first_binding + i] = {range.address, range.size_bytes, 0};
  }
  dirty_ |= kContext;
}

// One range of bytes for both bind points.
void Executor::execute(const cmd::PushConstants& command) {
  std::memcpy(graphics_.context.push_constants + command.offset, command.bytes.data(), command.bytes.size());
  std::memcpy(compute_.context.push_constants + command.offset, command.bytes.data(), command.bytes.size());
  dirty_ |= kContext;
}

}  // namespace pineda::icd
