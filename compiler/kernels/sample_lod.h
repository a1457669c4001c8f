// Level of detail (Vulkan 1.3, section 16.7 "Level-of-Detail Operation" and "Image Level(s) Selection").
#pragma once

#include "compiler/kernels/sample.h"

namespace pineda::kernels {

// A mip level for each lane; mostly the same one for the whole wave, and then what follows from it is scalar.
struct LevelIndex {
  ir::Value lane;     // I32; unset = level 0 of the view
  ir::Value uniform;  // B1, wave rate: all active lanes have the same level
  ir::Value wave;     // I32, wave rate: that level
  explicit operator bool() const { return static_cast<bool>(lane); }
};
LevelIndex level_index(ir::Builder& b, ir::Value lane_level);

struct LevelChoice {
  ir::Value magnify;  // B1; unset when both filters are the same or no LOD exists: then use the magnification filter
  LevelIndex level0;
  LevelIndex level1;   // linear mip filter only
  ir::Value fraction;  // F32, weight of level1: a multiple of 1/256; unset = one level
  // Anisotropic filtering: `probes` (I32, 1..16; unset = one) samples along `step`, in coordinates.
  ir::Value probes;
  std::array<ir::Value, 3> step{};
};

uint32_t axis_count(VkImageViewType type);  // coordinates apart from the layer; 3 for a cube's direction
bool is_array(VkImageViewType type);
bool is_cube(VkImageViewType type);

// LOD after bias and clamping to the sampler's range; unset when the request has none (unnormalized coordinates). The request has
// gradients or an explicit LOD (with_gradients).
ir::Value level_of_detail(ir::Builder& b, const SampleSource& source, const spirv::SampleRequest& request);
LevelChoice choose_levels(ir::Builder& b, const SampleSource& source, const spirv::SampleRequest& request);

}  // namespace pineda::kernels
