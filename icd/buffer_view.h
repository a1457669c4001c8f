// VkBufferView: a buffer seen as an image of one row ("texel buffer"), so that what reads and writes images serves it too.
#pragma once

#include "base/abi.h"
#include "icd/object.h"

namespace pineda::icd {

class BufferView : public Object {
 public:
  static VkResult check(Device& device, const VkBufferViewCreateInfo& info);
  BufferView(const Allocator& from, Device& device, const VkBufferViewCreateInfo& info);

  const ImageDescriptor& descriptor() const { return descriptor_; }
  uint32_t state_id() const { return descriptor_.state_id; }  // TextureStates

 private:
  ImageDescriptor descriptor_{};
};

}  // namespace pineda::icd
