// VkFramebuffer: the views that a render pass draws to.
#pragma once

#include "icd/object.h"

namespace pineda::icd {

class Framebuffer : public Object {
 public:
  Framebuffer(const Allocator& from, Device&, const VkFramebufferCreateInfo& info);

  const ImageView& view(uint32_t index) const { return *views_[index]; }
  VkExtent2D extent() const { return extent_; }
  uint32_t layer_count() const { return layer_count_; }

 private:
  // What was asked for, but never beyond an attachment: that would be invalid, and would write outside of images.
  VkExtent2D extent_;
  uint32_t layer_count_;
  HostVector<const ImageView*> views_;
};

}  // namespace pineda::icd
