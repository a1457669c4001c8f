// VkEvent: a flag that host and commands set, reset and wait for.
#pragma once

#include <atomic>

#include "icd/object.h"

namespace pineda::icd {

class Event : public Object {
 public:
  Event(const Allocator& from, Device& device, const VkEventCreateInfo&) : Object(from), device_(device) {}

  bool is_set() const { return set_.load(std::memory_order_acquire); }
  void set();
  void reset() { set_.store(false, std::memory_order_release); }
  void wait() const;

 private:
  Device& device_;
  std::atomic<bool> set_{false};
};

}  // namespace pineda::icd
