#include "icd/event.h"

#include "icd/api.h"
#include "icd/device.h"

namespace pineda::icd {

void Event::set() {
  set_.store(true, std::memory_order_release);
  device_.notifier.notify();
}

void Event::wait() const {
  device_.notifier.wait(Notifier::kForever, [&] { return is_set() || device_.lost(); });
}

VkResult api::CreateEvent(VkDevice device, const VkEventCreateInfo* info, const VkAllocationCallbacks* callbacks, VkEvent* out) {
  return create_device_object<Event>(device, info, callbacks, out);
}

void api::DestroyEvent(VkDevice device, VkEvent event, const VkAllocationCallbacks* callbacks) {
  destroy_device_object(device, event, callbacks);
}

VkResult api::GetEventStatus(VkDevice device, VkEvent event) {
  if (from(device)->lost()) return VK_ERROR_DEVICE_LOST;
  return from(event)->is_set() ? VK_EVENT_SET : VK_EVENT_RESET;
}

VkResult api::SetEvent(VkDevice, VkEvent event) {
  from(event)->set();
  return VK_SUCCESS;
}

VkResult api::ResetEvent(VkDevice, VkEvent event) {
  from(event)->reset();
  return VK_SUCCESS;
}

}  // namespace pineda::icd
