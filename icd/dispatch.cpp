#include "icd/dispatch.h"

#include <algorithm>
#include <array>

#include "icd/api.h"
#include "icd/wsi/platform_api.h"

namespace pineda::icd {
namespace {

PFN_vkVoidFunction erase(auto* function) { return reinterpret_cast<PFN_vkVoidFunction>(function); }

auto make_table() {
  std::array table{
#define PINEDA_GLOBAL(name) CommandEntry{"vk" #name, erase(&api::name), Level::kGlobal, Gate::kCore},
#define PINEDA_INSTANCE(name, gate) CommandEntry{"vk" #name, erase(&api::name), Level::kInstance, Gate::gate},
#define PINEDA_PHYSICAL(name, gate) CommandEntry{"vk" #name, erase(&api::name), Level::kPhysical, Gate::gate},
#define PINEDA_PLATFORM_INSTANCE(name, gate) CommandEntry{"vk" #name, erase(&api::name), Level::kInstance, Gate::gate},
#define PINEDA_PLATFORM_PHYSICAL(name, gate) CommandEntry{"vk" #name, erase(&api::name), Level::kPhysical, Gate::gate},
#define PINEDA_DEVICE(name, gate) CommandEntry{"vk" #name, erase(&api::name), Level::kDevice, Gate::gate},
#define PINEDA_COMMAND(name) CommandEntry{"vkCmd" #name, erase(&api::Cmd##name), Level::kDevice, Gate::kCore},
#define PINEDA_GATED_COMMAND(name, gate) CommandEntry{"vkCmd" #name, erase(&api::Cmd##name), Level::kDevice, Gate::gate},
#define PINEDA_ALIAS(alias, name, level, gate) CommandEntry{"vk" #alias, erase(&api::name), Level::level, Gate::gate},
#include "icd/commands.inc"
  };
  std::ranges::sort(table, {}, &CommandEntry::name);
  return table;
}

}  // namespace

const CommandEntry* find_command(std::string_view name) {
  static const auto table = make_table();
  const auto found = std::ranges::lower_bound(table, name, {}, &CommandEntry::name);
  return found != table.end() && found->name == name ? &*found : nullptr;
}

}  // namespace pineda::icd
