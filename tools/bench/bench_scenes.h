// Scenes that each stress one part of a driver. `compare` and `render` know them as bench:NAME.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string_view>

#include "tools/scene.h"

namespace pineda::tools {

struct BenchScene {
  const char* name;
  const char* description;
  VkExtent2D extent;
  std::function<std::unique_ptr<Scene>()> create;
};

// Rows that show how others grow are left out unless they are asked for (`pineda bench --scaling`).
inline constexpr std::string_view kGrowthPrefix = "grow-";

std::span<const BenchScene> bench_scenes();

}  // namespace pineda::tools
