#include "icd/pipeline_cache.h"

#include <cstring>

#include "compiler/build_id.h"
#include "icd/api.h"
#include "icd/device.h"
#include "icd/version.h"

namespace pineda::icd {
namespace {

struct RecordHeader {
  compiler::KernelHash key;
  uint64_t size_bytes;
  compiler::KernelHash checksum;  // of the code
};
static_assert(sizeof(VkPipelineCacheHeaderVersionOne) == 32 && sizeof(RecordHeader) == 40);

size_t padded(size_t bytes) { return (bytes + 7) & ~size_t{7}; }

VkPipelineCacheHeaderVersionOne our_header() {
  VkPipelineCacheHeaderVersionOne header{.headerSize = sizeof(VkPipelineCacheHeaderVersionOne),
                                         .headerVersion = VK_PIPELINE_CACHE_HEADER_VERSION_ONE,
                                         .vendorID = kVendorId,
                                         .deviceID = kDeviceId};
  get_pipeline_cache_uuid(header.pipelineCacheUUID);
  return header;
}

}  // namespace

void get_pipeline_cache_uuid(uint8_t (&out)[VK_UUID_SIZE]) {
  constexpr const char* kFormat = "Pineda pipeline cache 1 ";
  const compiler::KernelHash hash = compiler::hash_bytes(kFormat + compiler::build_id());
  std::memcpy(out, &hash, VK_UUID_SIZE);
}

PipelineCache::PipelineCache(const Allocator& from_allocator, Device&, const VkPipelineCacheCreateInfo& info)
    : Object(from_allocator) {
  if (info.initialDataSize > 0 && info.pInitialData) load({static_cast<const uint8_t*>(info.pInitialData), info.initialDataSize});
}

void PipelineCache::load(std::span<const uint8_t> data) {
  const VkPipelineCacheHeaderVersionOne header = our_header();
  if (data.size() < sizeof header || std::memcmp(data.data(), &header, sizeof header) != 0) return;
  data = data.subspan(sizeof header);
  RecordHeader record;
  while (data.size() >= sizeof record) {
    std::memcpy(&record, data.data(), sizeof record);
    data = data.subspan(sizeof record);
    if (record.size_bytes > data.size() || padded(record.size_bytes) > data.size()) return;
    auto blob = std::make_shared<const std::string>(reinterpret_cast<const char*>(data.data()), record.size_bytes);
    if (compiler::hash_bytes(*blob) != record.checksum) return;
    blobs_[record.key] = std::move(blob);
    data = data.subspan(padded(record.size_bytes));
  }
}

compiler::CodeBlob PipelineCache::find(const compiler::KernelHash& key) {
  const std::lock_guard lock(mutex_);
  const auto found = blobs_.find(key);
  return found == blobs_.end() ? nullptr : found->second;
}

void PipelineCache::insert(const compiler::KernelHash& key, const compiler::CodeBlob& blob) {
  const std::lock_guard lock(mutex_);
  blobs_.try_emplace(key, blob);
}

void PipelineCache::insert_when_finished(const compiler::ExecutablePtr& kernel) {
  const std::lock_guard lock(unfinished_mutex_);
  // What has been finished meanwhile need not be held any longer.
  std::erase_if(unfinished_, [&](const compiler::ExecutablePtr& other) {
    if (!other->is_finished()) return false;
    if (const compiler::CodeBlob blob = other->blob()) insert(other->key, blob);
    return true;
  });
  unfinished_.push_back(kernel);
}

void PipelineCache::settle() {
  const std::lock_guard lock(unfinished_mutex_);
  for (const compiler::ExecutablePtr& kernel : unfinished_) {
    const bool done = kernel->finish().has_value();
    if (const compiler::CodeBlob blob = done ? kernel->blob() : nullptr) insert(kernel->key, blob);
  }
  unfinished_.clear();
}

void PipelineCache::merge(PipelineCache& other) {
  if (&other == this) return;
  other.settle();
  const std::scoped_lock lock(mutex_, other.mutex_);
  blobs_.insert(other.blobs_.begin(), other.blobs_.end());
}

VkResult PipelineCache::get_data(size_t* size_bytes, void* data) {
  settle();
  const std::lock_guard lock(mutex_);
  const VkPipelineCacheHeaderVersionOne header = our_header();
  if (!data) {
    *size_bytes = sizeof header;
    for (const auto& [key, blob] : blobs_) *size_bytes += sizeof(RecordHeader) + padded(blob->size());
    return VK_SUCCESS;
  }
  const size_t room = *size_bytes;
  *size_bytes = 0;
  if (room < sizeof header) return VK_INCOMPLETE;  // "nothing will be written to pData and zero will be written to pDataSize"
  auto* const bytes = static_cast<uint8_t*>(data);
  size_t at = sizeof header;
  std::memcpy(bytes, &header, sizeof header);
  VkResult result = VK_SUCCESS;
  for (const auto& [key, blob] : blobs_) {
    const RecordHeader record{key, blob->size(), compiler::hash_bytes(*blob)};
    const size_t record_bytes = sizeof record + padded(blob->size());
    if (record_bytes > room - at) {
      result = VK_INCOMPLETE;
      continue;
    }
    std::memset(bytes + at, 0, record_bytes);
    std::memcpy(bytes + at, &record, sizeof record);
    std::memcpy(bytes + at + sizeof record, blob->data(), blob->size());
    at += record_bytes;
  }
  *size_bytes = at;
  return result;
}

VkResult api::CreatePipelineCache(VkDevice device, const VkPipelineCacheCreateInfo* info, const VkAllocationCallbacks* callbacks,
                                  VkPipelineCache* out) {
  return create_device_object<PipelineCache>(device, info, callbacks, out);
}

void api::DestroyPipelineCache(VkDevice device, VkPipelineCache cache, const VkAllocationCallbacks* callbacks) {
  destroy_device_object(device, cache, callbacks);
}

VkResult api::GetPipelineCacheData(VkDevice, VkPipelineCache cache, size_t* size_bytes, void* data) {
  return guarded([&] { return from(cache)->get_data(size_bytes, data); });
}

VkResult api::MergePipelineCaches(VkDevice, VkPipelineCache into, uint32_t count, const VkPipelineCache* caches) {
  return guarded([&] {
    for (uint32_t i = 0; i < count; ++i) from(into)->merge(*from(caches[i]));
    return VK_SUCCESS;
  });
}

}  // namespace pineda::icd
