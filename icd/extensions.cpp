#include "icd/extensions.h"

#include <algorithm>
#include <array>
#include <string_view>

#include "icd/wsi/platform_api.h"

namespace pineda::icd {
namespace {

struct Row {
  GateScope scope;
  Extension extension;
};

constexpr Row kRows[] = {
#define PINEDA_EXTENSION(scope, NAME, gate) \
  {GateScope::scope, {{VK_##NAME##_EXTENSION_NAME, VK_##NAME##_SPEC_VERSION}, Gate::gate}},
#include "icd/extensions.inc"
};

template <GateScope kScope>
constexpr auto extensions_of() {
  constexpr size_t kCount = std::ranges::count(kRows, kScope, &Row::scope);
  std::array<Extension, kCount> found{};
  size_t next = 0;
  for (const Row& row : kRows) {
    if (row.scope == kScope) found[next++] = row.extension;
  }
  return found;
}

}  // namespace

std::span<const Extension> instance_extensions() {
  static constexpr auto kFound = extensions_of<GateScope::kInstance>();
  return kFound;
}

std::span<const Extension> device_extensions() {
  static constexpr auto kFound = extensions_of<GateScope::kDevice>();
  return kFound;
}

std::optional<GateSet> enabled_gates(std::span<const Extension> known, uint32_t count, const char* const* names) {
  GateSet gates;
  for (uint32_t i = 0; i < count; ++i) {
    const auto found = std::ranges::find_if(
        known, [&](const Extension& extension) { return std::string_view(extension.properties.extensionName) == names[i]; });
    if (found == known.end()) return std::nullopt;
    gates.add(found->gate);
  }
  return gates;
}

}  // namespace pineda::icd
