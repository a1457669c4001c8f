#include "icd/fence.h"

#include <algorithm>
#include <span>

#include "icd/api.h"
#include "icd/device.h"

namespace pineda::icd {

Fence::Fence(const Allocator& from, Device& device, const VkFenceCreateInfo& info)
    : Object(from), device_(device), signaled_((info.flags & VK_FENCE_CREATE_SIGNALED_BIT) != 0) {}

void Fence::signal() {
  signaled_.store(true, std::memory_order_release);
  device_.notifier.notify();
}

VkResult api::CreateFence(VkDevice device, const VkFenceCreateInfo* info, const VkAllocationCallbacks* callbacks, VkFence* out) {
  return create_device_object<Fence>(device, info, callbacks, out);
}

void api::DestroyFence(VkDevice device, VkFence fence, const VkAllocationCallbacks* callbacks) {
  destroy_device_object(device, fence, callbacks);
}

VkResult api::ResetFences(VkDevice, uint32_t count, const VkFence* fences) {
  for (uint32_t i = 0; i < count; ++i) from(fences[i])->reset();
  return VK_SUCCESS;
}

VkResult api::GetFenceStatus(VkDevice device, VkFence fence) {
  if (from(device)->lost()) return VK_ERROR_DEVICE_LOST;
  return from(fence)->signaled() ? VK_SUCCESS : VK_NOT_READY;
}

VkResult api::WaitForFences(VkDevice handle, uint32_t count, const VkFence* fences, VkBool32 wait_all, uint64_t timeout_ns) {
  return guarded([&] {
    const std::span all(fences, count);
    const auto signaled = [](VkFence fence) { return from(fence)->signaled(); };
    return from(handle)->wait(timeout_ns,
                              [&] { return wait_all ? std::ranges::all_of(all, signaled) : std::ranges::any_of(all, signaled); });
  });
}

}  // namespace pineda::icd
