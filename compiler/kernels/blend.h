// One colour attachment at the end of a fragment kernel: blending, write mask, packing, store (Vulkan 1.3, section 30 "The
// Framebuffer").
#pragma once

#include "compiler/compile.h"
#include "compiler/kernels/tile.h"

namespace pineda::kernels {

// Components that the state writes and the format has (bit c).
uint32_t written_components(const compiler::BlendState& state, const FormatInfo& format);
// Whether what the attachment held before can show in what is stored for a covered pixel.
bool reads_destination(const compiler::BlendState& state, const FormatInfo& format);

// Blends `source` (F32, or I32 for integer formats; unset components were not written by the shader) and stores it for `covered`
// lanes.
Result<void> blend_and_store(ir::Builder& b, const compiler::BlendState& state, const FormatInfo& format, TileBlock& block,
                             const Channels& source, ir::Value covered);

}  // namespace pineda::kernels
