// The three exported symbols: the loader-driver interface, version 5 (LoaderDriverInterface.md of the Vulkan loader).
#include <algorithm>

#include "icd/api.h"
#include "icd/dispatch.h"
#include "icd/instance.h"

namespace pineda::icd {
namespace {

// 5: the driver checks VkApplicationInfo::apiVersion itself. 6 and 7 add nothing on Linux that this driver needs.
constexpr uint32_t kLoaderInterfaceVersion = 5;
// Before 3 the loader owned no surface objects and asked for names in other ways; nobody has shipped such a loader since 2016.
constexpr uint32_t kMinLoaderInterfaceVersion = 3;

}  // namespace

PFN_vkVoidFunction api::GetInstanceProcAddr(VkInstance handle, const char* name) {
  const CommandEntry* entry = find_command(name);
  if (!entry) return nullptr;
  const bool always =
      entry->level == Level::kGlobal || entry->function == reinterpret_cast<PFN_vkVoidFunction>(&api::GetInstanceProcAddr);
  if (always) return entry->function;
  return handle && from(handle)->has(entry->gate) ? entry->function : nullptr;
}

}  // namespace pineda::icd

#define PINEDA_EXPORT extern "C" __attribute__((visibility("default")))

PINEDA_EXPORT VkResult vk_icdNegotiateLoaderICDInterfaceVersion(uint32_t* version) {
  using namespace pineda::icd;
  if (*version < kMinLoaderInterfaceVersion) return VK_ERROR_INCOMPATIBLE_DRIVER;
  *version = std::min(*version, kLoaderInterfaceVersion);
  return VK_SUCCESS;
}

PINEDA_EXPORT PFN_vkVoidFunction vk_icdGetInstanceProcAddr(VkInstance instance, const char* name) {
  return pineda::icd::api::GetInstanceProcAddr(instance, name);
}

// Only commands of the physical device: the loader wraps these, and passes everything else by other ways.
PINEDA_EXPORT PFN_vkVoidFunction vk_icdGetPhysicalDeviceProcAddr(VkInstance instance, const char* name) {
  using namespace pineda::icd;
  const CommandEntry* entry = find_command(name);
  if (!entry || entry->level != Level::kPhysical) return nullptr;
  return !instance || from(instance)->has(entry->gate) ? entry->function : nullptr;
}
