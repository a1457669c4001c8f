#include "icd/physical_device.h"

#include <sched.h>
#include <unistd.h>

#include <algorithm>
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
#include "icd/version.h"

namespace pineda::icd {
namespace {

VkDeviceSize control_group_limit_bytes() {
  std::ifstream file("/sys/fs/cgroup/memory.max");
  VkDeviceSize limit_bytes = 0;
  return file >> limit_bytes ? limit_bytes : ~VkDeviceSize{0};  // "max" and a missing file: none
}

std::string device_name() {
  static constexpr struct {
    jit::Isa isa;
    const char* text;
  } kIsaNames[] = {{jit::Isa::kSse42, "SSE4.2"}, {jit::Isa::kAvx2, "AVX2"}, {jit::Isa::kAvx512, "AVX-512"}};
  std::string text = "Pineda (";
  switch (config().mode) {
    case Mode::kF32:
      text += "f32 evaluator";
      break;
    case Mode::kF64:
      text += "f64 evaluator";
      break;
    case Mode::kJit:
    case Mode::kCheck: {
      std::string error;  // told again, as an error, by the first compile
      const jit::Isa isa = jit::select_isa(&error);
      for (const auto& row : kIsaNames) {
        if (row.isa == isa) text += row.text;
      }
      break;
    }
  }
  const uint32_t threads = render_threads();
  return text + ", " + std::to_string(threads) + (threads == 1 ? " thread)" : " threads)");
}

template <size_t kSize>
void copy_text(char (&to)[kSize], const std::string& text) {
  std::snprintf(to, kSize, "%s", text.c_str());
}

void fill(VkPhysicalDeviceDriverPropertiesKHR& to) {
  to.driverID = VkDriverId(0);  // ids are registered with Khronos; this driver has none yet
  copy_text(to.driverName, "Pineda");
  copy_text(to.driverInfo, std::string("Pineda ") + kDriverVersionText);
  to.conformanceVersion = {0, 0, 0, 0};  // nothing has been submitted
}

VkQueueFamilyProperties queue_family() {
  return {.queueFlags = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT | VK_QUEUE_TRANSFER_BIT,
          .queueCount = 1,
          .timestampValidBits = 64,
          .minImageTransferGranularity = {1, 1, 1}};
}

}  // namespace

VkDeviceSize memory_heap_bytes() {
  static const VkDeviceSize bytes =
      std::min(VkDeviceSize(sysconf(_SC_PHYS_PAGES)) * VkDeviceSize(sysconf(_SC_PAGESIZE)), control_group_limit_bytes());
  return bytes;
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
    std::memcpy(out->pipelineCacheUUID, kPipelineCacheUuid, VK_UUID_SIZE);
    return VK_SUCCESS;
  });
}

void api::GetPhysicalDeviceQueueFamilyProperties(VkPhysicalDevice, uint32_t* count, VkQueueFamilyProperties* out) {
  const VkQueueFamilyProperties families[] = {queue_family()};
  (void)enumerate(std::span<const VkQueueFamilyProperties>(families), count, out);
}

void api::GetPhysicalDeviceMemoryProperties(VkPhysicalDevice, VkPhysicalDeviceMemoryProperties* out) {
  *out = {.memoryTypeCount = kMemoryTypeCount, .memoryHeapCount = 1};
  out->memoryTypes[0] = {.propertyFlags = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT | VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT |
                                          VK_MEMORY_PROPERTY_HOST_COHERENT_BIT | VK_MEMORY_PROPERTY_HOST_CACHED_BIT,
                         .heapIndex = 0};
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

// ---- VK_KHR_get_physical_device_properties2: the same answers, and the structures that a chain asks for
// -------------------------

void api::GetPhysicalDeviceFeatures2KHR(VkPhysicalDevice, VkPhysicalDeviceFeatures2* out) { out->features = kFeatures; }

void api::GetPhysicalDeviceProperties2KHR(VkPhysicalDevice device, VkPhysicalDeviceProperties2* out) {
  GetPhysicalDeviceProperties(device, &out->properties);
  for (auto* next = static_cast<VkBaseOutStructure*>(out->pNext); next; next = next->pNext) {
    // Structures of extensions that we do not have stay as they are ("ignored").
    if (next->sType == VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES) {
      fill(*reinterpret_cast<VkPhysicalDeviceDriverProperties*>(next));
    }
  }
}

void api::GetPhysicalDeviceFormatProperties2KHR(VkPhysicalDevice, VkFormat format, VkFormatProperties2* out) {
  out->formatProperties = format_properties(format);
}

VkResult api::GetPhysicalDeviceImageFormatProperties2KHR(VkPhysicalDevice, const VkPhysicalDeviceImageFormatInfo2* info,
                                                         VkImageFormatProperties2* out) {
  return image_format_properties({info->format, info->type, info->tiling, info->usage, info->flags}, &out->imageFormatProperties);
}

void api::GetPhysicalDeviceQueueFamilyProperties2KHR(VkPhysicalDevice, uint32_t* count, VkQueueFamilyProperties2* out) {
  const VkQueueFamilyProperties families[] = {queue_family()};
  (void)enumerate(std::span<const VkQueueFamilyProperties>(families), count, out,
                  [](VkQueueFamilyProperties2& to, const VkQueueFamilyProperties& family) { to.queueFamilyProperties = family; });
}

void api::GetPhysicalDeviceMemoryProperties2KHR(VkPhysicalDevice device, VkPhysicalDeviceMemoryProperties2* out) {
  GetPhysicalDeviceMemoryProperties(device, &out->memoryProperties);
}

void api::GetPhysicalDeviceSparseImageFormatProperties2KHR(VkPhysicalDevice, const VkPhysicalDeviceSparseImageFormatInfo2*,
                                                           uint32_t* count, VkSparseImageFormatProperties2*) {
  *count = 0;
}

}  // namespace pineda::icd
