#include "icd/queue.h"

#include "icd/api.h"
#include "icd/device.h"

namespace pineda::icd {

Queue::Queue(Device& owner)
    : device(owner), executor_(owner), pending_(HostAllocator<Work>(&owner.allocator, VK_SYSTEM_ALLOCATION_SCOPE_DEVICE)) {}

VkResult api::QueueSubmit(VkQueue queue, uint32_t count, const VkSubmitInfo* batches, VkFence fence) {
  return guarded([&] { return from(queue)->device.scheduler.submit(*from(queue), {batches, count}, from(fence)); });
}

VkResult api::QueueWaitIdle(VkQueue queue) {
  return guarded([&] { return from(queue)->device.scheduler.wait_idle(from(queue)); });
}

// No queue family has VK_QUEUE_SPARSE_BINDING_BIT and no sparse resource can be made, so a valid call binds nothing: the batches
// only order semaphores and a fence.
VkResult api::QueueBindSparse(VkQueue queue, uint32_t count, const VkBindSparseInfo* batches, VkFence fence) {
  return guarded([&] {
    std::vector<VkSubmitInfo> submits;
    for (uint32_t i = 0; i < count; ++i) {
      const VkBindSparseInfo& batch = batches[i];
      if (batch.bufferBindCount || batch.imageOpaqueBindCount || batch.imageBindCount) {
        return not_supported("vkQueueBindSparse: sparse resources are not supported");
      }
      submits.push_back({.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO,
                         .pNext = batch.pNext,
                         .waitSemaphoreCount = batch.waitSemaphoreCount,
                         .pWaitSemaphores = batch.pWaitSemaphores,
                         .signalSemaphoreCount = batch.signalSemaphoreCount,
                         .pSignalSemaphores = batch.pSignalSemaphores});
    }
    return from(queue)->device.scheduler.submit(*from(queue), submits, from(fence));
  });
}

}  // namespace pineda::icd
