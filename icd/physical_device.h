// VkPhysicalDevice: this machine's CPU. One per instance, embedded in it.
#pragma once

#include "icd/object.h"

namespace pineda::icd {

class PhysicalDevice : public Dispatchable {
 public:
  explicit PhysicalDevice(Instance& owner) : instance(owner) {}

  Instance& instance;
};

// Memory that the process may use: RAM, or the control group's limit when that is less.
VkDeviceSize memory_heap_bytes();
// Threads that render, from PINEDA_THREADS or the CPUs that the process may run on.
uint32_t render_threads();

inline constexpr uint32_t kMemoryTypeCount = 1;

}  // namespace pineda::icd
