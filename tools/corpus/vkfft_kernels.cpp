// Writes the SPIR-V of the kernels that VkFFT generates: it makes its GLSL for one device and one transform, so there is nothing
// to copy. Any Vulkan device will do; nothing is submitted.
//
//     vkfft_kernels OUT
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>

#define VKFFT_BACKEND 0
#include <vulkan/vulkan.h>

namespace {

std::filesystem::path folder;
std::string plan;
int number = 0;

// What VkFFT calls instead of vkCreateShaderModule.
VkResult keep_module(VkDevice device, const VkShaderModuleCreateInfo* info, const VkAllocationCallbacks* callbacks,
                     VkShaderModule* out) {
  std::ofstream(folder / (plan + "-" + std::to_string(number++) + ".spv"), std::ios::binary)
      .write(reinterpret_cast<const char*>(info->pCode), static_cast<std::streamsize>(info->codeSize));
  return vkCreateShaderModule(device, info, callbacks, out);
}

}  // namespace

#define vkCreateShaderModule keep_module
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wall"
#pragma GCC diagnostic ignored "-Wextra"
#pragma GCC diagnostic ignored "-Wformat-overflow"
#include <vkFFT.h>
#pragma GCC diagnostic pop
#undef vkCreateShaderModule

namespace {

struct Device {
  VkInstance instance = VK_NULL_HANDLE;
  VkPhysicalDevice physical = VK_NULL_HANDLE;
  VkDevice device = VK_NULL_HANDLE;
  VkQueue queue = VK_NULL_HANDLE;
  VkCommandPool pool = VK_NULL_HANDLE;
  VkFence fence = VK_NULL_HANDLE;

  bool open() {
    const VkApplicationInfo application{
        VK_STRUCTURE_TYPE_APPLICATION_INFO, nullptr, "vkfft_kernels", 0, nullptr, 0, VK_API_VERSION_1_1};
    VkInstanceCreateInfo instance_info{VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO};
    instance_info.pApplicationInfo = &application;
    if (vkCreateInstance(&instance_info, nullptr, &instance) != VK_SUCCESS) return false;
    uint32_t count = 1;
    if (vkEnumeratePhysicalDevices(instance, &count, &physical) < 0 || count == 0) return false;
    const float priority = 1;
    const VkDeviceQueueCreateInfo queue_info{VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO, nullptr, 0, 0, 1, &priority};
    VkPhysicalDeviceFeatures features{};
    features.shaderFloat64 = VK_TRUE;
    VkDeviceCreateInfo info{VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO};
    info.queueCreateInfoCount = 1;
    info.pQueueCreateInfos = &queue_info;
    info.pEnabledFeatures = &features;
    if (vkCreateDevice(physical, &info, nullptr, &device) != VK_SUCCESS) return false;
    vkGetDeviceQueue(device, 0, 0, &queue);
    const VkCommandPoolCreateInfo pool_info{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO, nullptr, 0, 0};
    const VkFenceCreateInfo fence_info{VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
    return vkCreateCommandPool(device, &pool_info, nullptr, &pool) == VK_SUCCESS &&
           vkCreateFence(device, &fence_info, nullptr, &fence) == VK_SUCCESS;
  }
};

struct Plan {
  const char* name;
  uint64_t x, y, z;
  bool real = false;
  int cosine = 0;  // type of the DCT
  bool wide = false;
};

// Every radix that VkFFT has, primes (Bluestein), lengths of one, two and three uploads, and each kind of transform.
constexpr Plan kPlans[] = {
    {"c2c-2", 2, 1, 1},
    {"c2c-8", 8, 1, 1},
    {"c2c-64", 64, 1, 1},
    {"c2c-256", 256, 1, 1},
    {"c2c-1024", 1024, 1, 1},
    {"c2c-4096", 4096, 1, 1},
    {"c2c-65536", 65536, 1, 1},
    {"c2c-1048576", 1048576, 1, 1},
    {"c2c-27", 27, 1, 1},
    {"c2c-125", 125, 1, 1},
    {"c2c-343", 343, 1, 1},
    {"c2c-121", 121, 1, 1},
    {"c2c-169", 169, 1, 1},
    {"c2c-15015", 15015, 1, 1},
    {"c2c-17", 17, 1, 1},
    {"c2c-97", 97, 1, 1},
    {"c2c-4099", 4099, 1, 1},
    {"c2c-64x64", 64, 64, 1},
    {"c2c-100x60", 100, 60, 1},
    {"c2c-512x512", 512, 512, 1},
    {"c2c-32x32x32", 32, 32, 32},
    {"r2c-256", 256, 1, 1, true},
    {"r2c-4096", 4096, 1, 1, true},
    {"r2c-128x64", 128, 64, 1, true},
    {"r2c-30x20x10", 30, 20, 10, true},
    {"dct1-33", 33, 1, 1, false, 1},
    {"dct2-64", 64, 1, 1, false, 2},
    {"dct3-64", 64, 1, 1, false, 3},
    {"dct4-64x64", 64, 64, 1, false, 4},
    {"f64-256", 256, 1, 1, false, 0, true},
    {"f64-97", 97, 1, 1, false, 0, true},
    {"f64-r2c-128", 128, 1, 1, true, 0, true},
};

bool generate(Device& d, const Plan& p) {
  plan = p.name;
  number = 0;
  VkFFTConfiguration configuration{};
  configuration.FFTdim = p.z > 1 ? 3 : p.y > 1 ? 2 : 1;
  configuration.size[0] = p.x;
  configuration.size[1] = p.y;
  configuration.size[2] = p.z;
  configuration.physicalDevice = &d.physical;
  configuration.device = &d.device;
  configuration.queue = &d.queue;
  configuration.commandPool = &d.pool;
  configuration.fence = &d.fence;
  configuration.isCompilerInitialized = 1;
  configuration.performR2C = p.real;
  configuration.performDCT = static_cast<uint64_t>(p.cosine);
  configuration.doublePrecision = p.wide;
  uint64_t bytes = (p.wide ? 16 : 8) * (p.real ? (p.x / 2 + 1) * 2 : p.x) * p.y * p.z;
  configuration.bufferSize = &bytes;
  VkFFTApplication application{};
  const VkFFTResult result = initializeVkFFT(&application, configuration);
  if (result == VKFFT_SUCCESS) deleteVkFFT(&application);
  if (result != VKFFT_SUCCESS) std::fprintf(stderr, "%s: VkFFT's error %d\n", p.name, static_cast<int>(result));
  return result == VKFFT_SUCCESS;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  folder = argv[1];
  std::filesystem::create_directories(folder);
  Device device;
  if (!device.open()) {
    std::fprintf(stderr, "vkfft_kernels: no Vulkan device\n");
    return 1;
  }
  glslang_initialize_process();
  int failed = 0;
  for (const Plan& p : kPlans) failed += !generate(device, p);
  glslang_finalize_process();
  return failed == 0 ? 0 : 1;
}
