#include "icd/buffer.h"

#include <algorithm>

#include "icd/api.h"
#include "icd/device.h"
#include "icd/device_memory.h"

namespace pineda::icd {

VkResult Buffer::check(Device&, const VkBufferCreateInfo& info) {
  constexpr VkBufferCreateFlags kSparse =
      VK_BUFFER_CREATE_SPARSE_BINDING_BIT | VK_BUFFER_CREATE_SPARSE_RESIDENCY_BIT | VK_BUFFER_CREATE_SPARSE_ALIASED_BIT;
  if (info.flags & kSparse) return not_supported("vkCreateBuffer: sparse buffers are not supported");
  return info.size <= memory_heap_bytes() ? VK_SUCCESS : VK_ERROR_OUT_OF_DEVICE_MEMORY;
}

BufferDescriptor Buffer::descriptor(VkDeviceSize offset, VkDeviceSize range) const {
  constexpr VkDeviceSize kMaxRange = 0xFFFFFFFFu;
  const VkDeviceSize size_bytes = address_ ? std::min(clamp(offset, range), kMaxRange) : 0;
  return {
      .address = reinterpret_cast<uint64_t>(address_) + offset, .size_bytes = static_cast<uint32_t>(size_bytes), .reserved = 0};
}

VkResult api::CreateBuffer(VkDevice device, const VkBufferCreateInfo* info, const VkAllocationCallbacks* callbacks,
                           VkBuffer* out) {
  return create_device_object<Buffer>(device, info, callbacks, out);
}

void api::DestroyBuffer(VkDevice device, VkBuffer buffer, const VkAllocationCallbacks* callbacks) {
  destroy_device_object(device, buffer, callbacks);
}

void api::GetBufferMemoryRequirements(VkDevice, VkBuffer buffer, VkMemoryRequirements* out) {
  const VkDeviceSize rounded =
      (from(buffer)->size_bytes() + kResourceAlignment_bytes - 1) / kResourceAlignment_bytes * kResourceAlignment_bytes;
  *out = {.size = rounded, .alignment = kResourceAlignment_bytes, .memoryTypeBits = 1u << kMappedMemoryType};
}

VkResult api::BindBufferMemory(VkDevice, VkBuffer buffer, VkDeviceMemory memory, VkDeviceSize offset) {
  from(buffer)->bind(from(memory)->data() + offset);
  return VK_SUCCESS;
}

// The host's address. Of the opaque addresses for capture and replay there are none (bufferDeviceAddressCaptureReplay).
VkDeviceAddress api::GetBufferDeviceAddressKHR(VkDevice, const VkBufferDeviceAddressInfo* info) {
  return reinterpret_cast<VkDeviceAddress>(from(info->buffer)->data());
}
uint64_t api::GetBufferOpaqueCaptureAddressKHR(VkDevice, const VkBufferDeviceAddressInfo*) { return 0; }
uint64_t api::GetDeviceMemoryOpaqueCaptureAddressKHR(VkDevice, const VkDeviceMemoryOpaqueCaptureAddressInfo*) { return 0; }

}  // namespace pineda::icd
