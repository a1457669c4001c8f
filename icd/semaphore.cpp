#include "icd/semaphore.h"

#include "icd/api.h"
#include "icd/device.h"

namespace pineda::icd {

VkResult api::CreateSemaphore(VkDevice device, const VkSemaphoreCreateInfo* info, const VkAllocationCallbacks* callbacks,
                              VkSemaphore* out) {
  return create_device_object<Semaphore>(device, info, callbacks, out);
}

void api::DestroySemaphore(VkDevice device, VkSemaphore semaphore, const VkAllocationCallbacks* callbacks) {
  destroy_device_object(device, semaphore, callbacks);
}

}  // namespace pineda::icd
