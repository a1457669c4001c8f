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
  for (VkEvent event : command.events) from(event)->wait();
}

void Executor::execute(const cmd::ResetQueryPool& command) { command.pool->reset(command.first, command.count); }
void Executor::execute(const cmd::WriteTimestamp& command) { command.pool->write_timestamp(command.query); }

void Executor::execute(const cmd::CopyQueryPoolResults& command) {
  if (!command.destination->data()) return;
  // Commands before this one have run, so WAIT would only hang on a query that was never written.
  const VkQueryResultFlags flags = command.flags & ~VkQueryResultFlags(VK_QUERY_RESULT_WAIT_BIT);
  (void)command.pool->results(
      {command.first, command.count, command.destination->data() + command.offset, command.stride, flags});
}

}  // namespace pineda::icd
