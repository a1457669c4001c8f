// Image sampling in IR (Vulkan 1.3, chapter 16 "Image Operations"). TextureState chooses the code; sizes, addresses, LOD limits
// and border colours are read from the descriptor. Precision: 8 bits of subtexel and of mip fraction, rounded to nearest;
// everything else is F32.
#pragma once

#include "compiler/compile.h"
#include "compiler/kernels/texel.h"

namespace pineda::kernels {

inline constexpr float kMaxSamplerLodBias = 16;  // VkPhysicalDeviceLimits::maxSamplerLodBias

struct SampleSource {
  const compiler::TextureState& state;
  ir::Value image;    // Ptr to an ImageDescriptor
  ir::Value sampler;  // Ptr to its sampler words or to a SamplerDescriptor
};

// Filtered sampling, gather, comparison, or texel fetch, as the request says.
Result<Channels> sample_image(ir::Builder& b, const SampleSource& source, const spirv::SampleRequest& request);

// Sizes and level count; a LOD query needs `source` (state and sampler).
Result<Channels> query_image(ir::Builder& b, ir::Value image, const SampleSource* source, const spirv::ImageQuery& query);

}  // namespace pineda::kernels
