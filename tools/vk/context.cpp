#include "tools/vk/context.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <string_view>
#include <vector>

#include "tools/error.h"

namespace pineda::tools {
namespace {

// Long enough for a frame of the f64 evaluator; the parent process has its own, shorter or longer, patience.
constexpr uint64_t kFenceTimeoutNs = 3'600'000'000'000;

VKAPI_ATTR VkBool32 VKAPI_CALL on_validation_message(VkDebugUtilsMessageSeverityFlagBitsEXT, VkDebugUtilsMessageTypeFlagsEXT,
                                                     const VkDebugUtilsMessengerCallbackDataEXT* data, void* user) {
  static_cast<std::vector<std::string>*>(user)->emplace_back(data->pMessage);
  return VK_FALSE;
}

VkDebugUtilsMessengerCreateInfoEXT messenger_info(std::vector<std::string>* messages) {
  return {.sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT,
          .messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT,
          .messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT,  // advice on speed is for other hardware
          .pfnUserCallback = on_validation_message,
          .pUserData = messages};
}

bool has_device_extension(VkPhysicalDevice device, std::string_view name) {
  uint32_t count = 0;
  check(vkEnumerateDeviceExtensionProperties(device, nullptr, &count, nullptr), "vkEnumerateDeviceExtensionProperties");
  std::vector<VkExtensionProperties> all(count);
  check(vkEnumerateDeviceExtensionProperties(device, nullptr, &count, all.data()), "vkEnumerateDeviceExtensionProperties");
  return std::ranges::any_of(all, [&](const VkExtensionProperties& one) { return name == one.extensionName; });
}

}  // namespace

const char* result_name(VkResult result) {
  switch (result) {
    case VK_SUCCESS:
      return "VK_SUCCESS";
    case VK_NOT_READY:
      return "VK_NOT_READY";
    case VK_TIMEOUT:
      return "VK_TIMEOUT";
    case VK_INCOMPLETE:
      return "VK_INCOMPLETE";
    case VK_ERROR_OUT_OF_HOST_MEMORY:
      return "VK_ERROR_OUT_OF_HOST_MEMORY";
    case VK_ERROR_OUT_OF_DEVICE_MEMORY:
      return "VK_ERROR_OUT_OF_DEVICE_MEMORY";
    case VK_ERROR_INITIALIZATION_FAILED:
      return "VK_ERROR_INITIALIZATION_FAILED";
    case VK_ERROR_DEVICE_LOST:
      return "VK_ERROR_DEVICE_LOST";
    case VK_ERROR_MEMORY_MAP_FAILED:
      return "VK_ERROR_MEMORY_MAP_FAILED";
    case VK_ERROR_LAYER_NOT_PRESENT:
      return "VK_ERROR_LAYER_NOT_PRESENT";
    case VK_ERROR_EXTENSION_NOT_PRESENT:
      return "VK_ERROR_EXTENSION_NOT_PRESENT";
    case VK_ERROR_FEATURE_NOT_PRESENT:
      return "VK_ERROR_FEATURE_NOT_PRESENT";
    case VK_ERROR_INCOMPATIBLE_DRIVER:
      return "VK_ERROR_INCOMPATIBLE_DRIVER";
    case VK_ERROR_TOO_MANY_OBJECTS:
      return "VK_ERROR_TOO_MANY_OBJECTS";
    case VK_ERROR_FORMAT_NOT_SUPPORTED:
      return "VK_ERROR_FORMAT_NOT_SUPPORTED";
    case VK_ERROR_FRAGMENTED_POOL:
      return "VK_ERROR_FRAGMENTED_POOL";
    case VK_ERROR_INVALID_SHADER_NV:
      return "VK_ERROR_INVALID_SHADER_NV";
    default:
      return "VK_ERROR_UNKNOWN";
  }
}

void check(VkResult result, const char* what) {
  if (result != VK_SUCCESS) fail("{} returned {} ({})", what, result_name(result), static_cast<int>(result));
}

VkContext::VkContext(std::vector<std::string>* validation_messages) {
  create_instance(validation_messages);
  create_device();
}

void VkContext::create_instance(std::vector<std::string>* validation_messages) {
  const char* const layer = "VK_LAYER_KHRONOS_validation";
  const char* const extension = VK_EXT_DEBUG_UTILS_EXTENSION_NAME;
  const VkApplicationInfo application{
      .sType = VK_STRUCTURE_TYPE_APPLICATION_INFO, .pApplicationName = "pineda", .apiVersion = VK_API_VERSION_1_0};
  const VkDebugUtilsMessengerCreateInfoEXT messenger = messenger_info(validation_messages);
  // The first is what VK_KHR_shader_float16_int8 depends on.
  const char* const extensions[] = {VK_KHR_GET_PHYSICAL_DEVICE_PROPERTIES_2_EXTENSION_NAME, extension};
  VkInstanceCreateInfo info{.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
                            .pApplicationInfo = &application,
                            .enabledExtensionCount = 1,
                            .ppEnabledExtensionNames = extensions};
  if (validation_messages) {
    info.pNext = &messenger;  // covers vkCreateInstance itself
    info.enabledLayerCount = 1;
    info.ppEnabledLayerNames = &layer;
    info.enabledExtensionCount = 2;
  }
  check(vkCreateInstance(&info, nullptr, &instance_), "vkCreateInstance");
  if (!validation_messages) return;
  const auto create =
      reinterpret_cast<PFN_vkCreateDebugUtilsMessengerEXT>(vkGetInstanceProcAddr(instance_, "vkCreateDebugUtilsMessengerEXT"));
  if (!create) fail("the Vulkan loader offers no {}", extension);
  check(create(instance_, &messenger, nullptr, &messenger_), "vkCreateDebugUtilsMessengerEXT");
}

void VkContext::create_device() {
  uint32_t device_count = 0;
  check(vkEnumeratePhysicalDevices(instance_, &device_count, nullptr), "vkEnumeratePhysicalDevices");
  if (device_count == 0) fail("the driver offers no Vulkan device");
  device_count = 1;  // each child process loads one driver, and its first device is the one
  const VkResult enumerated = vkEnumeratePhysicalDevices(instance_, &device_count, &physical_device_);
  if (enumerated != VK_INCOMPLETE) check(enumerated, "vkEnumeratePhysicalDevices");
  vkGetPhysicalDeviceMemoryProperties(physical_device_, &memory_properties_);

  uint32_t family_count = 0;
  vkGetPhysicalDeviceQueueFamilyProperties(physical_device_, &family_count, nullptr);
  std::vector<VkQueueFamilyProperties> families(family_count);
  vkGetPhysicalDeviceQueueFamilyProperties(physical_device_, &family_count, families.data());
  constexpr VkQueueFlags kNeeded = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT;
  while (queue_family_ < family_count && (families[queue_family_].queueFlags & kNeeded) != kNeeded) ++queue_family_;
  if (queue_family_ == family_count) fail("the driver offers no queue for graphics and compute");

  const float priority = 1.0f;
  const VkDeviceQueueCreateInfo queue_info{.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
                                           .queueFamilyIndex = queue_family_,
                                           .queueCount = 1,
                                           .pQueuePriorities = &priority};
  // What scenes use, where the driver has it.
  VkPhysicalDeviceFeatures available;
  vkGetPhysicalDeviceFeatures(physical_device_, &available);
  const VkPhysicalDeviceFeatures features{.fillModeNonSolid = available.fillModeNonSolid,
                                          .wideLines = available.wideLines,
                                          .largePoints = available.largePoints,
                                          .multiViewport = available.multiViewport,
                                          .samplerAnisotropy = available.samplerAnisotropy,
                                          .textureCompressionETC2 = available.textureCompressionETC2,
                                          .textureCompressionASTC_LDR = available.textureCompressionASTC_LDR,
                                          .textureCompressionBC = available.textureCompressionBC,
                                          .fragmentStoresAndAtomics = available.fragmentStoresAndAtomics,
                                          .shaderImageGatherExtended = available.shaderImageGatherExtended,
                                          .shaderClipDistance = available.shaderClipDistance,
                                          .shaderFloat64 = available.shaderFloat64};
  has_maintenance1_ = has_device_extension(physical_device_, VK_KHR_MAINTENANCE_1_EXTENSION_NAME);
  has_viewport_index_ =
      available.multiViewport && has_device_extension(physical_device_, VK_EXT_SHADER_VIEWPORT_INDEX_LAYER_EXTENSION_NAME);
  VkPhysicalDeviceLineRasterizationFeaturesEXT lines{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_LINE_RASTERIZATION_FEATURES_EXT};
  VkPhysicalDeviceShaderFloat16Int8Features half{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SHADER_FLOAT16_INT8_FEATURES,
                                                 .shaderFloat16 = VK_TRUE};
  const bool has_half = has_device_extension(physical_device_, VK_KHR_SHADER_FLOAT16_INT8_EXTENSION_NAME);
  const bool has_lines = has_device_extension(physical_device_, VK_EXT_LINE_RASTERIZATION_EXTENSION_NAME);
  if (has_lines) {
    VkPhysicalDeviceFeatures2 all{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, .pNext = &lines};
    const auto get = reinterpret_cast<PFN_vkGetPhysicalDeviceFeatures2KHR>(
        vkGetInstanceProcAddr(instance_, "vkGetPhysicalDeviceFeatures2KHR"));
    if (get) get(physical_device_, &all);
  }
  std::vector<const char*> extensions;
  void* chain = nullptr;
  if (has_maintenance1_) extensions.push_back(VK_KHR_MAINTENANCE_1_EXTENSION_NAME);
  if (has_viewport_index_) extensions.push_back(VK_EXT_SHADER_VIEWPORT_INDEX_LAYER_EXTENSION_NAME);
  if (has_half) {
    extensions.push_back(VK_KHR_SHADER_FLOAT16_INT8_EXTENSION_NAME);
    chain = &half;
  }
  if (has_lines) {
    extensions.push_back(VK_EXT_LINE_RASTERIZATION_EXTENSION_NAME);
    lines.pNext = chain;
    chain = &lines;
  }
  const VkDeviceCreateInfo info{.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                                .pNext = chain,
                                .queueCreateInfoCount = 1,
                                .pQueueCreateInfos = &queue_info,
                                .enabledExtensionCount = static_cast<uint32_t>(extensions.size()),
                                .ppEnabledExtensionNames = extensions.data(),
                                .pEnabledFeatures = &features};
  check(vkCreateDevice(physical_device_, &info, nullptr, &device_), "vkCreateDevice");
  vkGetDeviceQueue(device_, queue_family_, 0, &queue_);

  const VkCommandPoolCreateInfo pool_info{.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO, .queueFamilyIndex = queue_family_};
  VkCommandPool pool = VK_NULL_HANDLE;
  check(vkCreateCommandPool(device_, &pool_info, nullptr, &pool), "vkCreateCommandPool");
  command_pool_ = {device_, pool};
  const VkFenceCreateInfo fence_info{.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
  VkFence fence = VK_NULL_HANDLE;
  check(vkCreateFence(device_, &fence_info, nullptr, &fence), "vkCreateFence");
  fence_ = {device_, fence};
}

VkContext::~VkContext() {
  command_pool_ = {};
  fence_ = {};
  if (device_) vkDestroyDevice(device_, nullptr);
  if (messenger_) {
    const auto destroy = reinterpret_cast<PFN_vkDestroyDebugUtilsMessengerEXT>(
        vkGetInstanceProcAddr(instance_, "vkDestroyDebugUtilsMessengerEXT"));
    if (destroy) destroy(instance_, messenger_, nullptr);
  }
  if (instance_) vkDestroyInstance(instance_, nullptr);
}

bool VkContext::samples(VkFormat format) const {
  VkFormatProperties properties;
  vkGetPhysicalDeviceFormatProperties(physical_device_, format, &properties);
  return (properties.optimalTilingFeatures & VK_FORMAT_FEATURE_SAMPLED_IMAGE_FILTER_LINEAR_BIT) != 0;
}

VkSampleCountFlags VkContext::sample_counts() const {
  VkPhysicalDeviceProperties properties;
  vkGetPhysicalDeviceProperties(physical_device_, &properties);
  return properties.limits.framebufferColorSampleCounts & properties.limits.framebufferDepthSampleCounts;
}

DeviceInfo VkContext::info() const {
  VkPhysicalDeviceProperties properties;
  vkGetPhysicalDeviceProperties(physical_device_, &properties);
  const uint32_t version = properties.apiVersion;
  return {.name = properties.deviceName,
          .api_version = fmt::format("{}.{}.{}", VK_API_VERSION_MAJOR(version), VK_API_VERSION_MINOR(version),
                                     VK_API_VERSION_PATCH(version)),
          .driver_version = properties.driverVersion};
}

uint32_t VkContext::memory_type(uint32_t allowed_types, VkMemoryPropertyFlags wanted) const {
  for (uint32_t i = 0; i < memory_properties_.memoryTypeCount; ++i) {
    const bool allowed = (allowed_types >> i & 1u) != 0;
    if (allowed && (memory_properties_.memoryTypes[i].propertyFlags & wanted) == wanted) return i;
  }
  fail("no memory type has the properties {:#x} (allowed types {:#x})", wanted, allowed_types);
}

VkCommandBuffer VkContext::record(const std::function<void(VkCommandBuffer)>& commands) {
  const VkCommandBufferAllocateInfo allocate{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                             .commandPool = command_pool_,
                                             .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
                                             .commandBufferCount = 1};
  VkCommandBuffer buffer = VK_NULL_HANDLE;
  check(vkAllocateCommandBuffers(device_, &allocate, &buffer), "vkAllocateCommandBuffers");
  const VkCommandBufferBeginInfo begin{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
  check(vkBeginCommandBuffer(buffer, &begin), "vkBeginCommandBuffer");
  commands(buffer);
  check(vkEndCommandBuffer(buffer), "vkEndCommandBuffer");
  return buffer;
}

void VkContext::release(VkCommandBuffer commands) { vkFreeCommandBuffers(device_, command_pool_, 1, &commands); }

void VkContext::submit_and_wait(VkCommandBuffer commands) {
  const VkSubmitInfo submit{.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO, .commandBufferCount = 1, .pCommandBuffers = &commands};
  const VkFence fence = fence_;
  check(vkQueueSubmit(queue_, 1, &submit, fence), "vkQueueSubmit");
  check(vkWaitForFences(device_, 1, &fence, VK_TRUE, kFenceTimeoutNs), "vkWaitForFences");
  check(vkResetFences(device_, 1, &fence), "vkResetFences");
}

void VkContext::run_once(const std::function<void(VkCommandBuffer)>& commands) {
  const VkCommandBuffer buffer = record(commands);
  submit_and_wait(buffer);
  release(buffer);
}

}  // namespace pineda::tools
