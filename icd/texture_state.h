// Numbers for what selects code when a shader samples: the view's half and the sampler's half of compiler::TextureState are
// interned, so that a descriptor carries two small ids, and finding a pipeline's variant is a comparison of integers.
#pragma once

#include <cstdint>
#include <mutex>
#include <vector>

#include "compiler/compile.h"

namespace pineda::icd {

// Beside each image or sampler descriptor of a set. 0: nothing written yet.
struct TextureIds {
  uint32_t view = 0, sampler = 0;
};

class TextureStates {
 public:
  // Ids are never reused; states are few (formats x swizzles, filters x address modes), whatever the number of views and
  // samplers. Thread-safe.
  uint32_t intern_view(const compiler::TextureState& view_half);
  uint32_t intern_sampler(const compiler::TextureState& sampler_half);
  compiler::TextureState combine(uint32_t view, uint32_t sampler) const;

 private:
  mutable std::mutex mutex_;                              // guards both
  std::vector<compiler::TextureState> views_, samplers_;  // state of id i at i - 1
};

}  // namespace pineda::icd
