#include "icd/query_pool.h"

#include <bit>
#include <cstring>

#include "icd/api.h"
#include "icd/device.h"

namespace pineda::icd {
namespace {

uint8_t* put(uint8_t* out, uint64_t value, VkQueryResultFlags flags) {
  if (flags & VK_QUERY_RESULT_64_BIT) {
    std::memcpy(out, &value, 8);
    return out + 8;
  }
  const auto low = static_cast<uint32_t>(value);  // "the result may either wrap or saturate"
  std::memcpy(out, &low, 4);
  return out + 4;
}

}  // namespace

VkResult QueryPool::check(Device&, const VkQueryPoolCreateInfo& info) {
  constexpr VkQueryPipelineStatisticFlags kAll = (1u << kStatistics) - 1;
  switch (info.queryType) {
    case VK_QUERY_TYPE_TIMESTAMP:
    case VK_QUERY_TYPE_OCCLUSION:
      return VK_SUCCESS;
    case VK_QUERY_TYPE_PIPELINE_STATISTICS:
      if ((info.pipelineStatistics & ~kAll) == 0 && info.pipelineStatistics != 0) return VK_SUCCESS;
      [[fallthrough]];
    default:
      return not_supported("vkCreateQueryPool: this type of query is not supported");
  }
}

QueryPool::QueryPool(const Allocator& from, Device& device, const VkQueryPoolCreateInfo& info)
    : Object(from),
      type(info.queryType),
      device_(device),
      statistics_(info.queryType == VK_QUERY_TYPE_PIPELINE_STATISTICS ? info.pipelineStatistics : 0),
      query_count_(info.queryCount),
      values_per_query_(statistics_ ? static_cast<uint32_t>(std::popcount(statistics_)) : 1),
      values_(size_t{info.queryCount} * values_per_query_, HostAllocator<std::atomic<uint64_t>>(&allocator)),
      available_(info.queryCount, HostAllocator<std::atomic<bool>>(&allocator)) {}

void QueryPool::reset(uint32_t first, uint32_t count) {
  for (uint32_t i = first; i < end(first, count); ++i) available_[i].store(false, std::memory_order_release);
}

void QueryPool::write_timestamp(uint32_t query) {
  if (query >= query_count_) return;
  values_[query].store(monotonic_ns(), std::memory_order_relaxed);
  make_available(query);
}

void QueryPool::begin(uint32_t query) {
  available_[query].store(false, std::memory_order_release);
  for (uint32_t i = 0; i < values_per_query_; ++i)
    values_[size_t{query} * values_per_query_ + i].store(0, std::memory_order_relaxed);
}

void QueryPool::make_available(uint32_t query) {
  available_[query].store(true, std::memory_order_release);
  device_.notifier.notify();
}

// `counters` by bit of VkQueryPipelineStatisticFlagBits; those that were asked for are kept, in order.
void QueryPool::add_counters(uint32_t query, const std::array<uint64_t, kStatistics>& counters) {
  std::atomic<uint64_t>* value = &values_[size_t{query} * values_per_query_];
  for (uint32_t bit = 0; bit < kStatistics; ++bit) {
    if (statistics_ >> bit & 1) (value++)->fetch_add(counters[bit], std::memory_order_relaxed);
  }
}

void QueryPool::add(uint32_t query, const raster::PassStatistics& s) {
  std::array<uint64_t, kStatistics> counters{};
  const auto at = [&](VkQueryPipelineStatisticFlagBits bit) -> uint64_t& {
    return counters[static_cast<uint32_t>(std::countr_zero(static_cast<uint32_t>(bit)))];
  };
  at(VK_QUERY_PIPELINE_STATISTIC_INPUT_ASSEMBLY_VERTICES_BIT) = s.vertices_in;
  at(VK_QUERY_PIPELINE_STATISTIC_INPUT_ASSEMBLY_PRIMITIVES_BIT) = s.primitives_in;
  at(VK_QUERY_PIPELINE_STATISTIC_VERTEX_SHADER_INVOCATIONS_BIT) = s.vertices_shaded;
  at(VK_QUERY_PIPELINE_STATISTIC_CLIPPING_INVOCATIONS_BIT) = s.triangles_in;
  at(VK_QUERY_PIPELINE_STATISTIC_CLIPPING_PRIMITIVES_BIT) = s.triangles_binned;
  at(VK_QUERY_PIPELINE_STATISTIC_FRAGMENT_SHADER_INVOCATIONS_BIT) = s.fragments_shaded;
  add_counters(query, counters);
}

void QueryPool::add_compute(uint32_t query, uint64_t invocations) {
  std::array<uint64_t, kStatistics> counters{};
  counters[static_cast<uint32_t>(std::countr_zero<uint32_t>(VK_QUERY_PIPELINE_STATISTIC_COMPUTE_SHADER_INVOCATIONS_BIT))] =
      invocations;
  add_counters(query, counters);
}

VkResult QueryPool::results(const Request& request) const {
  VkResult result = VK_SUCCESS;
  const uint32_t value_bytes = request.flags & VK_QUERY_RESULT_64_BIT ? 8 : 4;
  for (uint32_t i = 0; request.first + i < end(request.first, request.count); ++i) {
    const uint32_t query = request.first + i;
    const auto is_available = [&] { return available_[query].load(std::memory_order_acquire); };
    if (request.flags & VK_QUERY_RESULT_WAIT_BIT) {
      device_.notifier.wait(Notifier::kForever, [&] { return is_available() || device_.lost(); });
      if (device_.lost()) return VK_ERROR_DEVICE_LOST;
    }
    const bool available = is_available();
    uint8_t* out = request.out + i * request.stride_bytes;
    for (uint32_t v = 0; v < values_per_query_; ++v) {
      // "VK_QUERY_RESULT_PARTIAL_BIT": between zero and the final result; otherwise the value's place stays as it was.
      if (available || (request.flags & VK_QUERY_RESULT_PARTIAL_BIT)) {
        const uint64_t value = values_[size_t{query} * values_per_query_ + v].load(std::memory_order_relaxed);
        put(out, available ? value : 0, request.flags);
      }
      out += value_bytes;
    }
    if (!available) result = VK_NOT_READY;
    if (request.flags & VK_QUERY_RESULT_WITH_AVAILABILITY_BIT) put(out, available, request.flags);
  }
  return result;
}

VkResult api::CreateQueryPool(VkDevice device, const VkQueryPoolCreateInfo* info, const VkAllocationCallbacks* callbacks,
                              VkQueryPool* out) {
  return create_device_object<QueryPool>(device, info, callbacks, out);
}

void api::DestroyQueryPool(VkDevice device, VkQueryPool pool, const VkAllocationCallbacks* callbacks) {
  destroy_device_object(device, pool, callbacks);
}

VkResult api::GetQueryPoolResults(VkDevice handle, VkQueryPool pool, uint32_t first, uint32_t count, size_t, void* data,
                                  VkDeviceSize stride, VkQueryResultFlags flags) {
  return guarded([&] {
    Device& device = *from(handle);
    while ((flags & VK_QUERY_RESULT_WAIT_BIT) && device.scheduler.help()) {
    }
    if (device.lost()) return VK_ERROR_DEVICE_LOST;
    return from(pool)->results({first, count, static_cast<uint8_t*>(data), stride, flags});
  });
}

void api::ResetQueryPoolEXT(VkDevice, VkQueryPool pool, uint32_t first, uint32_t count) { from(pool)->reset(first, count); }

}  // namespace pineda::icd
