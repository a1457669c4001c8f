// The one queue. Submissions execute in order, one at a time, on one of three threads:
//
//   - the submitting thread, inside vkQueueSubmit, when nothing is pending and the work is estimated to be short
//   (kInlineCost_ns): a thread
//     hop costs more than a small draw;
//   - a thread that waits without a deadline (vkQueueWaitIdle, vkWaitForFences): it takes pending work instead of sleeping beside
//   it;
//   - the queue's worker, started by the first submission that needs it.
//
// `running_` is the baton: who sets it (under the mutex) executes, so executor and thread pool need no lock of their own. Binary
// semaphores have nothing to do here: their waits are satisfied by order.
#pragma once

#include <condition_variable>
#include <deque>
#include <mutex>
#include <span>
#include <thread>

#include "icd/executor.h"
#include "icd/object.h"

namespace pineda::icd {

class Queue : public Dispatchable {
 public:
  explicit Queue(Device& owner);
  ~Queue();  // finishes what is pending

  VkResult submit(std::span<const VkSubmitInfo> batches, Fence* fence);
  VkResult wait_idle();
  // Executes the oldest pending submission on this thread; false when there is none or somebody else is at work.
  bool help();

 private:
  struct Work {
    HostVector<const CommandBuffer*> commands;
    Fence* fence;
  };

  void push_locked(std::span<const VkSubmitInfo> batches, Fence* fence);
  void run_next_locked(std::unique_lock<std::mutex>& lock);  // unlocks while it executes
  void execute(std::span<const CommandBuffer* const> commands) noexcept;
  void finish_locked(Fence* fence);
  void worker_main();

  Device& device_;
  Executor executor_;  // used by the holder of the baton
  std::mutex mutex_;   // guards all below
  std::condition_variable changed_;
  std::deque<Work, HostAllocator<Work>> pending_;
  bool running_ = false;
  bool stopping_ = false;
  std::thread worker_;
};

}  // namespace pineda::icd
