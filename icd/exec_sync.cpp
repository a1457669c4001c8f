// Execution of events and queries.
#include "icd/buffer.h"
#include "icd/device.h"
#include "icd/event.h"
#include "icd/executor.h"
#include "icd/query_pool.h"

namespace pineda::icd {

void Executor::execute(const cmd::SetEvent& command) { command.event->set(); }
void Executor::execute(const cmd::ResetEvent& command) { command.event->reset(); }

void Executor::execute(const cmd::WaitEvents& command) {
  for (VkEvent event : command.events) {
    if (!from(event)->is_set()) device_.scheduler.yield([&] { from(event)->wait(); });
  }
}

void Executor::execute(const cmd::ResetQueryPool& command) { command.pool->reset(command.first, command.count); }
void Executor::execute(const cmd::WriteTimestamp& command) { command.pool->write_timestamp(command.query + view_ordinal_); }

void Executor::execute(const cmd::CopyQueryPoolResults& command) {
  const VkDeviceSize query_bytes =
      (command.flags & VK_QUERY_RESULT_64_BIT ? 8 : 4) * (command.flags & VK_QUERY_RESULT_WITH_AVAILABILITY_BIT ? 2 : 1);
  const VkDeviceSize bytes = command.count == 0 ? 0 : (command.count - 1) * command.stride + query_bytes;
  if (!command.destination->data() || command.destination->clamp(command.offset, bytes) != bytes) return;
  // Commands before this one have run, so WAIT would only hang on a query that was never written.
  const VkQueryResultFlags flags = command.flags & ~VkQueryResultFlags(VK_QUERY_RESULT_WAIT_BIT);
  (void)command.pool->results(
      {command.first, command.count, command.destination->data() + command.offset, command.stride, flags});
}

}  // namespace pineda::icd
