// Execution of queries. Draws run when their pass does, so a query that ends inside of a pass has its result after it. Statistics
// are counted by passes: a query that begins or ends in the middle of one splits it. With multiview a query is as many
// consecutive ones as the subpass has views; each view counts in its own.
#include "icd/executor.h"
#include "icd/query_pool.h"

namespace pineda::icd {

void Executor::execute(const cmd::BeginQuery& command) {
  const uint32_t query = command.query + view_ordinal_;
  if (query >= command.pool->query_count()) return;
  const bool is_statistics = command.pool->type == VK_QUERY_TYPE_PIPELINE_STATISTICS;
  if (is_statistics && pass_) split_subpass(pass_desc_.samples);
  command.pool->begin(query);
  (is_statistics ? statistics_ : occlusion_) = {command.pool, query};
  dirty_ |= kPacket | kContext;
}

void Executor::execute(const cmd::EndQuery& command) {
  ActiveQuery& active = command.pool->type == VK_QUERY_TYPE_PIPELINE_STATISTICS ? statistics_ : occlusion_;
  if (active.pool != command.pool || active.query != command.query + view_ordinal_) return;
  if (&active == &statistics_ && pass_) split_subpass(pass_desc_.samples);
  if (&active == &occlusion_ && pass_) {
    ended_.push_back(active);
  } else {
    active.pool->make_available(active.query);
  }
  active = {};
  dirty_ |= kPacket | kContext;
}

void Executor::finish_queries(const raster::PassStatistics& statistics) {
  if (statistics_.pool) statistics_.pool->add(statistics_.query, statistics);
  for (const ActiveQuery& query : ended_) query.pool->make_available(query.query);
  ended_.clear();
}

}  // namespace pineda::icd
