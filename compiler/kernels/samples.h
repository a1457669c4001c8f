// The samples of a block in the tile buffers, and loops over them.
#pragma once

#include <functional>

#include "compiler/kernels/tile.h"

namespace pineda::kernels {

// Number of a sample's block in the buffers (base/abi.h, ThreadContext).
ir::Value sample_plane(ir::Builder& b, uint32_t samples, ir::Value block_index, ir::Value sample);

// Emits body(sample) for each sample: a few times over, or as a loop.
void for_samples(ir::Builder& b, uint32_t samples, const std::function<void(ir::Value sample)>& body);

// The same for body(sample, covered) -> B1; gives the mask of samples whose result was true.
ir::Value filter_samples(ir::Builder& b, uint32_t samples, ir::Value mask,
                         const std::function<ir::Value(ir::Value sample, ir::Value covered)>& body);

// ThreadContext::equal_samples of one block.
class EqualSamples {
 public:
  EqualSamples(ir::Builder& b, ir::Value block_index);
  ir::Value load(ir::Builder& b) const;  // B1
  void store(ir::Builder& b, bool equal) const;

 private:
  ir::Address at_;
};

// Copies sample 0 of a block to its other samples.
void spread_sample_0(ir::Builder& b, const FormatInfo& format, size_t thread_offset_bytes, uint32_t samples,
                     ir::Value block_index);

}  // namespace pineda::kernels
