// Queries of the physical device that Vulkan 1.1 added: the same answers as Vulkan 1.0's, and the structures that a chain asks
// for.
#include "icd/api.h"
#include "icd/chain.h"
#include "icd/enumerate.h"
#include "icd/features.h"
#include "icd/format_caps.h"
#include "icd/instance.h"
#include "icd/limits.h"
#include "icd/physical_device.h"
#include "icd/properties.h"

namespace pineda::icd {

void api::GetPhysicalDeviceFeatures2(VkPhysicalDevice, VkPhysicalDeviceFeatures2* out) {
  out->features = kFeatures;
  fill_features(out->pNext);
}

void api::GetPhysicalDeviceProperties2(VkPhysicalDevice device, VkPhysicalDeviceProperties2* out) {
  GetPhysicalDeviceProperties(device, &out->properties);
  (void)guarded([&] {
    fill_properties(out->pNext);
    return VK_SUCCESS;
  });
}

void api::GetPhysicalDeviceFormatProperties2(VkPhysicalDevice, VkFormat format, VkFormatProperties2* out) {
  out->formatProperties = format_properties(format);
}

VkResult api::GetPhysicalDeviceImageFormatProperties2(VkPhysicalDevice, const VkPhysicalDeviceImageFormatInfo2* info,
                                                      VkImageFormatProperties2* out) {
  const auto* external = find_in_chain<VkPhysicalDeviceExternalImageFormatInfo>(
      info->pNext, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_EXTERNAL_IMAGE_FORMAT_INFO);
  if (external && external->handleType != 0) return VK_ERROR_FORMAT_NOT_SUPPORTED;  // nothing is shared
  if (auto* to = find_in_chain<VkExternalImageFormatProperties>(out->pNext, VK_STRUCTURE_TYPE_EXTERNAL_IMAGE_FORMAT_PROPERTIES)) {
    to->externalMemoryProperties = {};
  }
  if (auto* to = find_in_chain<VkSamplerYcbcrConversionImageFormatProperties>(
          out->pNext, VK_STRUCTURE_TYPE_SAMPLER_YCBCR_CONVERSION_IMAGE_FORMAT_PROPERTIES)) {
    to->combinedImageSamplerDescriptorCount = 1;
  }
  const auto* stencil =
      find_in_chain<VkImageStencilUsageCreateInfo>(info->pNext, VK_STRUCTURE_TYPE_IMAGE_STENCIL_USAGE_CREATE_INFO);
  return image_format_properties(
      {info->format, info->type, info->tiling, info->usage, info->flags, stencil ? stencil->stencilUsage : 0},
      &out->imageFormatProperties);
}

void api::GetPhysicalDeviceQueueFamilyProperties2(VkPhysicalDevice, uint32_t* count, VkQueueFamilyProperties2* out) {
  (void)enumerate(queue_families(), count, out,
                  [](VkQueueFamilyProperties2& to, const VkQueueFamilyProperties& family) { to.queueFamilyProperties = family; });
}

void api::GetPhysicalDeviceMemoryProperties2(VkPhysicalDevice device, VkPhysicalDeviceMemoryProperties2* out) {
  GetPhysicalDeviceMemoryProperties(device, &out->memoryProperties);
  if (auto* to = find_in_chain<VkPhysicalDeviceMemoryBudgetPropertiesEXT>(
          out->pNext, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MEMORY_BUDGET_PROPERTIES_EXT)) {
    for (uint32_t i = 0; i < VK_MAX_MEMORY_HEAPS; ++i) to->heapBudget[i] = to->heapUsage[i] = 0;
    (void)guarded([&] {
      to->heapUsage[0] = device_memory_in_use();
      to->heapBudget[0] = memory_budget_bytes();
      return VK_SUCCESS;
    });
  }
}

void api::GetPhysicalDeviceSparseImageFormatProperties2(VkPhysicalDevice, const VkPhysicalDeviceSparseImageFormatInfo2*,
                                                        uint32_t* count, VkSparseImageFormatProperties2*) {
  *count = 0;
}

// Handles of other drivers and processes can be neither imported nor exported: no features, nothing compatible.
void api::GetPhysicalDeviceExternalBufferProperties(VkPhysicalDevice, const VkPhysicalDeviceExternalBufferInfo*,
                                                    VkExternalBufferProperties* out) {
  out->externalMemoryProperties = {};
}

void api::GetPhysicalDeviceExternalFenceProperties(VkPhysicalDevice, const VkPhysicalDeviceExternalFenceInfo*,
                                                   VkExternalFenceProperties* out) {
  out->exportFromImportedHandleTypes = 0;
  out->compatibleHandleTypes = 0;
  out->externalFenceFeatures = 0;
}

void api::GetPhysicalDeviceExternalSemaphoreProperties(VkPhysicalDevice, const VkPhysicalDeviceExternalSemaphoreInfo*,
                                                       VkExternalSemaphoreProperties* out) {
  out->exportFromImportedHandleTypes = 0;
  out->compatibleHandleTypes = 0;
  out->externalSemaphoreFeatures = 0;
}

// Every device is a group of one.
VkResult api::EnumeratePhysicalDeviceGroups(VkInstance instance, uint32_t* count, VkPhysicalDeviceGroupProperties* out) {
  const VkPhysicalDevice devices[] = {to_handle(&from(instance)->physical_device)};
  return enumerate(std::span<const VkPhysicalDevice>(devices), count, out,
                   [](VkPhysicalDeviceGroupProperties& to, const VkPhysicalDevice& device) {
                     to.physicalDeviceCount = 1;
                     to.physicalDevices[0] = device;
                     to.subsetAllocation = VK_FALSE;
                   });
}

}  // namespace pineda::icd
