// The tests of one sample of a fragment wave against the depth and stencil tile buffers, and what they write (Vulkan 1.3,
// sections 29.4 "Depth Bounds Test", 29.5 "Stencil Test" and 29.6 "Depth Test").
#pragma once

#include <optional>

#include "compiler/compile.h"
#include "compiler/kernels/tile.h"

namespace pineda::kernels {

// Whether any of the tests is on. Without a depth test nothing is written to depth either.
bool has_depth_stencil(const compiler::FragmentState& state);

class DepthStencil {
 public:
  // `plane`: number of the sample's block in the tile buffers (I32, wave rate).
  DepthStencil(ir::Builder& b, const compiler::FragmentState& state, ir::Value plane);

  // Clamps and quantises z to the attachment's format: what is compared and stored. Nothing without a depth test.
  void set_depth(ir::Builder& b, ir::Value z);
  // The stencil reference that the shader exports (I32), instead of the state's.
  void set_stencil_reference(ir::Value reference) { exported_reference_ = reference; }
  // `covered` without the lanes that fail.
  ir::Value test(ir::Builder& b, ir::Value covered);
  // Of the lanes that the last test() was given: the stencil operations' results.
  void write_stencil(ir::Builder& b);
  // Stores the depth of the lanes of `passed` when writes are enabled.
  void write_depth(ir::Builder& b, ir::Value passed);

 private:
  ir::Value in_bounds(ir::Builder& b);
  ir::Value depth_passes(ir::Builder& b);
  ir::Value stencil_passes(ir::Builder& b);
  ir::Value face_value(ir::Builder& b, size_t offset_bytes);
  ir::Value stencil_reference(ir::Builder& b);
  ir::Value stored_depth(ir::Builder& b);

  const compiler::FragmentState& state_;
  const FormatInfo* depth_format_ = nullptr;
  std::optional<TileBlock> depth_, stencil_;
  ir::Value code_;                                    // I32
  ir::Value is_front_;                                // B1, primitive rate
  ir::Value exported_reference_;                      // I32
  ir::Value tested_, stencil_passed_, depth_passed_;  // B1, of the last test()
};

// `a` compared with `c` (both I32 codes, or F32) by a Vulkan comparison operator.
ir::Value compare(ir::Builder& b, VkCompareOp op, ir::Value a, ir::Value c);

}  // namespace pineda::kernels
