// VkRenderPass: for each subpass, which attachments it draws to and reads, and what happens to their contents before and after.
#pragma once

#include <array>
#include <vector>

#include "base/abi.h"
#include "compiler/compile.h"
#include "icd/object.h"

namespace pineda::icd {

// An attachment as one subpass uses it. The first use in the render pass performs the load operation, the last use the store
// operation; between uses contents are kept in memory.
struct SubpassAttachment {
  uint32_t index = VK_ATTACHMENT_UNUSED;  // into the framebuffer's views and the clear values
  VkFormat format = VK_FORMAT_UNDEFINED;
  VkAttachmentLoadOp load = VK_ATTACHMENT_LOAD_OP_LOAD, stencil_load = VK_ATTACHMENT_LOAD_OP_LOAD;
  VkAttachmentStoreOp store = VK_ATTACHMENT_STORE_OP_STORE, stencil_store = VK_ATTACHMENT_STORE_OP_STORE;
  // Where the samples are resolved to, and how; of a colour, `resolve`.
  uint32_t resolve_index = VK_ATTACHMENT_UNUSED;
  compiler::KernelPtr resolve, stencil_resolve;
};

struct Subpass {
  std::array<SubpassAttachment, kMaxColorAttachments> color{};
  uint32_t color_count = 0;
  SubpassAttachment depth;        // and stencil
  uint32_t view_mask = 0;         // 0: no multiview
  uint32_t samples = 0;           // 0: no attachment, the pipelines decide
  bool reads_own_output = false;  // an input attachment is drawn to as well
  // Attachments whose first use is to be read, or both read and drawn to: their clears are done before the subpass.
  std::vector<SubpassAttachment> cleared_first;
};

class RenderPass : public Object {
 public:
  static VkResult check(Device& device, const VkRenderPassCreateInfo2& info);
  RenderPass(const Allocator& from, Device&, const VkRenderPassCreateInfo2& info);

  uint32_t attachment_count() const { return attachment_count_; }
  uint32_t subpass_count() const { return static_cast<uint32_t>(subpasses_.size()); }
  const Subpass& subpass(uint32_t index) const { return subpasses_[index]; }
  // Of what its dependencies and layouts say of render passes before and after it; other commands never run beside one.
  bool waits_for_passes() const { return waits_for_passes_; }    // earlier ones must have ended, whatever they draw to
  bool awaited_by_passes() const { return awaited_by_passes_; }  // it must have ended before a later one begins

 private:
  void set_order(const VkRenderPassCreateInfo2& info);
  void set_operations(const VkRenderPassCreateInfo2& info, uint32_t index);

  uint32_t attachment_count_;
  HostVector<Subpass> subpasses_;
  bool waits_for_passes_ = false, awaited_by_passes_ = false;
};

}  // namespace pineda::icd
