// VkQueue: an ordering domain. Its submissions start one after another, in the order of vkQueueSubmit; the device's scheduler
// (scheduler.h) decides where and when.
#pragma once

#include <deque>

#include "icd/executor.h"
#include "icd/labels.h"
#include "icd/object.h"

namespace pineda::icd {

struct SemaphoreOperation {
  Semaphore* semaphore;
  uint64_t value;  // of a timeline
};

struct Presentation {
  Swapchain* swapchain;
  uint32_t image;
};

// One VkSubmitInfo, or a VkPresentInfoKHR.
struct Work {
  explicit Work(const Allocator& from)
      : waits(HostAllocator<SemaphoreOperation>(&from)),
        commands(HostAllocator<const CommandBuffer*>(&from)),
        signals(HostAllocator<SemaphoreOperation>(&from)),
        presentations(HostAllocator<Presentation>(&from)) {}

  HostVector<SemaphoreOperation> waits;
  HostVector<const CommandBuffer*> commands;
  HostVector<SemaphoreOperation> signals;
  HostVector<Presentation> presentations;
  Fence* fence = nullptr;
  uint64_t sequence = 0;  // among all submissions of the device
};

class Queue : public Dispatchable {
 public:
  explicit Queue(Device& owner);

  Device& device;
  LabelStack labels;  // of vkQueue*DebugUtilsLabelEXT
  // Those of the command buffer that executes.
  std::vector<Label> command_labels() const { return executor_.labels(); }

 private:
  friend class Scheduler;

  Executor executor_;                              // used by who executes for the queue
  std::deque<Work, HostAllocator<Work>> pending_;  // guarded by the scheduler's mutex, like all below
  bool busy_ = false;                              // a submission executes
};

}  // namespace pineda::icd
