// The depth test of a fragment wave against its tile buffer (Vulkan 1.3, section 29.6 "Depth Test").
#pragma once

#include <optional>

#include "compiler/compile.h"
#include "compiler/kernels/tile.h"

namespace pineda::kernels {

class DepthTest {
 public:
  // Inactive when the state has no depth attachment or the test is off (then nothing is written either).
  DepthTest(ir::Builder& b, const compiler::FragmentState& state, ir::Value block_index);

  bool active() const { return format_ != nullptr; }
  // Clamps and quantises z to the attachment's format: what is compared and stored.
  void set_depth(ir::Builder& b, ir::Value z);
  // `covered` without the lanes that fail.
  ir::Value test(ir::Builder& b, ir::Value covered);
  // Stores the depth of the lanes of `passed` when writes are enabled.
  void write(ir::Builder& b, ir::Value passed);

 private:
  const compiler::DepthState state_;
  const bool depth_clamp_;
  const FormatInfo* format_ = nullptr;
  std::optional<TileBlock> block_;
  ir::Value code_;  // I32
};

// `a` compared with `c` (both I32 codes, or F32) by a Vulkan comparison operator.
ir::Value compare(ir::Builder& b, VkCompareOp op, ir::Value a, ir::Value c);

}  // namespace pineda::kernels
