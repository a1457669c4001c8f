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
#include <span>
#include <vector>

#define VK_NO_PROTOTYPES
#include <vulkan/vulkan.h>

#include "tests/paths.h"

namespace pineda::test {

using NegotiateFn = VkResult (*)(uint32_t*);
using GetProcFn = PFN_vkVoidFunction (*)(VkInstance, const char*);

inline void* driver_symbol(const char* name) {
  static void* const library = dlopen((tests::build_dir() + "/libvk_pineda.so").c_str(), RTLD_NOW | RTLD_LOCAL);
  EXPECT_NE(library, nullptr) << dlerror();
  return library ? dlsym(library, name) : nullptr;
}

// PINEDA_TEST_LOADER=1 goes through the Vulkan loader instead, and so through the layers of VK_INSTANCE_LAYERS.
inline PFN_vkVoidFunction driver_proc(VkInstance instance, const char* name) {
  static const auto get = [] {
    if (!std::getenv("PINEDA_TEST_LOADER")) return reinterpret_cast<GetProcFn>(driver_symbol("vk_icdGetInstanceProcAddr"));
    void* loader = dlopen("libvulkan.so.1", RTLD_NOW | RTLD_LOCAL);
    EXPECT_NE(loader, nullptr) << dlerror();
    return reinterpret_cast<GetProcFn>(dlsym(loader, "vkGetInstanceProcAddr"));
  }();
  return get(instance, name);
}

// VK(client, CreateFence)(...) calls vkCreateFence of the client's instance.
#define VK(client, name) reinterpret_cast<PFN_vk##name>(::pineda::test::driver_proc((client).instance, "vk" #name))

// Instance, device, queue and a command pool. Destruction waits for the queue.
class Client {
 public:
  explicit Client(const VkAllocationCallbacks* callbacks = nullptr, std::initializer_list<const char*> instance_extensions = {},
                  std::initializer_list<const char*> device_extensions = {}, const void* device_chain = nullptr)
      : callbacks_(callbacks) {
    VkApplicationInfo application{VK_STRUCTURE_TYPE_APPLICATION_INFO};
    application.apiVersion = VK_API_VERSION_1_1;
    VkInstanceCreateInfo instance_info{VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO};
    instance_info.pApplicationInfo = &application;
    instance_info.enabledExtensionCount = static_cast<uint32_t>(instance_extensions.size());
    instance_info.ppEnabledExtensionNames = instance_extensions.begin();
    const auto create = reinterpret_cast<PFN_vkCreateInstance>(driver_proc(nullptr, "vkCreateInstance"));
    result = create(&instance_info, callbacks, &instance);
    if (result != VK_SUCCESS) return;
    uint32_t count = 1;
    result = VK(*this, EnumeratePhysicalDevices)(instance, &count, &physical);
    if (result != VK_SUCCESS) return;
    const float priority = 1;
    const VkDeviceQueueCreateInfo queue_info{VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO, nullptr, 0, 0, 1, &priority};
    VkDeviceCreateInfo device_info{VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO};
    device_info.queueCreateInfoCount = 1;
    device_info.pQueueCreateInfos = &queue_info;
    device_info.enabledExtensionCount = static_cast<uint32_t>(device_extensions.size());
    device_info.ppEnabledExtensionNames = device_extensions.begin();
    device_info.pNext = device_chain;
    result = VK(*this, CreateDevice)(physical, &device_info, callbacks, &device);
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
    return out;
  }

  VkInstance instance = VK_NULL_HANDLE;
  VkPhysicalDevice physical = VK_NULL_HANDLE;
  VkDevice device = VK_NULL_HANDLE;
  VkQueue queue = VK_NULL_HANDLE;
  VkCommandPool pool = VK_NULL_HANDLE;
  VkResult result = VK_SUCCESS;  // of construction

 private:
  const VkAllocationCallbacks* callbacks_;
  std::vector<std::function<void()>> cleanup_;
};

inline VkImageSubresourceLayers color_layers(uint32_t level = 0, uint32_t first = 0, uint32_t count = 1) {
  return {VK_IMAGE_ASPECT_COLOR_BIT, level, first, count};
}

}  // namespace pineda::test
