#include "icd/instance.h"

#include "icd/api.h"
#include "icd/debug_utils.h"
#include "icd/enumerate.h"
#include "icd/extensions.h"
#include "icd/version.h"

namespace pineda::icd {

Instance::~Instance() { remove_messengers(*this); }

VkResult api::CreateInstance(const VkInstanceCreateInfo* info, const VkAllocationCallbacks* callbacks, VkInstance* out) {
  return guarded([&] {
    *out = VK_NULL_HANDLE;
    // Any 1.x is right for a driver of 1.1 and later; a variant is another API.
    const uint32_t api = info->pApplicationInfo ? info->pApplicationInfo->apiVersion : 0;
    if (VK_API_VERSION_VARIANT(api) != 0) return VK_ERROR_INCOMPATIBLE_DRIVER;
    if (info->enabledLayerCount != 0) return VK_ERROR_LAYER_NOT_PRESENT;
    const auto gates = enabled_gates(instance_extensions(), info->enabledExtensionCount, info->ppEnabledExtensionNames);
    if (!gates) return VK_ERROR_EXTENSION_NOT_PRESENT;
    auto instance = make_object<Instance>(Allocator(callbacks, Allocator()), VK_SYSTEM_ALLOCATION_SCOPE_INSTANCE, *gates);
    *out = to_handle(instance.release());
    return VK_SUCCESS;
  });
}

void api::DestroyInstance(VkInstance instance, const VkAllocationCallbacks* callbacks) {
  destroy_object(from(instance), callbacks, Allocator());
}

VkResult api::EnumerateInstanceVersion(uint32_t* out) {
  *out = kApiVersion;
  return VK_SUCCESS;
}

VkResult api::EnumerateInstanceExtensionProperties(const char* layer, uint32_t* count, VkExtensionProperties* out) {
  if (layer) return VK_ERROR_LAYER_NOT_PRESENT;
  return enumerate(instance_extensions(), count, out, [](VkExtensionProperties& to, const Extension& e) { to = e.properties; });
}

VkResult api::EnumerateInstanceLayerProperties(uint32_t* count, VkLayerProperties*) {
  *count = 0;
  return VK_SUCCESS;
}

VkResult api::EnumeratePhysicalDevices(VkInstance instance, uint32_t* count, VkPhysicalDevice* out) {
  const VkPhysicalDevice devices[] = {to_handle(&from(instance)->physical_device)};
  return enumerate(std::span<const VkPhysicalDevice>(devices), count, out);
}

}  // namespace pineda::icd
