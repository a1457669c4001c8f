#include "icd/framebuffer.h"

#include <algorithm>

#include "icd/api.h"
#include "icd/device.h"
#include "icd/image_view.h"

namespace pineda::icd {

Framebuffer::Framebuffer(const Allocator& from_allocator, Device&, const VkFramebufferCreateInfo& info)
    : Object(from_allocator),
      extent_{info.width, info.height},
      layer_count_(info.layers),
      views_(HostAllocator<const ImageView*>(&allocator)) {
  if (info.flags & VK_FRAMEBUFFER_CREATE_IMAGELESS_BIT) return;
  views_.reserve(info.attachmentCount);
  for (uint32_t i = 0; i < info.attachmentCount; ++i) views_.push_back(from(info.pAttachments[i]));
  clamp_to(views_, &extent_, &layer_count_);
}

void Framebuffer::clamp_to(std::span<const ImageView* const> views, VkExtent2D* extent, uint32_t* layer_count) {
  for (const ImageView* view : views) {
    extent->width = std::min(extent->width, view->extent().width);
    extent->height = std::min(extent->height, view->extent().height);
    *layer_count = std::min(*layer_count, view->layer_count());
  }
}

VkResult api::CreateFramebuffer(VkDevice device, const VkFramebufferCreateInfo* info, const VkAllocationCallbacks* callbacks,
                                VkFramebuffer* out) {
  return create_device_object<Framebuffer>(device, info, callbacks, out);
}

void api::DestroyFramebuffer(VkDevice device, VkFramebuffer framebuffer, const VkAllocationCallbacks* callbacks) {
  destroy_device_object(device, framebuffer, callbacks);
}

}  // namespace pineda::icd
