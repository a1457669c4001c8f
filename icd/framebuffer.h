// VkFramebuffer: the views that a render pass draws to.
#pragma once

#include <span>

#include "icd/object.h"

namespace pineda::icd {

class Framebuffer : public Object {
 public:
  Framebuffer(const Allocator& from, Device&, const VkFramebufferCreateInfo& info);

  // Empty for an imageless framebuffer: the views come with vkCmdBeginRenderPass.
  std::span<const ImageView* const> views() const { return views_; }
  // What lies inside of all views: drawing beyond an attachment would be invalid, and would write outside of images.
  static void clamp_to(std::span<const ImageView* const> views, VkExtent2D* extent, uint32_t* layer_count);

  VkExtent2D extent() const { return extent_; }
  uint32_t layer_count() const { return layer_count_; }

 private:
  VkExtent2D extent_;
  uint32_t layer_count_;
  HostVector<const ImageView*> views_;
};

}  // namespace pineda::icd
