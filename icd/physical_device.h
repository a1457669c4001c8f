// VkPhysicalDevice: this machine's CPU. One per instance, embedded in it.
#pragma once

#include <span>
#include <string>

#include "icd/object.h"

namespace pineda::icd {

class PhysicalDevice : public Dispatchable {
 public:
  explicit PhysicalDevice(Instance& owner) : instance(owner) {}

  Instance& instance;
};

std::span<const VkQueueFamilyProperties> queue_families();
// Memory that the process may use: RAM, or the control group's limit when that is less.
VkDeviceSize memory_heap_bytes();
// Of all devices of the process: what vkAllocateMemory has given.
VkDeviceSize device_memory_in_use();
void count_device_memory(int64_t change_bytes);
// What the process can have of the heap now: what it has and what the machine has left.
VkDeviceSize memory_budget_bytes();
// How kernels run: "AVX2", "f64 evaluator".
std::string code_path_name();
// Threads that render, from PINEDA_THREADS or the CPUs that the process may run on.
uint32_t render_threads();

// Types of memory, by index. Lazily allocated memory backs transient attachments only; it has pages where something was written.
inline constexpr uint32_t kMappedMemoryType = 0, kLazyMemoryType = 1, kMemoryTypeCount = 2;
inline constexpr uint32_t kQueueFamilyCount = 3;  // everything; compute and transfer; transfer: one queue each

}  // namespace pineda::icd
