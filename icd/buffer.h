// VkBuffer: a range of device memory.
#pragma once

#include <cstring>

#include "base/abi.h"
#include "icd/object.h"

namespace pineda::icd {

class Buffer : public Object {
 public:
  static VkResult check(Device& device, const VkBufferCreateInfo& info);
  Buffer(const Allocator& from, Device&, const VkBufferCreateInfo& info) : Object(from), size_bytes_(info.size) {}

  void bind(uint8_t* address) { address_ = address; }
  uint8_t* data() const { return address_; }  // null until memory is bound
  VkDeviceSize size_bytes() const { return size_bytes_; }

  // Bytes from offset to the end of the range (VK_WHOLE_SIZE: of the buffer), never past the end.
  VkDeviceSize clamp(VkDeviceSize offset, VkDeviceSize range) const {
    if (offset >= size_bytes_) return 0;
    const VkDeviceSize rest = size_bytes_ - offset;
    return range < rest ? range : rest;  // VK_WHOLE_SIZE is the largest number
  }
  // A structure of an indirect command; false when it is not inside the buffer.
  template <typename T>
  bool read(VkDeviceSize offset, T* out) const {
    if (!address_ || clamp(offset, sizeof(T)) != sizeof(T)) return false;
    std::memcpy(out, address_ + offset, sizeof(T));
    return true;
  }
  BufferDescriptor descriptor(VkDeviceSize offset, VkDeviceSize range) const;

 private:
  const VkDeviceSize size_bytes_;
  uint8_t* address_ = nullptr;
};

}  // namespace pineda::icd
