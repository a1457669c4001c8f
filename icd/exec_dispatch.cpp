// Execution of dispatches.
#include <algorithm>

#include "base/config.h"
#include "icd/buffer.h"
#include "icd/compute_pipeline.h"
#include "icd/device.h"
#include "icd/executor.h"
#include "icd/explain.h"
#include "icd/query_pool.h"

namespace pineda::icd {

void Executor::dispatch(std::array<uint32_t, 3> base, std::array<uint32_t, 3> count) {
  if (!compute_pipeline_ || pass_ || count[0] == 0 || count[1] == 0 || count[2] == 0) return;
  if (!compute_kernel_) compute_kernel_ = compute_pipeline_->kernel(compute_.sets.data());
  if (!compute_kernel_) {
    device_.lose("a compute pipeline could not be compiled (its error was reported)");
    return;
  }
  if (statistics_.pool) {
    const auto& size = compute_kernel_->local_size;
    statistics_.pool->add_compute(statistics_.query,
                                  uint64_t{count[0]} * count[1] * count[2] * (uint64_t{size[0]} * size[1] * size[2]));
  }
  if (debug(kDebugExplain)) say_once(explain_dispatch(compute_pipeline_->name(), count, compute_kernel_->local_size));
  update_addresses();
  std::ranges::copy(count, compute_.context.workgroup_count);
  raster::dispatch(device_.pool, {.kernel = compute_kernel_->kernel->handle,
                                  .context = &compute_.context,
                                  .base = base,
                                  .count = count,
                                  .local_size = compute_kernel_->local_size,
                                  .shared_memory_bytes = compute_kernel_->shared_memory_bytes,
                                  .wave_frame_bytes = compute_kernel_->wave_frame_bytes});
}

void Executor::execute(const cmd::Dispatch& command) { dispatch({}, command.count); }
void Executor::execute(const cmd::DispatchBase& command) { dispatch(command.base, command.count); }

void Executor::execute(const cmd::DispatchIndirect& command) {
  VkDispatchIndirectCommand count;
  if (command.buffer->read(command.offset, &count)) dispatch({}, {count.x, count.y, count.z});
}

}  // namespace pineda::icd
