#include "icd/render_pass.h"

#include <span>

#include "base/format.h"
#include "icd/api.h"
#include "icd/device.h"
#include "icd/render_pass_info.h"

namespace pineda::icd {
namespace {

VkResult check_subpass(const VkRenderPassCreateInfo2& info, const VkSubpassDescription2& subpass) {
  if (subpass.pipelineBindPoint != VK_PIPELINE_BIND_POINT_GRAPHICS)
    return not_supported("vkCreateRenderPass: bind point is not graphics");
  if (subpass.colorAttachmentCount > kMaxColorAttachments)
    return not_supported("vkCreateRenderPass: more than 8 colour attachments");
  const auto known = [&](uint32_t index) { return index == VK_ATTACHMENT_UNUSED || index < info.attachmentCount; };
  for (uint32_t i = 0; i < subpass.inputAttachmentCount; ++i) {
    if (subpass.pInputAttachments[i].attachment != VK_ATTACHMENT_UNUSED) {
      return not_supported("vkCreateRenderPass: input attachments are not supported");
    }
  }
  for (uint32_t i = 0; i < subpass.colorAttachmentCount; ++i) {
    if (!known(subpass.pColorAttachments[i].attachment))
      return not_supported("vkCreateRenderPass: colour attachment index out of range");
    if (subpass.pResolveAttachments && subpass.pResolveAttachments[i].attachment != VK_ATTACHMENT_UNUSED) {
      return not_supported("vkCreateRenderPass: resolve attachments are not supported (images have one sample)");
    }
  }
  if (subpass.pDepthStencilAttachment && !known(subpass.pDepthStencilAttachment->attachment)) {
    return not_supported("vkCreateRenderPass: depth attachment index out of range");
  }
  return VK_SUCCESS;
}

}  // namespace

VkResult RenderPass::check(Device&, const VkRenderPassCreateInfo2& info) {
  for (uint32_t i = 0; i < info.attachmentCount; ++i) {
    const VkAttachmentDescription2& attachment = info.pAttachments[i];
    if (attachment.samples != VK_SAMPLE_COUNT_1_BIT) return not_supported("vkCreateRenderPass: attachments have one sample");
    const FormatInfo* format = find_format(attachment.format);
    if (!format || !(format->uses & (kUseColor | kUseDepth))) {
      return not_supported("vkCreateRenderPass: format " + std::to_string(attachment.format) + " cannot be an attachment");
    }
  }
  for (uint32_t i = 0; i < info.subpassCount; ++i) {
    if (const VkResult result = check_subpass(info, info.pSubpasses[i]); result != VK_SUCCESS) return result;
  }
  return VK_SUCCESS;
}

RenderPass::RenderPass(const Allocator& from, Device&, const VkRenderPassCreateInfo2& info)
    : Object(from), attachment_count_(info.attachmentCount), subpasses_(info.subpassCount, HostAllocator<Subpass>(&allocator)) {
  const auto reference = [&](SubpassAttachment& to, uint32_t index) {
    to.index = index;
    if (index != VK_ATTACHMENT_UNUSED) to.format = info.pAttachments[index].format;
  };
  for (uint32_t s = 0; s < info.subpassCount; ++s) {
    const VkSubpassDescription2& description = info.pSubpasses[s];
    subpasses_[s].view_mask = description.viewMask;
    subpasses_[s].color_count = description.colorAttachmentCount;
    for (uint32_t i = 0; i < description.colorAttachmentCount; ++i) {
      reference(subpasses_[s].color[i], description.pColorAttachments[i].attachment);
    }
    if (description.pDepthStencilAttachment) reference(subpasses_[s].depth, description.pDepthStencilAttachment->attachment);
  }
  // First and last use of each attachment.
  for (uint32_t index = 0; index < info.attachmentCount; ++index) {
    SubpassAttachment* last = nullptr;
    const auto visit = [&](SubpassAttachment& use) {
      if (use.index != index) return;
      if (!last) use.load = info.pAttachments[index].loadOp;
      last = &use;
    };
    for (Subpass& subpass : subpasses_) {
      for (SubpassAttachment& use : std::span(subpass.color).first(subpass.color_count)) visit(use);
      visit(subpass.depth);
    }
    if (last) last->store = info.pAttachments[index].storeOp;
  }
}

VkResult api::CreateRenderPass2KHR(VkDevice device, const VkRenderPassCreateInfo2* info, const VkAllocationCallbacks* callbacks,
                                   VkRenderPass* out) {
  return create_device_object<RenderPass>(device, info, callbacks, out);
}

VkResult api::CreateRenderPass(VkDevice device, const VkRenderPassCreateInfo* info, const VkAllocationCallbacks* callbacks,
                               VkRenderPass* out) {
  *out = VK_NULL_HANDLE;
  return guarded([&] { return CreateRenderPass2KHR(device, &RenderPassInfo2(*info).info(), callbacks, out); });
}

void api::DestroyRenderPass(VkDevice device, VkRenderPass render_pass, const VkAllocationCallbacks* callbacks) {
  destroy_device_object(device, render_pass, callbacks);
}

// Render areas need no alignment: clears and stores are clipped to them exactly.
void api::GetRenderAreaGranularity(VkDevice, VkRenderPass, VkExtent2D* out) { *out = {1, 1}; }

}  // namespace pineda::icd
