#include "icd/pipeline_cache.h"

#include <cstring>

#include "icd/api.h"
#include "icd/device.h"
#include "icd/version.h"

namespace pineda::icd {

VkResult api::CreatePipelineCache(VkDevice device, const VkPipelineCacheCreateInfo* info, const VkAllocationCallbacks* callbacks,
                                  VkPipelineCache* out) {
  return create_device_object<PipelineCache>(device, info, callbacks, out);
}

void api::DestroyPipelineCache(VkDevice device, VkPipelineCache cache, const VkAllocationCallbacks* callbacks) {
  destroy_device_object(device, cache, callbacks);
}

VkResult api::GetPipelineCacheData(VkDevice, VkPipelineCache, size_t* size_bytes, void* data) {
  VkPipelineCacheHeaderVersionOne header{.headerSize = sizeof(VkPipelineCacheHeaderVersionOne),
                                         .headerVersion = VK_PIPELINE_CACHE_HEADER_VERSION_ONE,
                                         .vendorID = kVendorId,
                                         .deviceID = kDeviceId};
  static_assert(sizeof(header) == 32);
  std::memcpy(header.pipelineCacheUUID, kPipelineCacheUuid, VK_UUID_SIZE);
  if (!data) {
    *size_bytes = sizeof(header);
    return VK_SUCCESS;
  }
  if (*size_bytes < sizeof(header)) {  // "if dataSize is less than ... the header, nothing is written"
    *size_bytes = 0;
    return VK_INCOMPLETE;
  }
  std::memcpy(data, &header, sizeof(header));
  *size_bytes = sizeof(header);
  return VK_SUCCESS;
}

VkResult api::MergePipelineCaches(VkDevice, VkPipelineCache, uint32_t, const VkPipelineCache*) { return VK_SUCCESS; }

}  // namespace pineda::icd
