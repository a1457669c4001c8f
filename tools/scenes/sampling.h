// Scenes that show what samplers do: one triangle over the screen, one texture.
#pragma once

#include "tools/scene.h"

namespace pineda::tools {

enum class SamplingKind {
  kFiltering,
  kRecedingPlane,
  kCubeSeams,
  kBorders,
  kVolume,
  kShadowMap,
  kGathers,
  kUpscale,
  kLookupTable,
  kBlur
};

// `layer_count`: how often the screen is covered.
std::unique_ptr<Scene> make_sampling_scene(SamplingKind kind, uint32_t layer_count = 1);

}  // namespace pineda::tools
