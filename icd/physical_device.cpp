#include "icd/physical_device.h"

#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstring>
#include <fstream>

#include "base/config.h"
#include "compiler/jit/jit.h"
#include "icd/api.h"
#include "icd/enumerate.h"
#include "icd/extensions.h"
#include "icd/format_caps.h"
#include "icd/limits.h"
#include "icd/pipeline_cache.h"
#include "icd/version.h"

namespace pineda::icd {
namespace {

VkDeviceSize control_group_limit_bytes() {
  std::ifstream file("/sys/fs/cgroup/memory.max");
  VkDeviceSize limit_bytes = 0;
  return file >> limit_bytes ? limit_bytes : ~VkDeviceSize{0};  // "max" and a missing file: none
}

std::string device_name() {
  const uint32_t threads = render_threads();
  return "Pineda (" + code_path_name() + ", " + std::to_string(threads) + (threads == 1 ? " thread)" : " threads)");
}

template <size_t kSize>
void copy_text(char (&to)[kSize], const std::string& text) {
  std::snprintf(to, kSize, "%s", text.c_str());
}

}  // namespace

std::span<const VkQueueFamilyProperties> queue_families() {
  static constexpr auto kFamily = [](VkQueueFlags flags) {
    return VkQueueFamilyProperties{
        .queueFlags = flags, .queueCount = 1, .timestampValidBits = 64, .minImageTransferGranularity = {1, 1, 1}};
  };
  static constexpr VkQueueFamilyProperties kFamilies[kQueueFamilyCount] = {
      kFamily(VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT | VK_QUEUE_TRANSFER_BIT),
      kFamily(VK_QUEUE_COMPUTE_BIT | VK_QUEUE_TRANSFER_BIT),
      kFamily(VK_QUEUE_TRANSFER_BIT),
  };
  return kFamilies;
}

VkDeviceSize memory_heap_bytes() {
  static const VkDeviceSize bytes =
      std::min(VkDeviceSize(sysconf(_SC_PHYS_PAGES)) * VkDeviceSize(sysconf(_SC_PAGESIZE)), control_group_limit_bytes());
  return bytes;
}

namespace {

std::atomic<int64_t> g_device_memory_bytes{0};

// MemAvailable of /proc/meminfo: what can be had without swapping; 0 when the file tells nothing.
VkDeviceSize available_memory_bytes() {
  std::ifstream file("/proc/meminfo");
  VkDeviceSize kib = 0;
  for (std::string name; file >> name; file.ignore(256, '\n')) {
    if (name == "MemAvailable:" && file >> kib) break;
  }
  return kib * 1024;
}

}  // namespace

VkDeviceSize device_memory_in_use() { return VkDeviceSize(std::max<int64_t>(g_device_memory_bytes.load(), 0)); }
void count_device_memory(int64_t change_bytes) { g_device_memory_bytes.fetch_add(change_bytes, std::memory_order_relaxed); }

VkDeviceSize memory_budget_bytes() {
  return std::clamp<VkDeviceSize>(device_memory_in_use() + available_memory_bytes(), 1, memory_heap_bytes());
}

std::string code_path_name() {
  static constexpr struct {
    jit::Isa isa;
    const char* text;
  } kIsaNames[] = {{jit::Isa::kSse42, "SSE4.2"}, {jit::Isa::kAvx2, "AVX2"}, {jit::Isa::kAvx512, "AVX-512"}};
  switch (config().mode) {
    case Mode::kF32:
      return "f32 evaluator";
    case Mode::kF64:
      return "f64 evaluator";
    case Mode::kJit:
    case Mode::kCheck:
      break;
  }
  std::string error;  // told again, as an error, by the first compile
  const jit::Isa isa = jit::select_isa(&error);
  for (const auto& row : kIsaNames) {
    if (row.isa == isa) return row.text;
  }
  return "unknown";
}

uint32_t render_threads() {
  if (config().threads != 0) return config().threads;
  cpu_set_t cpus;
  CPU_ZERO(&cpus);
  // Affinity, not the number of CPUs: containers and taskset narrow it.
  const int count = sched_getaffinity(0, sizeof(cpus), &cpus) == 0 ? CPU_COUNT(&cpus) : int(sysconf(_SC_NPROCESSORS_ONLN));
  return uint32_t(std::clamp(count, 1, 256));
}

void api::GetPhysicalDeviceFeatures(VkPhysicalDevice, VkPhysicalDeviceFeatures* out) { *out = kFeatures; }

void api::GetPhysicalDeviceProperties(VkPhysicalDevice, VkPhysicalDeviceProperties* out) {
  (void)guarded([&] {
    *out = {.apiVersion = kApiVersion,
            .driverVersion = kDriverVersion,
            .vendorID = kVendorId,
            .deviceID = kDeviceId,
            .deviceType = VK_PHYSICAL_DEVICE_TYPE_CPU,
            .limits = kLimits};
    copy_text(out->deviceName, device_name());
    get_pipeline_cache_uuid(out->pipelineCacheUUID);
    return VK_SUCCESS;
  });
}

void api::GetPhysicalDeviceQueueFamilyProperties(VkPhysicalDevice, uint32_t* count, VkQueueFamilyProperties* out) {
  (void)enumerate(queue_families(), count, out);
}

void api::GetPhysicalDeviceMemoryProperties(VkPhysicalDevice, VkPhysicalDeviceMemoryProperties* out) {
  *out = {.memoryTypeCount = kMemoryTypeCount, .memoryHeapCount = 1};
  out->memoryTypes[kMappedMemoryType] = {
      .propertyFlags = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT | VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT |
                       VK_MEMORY_PROPERTY_HOST_COHERENT_BIT | VK_MEMORY_PROPERTY_HOST_CACHED_BIT,
      .heapIndex = 0};
  out->memoryTypes[kLazyMemoryType] = {
      .propertyFlags = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT | VK_MEMORY_PROPERTY_LAZILY_ALLOCATED_BIT, .heapIndex = 0};
  out->memoryHeaps[0] = {.size = memory_heap_bytes(), .flags = VK_MEMORY_HEAP_DEVICE_LOCAL_BIT};
}

void api::GetPhysicalDeviceFormatProperties(VkPhysicalDevice, VkFormat format, VkFormatProperties* out) {
  *out = format_properties(format);
}

VkResult api::GetPhysicalDeviceImageFormatProperties(VkPhysicalDevice, VkFormat format, VkImageType type, VkImageTiling tiling,
                                                     VkImageUsageFlags usage, VkImageCreateFlags flags,
                                                     VkImageFormatProperties* out) {
  return image_format_properties({format, type, tiling, usage, flags}, out);
}

void api::GetPhysicalDeviceSparseImageFormatProperties(VkPhysicalDevice, VkFormat, VkImageType, VkSampleCountFlagBits,
                                                       VkImageUsageFlags, VkImageTiling, uint32_t* count,
                                                       VkSparseImageFormatProperties*) {
  *count = 0;
}

VkResult api::EnumerateDeviceExtensionProperties(VkPhysicalDevice, const char* layer, uint32_t* count,
                                                 VkExtensionProperties* out) {
  if (layer) return VK_ERROR_LAYER_NOT_PRESENT;
  return enumerate(device_extensions(), count, out, [](VkExtensionProperties& to, const Extension& e) { to = e.properties; });
}

VkResult api::EnumerateDeviceLayerProperties(VkPhysicalDevice, uint32_t* count, VkLayerProperties*) {
  *count = 0;
  return VK_SUCCESS;
}

}  // namespace pineda::icd
