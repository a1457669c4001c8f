// What the driver can do, as data (limits.cpp): the tables that vkGetPhysicalDevice* copy.
#pragma once

#include "icd/vulkan_api.h"

namespace pineda::icd {

inline constexpr uint32_t kMaxViews = 32;  // a view mask has 32 bits
// VkPhysicalDeviceMaintenance3Properties: a set of so many descriptors of any type has room (kMaxSetBytes).
inline constexpr uint32_t kMaxPerSetDescriptors = 65536;
// VkPhysicalDeviceDescriptorIndexingProperties: sets are read when commands are executed, so updates after a bind cost nothing.
inline constexpr uint32_t kMaxUpdateAfterBindDescriptors = 500'000;

extern const VkPhysicalDeviceLimits kLimits;
extern const VkPhysicalDeviceFeatures kFeatures;

}  // namespace pineda::icd
