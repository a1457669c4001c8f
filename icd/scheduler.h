// Executes the submissions of all queues of a device, one at a time: a submission has all threads of the pool, so two at once
// would only share them. A submission starts when those before it on its queue are done and its semaphores are signalled; among
// several that could start, the oldest does. It executes on one of three threads:
//
//   - the submitting thread, inside vkQueueSubmit, when nothing is in its way and the work is estimated to be short: a thread hop
//     costs more than a small draw;
//   - a thread that waits without a deadline (vkQueueWaitIdle, vkWaitForFences, vkWaitSemaphores): it takes pending work instead
//   of
//     sleeping beside it;
//   - the scheduler's worker, started by the first submission that needs it.
//
// `running_` is the baton: who sets it (under the mutex) executes, so executors and thread pool need no lock of their own.
#pragma once

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <span>
#include <thread>

#include "icd/queue.h"

namespace pineda::icd {

class Scheduler {
 public:
  explicit Scheduler(Device& owner) : device_(owner) {}
  ~Scheduler();  // finishes what can start

  VkResult submit(Queue& queue, std::span<const VkSubmitInfo> batches, Fence* fence);
  VkResult present(Queue& queue, const VkPresentInfoKHR& info);
  // Of a queue; null: of all.
  VkResult wait_idle(const Queue* queue);
  // Executes the oldest submission that can start on this thread; false when there is none or somebody else is at work.
  bool help();
  // What executes now, for messages: null when nothing does. The command buffer may only be compared; its queue stays.
  struct Executing {
    const CommandBuffer* command_buffer;
    const Queue* queue;
  };
  Executing executing() const { return {executing_.load(), executing_queue_.load()}; }
  // Changes what submissions may wait for.
  template <typename Change>
  void change(Change&& change) {
    {
      const std::scoped_lock lock(mutex_);
      change();
    }
    changed_.notify_all();
  }
  // For who executes and has to wait for the host: others may execute meanwhile.
  template <typename Wait>
  void yield(Wait&& wait) {
    pause();
    wait();
    resume();
  }

 private:
  void push_locked(Queue& queue, std::span<const VkSubmitInfo> batches, Fence* fence);
  bool can_start_now(const Queue& queue, std::span<const VkSubmitInfo> batches) const;
  Queue* next_locked();
  bool idle_locked(const Queue* queue);
  void run_front_locked(Queue& queue, std::unique_lock<std::mutex>& lock);  // unlocks while it executes
  void execute(Queue& queue, std::span<const CommandBuffer* const> commands) noexcept;
  void show(std::span<const Presentation> presentations) noexcept;
  void finish_locked(Queue& queue, Fence* fence);
  void pause();
  void resume();
  void worker_main();

  Device& device_;
  std::atomic<const CommandBuffer*> executing_{nullptr};
  std::atomic<const Queue*> executing_queue_{nullptr};
  std::mutex mutex_;  // guards all below and the queues' pending work
  std::condition_variable changed_;
  uint64_t next_sequence_ = 0;
  bool running_ = false;
  bool stopping_ = false;
  std::thread worker_;
};

}  // namespace pineda::icd
