// The feature structures of Vulkan 1.1 and of extensions, as data (features.cpp). Vulkan 1.0's own is kFeatures in limits.h.
#pragma once

#include "icd/vulkan_api.h"

namespace pineda::icd {

// Fills every feature structure of an output chain that the driver knows; the others stay as they are.
void fill_features(void* chain);

// Whether all that is wanted is there, in Vulkan 1.0's structure and in a chain (VkPhysicalDeviceFeatures2 included).
bool features_available(const VkPhysicalDeviceFeatures& wanted);
bool features_available(const void* chain);

}  // namespace pineda::icd
