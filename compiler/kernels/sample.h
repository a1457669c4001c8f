// Image sampling in IR (Vulkan 1.3, chapter 16 "Image Operations"). TextureState chooses the code; sizes, addresses, LOD limits
// and border colours are read from the descriptor. Precision: 8 bits of subtexel and of mip fraction, rounded to nearest;
// everything else is F32.
#pragma once

#include "compiler/compile.h"
#include "compiler/kernels/texel.h"

namespace pineda::kernels {

inline constexpr float kMaxSamplerLodBias = 16;  // VkPhysicalDeviceLimits::maxSamplerLodBias
inline constexpr float kMaxAnisotropy = 16;      // VkPhysicalDeviceLimits::maxSamplerAnisotropy

struct SampleSource {
  const compiler::TextureState& state;
  ir::Value image;    // Ptr to an ImageDescriptor
  ir::Value sampler;  // Ptr to its sampler words or to a SamplerDescriptor
};

// Filtered sampling, gather, comparison, or texel fetch, as the request says. What is computed does not depend on the
// surroundings (nothing is contracted into an FMA across its border), so a copy that is called gives the same bits
// (sample_call.h).
Result<Channels> sample_image(ir::Builder& b, const SampleSource& source, const spirv::SampleRequest& request);

Result<Channels> query_image(ir::Builder& b, ir::Value image, const spirv::ImageQuery& query);  // all kinds but kLod
Result<Channels> query_lod(ir::Builder& b, const SampleSource& source, const spirv::SampleRequest& request);
spirv::SampleRequest lod_request(ir::Builder& b, const spirv::ImageQuery& query);  // what a kLod query asks about

// An implicit LOD becomes one of gradients: the differences to a quad's first pixel, the same for its four pixels.
spirv::SampleRequest with_gradients(ir::Builder& b, spirv::SampleRequest request, uint32_t axes);

}  // namespace pineda::kernels
