// VkDeviceMemory: an anonymous mapping. New memory reads as zero (the kernel's pages), costs nothing until it is touched, and is
// always mapped. Lazily allocated memory is the same without huge pages, so that what backs it is what was written.
#pragma once

#include "icd/object.h"

namespace pineda::icd {

class DeviceMemory : public Object {
 public:
  static VkResult check(Device& device, const VkMemoryAllocateInfo& info);
  DeviceMemory(const Allocator& from, Device& device, const VkMemoryAllocateInfo& info);
  ~DeviceMemory();

  uint8_t* data() const { return data_; }  // null: the mapping failed
  VkDeviceSize size_bytes() const { return size_bytes_; }
  bool lazy() const { return lazy_; }
  // What backs it now: all of it, or the pages of lazily allocated memory that hold something.
  VkDeviceSize committed_bytes() const;

 private:
  Device& device_;
  const VkDeviceSize size_bytes_;
  const bool has_address_;  // shaders may reach it by pointers
  const bool lazy_;
  VkDeviceSize mapping_bytes_ = 0;
  uint8_t* mapping_ = nullptr;
  uint8_t* data_ = nullptr;
};

// Alignment of every resource: one cache line.
inline constexpr VkDeviceSize kResourceAlignment_bytes = 64;

}  // namespace pineda::icd
