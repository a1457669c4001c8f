// A small Vulkan 1.0 client: instance, device, one queue, and submission with a fence. All scenes and benchmark rows use it, with
// core features, VK_KHR_maintenance1 where the driver has it, and the modes of lines.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tools/vk/handles.h"

namespace pineda::tools {

void check(VkResult result, const char* what);  // throws ToolError naming the call and the result
const char* result_name(VkResult result);

struct DeviceInfo {
  std::string name, api_version;
  uint32_t driver_version = 0;
};

class VkContext {
 public:
  // With a list to write to, the validation layer is on, and its warnings and errors go there.
  explicit VkContext(std::vector<std::string>* validation_messages = nullptr);
  ~VkContext();
  VkContext(const VkContext&) = delete;
  VkContext& operator=(const VkContext&) = delete;

  VkDevice device() const { return device_; }
  VkPhysicalDevice physical_device() const { return physical_device_; }
  bool has_maintenance1() const { return has_maintenance1_; }      // viewports of negative height
  bool has_viewport_index() const { return has_viewport_index_; }  // several viewports, which the vertex shader chooses from
  VkQueue queue() const { return queue_; }
  DeviceInfo info() const;
  bool samples(VkFormat format) const;       // whether images of it can be sampled with linear filtering
  VkSampleCountFlags sample_counts() const;  // of colour and depth attachments together

  uint32_t memory_type(uint32_t allowed_types, VkMemoryPropertyFlags wanted) const;
  VkCommandBuffer record(const std::function<void(VkCommandBuffer)>& commands);  // freed with the context, or by release()
  void release(VkCommandBuffer commands);
  void submit_and_wait(VkCommandBuffer commands);
  void run_once(const std::function<void(VkCommandBuffer)>& commands);

 private:
  void create_instance(std::vector<std::string>* validation_messages);
  void create_device();

  VkInstance instance_ = VK_NULL_HANDLE;
  VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
  VkPhysicalDevice physical_device_ = VK_NULL_HANDLE;
  VkDevice device_ = VK_NULL_HANDLE;
  VkQueue queue_ = VK_NULL_HANDLE;
  uint32_t queue_family_ = 0;
  bool has_maintenance1_ = false, has_viewport_index_ = false;
  VkPhysicalDeviceMemoryProperties memory_properties_{};
  CommandPoolHandle command_pool_;
  FenceHandle fence_;
};

}  // namespace pineda::tools
