// What the driver can do, as data (limits.cpp): the tables that vkGetPhysicalDevice* copy.
#pragma once

#include "icd/vulkan_api.h"

namespace pineda::icd {

extern const VkPhysicalDeviceLimits kLimits;
extern const VkPhysicalDeviceFeatures kFeatures;

}  // namespace pineda::icd
