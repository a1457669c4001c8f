// The extensions, as data.
#pragma once

#include <optional>
#include <span>
#include <string_view>

#include "icd/dispatch.h"
#include "icd/vulkan_api.h"

namespace pineda::icd {

struct Extension {
  VkExtensionProperties properties;
  Gate gate;  // of its commands; kCore when it has none
};

std::span<const Extension> instance_extensions();
std::span<const Extension> device_extensions();

// Gate bits of the named extensions; nothing when one is not among the known.
std::optional<uint32_t> enabled_gates(std::span<const Extension> known, uint32_t count, const char* const* names);

}  // namespace pineda::icd
