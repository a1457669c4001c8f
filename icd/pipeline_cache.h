// VkPipelineCache: a valid header and nothing after it. Kernels are cached by the compiler, by their IR, for all devices of the
// process.
#pragma once

#include "icd/object.h"

namespace pineda::icd {

class PipelineCache : public Object {
 public:
  PipelineCache(const Allocator& from, Device&, const VkPipelineCacheCreateInfo&) : Object(from) {}
};

}  // namespace pineda::icd
