// Scenes that show fixed-function state, a cell for each.
#pragma once

#include <memory>

#include "tools/scene.h"

namespace pineda::tools {

enum class StatesKind { kBlendModes, kStencil, kDepthBias, kLineModes, kRestart };
std::unique_ptr<Scene> make_states_scene(StatesKind kind);

}  // namespace pineda::tools
