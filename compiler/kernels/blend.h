// One colour attachment at the end of a fragment kernel: blending, write mask, packing, store (Vulkan 1.3, section 30 "The
// Framebuffer").
#pragma once

#include <optional>

#include "compiler/compile.h"
#include "compiler/kernels/tile.h"

namespace pineda::kernels {

// Components that the state writes and the format has (bit c).
uint32_t written_components(const compiler::BlendState& state, const FormatInfo& format);

// What becomes of a colour on its way into an attachment.
struct ColorOperation {
  const compiler::BlendState& state;
  const FormatInfo& format;
  std::optional<VkLogicOp> logic_op;  // then nothing is blended
};
// Whether what the attachment held before can show in what is stored for a covered pixel.
bool reads_destination(const ColorOperation& operation);
// Empty when the operation can be done.
Result<void> check(const ColorOperation& operation);

// The shader's outputs: F32, or I32 for integer formats; unset components were not written.
struct ColorSources {
  Channels first{}, second{};  // second: of dual-source blending
};

// Combines the sources with the block's texels and stores the result for `covered` lanes.
void blend_and_store(ir::Builder& b, const ColorOperation& operation, TileBlock& block, const ColorSources& sources,
                     ir::Value covered);

}  // namespace pineda::kernels
