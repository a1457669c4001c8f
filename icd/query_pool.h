// VkQueryPool of timestamps. Occlusion and statistics queries are refused at creation: the rasterizer's counters are not
// connected to them.
#pragma once

#include <algorithm>
#include <atomic>

#include "icd/object.h"

namespace pineda::icd {

class QueryPool : public Object {
 public:
  static VkResult check(Device& device, const VkQueryPoolCreateInfo& info);
  QueryPool(const Allocator& from, Device& device, const VkQueryPoolCreateInfo& info);

  void reset(uint32_t first, uint32_t count);
  void write_timestamp(uint32_t query);

  struct Request {
    uint32_t first, count;
    uint8_t* out;
    VkDeviceSize stride_bytes;
    VkQueryResultFlags flags;
  };
  // VK_NOT_READY when a query that was asked for has no result. Waits when the flags say so.
  VkResult results(const Request& request) const;

 private:
  struct Query {
    std::atomic<uint64_t> value_ns{0};
    std::atomic<bool> available{false};
  };

  // One past the last query of a range, within the pool.
  uint32_t end(uint32_t first, uint32_t count) const {
    return static_cast<uint32_t>(std::min<uint64_t>(uint64_t(first) + count, queries_.size()));
  }

  Device& device_;
  HostVector<Query> queries_;
};

}  // namespace pineda::icd
