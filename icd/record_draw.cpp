// Recording of render passes, draws and dispatches.
#include "icd/api.h"
#include "icd/buffer.h"
#include "icd/chain.h"
#include "icd/command_buffer.h"
#include "icd/framebuffer.h"
#include "icd/render_pass.h"

namespace pineda::icd {
namespace {

uint64_t draw_cost_ns(const CommandBuffer& cb, uint64_t vertices, uint64_t instances) {
  return cost::kDraw_ns + vertices * instances * cost::kVertex_ns + cb.area_px / cost::kPixelsPer_ns;
}

}  // namespace

void api::CmdDraw(VkCommandBuffer handle, uint32_t vertex_count, uint32_t instance_count, uint32_t first_vertex,
                  uint32_t first_instance) {
  CommandBuffer& cb = *from(handle);
  cb.record([&] {
    cb.append(cmd::Draw{vertex_count, instance_count, first_vertex, first_instance});
    cb.add_cost(draw_cost_ns(cb, vertex_count, instance_count));
  });
}

void api::CmdDrawIndexed(VkCommandBuffer handle, uint32_t index_count, uint32_t instance_count, uint32_t first_index,
                         int32_t vertex_offset, uint32_t first_instance) {
  CommandBuffer& cb = *from(handle);
  cb.record([&] {
    cb.append(cmd::DrawIndexed{index_count, instance_count, first_index, vertex_offset, first_instance});
    cb.add_cost(draw_cost_ns(cb, index_count, instance_count));
  });
}

void api::CmdDrawIndirect(VkCommandBuffer handle, VkBuffer buffer, VkDeviceSize offset, uint32_t draw_count, uint32_t stride) {
  CommandBuffer& cb = *from(handle);
  cb.record([&] {
    cb.append(cmd::DrawIndirect{from(buffer), offset, draw_count, stride});
    cb.add_cost(cost::kUnknown_ns);
  });
}

void api::CmdDrawIndexedIndirect(VkCommandBuffer handle, VkBuffer buffer, VkDeviceSize offset, uint32_t draw_count,
                                 uint32_t stride) {
  CommandBuffer& cb = *from(handle);
  cb.record([&] {
    cb.append(cmd::DrawIndexedIndirect{from(buffer), offset, draw_count, stride});
    cb.add_cost(cost::kUnknown_ns);
  });
}

void api::CmdDrawIndirectCountKHR(VkCommandBuffer handle, VkBuffer buffer, VkDeviceSize offset, VkBuffer count_buffer,
                                  VkDeviceSize count_offset, uint32_t max_draw_count, uint32_t stride) {
  CommandBuffer& cb = *from(handle);
  cb.record([&] {
    cb.append(cmd::DrawIndirectCountKHR{{from(buffer), offset, max_draw_count, stride}, from(count_buffer), count_offset});
    cb.add_cost(cost::kUnknown_ns);
  });
}

void api::CmdDrawIndexedIndirectCountKHR(VkCommandBuffer handle, VkBuffer buffer, VkDeviceSize offset, VkBuffer count_buffer,
                                         VkDeviceSize count_offset, uint32_t max_draw_count, uint32_t stride) {
  CommandBuffer& cb = *from(handle);
  cb.record([&] {
    cb.append(cmd::DrawIndexedIndirectCountKHR{{from(buffer), offset, max_draw_count, stride}, from(count_buffer), count_offset});
    cb.add_cost(cost::kUnknown_ns);
  });
}

void api::CmdDispatch(VkCommandBuffer handle, uint32_t x, uint32_t y, uint32_t z) {
  CommandBuffer& cb = *from(handle);
  cb.record([&] {
    cb.append(cmd::Dispatch{{x, y, z}});
    cb.add_cost(uint64_t(x) * y * z * cb.workgroup_invocations * cost::kInvocation_ns);
  });
}

void api::CmdDispatchBase(VkCommandBuffer handle, uint32_t base_x, uint32_t base_y, uint32_t base_z, uint32_t x, uint32_t y,
                          uint32_t z) {
  CommandBuffer& cb = *from(handle);
  cb.record([&] {
    cb.append(cmd::DispatchBase{{base_x, base_y, base_z}, {x, y, z}});
    cb.add_cost(uint64_t(x) * y * z * cb.workgroup_invocations * cost::kInvocation_ns);
  });
}

void api::CmdDispatchIndirect(VkCommandBuffer handle, VkBuffer buffer, VkDeviceSize offset) {
  CommandBuffer& cb = *from(handle);
  cb.record([&] {
    cb.append(cmd::DispatchIndirect{from(buffer), offset});
    cb.add_cost(cost::kUnknown_ns);
  });
}

void api::CmdBeginRenderPass(VkCommandBuffer handle, const VkRenderPassBeginInfo* info, VkSubpassContents) {
  CommandBuffer& cb = *from(handle);
  const auto* group =
      find_in_chain<VkDeviceGroupRenderPassBeginInfo>(info->pNext, VK_STRUCTURE_TYPE_DEVICE_GROUP_RENDER_PASS_BEGIN_INFO);
  const VkRect2D& area = group && group->deviceRenderAreaCount > 0 ? group->pDeviceRenderAreas[0] : info->renderArea;
  cb.record([&] {
    const Framebuffer& framebuffer = *from(info->framebuffer);
    cmd::BeginRenderPass begin{.render_pass = from(info->renderPass),
                               .views = framebuffer.views(),
                               .extent = framebuffer.extent(),
                               .layer_count = framebuffer.layer_count(),
                               .area = area,
                               .clear_values = cb.copy(info->pClearValues, info->clearValueCount)};
    const auto* imageless =
        find_in_chain<VkRenderPassAttachmentBeginInfo>(info->pNext, VK_STRUCTURE_TYPE_RENDER_PASS_ATTACHMENT_BEGIN_INFO);
    if (imageless && imageless->attachmentCount > 0) {
      static_assert(sizeof(ImageView*) == sizeof(VkImageView));
      begin.views = cb.copy(reinterpret_cast<const ImageView* const*>(imageless->pAttachments), imageless->attachmentCount);
      Framebuffer::clamp_to(begin.views, &begin.extent, &begin.layer_count);
    }
    if (begin.views.size() < begin.render_pass->attachment_count()) {
      return cb.fail(not_supported("vkCmdBeginRenderPass: the framebuffer has fewer attachments than the render pass"));
    }
    cb.append(begin);
    cb.area_px = uint64_t(area.extent.width) * area.extent.height;
    cb.add_cost(cb.area_px / cost::kPixelsPer_ns);
  });
}

void api::CmdNextSubpass(VkCommandBuffer handle, VkSubpassContents) {
  CommandBuffer& cb = *from(handle);
  cb.record([&] {
    cb.append(cmd::NextSubpass{});
    cb.add_cost(cb.area_px / cost::kPixelsPer_ns);
  });
}

void api::CmdEndRenderPass(VkCommandBuffer handle) {
  CommandBuffer& cb = *from(handle);
  cb.record([&] {
    cb.append(cmd::EndRenderPass{});
    cb.area_px = 0;
  });
}

void api::CmdBeginRenderPass2KHR(VkCommandBuffer handle, const VkRenderPassBeginInfo* info, const VkSubpassBeginInfo* begin) {
  CmdBeginRenderPass(handle, info, begin->contents);
}

void api::CmdNextSubpass2KHR(VkCommandBuffer handle, const VkSubpassBeginInfo* begin, const VkSubpassEndInfo*) {
  CmdNextSubpass(handle, begin->contents);
}

void api::CmdEndRenderPass2KHR(VkCommandBuffer handle, const VkSubpassEndInfo*) { CmdEndRenderPass(handle); }

// The only device of a group executes everything.
void api::CmdSetDeviceMask(VkCommandBuffer, uint32_t) {}

void api::CmdClearAttachments(VkCommandBuffer handle, uint32_t attachment_count, const VkClearAttachment* attachments,
                              uint32_t rect_count, const VkClearRect* rects) {
  CommandBuffer& cb = *from(handle);
  cb.record([&] {
    cb.append(cmd::ClearAttachments{cb.copy(attachments, attachment_count), cb.copy(rects, rect_count)});
    cb.add_cost(cb.area_px / cost::kPixelsPer_ns);
  });
}

void api::CmdExecuteCommands(VkCommandBuffer handle, uint32_t count, const VkCommandBuffer* command_buffers) {
  CommandBuffer& cb = *from(handle);
  cb.record([&] {
    cb.append(cmd::ExecuteCommands{cb.copy(command_buffers, count)});
    for (uint32_t i = 0; i < count; ++i) cb.inherit_from(*from(command_buffers[i]));
  });
}

}  // namespace pineda::icd
