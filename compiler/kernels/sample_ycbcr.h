// Images of several planes through a sampler YCbCr conversion (Vulkan 1.3, sections 16.5.7 "Chroma Reconstruction" and "Sampler
// Y'CbCr Conversion"). levels[p] of the descriptor is plane p; such views have one level and one layer, and address modes clamp.
#pragma once

#include "compiler/kernels/sample.h"

namespace pineda::kernels {

// The state has a conversion.
Result<Channels> sample_ycbcr(ir::Builder& b, const SampleSource& source, const spirv::SampleRequest& request);

}  // namespace pineda::kernels
