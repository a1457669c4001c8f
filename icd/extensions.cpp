#include "icd/extensions.h"

namespace pineda::icd {

std::span<const InstanceExtension> instance_extensions() {
  static constexpr InstanceExtension kExtensions[] = {
      {{VK_KHR_GET_PHYSICAL_DEVICE_PROPERTIES_2_EXTENSION_NAME, VK_KHR_GET_PHYSICAL_DEVICE_PROPERTIES_2_SPEC_VERSION},
       kProperties2},
      {{VK_EXT_DEBUG_UTILS_EXTENSION_NAME, VK_EXT_DEBUG_UTILS_SPEC_VERSION}, kDebugUtils},
  };
  return kExtensions;
}

std::span<const VkExtensionProperties> device_extensions() {
  static constexpr VkExtensionProperties kExtensions[] = {
      {VK_KHR_DRIVER_PROPERTIES_EXTENSION_NAME, VK_KHR_DRIVER_PROPERTIES_SPEC_VERSION},
      // Only a name in SPIR-V: what BufferBlock said before.
      {VK_KHR_STORAGE_BUFFER_STORAGE_CLASS_EXTENSION_NAME, VK_KHR_STORAGE_BUFFER_STORAGE_CLASS_SPEC_VERSION},
      // Accesses need no alignment in the IR, so blocks may be laid out as the extension allows.
      {VK_KHR_RELAXED_BLOCK_LAYOUT_EXTENSION_NAME, VK_KHR_RELAXED_BLOCK_LAYOUT_SPEC_VERSION},
  };
  return kExtensions;
}

}  // namespace pineda::icd
