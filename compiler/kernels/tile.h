// The 4x4 block of one attachment that a fragment wave covers, in its tile buffer (base/abi.h: lane order, 32-bit planes).
#pragma once

#include "compiler/kernels/texel.h"

namespace pineda::kernels {

class TileBlock {
 public:
  // `thread_offset_bytes`: of the attachment's pointer in ThreadContext. block_index: I32, wave rate.
  TileBlock(ir::Builder& b, const FormatInfo& format, size_t thread_offset_bytes, ir::Value block_index);

  // The block's texels before this wave; loaded once.
  const Words& old(ir::Builder& b);
  // Replaces the words of lanes where `covered` holds.
  void store(ir::Builder& b, const Words& words, ir::Value covered);
  // Replaces all words.
  void replace(ir::Builder& b, const Words& words);

 private:
  const FormatInfo& format_;
  ir::Value base_;
  Words old_{};
};

}  // namespace pineda::kernels
