#include "icd/extensions.h"

#include <algorithm>
#include <string_view>

namespace pineda::icd {

std::span<const Extension> instance_extensions() {
  static constexpr Extension kExtensions[] = {
      {{VK_KHR_GET_PHYSICAL_DEVICE_PROPERTIES_2_EXTENSION_NAME, VK_KHR_GET_PHYSICAL_DEVICE_PROPERTIES_2_SPEC_VERSION},
       kProperties2},
      {{VK_EXT_DEBUG_UTILS_EXTENSION_NAME, VK_EXT_DEBUG_UTILS_SPEC_VERSION}, kDebugUtils},
  };
  return kExtensions;
}

std::span<const Extension> device_extensions() {
  static constexpr Extension kExtensions[] = {
      {{VK_KHR_DRIVER_PROPERTIES_EXTENSION_NAME, VK_KHR_DRIVER_PROPERTIES_SPEC_VERSION}, kCore},
      // Negative viewport heights (raster/viewport.cpp), vkTrimCommandPool, copies between layers and slices.
      {{VK_KHR_MAINTENANCE_1_EXTENSION_NAME, VK_KHR_MAINTENANCE_1_SPEC_VERSION}, kMaintenance1},
      // Only a name in SPIR-V: what BufferBlock said before.
      {{VK_KHR_STORAGE_BUFFER_STORAGE_CLASS_EXTENSION_NAME, VK_KHR_STORAGE_BUFFER_STORAGE_CLASS_SPEC_VERSION}, kCore},
      // Accesses need no alignment in the IR, so blocks may be laid out as the extension allows.
      {{VK_KHR_RELAXED_BLOCK_LAYOUT_EXTENSION_NAME, VK_KHR_RELAXED_BLOCK_LAYOUT_SPEC_VERSION}, kCore},
  };
  return kExtensions;
}

std::optional<uint32_t> enabled_gates(std::span<const Extension> known, uint32_t count, const char* const* names) {
  uint32_t gates = 0;
  for (uint32_t i = 0; i < count; ++i) {
    const auto found = std::ranges::find_if(
        known, [&](const Extension& extension) { return std::string_view(extension.properties.extensionName) == names[i]; });
    if (found == known.end()) return std::nullopt;
    gates |= found->gate;
  }
  return gates;
}

}  // namespace pineda::icd
