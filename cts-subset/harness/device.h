// The device under test: the first physical device that the loader offers, with everything enabled that it supports.
#pragma once

#include <vulkan/vulkan.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <vector>

namespace pineda::cts {

void check(VkResult result, const char* call);  // throws Failure that names the call and the result

// What the driver reports. Structures of an extension (or core version) that it lacks stay zero.
struct Capabilities {
  uint32_t api_version = VK_API_VERSION_1_0;
  VkPhysicalDeviceProperties properties{};
  VkPhysicalDeviceFeatures features{};
  VkPhysicalDeviceMemoryProperties memory{};
  std::vector<VkQueueFamilyProperties> queue_families;
  std::set<std::string, std::less<>> extensions;
  VkPhysicalDeviceSubgroupProperties subgroup{};
  VkPhysicalDevice16BitStorageFeatures storage_16bit{};
  VkPhysicalDevice8BitStorageFeatures storage_8bit{};
  VkPhysicalDeviceShaderFloat16Int8Features float16_int8{};
  VkPhysicalDeviceMultiviewFeatures multiview{};
  VkPhysicalDeviceVariablePointersFeatures variable_pointers{};
  VkPhysicalDeviceShaderDrawParametersFeatures draw_parameters{};
  VkPhysicalDeviceScalarBlockLayoutFeatures scalar_layout{};
  VkPhysicalDeviceLineRasterizationFeaturesEXT lines{};
  VkPhysicalDeviceProvokingVertexFeaturesEXT provoking_vertex{};
  VkPhysicalDeviceDepthClipEnableFeaturesEXT depth_clip{};
  VkPhysicalDeviceCustomBorderColorFeaturesEXT custom_border{};
  VkPhysicalDeviceIndexTypeUint8FeaturesEXT index_uint8{};
};

class Device {
 public:
  Device();
  ~Device();
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  const Capabilities& caps() const { return caps_; }
  const VkPhysicalDeviceLimits& limits() const { return caps_.properties.limits; }
  bool has_extension(std::string_view name) const { return caps_.extensions.contains(name); }
  VkFormatProperties format(VkFormat format) const;
  VkInstance instance() const { return instance_; }
  VkPhysicalDevice physical() const { return physical_; }
  VkDevice handle() const { return device_; }
  VkQueue queue() const { return queue_; }
  uint32_t queue_family() const { return queue_family_; }

  uint32_t memory_type(uint32_t allowed_types, VkMemoryPropertyFlags wanted) const;  // throws when there is none
  // Records into a fresh command buffer, submits it and waits. A device loss throws.
  void run(const std::function<void(VkCommandBuffer)>& record);

 private:
  void create_instance();
  void query_capabilities();
  void create_device();

  VkInstance instance_ = VK_NULL_HANDLE;
  VkPhysicalDevice physical_ = VK_NULL_HANDLE;
  VkDevice device_ = VK_NULL_HANDLE;
  VkQueue queue_ = VK_NULL_HANDLE;
  VkCommandPool pool_ = VK_NULL_HANDLE;
  uint32_t queue_family_ = 0;
  Capabilities caps_;
};

Device& shared_device();  // made on first use
void discard_shared_device();

}  // namespace pineda::cts
