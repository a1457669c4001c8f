#include "icd/query_pool.h"

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
  if (info.queryType == VK_QUERY_TYPE_TIMESTAMP) return VK_SUCCESS;
  return not_supported("vkCreateQueryPool: only timestamp queries are supported");
}

QueryPool::QueryPool(const Allocator& from, Device& device, const VkQueryPoolCreateInfo& info)
    : Object(from), device_(device), queries_(info.queryCount, HostAllocator<Query>(&allocator)) {}

void QueryPool::reset(uint32_t first, uint32_t count) {
  for (uint32_t i = first; i < end(first, count); ++i) queries_[i].available.store(false, std::memory_order_release);
}

void QueryPool::write_timestamp(uint32_t query) {
  if (query >= queries_.size()) return;
  queries_[query].value_ns.store(monotonic_ns(), std::memory_order_relaxed);
  queries_[query].available.store(true, std::memory_order_release);
  device_.notifier.notify();
}

VkResult QueryPool::results(const Request& request) const {
  VkResult result = VK_SUCCESS;
  for (uint32_t i = 0; request.first + i < end(request.first, request.count); ++i) {
    const Query& query = queries_[request.first + i];
    const auto is_available = [&] { return query.available.load(std::memory_order_acquire); };
    if (request.flags & VK_QUERY_RESULT_WAIT_BIT) {
      device_.notifier.wait(Notifier::kForever, [&] { return is_available() || device_.lost(); });
      if (device_.lost()) return VK_ERROR_DEVICE_LOST;
    }
    const bool available = is_available();
    uint8_t* out = request.out + i * request.stride_bytes;
    if (available) {
      out = put(out, query.value_ns.load(std::memory_order_relaxed), request.flags);
    } else {
      result = VK_NOT_READY;
      out += request.flags & VK_QUERY_RESULT_64_BIT ? 8 : 4;  // the value's place stays as it was
    }
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
