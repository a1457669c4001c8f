#include "icd/render_pass_info.h"

#include "icd/chain.h"

namespace pineda::icd {

RenderPassInfo2::RenderPassInfo2(const VkRenderPassCreateInfo& info) {
  add_attachments(info);
  add_subpasses(info);
  add_dependencies(info);
  info_.flags = info.flags;
  info_.attachmentCount = static_cast<uint32_t>(attachments_.size());
  info_.pAttachments = attachments_.data();
  info_.subpassCount = static_cast<uint32_t>(subpasses_.size());
  info_.pSubpasses = subpasses_.data();
  info_.dependencyCount = static_cast<uint32_t>(dependencies_.size());
  info_.pDependencies = dependencies_.data();
}

void RenderPassInfo2::add_attachments(const VkRenderPassCreateInfo& info) {
  for (uint32_t i = 0; i < info.attachmentCount; ++i) {
    const VkAttachmentDescription& a = info.pAttachments[i];
    attachments_.push_back({.sType = VK_STRUCTURE_TYPE_ATTACHMENT_DESCRIPTION_2,
                            .flags = a.flags,
                            .format = a.format,
                            .samples = a.samples,
                            .loadOp = a.loadOp,
                            .storeOp = a.storeOp,
                            .stencilLoadOp = a.stencilLoadOp,
                            .stencilStoreOp = a.stencilStoreOp,
                            .initialLayout = a.initialLayout,
                            .finalLayout = a.finalLayout});
  }
}

// Null when there are none.
const VkAttachmentReference2* RenderPassInfo2::add_references(const VkAttachmentReference* references, uint32_t count) {
  if (!references || count == 0) return nullptr;
  const size_t first = references_.size();
  for (uint32_t i = 0; i < count; ++i) {
    references_.push_back({.sType = VK_STRUCTURE_TYPE_ATTACHMENT_REFERENCE_2,
                           .attachment = references[i].attachment,
                           .layout = references[i].layout});
  }
  return references_.data() + first;
}

void RenderPassInfo2::add_subpasses(const VkRenderPassCreateInfo& info) {
  const auto* multiview =
      find_in_chain<VkRenderPassMultiviewCreateInfo>(info.pNext, VK_STRUCTURE_TYPE_RENDER_PASS_MULTIVIEW_CREATE_INFO);
  size_t reference_count = 0;
  for (uint32_t i = 0; i < info.subpassCount; ++i) {
    reference_count += info.pSubpasses[i].inputAttachmentCount + 2 * info.pSubpasses[i].colorAttachmentCount + 1;
  }
  references_.reserve(reference_count);
  for (uint32_t i = 0; i < info.subpassCount; ++i) {
    const VkSubpassDescription& s = info.pSubpasses[i];
    subpasses_.push_back({.sType = VK_STRUCTURE_TYPE_SUBPASS_DESCRIPTION_2,
                          .flags = s.flags,
                          .pipelineBindPoint = s.pipelineBindPoint,
                          .viewMask = multiview && i < multiview->subpassCount ? multiview->pViewMasks[i] : 0,
                          .inputAttachmentCount = s.inputAttachmentCount,
                          .pInputAttachments = add_references(s.pInputAttachments, s.inputAttachmentCount),
                          .colorAttachmentCount = s.colorAttachmentCount,
                          .pColorAttachments = add_references(s.pColorAttachments, s.colorAttachmentCount),
                          .pResolveAttachments = add_references(s.pResolveAttachments, s.colorAttachmentCount),
                          .pDepthStencilAttachment = add_references(s.pDepthStencilAttachment, 1),
                          .preserveAttachmentCount = s.preserveAttachmentCount,
                          .pPreserveAttachments = s.pPreserveAttachments});
  }
  const auto* aspects = find_in_chain<VkRenderPassInputAttachmentAspectCreateInfo>(
      info.pNext, VK_STRUCTURE_TYPE_RENDER_PASS_INPUT_ATTACHMENT_ASPECT_CREATE_INFO);
  for (uint32_t i = 0; aspects && i < aspects->aspectReferenceCount; ++i) {
    const VkInputAttachmentAspectReference& aspect = aspects->pAspectReferences[i];
    if (aspect.subpass >= info.subpassCount) continue;
    const VkSubpassDescription2& subpass = subpasses_[aspect.subpass];
    if (aspect.inputAttachmentIndex >= subpass.inputAttachmentCount) continue;
    references_[size_t(subpass.pInputAttachments - references_.data()) + aspect.inputAttachmentIndex].aspectMask =
        aspect.aspectMask;
  }
}

void RenderPassInfo2::add_dependencies(const VkRenderPassCreateInfo& info) {
  const auto* multiview =
      find_in_chain<VkRenderPassMultiviewCreateInfo>(info.pNext, VK_STRUCTURE_TYPE_RENDER_PASS_MULTIVIEW_CREATE_INFO);
  for (uint32_t i = 0; i < info.dependencyCount; ++i) {
    const VkSubpassDependency& d = info.pDependencies[i];
    dependencies_.push_back({.sType = VK_STRUCTURE_TYPE_SUBPASS_DEPENDENCY_2,
                             .srcSubpass = d.srcSubpass,
                             .dstSubpass = d.dstSubpass,
                             .srcStageMask = d.srcStageMask,
                             .dstStageMask = d.dstStageMask,
                             .srcAccessMask = d.srcAccessMask,
                             .dstAccessMask = d.dstAccessMask,
                             .dependencyFlags = d.dependencyFlags,
                             .viewOffset = multiview && i < multiview->dependencyCount ? multiview->pViewOffsets[i] : 0});
  }
}

}  // namespace pineda::icd
