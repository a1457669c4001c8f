// Vertex attributes: binding memory -> shader inputs (Vulkan 1.3, section 22.3 "Vertex Input Address Calculation").
#pragma once

#include "compiler/compile.h"
#include "compiler/kernels/texel.h"

namespace pineda::kernels {

// All four components of the attribute at `location` for this wave's vertices; (0, 0, 0, 1) where the format lacks one.
// Components are F32 or, for integer formats, I32. A location without an attribute gives an error.
Result<Channels> fetch_attribute(ir::Builder& b, const compiler::VertexState& state, uint32_t location, ir::Value vertex_index,
                                 ir::Value instance_index);

}  // namespace pineda::kernels
