// The property structures of Vulkan 1.1 and of extensions (properties.cpp). Vulkan 1.0's own is made in physical_device.cpp.
#pragma once

#include "icd/vulkan_api.h"

namespace pineda::icd {

// Fills every property structure of an output chain that the driver knows; the others stay as they are ("ignored").
void fill_properties(void* chain);

}  // namespace pineda::icd
