// The extensions, as data.
#pragma once

#include <span>
#include <string_view>

#include "icd/dispatch.h"
#include "icd/vulkan_api.h"

namespace pineda::icd {

struct InstanceExtension {
  VkExtensionProperties properties;
  Gate gate;
};

std::span<const InstanceExtension> instance_extensions();
std::span<const VkExtensionProperties> device_extensions();

}  // namespace pineda::icd
