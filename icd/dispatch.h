// Name -> function, from commands.inc; and the gates that say which commands exist, from extensions.inc.
#pragma once

#include <bitset>
#include <cstdint>
#include <string_view>

#include "icd/vulkan_api.h"

namespace pineda::icd {

enum class Level : uint8_t { kGlobal, kInstance, kPhysical, kDevice };

// The extension that must be enabled for a command to exist; kCore: none.
enum class Gate : uint8_t {
  kCore,
#define PINEDA_EXTENSION(scope, NAME, gate) gate,
#include "icd/extensions.inc"
  kCount
};

enum class GateScope : uint8_t { kInstance, kDevice };
constexpr GateScope scope_of(Gate gate) {
  switch (gate) {
#define PINEDA_EXTENSION(scope, NAME, gate) \
  case Gate::gate:                          \
    return GateScope::scope;
#include "icd/extensions.inc"
    default:
      return GateScope::kInstance;
  }
}

// The gates that are open.
class GateSet {
 public:
  GateSet() { add(Gate::kCore); }
  void add(Gate gate) { bits_.set(size_t(gate)); }
  bool has(Gate gate) const { return bits_.test(size_t(gate)); }

 private:
  std::bitset<size_t(Gate::kCount)> bits_;
};

struct CommandEntry {
  std::string_view name;  // with vk
  PFN_vkVoidFunction function;
  Level level;
  Gate gate;
};

// Null when the driver has no command of that name.
const CommandEntry* find_command(std::string_view name);

}  // namespace pineda::icd
