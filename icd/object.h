// Handles and the border between API commands and C++.
//
// A handle is the object's address. Dispatchable objects start with the loader's word; their other members follow.
#pragma once

#include <exception>
#include <string>

#include "base/log.h"
#include "icd/allocator.h"
#include "icd/vulkan_api.h"

namespace pineda::icd {

// First base of Instance, PhysicalDevice, Device, Queue and CommandBuffer: the loader replaces the word by its dispatch table.
struct Dispatchable {
  uintptr_t loader_word = 0x01CDC0DE;  // ICD_LOADER_MAGIC of vk_icd.h
};

// from(handle) -> object, to_handle(object) -> handle, for one pair of types.
#define PINEDA_HANDLE(Type, VkType)                                            \
  class Type;                                                                  \
  inline Type* from(VkType handle) { return reinterpret_cast<Type*>(handle); } \
  inline VkType to_handle(Type* object) { return reinterpret_cast<VkType>(object); }

PINEDA_HANDLE(Instance, VkInstance)
PINEDA_HANDLE(PhysicalDevice, VkPhysicalDevice)
PINEDA_HANDLE(Device, VkDevice)
PINEDA_HANDLE(Queue, VkQueue)
PINEDA_HANDLE(CommandBuffer, VkCommandBuffer)
PINEDA_HANDLE(DeviceMemory, VkDeviceMemory)
PINEDA_HANDLE(Fence, VkFence)
PINEDA_HANDLE(Semaphore, VkSemaphore)
PINEDA_HANDLE(Event, VkEvent)
PINEDA_HANDLE(QueryPool, VkQueryPool)
PINEDA_HANDLE(Buffer, VkBuffer)
PINEDA_HANDLE(BufferView, VkBufferView)
PINEDA_HANDLE(Image, VkImage)
PINEDA_HANDLE(ImageView, VkImageView)
PINEDA_HANDLE(Sampler, VkSampler)
PINEDA_HANDLE(Framebuffer, VkFramebuffer)
PINEDA_HANDLE(RenderPass, VkRenderPass)
PINEDA_HANDLE(ShaderModule, VkShaderModule)
PINEDA_HANDLE(PipelineCache, VkPipelineCache)
PINEDA_HANDLE(Pipeline, VkPipeline)
PINEDA_HANDLE(PipelineLayout, VkPipelineLayout)
PINEDA_HANDLE(DescriptorSetLayout, VkDescriptorSetLayout)
PINEDA_HANDLE(DescriptorPool, VkDescriptorPool)
PINEDA_HANDLE(DescriptorSet, VkDescriptorSet)
PINEDA_HANDLE(DescriptorUpdateTemplate, VkDescriptorUpdateTemplate)
PINEDA_HANDLE(SamplerYcbcrConversion, VkSamplerYcbcrConversion)
PINEDA_HANDLE(Surface, VkSurfaceKHR)
PINEDA_HANDLE(Swapchain, VkSwapchainKHR)
PINEDA_HANDLE(CommandPool, VkCommandPool)
PINEDA_HANDLE(DebugMessenger, VkDebugUtilsMessengerEXT)
PINEDA_HANDLE(DebugReportCallback, VkDebugReportCallbackEXT)
#undef PINEDA_HANDLE

// Runs the body of an API command; every exception ends here.
template <typename Body>
VkResult guarded(Body&& body) noexcept {
  try {
    return body();
  } catch (const std::bad_alloc&) {
    return VK_ERROR_OUT_OF_HOST_MEMORY;
  } catch (const std::exception& e) {
    report(Severity::kError, std::string("unexpected failure: ") + e.what());
    return VK_ERROR_UNKNOWN;
  }
}

// Refuses what the driver does not do. VK_ERROR_FEATURE_NOT_PRESENT is the specification's code for "a requested feature is not
// supported"; for most commands it is not in the list of expected codes, because a valid application asks the feature bits first.
// The message says what it was.
[[nodiscard]] inline VkResult not_supported(std::string_view what) {
  report(Severity::kError, what);
  return VK_ERROR_FEATURE_NOT_PRESENT;
}

}  // namespace pineda::icd
