#include "icd/semaphore.h"

#include <algorithm>

#include "icd/api.h"
#include "icd/chain.h"
#include "icd/device.h"

namespace pineda::icd {
namespace {

const VkSemaphoreTypeCreateInfo* type_info(const VkSemaphoreCreateInfo& info) {
  return find_in_chain<VkSemaphoreTypeCreateInfo>(info.pNext, VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO);
}

bool wants_timeline(const VkSemaphoreCreateInfo& info) {
  const auto* type = type_info(info);
  return type && type->semaphoreType == VK_SEMAPHORE_TYPE_TIMELINE;
}

}  // namespace

Semaphore::Semaphore(const Allocator& from, Device& device, const VkSemaphoreCreateInfo& info)
    : Object(from), device_(device), is_timeline_(wants_timeline(info)) {
  if (is_timeline_) value_ = type_info(info)->initialValue;
}

void Semaphore::signal(uint64_t value) {
  const uint64_t next = is_timeline_ ? std::max(value, value_.load(std::memory_order_relaxed)) : 1;
  value_.store(next, std::memory_order_release);
  if (is_timeline_) device_.notifier.notify();
}

void Semaphore::signal_from_host(uint64_t value) {
  device_.scheduler.change([&] { signal(value); });
}

VkResult api::CreateSemaphore(VkDevice device, const VkSemaphoreCreateInfo* info, const VkAllocationCallbacks* callbacks,
                              VkSemaphore* out) {
  return create_device_object<Semaphore>(device, info, callbacks, out);
}

void api::DestroySemaphore(VkDevice device, VkSemaphore semaphore, const VkAllocationCallbacks* callbacks) {
  destroy_device_object(device, semaphore, callbacks);
}

VkResult api::GetSemaphoreCounterValueKHR(VkDevice device, VkSemaphore semaphore, uint64_t* out) {
  *out = from(semaphore)->value();
  return from(device)->lost() ? VK_ERROR_DEVICE_LOST : VK_SUCCESS;
}

VkResult api::WaitSemaphoresKHR(VkDevice handle, const VkSemaphoreWaitInfo* info, uint64_t timeout_ns) {
  return guarded([&] {
    const auto reached = [&](uint32_t i) { return from(info->pSemaphores[i])->satisfies(info->pValues[i]); };
    const bool any = (info->flags & VK_SEMAPHORE_WAIT_ANY_BIT) != 0;
    return from(handle)->wait(timeout_ns, [&] {
      for (uint32_t i = 0; i < info->semaphoreCount; ++i) {
        if (reached(i) == any) return any;
      }
      return !any;
    });
  });
}

VkResult api::SignalSemaphoreKHR(VkDevice, const VkSemaphoreSignalInfo* info) {
  return guarded([&] {
    from(info->semaphore)->signal_from_host(info->value);
    return VK_SUCCESS;
  });
}

}  // namespace pineda::icd
