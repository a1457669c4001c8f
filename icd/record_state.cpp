// Recording of binds and dynamic state.
#include <algorithm>

#include "icd/api.h"
#include "icd/buffer.h"
#include "icd/command_buffer.h"
#include "icd/compute_pipeline.h"
#include "icd/graphics_pipeline.h"

namespace pineda::icd {

void api::CmdBindPipeline(VkCommandBuffer handle, VkPipelineBindPoint, VkPipeline pipeline_handle) {
  CommandBuffer& cb = *from(handle);
  cb.record([&] {
    const Pipeline* pipeline = from(pipeline_handle);
    const bool is_graphics = pipeline->bind_point == VK_PIPELINE_BIND_POINT_GRAPHICS;
    const auto* compute = is_graphics ? nullptr : static_cast<const ComputePipeline*>(pipeline);
    if (compute) cb.workgroup_invocations = compute->invocations();
    cb.append(cmd::BindPipeline{is_graphics ? static_cast<const GraphicsPipeline*>(pipeline) : nullptr, compute});
  });
}

void api::CmdSetViewport(VkCommandBuffer handle, uint32_t first, uint32_t count, const VkViewport* viewports) {
  CommandBuffer& cb = *from(handle);
  if (first >= kMaxViewports) return;
  cb.record([&] { cb.append(cmd::SetViewport{first, cb.copy(viewports, std::min(count, kMaxViewports - first))}); });
}

void api::CmdSetScissor(VkCommandBuffer handle, uint32_t first, uint32_t count, const VkRect2D* scissors) {
  CommandBuffer& cb = *from(handle);
  if (first >= kMaxViewports) return;
  cb.record([&] { cb.append(cmd::SetScissor{first, cb.copy(scissors, std::min(count, kMaxViewports - first))}); });
}

void api::CmdSetLineWidth(VkCommandBuffer handle, float width) {
  CommandBuffer& cb = *from(handle);
  cb.record([&] { cb.append(cmd::SetLineWidth{width}); });
}

void api::CmdSetLineStippleEXT(VkCommandBuffer handle, uint32_t factor, uint16_t pattern) {
  CommandBuffer& cb = *from(handle);
  cb.record([&] { cb.append(cmd::SetLineStippleEXT{factor, pattern}); });
}

void api::CmdSetDepthBias(VkCommandBuffer handle, float constant, float clamp, float slope) {
  CommandBuffer& cb = *from(handle);
  cb.record([&] { cb.append(cmd::SetDepthBias{constant, clamp, slope}); });
}

void api::CmdSetBlendConstants(VkCommandBuffer handle, const float constants[4]) {
  CommandBuffer& cb = *from(handle);
  cb.record([&] { cb.append(cmd::SetBlendConstants{{constants[0], constants[1], constants[2], constants[3]}}); });
}

void api::CmdSetDepthBounds(VkCommandBuffer handle, float min, float max) {
  CommandBuffer& cb = *from(handle);
  cb.record([&] { cb.append(cmd::SetDepthBounds{{min, max}}); });
}

void api::CmdSetStencilCompareMask(VkCommandBuffer handle, VkStencilFaceFlags faces, uint32_t mask) {
  CommandBuffer& cb = *from(handle);
  cb.record([&] { cb.append(cmd::SetStencilCompareMask{faces, mask}); });
}

void api::CmdSetStencilWriteMask(VkCommandBuffer handle, VkStencilFaceFlags faces, uint32_t mask) {
  CommandBuffer& cb = *from(handle);
  cb.record([&] { cb.append(cmd::SetStencilWriteMask{faces, mask}); });
}

void api::CmdSetStencilReference(VkCommandBuffer handle, VkStencilFaceFlags faces, uint32_t reference) {
  CommandBuffer& cb = *from(handle);
  cb.record([&] { cb.append(cmd::SetStencilReference{faces, reference}); });
}

void api::CmdBindDescriptorSets(VkCommandBuffer handle, VkPipelineBindPoint bind_point, VkPipelineLayout layout,
                                uint32_t first_set, uint32_t set_count, const VkDescriptorSet* sets, uint32_t offset_count,
                                const uint32_t* offsets) {
  CommandBuffer& cb = *from(handle);
  if (first_set >= kMaxSets) return;
  cb.record([&] {
    cb.append(cmd::BindDescriptorSets{.bind_point = bind_point,
                                      .first_set = first_set,
                                      .dynamic_base = from(layout)->dynamic_base(first_set),
                                      .sets = cb.copy(sets, std::min(set_count, kMaxSets - first_set)),
                                      .dynamic_offsets = cb.copy(offsets, offset_count)});
  });
}

void api::CmdBindIndexBuffer(VkCommandBuffer handle, VkBuffer buffer, VkDeviceSize offset, VkIndexType type) {
  CommandBuffer& cb = *from(handle);
  cb.record([&] { cb.append(cmd::BindIndexBuffer{from(buffer), offset, type}); });
}

void api::CmdBindVertexBuffers(VkCommandBuffer handle, uint32_t first, uint32_t count, const VkBuffer* buffers,
                               const VkDeviceSize* offsets) {
  CommandBuffer& cb = *from(handle);
  if (first >= kMaxVertexBindings) return;
  count = std::min(count, kMaxVertexBindings - first);
  cb.record([&] { cb.append(cmd::BindVertexBuffers{first, cb.copy(buffers, count), cb.copy(offsets, count)}); });
}

void api::CmdPushConstants(VkCommandBuffer handle, VkPipelineLayout, VkShaderStageFlags, uint32_t offset, uint32_t size,
                           const void* values) {
  CommandBuffer& cb = *from(handle);
  if (offset > kMaxPushConstantBytes || size > kMaxPushConstantBytes - offset) return;
  cb.record([&] { cb.append(cmd::PushConstants{offset, cb.copy(static_cast<const uint8_t*>(values), size)}); });
}

}  // namespace pineda::icd
