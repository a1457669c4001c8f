// vkCreateRenderPass in the terms of vkCreateRenderPass2, which says everything in one place: view masks and aspects are members
// there, not structures of a chain.
#pragma once

#include <vector>

#include "icd/vulkan_api.h"

namespace pineda::icd {

class RenderPassInfo2 {
 public:
  explicit RenderPassInfo2(const VkRenderPassCreateInfo& info);  // throws std::bad_alloc
  RenderPassInfo2(const RenderPassInfo2&) = delete;

  const VkRenderPassCreateInfo2& info() const { return info_; }

 private:
  void add_attachments(const VkRenderPassCreateInfo& info);
  void add_subpasses(const VkRenderPassCreateInfo& info);
  void add_dependencies(const VkRenderPassCreateInfo& info);
  const VkAttachmentReference2* add_references(const VkAttachmentReference* references, uint32_t count);

  VkRenderPassCreateInfo2 info_{VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO_2};
  std::vector<VkAttachmentDescription2> attachments_;
  std::vector<VkAttachmentReference2> references_;  // of all subpasses; reserved, so that pointers stay
  std::vector<VkSubpassDescription2> subpasses_;
  std::vector<VkSubpassDependency2> dependencies_;
};

}  // namespace pineda::icd
