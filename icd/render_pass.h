// VkRenderPass: for each subpass, which attachments it draws to and what happens to their contents before and after.
#pragma once

#include <array>

#include "base/abi.h"
#include "icd/object.h"

namespace pineda::icd {

// An attachment as one subpass uses it. The first use in the render pass performs the load operation, the last use the store
// operation; between uses contents are kept in memory.
struct SubpassAttachment {
  uint32_t index = VK_ATTACHMENT_UNUSED;  // into the framebuffer's views and the clear values
  VkFormat format = VK_FORMAT_UNDEFINED;
  VkAttachmentLoadOp load = VK_ATTACHMENT_LOAD_OP_LOAD;
  VkAttachmentStoreOp store = VK_ATTACHMENT_STORE_OP_STORE;
};

struct Subpass {
  std::array<SubpassAttachment, kMaxColorAttachments> color{};
  uint32_t color_count = 0;
  SubpassAttachment depth;
  uint32_t view_mask = 0;  // 0: no multiview
};

class RenderPass : public Object {
 public:
  static VkResult check(Device& device, const VkRenderPassCreateInfo2& info);
  RenderPass(const Allocator& from, Device&, const VkRenderPassCreateInfo2& info);

  uint32_t attachment_count() const { return attachment_count_; }
  uint32_t subpass_count() const { return static_cast<uint32_t>(subpasses_.size()); }
  const Subpass& subpass(uint32_t index) const { return subpasses_[index]; }

 private:
  uint32_t attachment_count_;
  HostVector<Subpass> subpasses_;
};

}  // namespace pineda::icd
