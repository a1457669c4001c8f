// The extensions, as data: extensions.inc.
#pragma once

#include <optional>
#include <span>

#include "icd/dispatch.h"
#include "icd/vulkan_api.h"

namespace pineda::icd {

struct Extension {
  VkExtensionProperties properties;
  Gate gate;
};

std::span<const Extension> instance_extensions();
std::span<const Extension> device_extensions();

// Gates of the named extensions; nothing when one is not among the known.
std::optional<GateSet> enabled_gates(std::span<const Extension> known, uint32_t count, const char* const* names);

}  // namespace pineda::icd
