// vkCreateGraphicsPipelines and vkCreateComputePipelines.
#pragma once

#include <vector>

#include "base/float_environment.h"
#include "base/parallel_for.h"
#include "icd/device.h"
#include "icd/pipeline.h"
#include "icd/pipeline_cache.h"

namespace pineda::icd {

// vkCreate*Pipelines: all are compiled at once, on as many threads as help; a failed one leaves a null handle, and the first
// failure in order is the result. Objects are made on this thread alone: allocation callbacks are called "from the same thread as
// the originating Vulkan command" (Memory Allocation).
template <typename PipelineType, typename Info>
VkResult create_pipelines(VkDevice device, VkPipelineCache cache, uint32_t count, const Info* infos,
                          const VkAllocationCallbacks* callbacks, VkPipeline* out) {
  const Allocator allocator(callbacks, from(device)->allocator);
  compiler::CodeStore* const store = cache ? static_cast<compiler::CodeStore*>(from(cache)) : nullptr;
  struct One {
    Owned<PipelineType> pipeline;
    VkResult result = VK_SUCCESS;
  };
  std::vector<One> made(count);
  for (uint32_t i = 0; i < count; ++i) {
    made[i].result = guarded([&] {
      made[i].pipeline = make_object<PipelineType>(allocator, VK_SYSTEM_ALLOCATION_SCOPE_OBJECT, *from(device));
      return VK_SUCCESS;
    });
  }
  parallel_for(count, [&](uint32_t i) {
    const ScopedFloatEnvironment environment;  // constant folding
    if (made[i].result == VK_SUCCESS) made[i].result = guarded([&] { return made[i].pipeline->init(infos[i], store); });
  });
  VkResult result = VK_SUCCESS;
  for (uint32_t i = 0; i < count; ++i) {
    const bool succeeded = made[i].result == VK_SUCCESS;
    out[i] = succeeded ? to_handle(static_cast<Pipeline*>(made[i].pipeline.release())) : VK_NULL_HANDLE;
    if (result == VK_SUCCESS) result = made[i].result;
  }
  return result;
}

}  // namespace pineda::icd
