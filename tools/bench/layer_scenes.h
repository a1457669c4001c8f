// Layers that each cover the whole target.
#pragma once

#include <memory>

#include "tools/scene.h"

namespace pineda::tools {

enum class LayerKind { kOpaque, kBlended, kTrilinear, kTrilinearBc7, kTrilinearAstc, kLitFrontToBack };

std::unique_ptr<Scene> make_layer_scene(LayerKind kind, uint32_t layer_count);

}  // namespace pineda::tools
