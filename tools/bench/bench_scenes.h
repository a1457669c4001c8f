// Scenes that each stress one part of a driver. `compare` and `render` know them as bench:NAME.
#pragma once

#include <functional>
#include <memory>
#include <span>

#include "tools/scene.h"

namespace pineda::tools {

struct BenchScene {
  const char* name;
  const char* description;
  VkExtent2D extent;
  std::function<std::unique_ptr<Scene>()> create;
};

std::span<const BenchScene> bench_scenes();

}  // namespace pineda::tools
