// VkFence: a flag that the queue raises. Waiting is the device's Notifier.
#pragma once

#include <atomic>

#include "icd/object.h"

namespace pineda::icd {

class Fence : public Object {
 public:
  Fence(const Allocator& from, Device& device, const VkFenceCreateInfo& info);

  bool signaled() const { return signaled_.load(std::memory_order_acquire); }
  void signal();
  void reset() { signaled_.store(false, std::memory_order_release); }

 private:
  Device& device_;
  std::atomic<bool> signaled_;
};

}  // namespace pineda::icd
