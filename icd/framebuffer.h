// VkFramebuffer: the views that a render pass draws to.
#pragma once

#include "icd/object.h"

namespace pineda::icd {

class Framebuffer : public Object {
 public:
  Framebuffer(const Allocator& from, Device&, const VkFramebufferCreateInfo& info);

  const ImageView& view(uint32_t index) const { return *views_[index]; }
  const VkExtent2D extent;
  const uint32_t layer_count;

 private:
  HostVector<const ImageView*> views_;
};

}  // namespace pineda::icd
