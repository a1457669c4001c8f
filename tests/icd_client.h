// A small Vulkan client for the driver's tests. Commands come straight from the driver's vk_icdGetInstanceProcAddr, as a loader
// would ask for them: so allocation callbacks see the driver's allocations only, and every command can be called.
#pragma once

#include <dlfcn.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <initializer_list>
#include <optional>
#include <span>
#include <vector>

#define VK_NO_PROTOTYPES
#include <vulkan/vulkan.h>

#include "base/format.h"
#include "tests/everything.h"
#include "tests/paths.h"
#include "tests/validation.h"

namespace pineda::test {

using NegotiateFn = VkResult (*)(uint32_t*);
using GetProcFn = PFN_vkVoidFunction (*)(VkInstance, const char*);

inline void* driver_symbol(const char* name) {
  static void* const library = dlopen((tests::build_dir() + "/libvk_pineda.so").c_str(), RTLD_NOW | RTLD_LOCAL);
  EXPECT_NE(library, nullptr) << dlerror();
  return library ? dlsym(library, name) : nullptr;
}

// The loader's vkGetInstanceProcAddr: validated tests (validation.h) are its clients.
inline PFN_vkGetInstanceProcAddr loader_proc() {
  static const auto get = [] {
    void* loader = dlopen("libvulkan.so.1", RTLD_NOW | RTLD_LOCAL);
    EXPECT_NE(loader, nullptr) << dlerror();
    return reinterpret_cast<PFN_vkGetInstanceProcAddr>(dlsym(loader, "vkGetInstanceProcAddr"));
  }();
  return get;
}

inline PFN_vkVoidFunction driver_proc(VkInstance instance, const char* name) {
  static const auto get = reinterpret_cast<GetProcFn>(driver_symbol("vk_icdGetInstanceProcAddr"));
  if (!is_validating()) return get(instance, name);
  const PFN_vkCreateInstance create = [](const VkInstanceCreateInfo* info, const VkAllocationCallbacks* callbacks,
                                         VkInstance* out) {
    return create_validated_instance(loader_proc(), *info, callbacks, out);
  };
  const PFN_vkDestroyInstance destroy = [](VkInstance gone, const VkAllocationCallbacks* callbacks) {
    destroy_validated_instance(loader_proc(), gone, callbacks);
  };
  if (std::strcmp(name, "vkCreateInstance") == 0) return reinterpret_cast<PFN_vkVoidFunction>(create);
  if (std::strcmp(name, "vkDestroyInstance") == 0) return reinterpret_cast<PFN_vkVoidFunction>(destroy);
  return loader_proc()(instance, name);
}

// VK(client, CreateFence)(...) calls vkCreateFence of the client's instance.
#define VK(client, name) reinterpret_cast<PFN_vk##name>(::pineda::test::driver_proc((client).instance, "vk" #name))

inline constexpr uint32_t kQueueFamilies = 3;
inline constexpr VkAccessFlags kAnyAccess = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT;

// What of the driver is enabled in instance and device besides what a test asks for.
enum class Enabled { kEverything, kOnlyAsked };

// Instance, device with a queue of each family, a command pool of the first family. Destruction waits for the queues.
class Client {
 public:
  explicit Client(const VkAllocationCallbacks* callbacks = nullptr, std::initializer_list<const char*> instance_extensions = {},
                  std::initializer_list<const char*> device_extensions = {}, Enabled enabled = Enabled::kEverything)
      : callbacks_(callbacks) {
    result = create_instance(instance_extensions, enabled);
    if (result != VK_SUCCESS) return;
    uint32_t count = 1;
    result = VK(*this, EnumeratePhysicalDevices)(instance, &count, &physical);
    if (result != VK_SUCCESS) return;
    result = create_device(device_extensions, enabled);
    if (result != VK_SUCCESS) return;
    VK(*this, GetDeviceQueue)(device, 0, 0, &queue);
    VkCommandPoolCreateInfo pool_info{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
    pool_info.flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT;
    result = VK(*this, CreateCommandPool)(device, &pool_info, callbacks, &pool);
  }
  ~Client() {
    if (device) VK(*this, DeviceWaitIdle)(device);
    for (const auto& release : cleanup_) release();
    if (pool) VK(*this, DestroyCommandPool)(device, pool, callbacks_);
    if (device) VK(*this, DestroyDevice)(device, callbacks_);
    if (instance) VK(*this, DestroyInstance)(instance, callbacks_);
  }
  Client(const Client&) = delete;

  // Runs before the device goes, in reverse order of the calls.
  void defer(std::function<void()> release) { cleanup_.insert(cleanup_.begin(), std::move(release)); }

  VkCommandBuffer command_buffer(VkCommandBufferLevel level = VK_COMMAND_BUFFER_LEVEL_PRIMARY) {
    const VkCommandBufferAllocateInfo info{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO, nullptr, pool, level, 1};
    VkCommandBuffer out = VK_NULL_HANDLE;
    EXPECT_EQ(VK(*this, AllocateCommandBuffers)(device, &info, &out), VK_SUCCESS);
    return out;
  }
  void begin(VkCommandBuffer command_buffer) {
    const VkCommandBufferBeginInfo info{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    EXPECT_EQ(VK(*this, BeginCommandBuffer)(command_buffer, &info), VK_SUCCESS);
  }
  VkResult submit(VkCommandBuffer command_buffer, VkFence fence = VK_NULL_HANDLE) {
    VkSubmitInfo info{VK_STRUCTURE_TYPE_SUBMIT_INFO};
    info.commandBufferCount = 1;
    info.pCommandBuffers = &command_buffer;
    return VK(*this, QueueSubmit)(queue, 1, &info, fence);
  }
  // Records, submits and waits.
  void run(const std::function<void(VkCommandBuffer)>& record) {
    const VkCommandBuffer cb = command_buffer();
    begin(cb);
    record(cb);
    EXPECT_EQ(VK(*this, EndCommandBuffer)(cb), VK_SUCCESS);
    EXPECT_EQ(submit(cb), VK_SUCCESS);
    EXPECT_EQ(VK(*this, QueueWaitIdle)(queue), VK_SUCCESS);
    VK(*this, FreeCommandBuffers)(device, pool, 1, &cb);
  }

  // Mapped memory of the only type.
  VkDeviceMemory memory(VkDeviceSize size_bytes, void** mapped = nullptr) {
    const VkMemoryAllocateInfo info{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, nullptr, size_bytes, 0};
    VkDeviceMemory out = VK_NULL_HANDLE;
    EXPECT_EQ(VK(*this, AllocateMemory)(device, &info, nullptr, &out), VK_SUCCESS);
    if (mapped) {
      EXPECT_EQ(VK(*this, MapMemory)(device, out, 0, VK_WHOLE_SIZE, 0, mapped), VK_SUCCESS);
    }
    defer([this, out] { VK(*this, FreeMemory)(device, out, nullptr); });
    return out;
  }

  struct Buffer {
    VkBuffer handle = VK_NULL_HANDLE;
    uint8_t* data = nullptr;
    template <typename T>
    T* as() const {
      return reinterpret_cast<T*>(data);
    }
  };
  Buffer buffer(VkDeviceSize size_bytes) {
    VkBufferCreateInfo info{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
    info.size = size_bytes;
    info.usage = VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT | VK_BUFFER_USAGE_STORAGE_BUFFER_BIT |
                 VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT | VK_BUFFER_USAGE_VERTEX_BUFFER_BIT | VK_BUFFER_USAGE_INDEX_BUFFER_BIT |
                 VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT | VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT |
                 VK_BUFFER_USAGE_STORAGE_TEXEL_BUFFER_BIT;
    Buffer out;
    EXPECT_EQ(VK(*this, CreateBuffer)(device, &info, nullptr, &out.handle), VK_SUCCESS);
    VkMemoryRequirements requirements;
    VK(*this, GetBufferMemoryRequirements)(device, out.handle, &requirements);
    void* mapped = nullptr;
    EXPECT_EQ(VK(*this, BindBufferMemory)(device, out.handle, memory(requirements.size, &mapped), 0), VK_SUCCESS);
    out.data = static_cast<uint8_t*>(mapped);
    defer([this, handle = out.handle] { VK(*this, DestroyBuffer)(device, handle, nullptr); });
    return out;
  }

  VkImage image(VkFormat format, VkExtent3D extent, uint32_t levels = 1, uint32_t layers = 1, VkImageUsageFlags usage = 0,
                VkImageType type = VK_IMAGE_TYPE_2D) {
    VkImageCreateInfo info{VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO};
    info.imageType = type;
    info.format = format;
    info.extent = extent;
    info.mipLevels = levels;
    info.arrayLayers = layers;
    info.samples = VK_SAMPLE_COUNT_1_BIT;
    info.usage = usage | VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT;
    VkImage out = VK_NULL_HANDLE;
    EXPECT_EQ(VK(*this, CreateImage)(device, &info, nullptr, &out), VK_SUCCESS);
    VkMemoryRequirements requirements;
    VK(*this, GetImageMemoryRequirements)(device, out, &requirements);
    EXPECT_EQ(VK(*this, BindImageMemory)(device, out, memory(requirements.size), 0), VK_SUCCESS);
    defer([this, out] { VK(*this, DestroyImage)(device, out, nullptr); });
    to_general(out, format);
    return out;
  }
  // Takes all of an image to another layout; whatever came before is seen by whatever follows.
  void transition(VkCommandBuffer cb, VkImage image, VkImageAspectFlags aspects, VkImageLayout from, VkImageLayout to) {
    const VkImageMemoryBarrier barrier{VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER,
                                       nullptr,
                                       kAnyAccess,
                                       kAnyAccess,
                                       from,
                                       to,
                                       VK_QUEUE_FAMILY_IGNORED,
                                       VK_QUEUE_FAMILY_IGNORED,
                                       image,
                                       {aspects, 0, VK_REMAINING_MIP_LEVELS, 0, VK_REMAINING_ARRAY_LAYERS}};
    VK(*this, CmdPipelineBarrier)
    (cb, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, 0, 0, nullptr, 0, nullptr, 1, &barrier);
  }
  // Takes a new image to VK_IMAGE_LAYOUT_GENERAL, in which tests use their images.
  void to_general(VkImage image, VkFormat format) {
    run([&](VkCommandBuffer cb) {
      transition(cb, image, find_format(format)->aspects, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_GENERAL);
    });
  }
  // What follows sees what came before.
  void barrier(VkCommandBuffer cb) {
    const VkMemoryBarrier all{VK_STRUCTURE_TYPE_MEMORY_BARRIER, nullptr, kAnyAccess, kAnyAccess};
    VK(*this, CmdPipelineBarrier)
    (cb, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, 0, 1, &all, 0, nullptr, 0, nullptr);
  }

  VkInstance instance = VK_NULL_HANDLE;
  VkPhysicalDevice physical = VK_NULL_HANDLE;
  VkDevice device = VK_NULL_HANDLE;
  VkQueue queue = VK_NULL_HANDLE;
  VkCommandPool pool = VK_NULL_HANDLE;
  VkResult result = VK_SUCCESS;  // of construction

 private:
  VkResult create_instance(std::initializer_list<const char*> asked, Enabled enabled) {
    const auto enumerate = reinterpret_cast<PFN_vkEnumerateInstanceExtensionProperties>(
        driver_proc(nullptr, "vkEnumerateInstanceExtensionProperties"));
    const ExtensionNames extensions(
        [&](uint32_t* count, VkExtensionProperties* out) {
          enabled == Enabled::kEverything ? enumerate(nullptr, count, out) : VK_SUCCESS;
        },
        asked);
    VkApplicationInfo application{VK_STRUCTURE_TYPE_APPLICATION_INFO};
    application.apiVersion = VK_API_VERSION_1_1;
    VkInstanceCreateInfo info{VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO};
    info.pApplicationInfo = &application;
    info.enabledExtensionCount = extensions.count();
    info.ppEnabledExtensionNames = extensions.data();
    return reinterpret_cast<PFN_vkCreateInstance>(driver_proc(nullptr, "vkCreateInstance"))(&info, callbacks_, &instance);
  }

  VkResult create_device(std::initializer_list<const char*> asked, Enabled enabled) {
    const bool everything = enabled == Enabled::kEverything;
    const ExtensionNames extensions(
        [&](uint32_t* count, VkExtensionProperties* out) {
          everything ? VK(*this, EnumerateDeviceExtensionProperties)(physical, nullptr, count, out) : VK_SUCCESS;
        },
        asked);
    uint32_t families = 0;
    VK(*this, GetPhysicalDeviceQueueFamilyProperties)(physical, &families, nullptr);
    EXPECT_EQ(families, kQueueFamilies);
    std::optional<FeatureChain> features;
    if (everything) features.emplace(VK(*this, GetPhysicalDeviceFeatures2), physical);
    const float priority = 1;
    VkDeviceQueueCreateInfo queues[kQueueFamilies];
    for (uint32_t i = 0; i < kQueueFamilies; ++i) {
      queues[i] = {VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO, nullptr, 0, i, 1, &priority};
    }
    VkDeviceCreateInfo info{VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO, features ? features->head() : nullptr};
    info.queueCreateInfoCount = kQueueFamilies;
    info.pQueueCreateInfos = queues;
    info.enabledExtensionCount = extensions.count();
    info.ppEnabledExtensionNames = extensions.data();
    return VK(*this, CreateDevice)(physical, &info, callbacks_, &device);
  }

  const VkAllocationCallbacks* callbacks_;
  std::vector<std::function<void()>> cleanup_;
};

inline VkImageSubresourceLayers color_layers(uint32_t level = 0, uint32_t first = 0, uint32_t count = 1) {
  return {VK_IMAGE_ASPECT_COLOR_BIT, level, first, count};
}

}  // namespace pineda::test
