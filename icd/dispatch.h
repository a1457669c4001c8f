// Name -> function, from commands.inc.
#pragma once

#include <cstdint>
#include <string_view>

#include "icd/vulkan_api.h"

namespace pineda::icd {

enum class Level : uint8_t { kGlobal, kInstance, kPhysical, kDevice };

// The extension that must be enabled for a command to exist.
enum Gate : uint32_t { kCore = 0, kProperties2 = 1, kDebugUtils = 2, kMaintenance1 = 4 };
inline constexpr uint32_t kDeviceGates = kMaintenance1;  // the others are extensions of the instance

struct CommandEntry {
  std::string_view name;  // with vk
  PFN_vkVoidFunction function;
  Level level;
  Gate gate;
};

// Null when the driver has no command of that name.
const CommandEntry* find_command(std::string_view name);

}  // namespace pineda::icd
