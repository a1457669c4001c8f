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
  views_.reserve(info.attachmentCount);
  for (uint32_t i = 0; i < info.attachmentCount; ++i) {
    const ImageView& view = *from(info.pAttachments[i]);
    views_.push_back(&view);
    extent_.width = std::min(extent_.width, view.extent().width);
    extent_.height = std::min(extent_.height, view.extent().height);
    layer_count_ = std::min(layer_count_, view.layer_count());
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
