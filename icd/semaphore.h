// VkSemaphore. A binary one is a payload of 0 or 1, a timeline one a counter; both are read without a lock and changed so that
// the scheduler (scheduler.h) and waiting hosts hear of it.
#pragma once

#include <atomic>

#include "icd/object.h"

namespace pineda::icd {

class Semaphore : public Object {
 public:
  Semaphore(const Allocator& from, Device& device, const VkSemaphoreCreateInfo& info);

  bool is_timeline() const { return is_timeline_; }
  uint64_t value() const { return value_.load(std::memory_order_acquire); }

  // Of a wait operation; `value` is that of a timeline.
  bool satisfies(uint64_t value) const { return this->value() >= (is_timeline_ ? value : 1); }
  // The wait operation takes the payload of a binary semaphore.
  void consume() {
    if (!is_timeline_) value_.store(0, std::memory_order_relaxed);
  }
  // Of a signal operation of the queue, under the scheduler's lock. A timeline never goes back, even when an application says so.
  void signal(uint64_t value);
  // Of the host or the presentation engine: wakes the scheduler.
  void signal_from_host(uint64_t value);

 private:
  Device& device_;
  const bool is_timeline_;
  std::atomic<uint64_t> value_{0};
};

}  // namespace pineda::icd
