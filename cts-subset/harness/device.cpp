#include "cts-subset/harness/device.h"

#include <fmt/format.h>

#include <algorithm>

#include "cts-subset/harness/case.h"

namespace pineda::cts {
namespace {

// The optional structures: where they come from, and where Capabilities keeps them. One table for asking and for enabling.
struct FeatureStruct {
  uint32_t core_version;  // 0: only by the extension
  const char* extension;
  VkStructureType type;
  void* (*member)(Capabilities&);
};

template <auto kMember>
void* member_of(Capabilities& caps) {
  return &(caps.*kMember);
}

constexpr FeatureStruct kFeatureStructs[] = {
    {VK_API_VERSION_1_1, VK_KHR_16BIT_STORAGE_EXTENSION_NAME, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_16BIT_STORAGE_FEATURES,
     member_of<&Capabilities::storage_16bit>},
    {VK_API_VERSION_1_1, VK_KHR_MULTIVIEW_EXTENSION_NAME, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MULTIVIEW_FEATURES,
     member_of<&Capabilities::multiview>},
    {VK_API_VERSION_1_1, VK_KHR_VARIABLE_POINTERS_EXTENSION_NAME, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VARIABLE_POINTERS_FEATURES,
     member_of<&Capabilities::variable_pointers>},
    {VK_API_VERSION_1_1, nullptr, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SHADER_DRAW_PARAMETERS_FEATURES,
     member_of<&Capabilities::draw_parameters>},
    {VK_API_VERSION_1_2, VK_KHR_8BIT_STORAGE_EXTENSION_NAME, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_8BIT_STORAGE_FEATURES,
     member_of<&Capabilities::storage_8bit>},
    {VK_API_VERSION_1_2, VK_KHR_SHADER_FLOAT16_INT8_EXTENSION_NAME,
     VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SHADER_FLOAT16_INT8_FEATURES, member_of<&Capabilities::float16_int8>},
    {VK_API_VERSION_1_2, VK_EXT_SCALAR_BLOCK_LAYOUT_EXTENSION_NAME,
     VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SCALAR_BLOCK_LAYOUT_FEATURES, member_of<&Capabilities::scalar_layout>},
    {0, VK_EXT_LINE_RASTERIZATION_EXTENSION_NAME, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_LINE_RASTERIZATION_FEATURES_EXT,
     member_of<&Capabilities::lines>},
    {0, VK_EXT_PROVOKING_VERTEX_EXTENSION_NAME, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROVOKING_VERTEX_FEATURES_EXT,
     member_of<&Capabilities::provoking_vertex>},
    {0, VK_EXT_DEPTH_CLIP_ENABLE_EXTENSION_NAME, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DEPTH_CLIP_ENABLE_FEATURES_EXT,
     member_of<&Capabilities::depth_clip>},
    {0, VK_EXT_CUSTOM_BORDER_COLOR_EXTENSION_NAME, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_CUSTOM_BORDER_COLOR_FEATURES_EXT,
     member_of<&Capabilities::custom_border>},
    {0, VK_EXT_INDEX_TYPE_UINT8_EXTENSION_NAME, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_INDEX_TYPE_UINT8_FEATURES_EXT,
     member_of<&Capabilities::index_uint8>},
};

// Extensions without a feature structure that cases use.
constexpr const char* kPlainExtensions[] = {
    VK_KHR_MAINTENANCE_1_EXTENSION_NAME,
    VK_KHR_MAINTENANCE_2_EXTENSION_NAME,
    VK_KHR_STORAGE_BUFFER_STORAGE_CLASS_EXTENSION_NAME,
    VK_KHR_RELAXED_BLOCK_LAYOUT_EXTENSION_NAME,
    VK_KHR_SAMPLER_MIRROR_CLAMP_TO_EDGE_EXTENSION_NAME,
    VK_KHR_SHADER_DRAW_PARAMETERS_EXTENSION_NAME,
    VK_EXT_SHADER_VIEWPORT_INDEX_LAYER_EXTENSION_NAME,
    VK_KHR_SWAPCHAIN_EXTENSION_NAME,
};

bool offered(const FeatureStruct& entry, const Capabilities& caps) {
  return (entry.core_version && caps.api_version >= entry.core_version) ||
         (entry.extension && caps.extensions.contains(std::string_view(entry.extension)));
}

// Links the offered structures into a chain; returns its head.
void* chain_features(Capabilities& caps) {
  VkBaseOutStructure* head = nullptr;
  for (const FeatureStruct& entry : kFeatureStructs) {
    if (!offered(entry, caps)) continue;
    auto* node = static_cast<VkBaseOutStructure*>(entry.member(caps));
    node->sType = entry.type;
    node->pNext = head;
    head = node;
  }
  return head;
}

std::unique_ptr<Device>& shared_slot() {
  static std::unique_ptr<Device> device;
  return device;
}

}  // namespace

void check(VkResult result, const char* call) {
  if (result < 0) throw Failure(fmt::format("{} returned {}", call, static_cast<int>(result)));
}

Device::Device() {
  create_instance();
  query_capabilities();
  create_device();
}

Device::~Device() {
  if (device_) {
    vkDeviceWaitIdle(device_);
    vkDestroyCommandPool(device_, pool_, nullptr);
    vkDestroyDevice(device_, nullptr);
  }
  vkDestroyInstance(instance_, nullptr);
}

void Device::create_instance() {
  uint32_t loader_version = VK_API_VERSION_1_0;
  vkEnumerateInstanceVersion(&loader_version);
  VkApplicationInfo application{VK_STRUCTURE_TYPE_APPLICATION_INFO};
  application.pApplicationName = "pineda-cts";
  application.apiVersion = std::min(loader_version, VK_API_VERSION_1_3);
  uint32_t count = 0;
  vkEnumerateInstanceExtensionProperties(nullptr, &count, nullptr);
  std::vector<VkExtensionProperties> offered(count);
  vkEnumerateInstanceExtensionProperties(nullptr, &count, offered.data());
  std::vector<const char*> extensions;
  for (const char* name : {VK_KHR_GET_PHYSICAL_DEVICE_PROPERTIES_2_EXTENSION_NAME, VK_KHR_SURFACE_EXTENSION_NAME,
                           VK_EXT_HEADLESS_SURFACE_EXTENSION_NAME}) {
    if (std::ranges::any_of(offered, [&](const auto& e) { return std::string_view(e.extensionName) == name; }))
      extensions.push_back(name);
  }
  VkInstanceCreateInfo info{VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO};
  info.pApplicationInfo = &application;
  info.enabledExtensionCount = static_cast<uint32_t>(extensions.size());
  info.ppEnabledExtensionNames = extensions.data();
  check(vkCreateInstance(&info, nullptr, &instance_), "vkCreateInstance");
}

void Device::query_capabilities() {
  uint32_t count = 1;
  check(vkEnumeratePhysicalDevices(instance_, &count, &physical_), "vkEnumeratePhysicalDevices");
  expect(count == 1, "there is no physical device");
  vkGetPhysicalDeviceProperties(physical_, &caps_.properties);
  vkGetPhysicalDeviceFeatures(physical_, &caps_.features);
  vkGetPhysicalDeviceMemoryProperties(physical_, &caps_.memory);
  caps_.api_version = caps_.properties.apiVersion;
  vkGetPhysicalDeviceQueueFamilyProperties(physical_, &count, nullptr);
  caps_.queue_families.resize(count);
  vkGetPhysicalDeviceQueueFamilyProperties(physical_, &count, caps_.queue_families.data());
  vkEnumerateDeviceExtensionProperties(physical_, nullptr, &count, nullptr);
  std::vector<VkExtensionProperties> extensions(count);
  vkEnumerateDeviceExtensionProperties(physical_, nullptr, &count, extensions.data());
  for (const VkExtensionProperties& extension : extensions) caps_.extensions.insert(extension.extensionName);

  VkPhysicalDeviceFeatures2 features{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, chain_features(caps_)};
  const auto get_features =
      reinterpret_cast<PFN_vkGetPhysicalDeviceFeatures2>(vkGetInstanceProcAddr(instance_, "vkGetPhysicalDeviceFeatures2KHR"));
  if (get_features) get_features(physical_, &features);
  if (caps_.api_version >= VK_API_VERSION_1_1) {
    caps_.subgroup.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES;
    VkPhysicalDeviceProperties2 properties{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &caps_.subgroup};
    vkGetPhysicalDeviceProperties2(physical_, &properties);
  }
}

void Device::create_device() {
  const VkQueueFlags wanted = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT;
  const auto family =
      std::ranges::find_if(caps_.queue_families, [&](const auto& f) { return (f.queueFlags & wanted) == wanted; });
  expect(family != caps_.queue_families.end(), "no queue family has graphics and compute");
  queue_family_ = static_cast<uint32_t>(family - caps_.queue_families.begin());

  std::vector<const char*> extensions;
  for (const FeatureStruct& entry : kFeatureStructs) {
    if (entry.extension && has_extension(entry.extension)) extensions.push_back(entry.extension);
  }
  for (const char* name : kPlainExtensions) {
    if (has_extension(name)) extensions.push_back(name);
  }
  const float priority = 1.0f;
  VkDeviceQueueCreateInfo queue{VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO};
  queue.queueFamilyIndex = queue_family_;
  queue.queueCount = 1;
  queue.pQueuePriorities = &priority;
  VkDeviceCreateInfo info{VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO, chain_features(caps_)};
  info.queueCreateInfoCount = 1;
  info.pQueueCreateInfos = &queue;
  info.enabledExtensionCount = static_cast<uint32_t>(extensions.size());
  info.ppEnabledExtensionNames = extensions.data();
  info.pEnabledFeatures = &caps_.features;
  check(vkCreateDevice(physical_, &info, nullptr, &device_), "vkCreateDevice");
  vkGetDeviceQueue(device_, queue_family_, 0, &queue_);
  VkCommandPoolCreateInfo pool{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
  pool.queueFamilyIndex = queue_family_;
  check(vkCreateCommandPool(device_, &pool, nullptr, &pool_), "vkCreateCommandPool");
}

VkFormatProperties Device::format(VkFormat format) const {
  VkFormatProperties properties;
  vkGetPhysicalDeviceFormatProperties(physical_, format, &properties);
  return properties;
}

uint32_t Device::memory_type(uint32_t allowed_types, VkMemoryPropertyFlags wanted) const {
  for (uint32_t i = 0; i < caps_.memory.memoryTypeCount; ++i) {
    if ((allowed_types >> i & 1) && (caps_.memory.memoryTypes[i].propertyFlags & wanted) == wanted) return i;
  }
  throw Failure("no memory type fits");
}

void Device::run(const std::function<void(VkCommandBuffer)>& record) {
  check(vkResetCommandPool(device_, pool_, 0), "vkResetCommandPool");
  VkCommandBufferAllocateInfo allocate{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
  allocate.commandPool = pool_;
  allocate.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
  allocate.commandBufferCount = 1;
  VkCommandBuffer commands;
  check(vkAllocateCommandBuffers(device_, &allocate, &commands), "vkAllocateCommandBuffers");
  VkCommandBufferBeginInfo begin{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
  begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
  check(vkBeginCommandBuffer(commands, &begin), "vkBeginCommandBuffer");
  record(commands);
  check(vkEndCommandBuffer(commands), "vkEndCommandBuffer");
  VkSubmitInfo submit{VK_STRUCTURE_TYPE_SUBMIT_INFO};
  submit.commandBufferCount = 1;
  submit.pCommandBuffers = &commands;
  check(vkQueueSubmit(queue_, 1, &submit, VK_NULL_HANDLE), "vkQueueSubmit");
  check(vkQueueWaitIdle(queue_), "vkQueueWaitIdle");
  vkFreeCommandBuffers(device_, pool_, 1, &commands);
}

Device& shared_device() {
  if (!shared_slot()) shared_slot() = std::make_unique<Device>();
  return *shared_slot();
}

void discard_shared_device() { shared_slot().reset(); }

}  // namespace pineda::cts
