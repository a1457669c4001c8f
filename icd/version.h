// Who we are, in the numbers that Vulkan asks for.
#pragma once

#include "icd/vulkan_api.h"

namespace pineda::icd {

inline constexpr uint32_t kApiVersion = VK_MAKE_API_VERSION(0, 1, 1, VK_HEADER_VERSION);
inline constexpr uint32_t kDriverVersion = VK_MAKE_API_VERSION(0, 0, 1, 0);
inline constexpr const char* kDriverVersionText = "0.1.0";

// A vendor without a PCI id takes a Khronos vendor id (0x10000 and up) by registration. Pineda has none yet; 0 is assigned to
// nobody, so no client mistakes the driver for one it has workarounds for.
inline constexpr uint32_t kVendorId = 0;
inline constexpr uint32_t kDeviceId = 1;

}  // namespace pineda::icd
