#include "icd/queue.h"

#include <system_error>

#include "base/blocked_signals.h"
#include "base/float_environment.h"
#include "icd/api.h"
#include "icd/command_buffer.h"
#include "icd/device.h"
#include "icd/fence.h"

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

}  // namespace

Queue::Queue(Device& owner)
    : device_(owner), executor_(owner), pending_(HostAllocator<Work>(&owner.allocator, VK_SYSTEM_ALLOCATION_SCOPE_DEVICE)) {}

Queue::~Queue() {
  {
    const std::scoped_lock lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
  if (worker_.joinable()) worker_.join();
}

VkResult Queue::submit(std::span<const VkSubmitInfo> batches, Fence* fence) {
  if (device_.lost()) return VK_ERROR_DEVICE_LOST;
  const bool heavy = worth_a_thread(batches);
  std::unique_lock lock(mutex_);
  if (heavy || running_ || !pending_.empty()) {
    push_locked(batches, fence);
    lock.unlock();
    changed_.notify_all();
    return VK_SUCCESS;
  }
  if (!batches.empty()) {
    running_ = true;
    lock.unlock();
    for (const VkSubmitInfo& batch : batches) execute(commands_of(batch));
    lock.lock();
  }
  finish_locked(fence);
  return device_.lost() ? VK_ERROR_DEVICE_LOST : VK_SUCCESS;
}

// Everything that can fail comes before the queue changes.
void Queue::push_locked(std::span<const VkSubmitInfo> batches, Fence* fence) {
  if (!worker_.joinable()) {
    try {
      const BlockedSignals blocked;
      worker_ = std::thread([this] { worker_main(); });
    } catch (const std::system_error&) {
      throw std::bad_alloc();  // no thread to be had: VK_ERROR_OUT_OF_HOST_MEMORY
    }
  }
  Work work{HostVector<const CommandBuffer*>(HostAllocator<const CommandBuffer*>(&device_.allocator)), fence};
  for (const VkSubmitInfo& batch : batches) {
    const auto commands = commands_of(batch);
    work.commands.insert(work.commands.end(), commands.begin(), commands.end());
  }
  pending_.push_back(std::move(work));
}

void Queue::run_next_locked(std::unique_lock<std::mutex>& lock) {
  const Work work = std::move(pending_.front());
  pending_.pop_front();
  running_ = true;
  lock.unlock();
  execute(work.commands);
  lock.lock();
  finish_locked(work.fence);
}

void Queue::execute(std::span<const CommandBuffer* const> commands) noexcept {
  const ScopedFloatEnvironment environment;
  try {
    for (const CommandBuffer* command_buffer : commands) {
      if (device_.lost()) return;
      executor_.run(*command_buffer);
    }
  } catch (const std::bad_alloc&) {
    executor_.abandon();
    device_.lose("out of host memory while commands were executed");
  } catch (const std::exception& e) {
    executor_.abandon();
    device_.lose(e.what());
  }
}

// A fence is signalled only when running_ is down again: who has waited for it must find the queue idle, or its next small
// submission would be handed to the worker. After a loss fences are signalled too, because waits must end.
void Queue::finish_locked(Fence* fence) {
  running_ = false;
  if (fence) fence->signal();
  changed_.notify_all();
}

bool Queue::help() {
  std::unique_lock lock(mutex_);
  if (running_ || pending_.empty()) return false;
  run_next_locked(lock);
  return true;
}

VkResult Queue::wait_idle() {
  std::unique_lock lock(mutex_);
  while (running_ || !pending_.empty()) {
    if (!running_) {
      run_next_locked(lock);
    } else {
      changed_.wait(lock);
    }
  }
  return device_.lost() ? VK_ERROR_DEVICE_LOST : VK_SUCCESS;
}

void Queue::worker_main() {
  pthread_setname_np(pthread_self(), "pineda-queue");
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [&] { return (!running_ && !pending_.empty()) || (stopping_ && pending_.empty()); });
    if (pending_.empty()) return;
    run_next_locked(lock);
  }
}

VkResult api::QueueSubmit(VkQueue queue, uint32_t count, const VkSubmitInfo* batches, VkFence fence) {
  return guarded([&] { return from(queue)->submit({batches, count}, from(fence)); });
}

VkResult api::QueueWaitIdle(VkQueue queue) {
  return guarded([&] { return from(queue)->wait_idle(); });
}

// The queue family has no VK_QUEUE_SPARSE_BINDING_BIT and no sparse resource can be made, so a valid call binds nothing: the
// batches only order semaphores and a fence.
VkResult api::QueueBindSparse(VkQueue queue, uint32_t count, const VkBindSparseInfo* batches, VkFence fence) {
  return guarded([&] {
    for (uint32_t i = 0; i < count; ++i) {
      if (batches[i].bufferBindCount || batches[i].imageOpaqueBindCount || batches[i].imageBindCount) {
        return not_supported("vkQueueBindSparse: sparse resources are not supported");
      }
    }
    return from(queue)->submit({}, from(fence));
  });
}

}  // namespace pineda::icd
