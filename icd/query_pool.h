// VkQueryPool: occlusion, pipeline statistics, timestamps. Commands write results in execution order; each query is available
// when its result is whole.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>

#include "icd/object.h"
#include "raster/raster.h"

namespace pineda::icd {

class QueryPool : public Object {
 public:
  static VkResult check(Device& device, const VkQueryPoolCreateInfo& info);
  QueryPool(const Allocator& from, Device& device, const VkQueryPoolCreateInfo& info);

  const VkQueryType type;
  uint32_t query_count() const { return query_count_; }

  void reset(uint32_t first, uint32_t count);
  void write_timestamp(uint32_t query);

  // An occlusion or statistics query, from vkCmdBeginQuery on: its counters are zero.
  void begin(uint32_t query);
  // Counter of an occlusion query.
  std::atomic<uint64_t>* counter(uint32_t query) { return &values_[size_t{query} * values_per_query_]; }
  void add(uint32_t query, const raster::PassStatistics& statistics);
  void add_compute(uint32_t query, uint64_t invocations);
  void make_available(uint32_t query);

  struct Request {
    uint32_t first, count;
    uint8_t* out;
    VkDeviceSize stride_bytes;
    VkQueryResultFlags flags;
  };
  // VK_NOT_READY when a query that was asked for has no result. Waits when the flags say so.
  VkResult results(const Request& request) const;

 private:
  static constexpr uint32_t kStatistics = 11;  // bits of VkQueryPipelineStatisticFlags
  // One past the last query of a range, within the pool.
  uint32_t end(uint32_t first, uint32_t count) const {
    return static_cast<uint32_t>(std::min<uint64_t>(uint64_t(first) + count, query_count_));
  }
  void add_counters(uint32_t query, const std::array<uint64_t, kStatistics>& counters);

  Device& device_;
  const VkQueryPipelineStatisticFlags statistics_;
  const uint32_t query_count_, values_per_query_;
  HostVector<std::atomic<uint64_t>> values_;  // of query 0, of query 1, ...
  HostVector<std::atomic<bool>> available_;
};

}  // namespace pineda::icd
