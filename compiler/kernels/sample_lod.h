// Level of detail (Vulkan 1.3, section 16.7 "Level-of-Detail Operation" and "Image Level(s) Selection").
#pragma once

#include "compiler/kernels/sample.h"

namespace pineda::kernels {

struct LevelChoice {
  ir::Value magnify;   // B1; unset when both filters are the same or no LOD exists: then use the magnification filter
  ir::Value level0;    // I32; unset = level 0
  ir::Value level1;    // linear mip filter only
  ir::Value fraction;  // F32, weight of level1: a multiple of 1/256; unset = one level
};

uint32_t axis_count(VkImageViewType type);  // coordinates apart from the layer

// LOD after bias and clamping to the sampler's range; unset when the request has none (unnormalized coordinates).
ir::Value level_of_detail(ir::Builder& b, const SampleSource& source, const spirv::SampleRequest& request);
LevelChoice choose_levels(ir::Builder& b, const SampleSource& source, const spirv::SampleRequest& request);

}  // namespace pineda::kernels
