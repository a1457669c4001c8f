#include "icd/scheduler.h"

#include <algorithm>
#include <system_error>

#include "base/blocked_signals.h"
#include "base/float_environment.h"
#include "icd/chain.h"
#include "icd/command_buffer.h"
#include "icd/device.h"
#include "icd/fence.h"
#include "icd/semaphore.h"
#include "icd/wsi/swapchain.h"

namespace pineda::icd {
namespace {

// Twice what handing work to a sleeping thread and waiting for it costs on a virtual machine (some 100 us).
constexpr uint64_t kInlineCost_ns = 200'000;

std::span<const CommandBuffer* const> commands_of(const VkSubmitInfo& batch) {
  static_assert(sizeof(CommandBuffer*) == sizeof(VkCommandBuffer));
  return {reinterpret_cast<const CommandBuffer* const*>(batch.pCommandBuffers), batch.commandBufferCount};
}

bool worth_a_thread(std::span<const VkSubmitInfo> batches) {
  uint64_t cost_ns = 0;
  for (const VkSubmitInfo& batch : batches) {
    for (const CommandBuffer* command_buffer : commands_of(batch)) {
      if (command_buffer->waits_for_host()) return true;  // vkCmdWaitEvents: the event may be set after vkQueueSubmit
      cost_ns += command_buffer->cost_ns();
    }
  }
  return cost_ns > kInlineCost_ns;
}

// The wait and signal operations of a batch with the values of timelines; binary semaphores have none.
class Operations {
 public:
  explicit Operations(const VkSubmitInfo& batch)
      : batch_(batch),
        timeline_(find_in_chain<VkTimelineSemaphoreSubmitInfo>(batch.pNext, VK_STRUCTURE_TYPE_TIMELINE_SEMAPHORE_SUBMIT_INFO)) {}

  uint32_t wait_count() const { return batch_.waitSemaphoreCount; }
  SemaphoreOperation wait(uint32_t i) const {
    const bool has_value = timeline_ && i < timeline_->waitSemaphoreValueCount;
    return {from(batch_.pWaitSemaphores[i]), has_value ? timeline_->pWaitSemaphoreValues[i] : 0};
  }
  uint32_t signal_count() const { return batch_.signalSemaphoreCount; }
  SemaphoreOperation signal(uint32_t i) const {
    const bool has_value = timeline_ && i < timeline_->signalSemaphoreValueCount;
    return {from(batch_.pSignalSemaphores[i]), has_value ? timeline_->pSignalSemaphoreValues[i] : 0};
  }

 private:
  const VkSubmitInfo& batch_;
  const VkTimelineSemaphoreSubmitInfo* timeline_;
};

bool satisfied(const SemaphoreOperation& wait) { return wait.semaphore->satisfies(wait.value); }

}  // namespace

Scheduler::~Scheduler() {
  {
    const std::scoped_lock lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
  if (worker_.joinable()) worker_.join();
}

bool Scheduler::can_start_now(const Queue& queue, std::span<const VkSubmitInfo> batches) const {
  if (running_ || queue.busy_ || !queue.pending_.empty()) return false;
  for (const VkSubmitInfo& batch : batches) {
    const Operations operations(batch);
    for (uint32_t i = 0; i < operations.wait_count(); ++i) {
      if (!satisfied(operations.wait(i))) return false;
    }
  }
  return true;
}

VkResult Scheduler::submit(Queue& queue, std::span<const VkSubmitInfo> batches, Fence* fence) {
  if (device_.lost()) return VK_ERROR_DEVICE_LOST;
  const bool heavy = worth_a_thread(batches);
  std::unique_lock lock(mutex_);
  if (heavy || !can_start_now(queue, batches)) {
    push_locked(queue, batches, fence);
    lock.unlock();
    changed_.notify_all();
    return VK_SUCCESS;
  }
  for (const VkSubmitInfo& batch : batches) {
    const Operations operations(batch);
    for (uint32_t i = 0; i < operations.wait_count(); ++i) operations.wait(i).semaphore->consume();
    running_ = queue.busy_ = true;
    lock.unlock();
    execute(queue, commands_of(batch));
    lock.lock();
    for (uint32_t i = 0; i < operations.signal_count(); ++i) {
      const SemaphoreOperation signal = operations.signal(i);
      signal.semaphore->signal(signal.value);
    }
  }
  finish_locked(queue, fence);
  return device_.lost() ? VK_ERROR_DEVICE_LOST : VK_SUCCESS;
}

// The results are what is known before the images are shown; what the window system says then is told by the next acquisition.
VkResult Scheduler::present(Queue& queue, const VkPresentInfoKHR& info) {
  if (device_.lost()) return VK_ERROR_DEVICE_LOST;
  const VkSubmitInfo batch{.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO,
                           .waitSemaphoreCount = info.waitSemaphoreCount,
                           .pWaitSemaphores = info.pWaitSemaphores};
  Work work(device_.allocator);
  for (uint32_t i = 0; i < info.swapchainCount; ++i) {
    work.presentations.push_back({from(info.pSwapchains[i]), info.pImageIndices[i]});
  }
  std::unique_lock lock(mutex_);
  const bool now = can_start_now(queue, {&batch, 1});
  if (!now) push_locked(queue, {&batch, 1}, nullptr);
  VkResult worst = VK_SUCCESS;
  for (uint32_t i = 0; i < info.swapchainCount; ++i) {
    const VkResult result = work.presentations[i].swapchain->queue_image(work.presentations[i].image);
    if (info.pResults) info.pResults[i] = result;
    worst = std::min(worst, result);
  }
  if (!now) {
    queue.pending_.back().presentations = std::move(work.presentations);
    lock.unlock();
    changed_.notify_all();
    return worst;
  }
  for (uint32_t i = 0; i < info.waitSemaphoreCount; ++i) from(info.pWaitSemaphores[i])->consume();
  running_ = queue.busy_ = true;
  lock.unlock();
  show(work.presentations);
  lock.lock();
  finish_locked(queue, nullptr);
  return worst;
}

// Everything that can fail comes before the queue changes.
void Scheduler::push_locked(Queue& queue, std::span<const VkSubmitInfo> batches, Fence* fence) {
  if (!worker_.joinable()) {
    try {
      const BlockedSignals blocked;
      worker_ = std::thread([this] { worker_main(); });
    } catch (const std::system_error&) {
      throw std::bad_alloc();  // no thread to be had: VK_ERROR_OUT_OF_HOST_MEMORY
    }
  }
  const size_t before = queue.pending_.size();
  try {
    for (size_t b = 0; b < std::max<size_t>(batches.size(), 1); ++b) {
      Work work(device_.allocator);
      work.sequence = next_sequence_++;
      if (b < batches.size()) {
        const Operations operations(batches[b]);
        const auto commands = commands_of(batches[b]);
        for (uint32_t i = 0; i < operations.wait_count(); ++i) work.waits.push_back(operations.wait(i));
        work.commands.assign(commands.begin(), commands.end());
        for (uint32_t i = 0; i < operations.signal_count(); ++i) work.signals.push_back(operations.signal(i));
      }
      queue.pending_.push_back(std::move(work));
    }
  } catch (...) {
    queue.pending_.erase(queue.pending_.begin() + ptrdiff_t(before), queue.pending_.end());
    throw;
  }
  queue.pending_.back().fence = fence;
}

// The queue whose front is the oldest that can start. After a loss everything can: it will not execute, but waits must end.
Queue* Scheduler::next_locked() {
  Queue* next = nullptr;
  if (running_) return nullptr;
  for (Queue& queue : device_.queues) {
    if (queue.busy_ || queue.pending_.empty()) continue;
    const Work& front = queue.pending_.front();
    if (next && next->pending_.front().sequence < front.sequence) continue;
    if (device_.lost() || std::ranges::all_of(front.waits, satisfied)) next = &queue;
  }
  return next;
}

void Scheduler::run_front_locked(Queue& queue, std::unique_lock<std::mutex>& lock) {
  const Work work = std::move(queue.pending_.front());
  queue.pending_.pop_front();
  for (const SemaphoreOperation& wait : work.waits) wait.semaphore->consume();
  running_ = queue.busy_ = true;
  lock.unlock();
  execute(queue, work.commands);
  show(work.presentations);
  lock.lock();
  for (const SemaphoreOperation& signal : work.signals) signal.semaphore->signal(signal.value);
  finish_locked(queue, work.fence);
}

void Scheduler::execute(Queue& queue, std::span<const CommandBuffer* const> commands) noexcept {
  if (commands.empty()) return;
  const ScopedFloatEnvironment environment;
  executing_queue_.store(&queue, std::memory_order_release);
  device_.watchdog.begin();
  try {
    for (const CommandBuffer* command_buffer : commands) {
      if (device_.lost()) break;
      executing_.store(command_buffer, std::memory_order_release);
      queue.executor_.run(*command_buffer);
    }
  } catch (const std::bad_alloc&) {
    device_.lose("out of host memory while commands were executed");
    queue.executor_.abandon();
  } catch (const std::exception& e) {
    device_.lose(e.what());
    queue.executor_.abandon();
  }
  device_.watchdog.end();
  executing_.store(nullptr, std::memory_order_release);
}

void Scheduler::show(std::span<const Presentation> presentations) noexcept {
  for (const Presentation& presentation : presentations) presentation.swapchain->show(presentation.image);
}

// A fence is signalled only when the baton is down again: who has waited for it must find the queue idle, or its next small
// submission would be handed to the worker. After a loss fences are signalled too, because waits must end.
void Scheduler::finish_locked(Queue& queue, Fence* fence) {
  running_ = queue.busy_ = false;
  if (fence) fence->signal();
  changed_.notify_all();
}

void Scheduler::pause() {
  device_.watchdog.end();
  change([&] { running_ = false; });
}

void Scheduler::resume() {
  {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return !running_; });
    running_ = true;
  }
  device_.watchdog.begin();
}

bool Scheduler::help() {
  std::unique_lock lock(mutex_);
  Queue* queue = next_locked();
  if (queue) run_front_locked(*queue, lock);
  return queue != nullptr;
}

bool Scheduler::idle_locked(const Queue* of) {
  return std::ranges::all_of(
      device_.queues, [&](const Queue& queue) { return (of && of != &queue) || (!queue.busy_ && queue.pending_.empty()); });
}

VkResult Scheduler::wait_idle(const Queue* queue) {
  std::unique_lock lock(mutex_);
  while (!idle_locked(queue)) {
    if (Queue* next = next_locked()) {
      run_front_locked(*next, lock);
    } else {
      changed_.wait(lock);
    }
  }
  return device_.lost() ? VK_ERROR_DEVICE_LOST : VK_SUCCESS;
}

void Scheduler::worker_main() {
  pthread_setname_np(pthread_self(), "pineda-queue");
  std::unique_lock lock(mutex_);
  for (;;) {
    Queue* next = nullptr;
    changed_.wait(lock, [&] { return (next = next_locked()) || (stopping_ && !running_); });
    if (!next) return;  // what is left waits for semaphores that nobody will signal
    run_front_locked(*next, lock);
  }
}

}  // namespace pineda::icd
