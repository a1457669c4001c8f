#include "icd/device_memory.h"

#include <sys/mman.h>

#include <algorithm>
#include <vector>

#include "icd/api.h"
#include "icd/chain.h"
#include "icd/device.h"

namespace pineda::icd {
namespace {

constexpr VkDeviceSize kPageBytes = 4096;
constexpr VkDeviceSize kHugePageBytes = 2u << 20;

bool wants_address(const VkMemoryAllocateInfo& info) {
  const auto* flags = find_in_chain<VkMemoryAllocateFlagsInfo>(info.pNext, VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO);
  return flags && (flags->flags & VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT);
}

VkDeviceSize align_up(VkDeviceSize value, VkDeviceSize alignment) { return (value + alignment - 1) / alignment * alignment; }

}  // namespace

VkResult DeviceMemory::check(Device&, const VkMemoryAllocateInfo& info) {
  if (info.memoryTypeIndex >= kMemoryTypeCount) return not_supported("vkAllocateMemory: no such memory type");
  return info.allocationSize <= memory_heap_bytes() ? VK_SUCCESS : VK_ERROR_OUT_OF_DEVICE_MEMORY;
}

// Allocations of a huge page and more start at one and ask for them: first touch of a 1080p attachment is 4 page faults instead
// of 2000.
DeviceMemory::DeviceMemory(const Allocator& from, Device& device, const VkMemoryAllocateInfo& info)
    : Object(from),
      device_(device),
      size_bytes_(info.allocationSize),
      has_address_(wants_address(info)),
      lazy_(info.memoryTypeIndex == kLazyMemoryType) {
  const bool huge = size_bytes_ >= kHugePageBytes && !lazy_;
  if (!device_.reserve_memory(size_bytes_)) return;
  mapping_bytes_ = align_up(size_bytes_, kPageBytes) + (huge ? kHugePageBytes : 0);
  void* mapping = mmap(nullptr, mapping_bytes_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (mapping == MAP_FAILED) {
    device_.return_memory(size_bytes_);
    return;
  }
  mapping_ = static_cast<uint8_t*>(mapping);
  data_ = mapping_;
  if (lazy_) madvise(mapping_, mapping_bytes_, MADV_NOHUGEPAGE);
  if (huge) {
    data_ = reinterpret_cast<uint8_t*>(align_up(reinterpret_cast<uintptr_t>(mapping_), kHugePageBytes));
    madvise(data_, align_up(size_bytes_, kPageBytes), MADV_HUGEPAGE);  // a wish: failure changes nothing
  }
  if (has_address_) device_.addresses.add(reinterpret_cast<uint64_t>(data_), size_bytes_);
}

DeviceMemory::~DeviceMemory() {
  if (!mapping_) return;
  if (has_address_) device_.addresses.remove(reinterpret_cast<uint64_t>(data_));
  munmap(mapping_, mapping_bytes_);
  device_.return_memory(size_bytes_);
}

VkDeviceSize DeviceMemory::committed_bytes() const {
  if (!lazy_) return size_bytes_;
  std::vector<unsigned char> resident(mapping_bytes_ / kPageBytes);
  if (mincore(mapping_, mapping_bytes_, resident.data()) != 0) return size_bytes_;
  const auto pages = std::ranges::count_if(resident, [](unsigned char page) { return (page & 1) != 0; });
  return std::min(VkDeviceSize(pages) * kPageBytes, size_bytes_);
}

VkResult api::AllocateMemory(VkDevice device, const VkMemoryAllocateInfo* info, const VkAllocationCallbacks* callbacks,
                             VkDeviceMemory* out) {
  const VkResult result = create_device_object<DeviceMemory>(device, info, callbacks, out);
  if (result == VK_SUCCESS && !from(*out)->data()) {
    FreeMemory(device, *out, callbacks);
    *out = VK_NULL_HANDLE;
    return VK_ERROR_OUT_OF_DEVICE_MEMORY;
  }
  return result;
}

void api::FreeMemory(VkDevice device, VkDeviceMemory memory, const VkAllocationCallbacks* callbacks) {
  destroy_device_object(device, memory, callbacks);
}

VkResult api::MapMemory(VkDevice, VkDeviceMemory memory, VkDeviceSize offset, VkDeviceSize, VkMemoryMapFlags, void** out) {
  if (from(memory)->lazy()) return VK_ERROR_MEMORY_MAP_FAILED;
  *out = from(memory)->data() + offset;
  return VK_SUCCESS;
}

// Mapped and coherent at all times.
void api::UnmapMemory(VkDevice, VkDeviceMemory) {}
VkResult api::FlushMappedMemoryRanges(VkDevice, uint32_t, const VkMappedMemoryRange*) { return VK_SUCCESS; }
VkResult api::InvalidateMappedMemoryRanges(VkDevice, uint32_t, const VkMappedMemoryRange*) { return VK_SUCCESS; }

void api::GetDeviceMemoryCommitment(VkDevice, VkDeviceMemory memory, VkDeviceSize* out) {
  *out = from(memory)->size_bytes();
  (void)guarded([&] {
    *out = from(memory)->committed_bytes();
    return VK_SUCCESS;
  });
}

}  // namespace pineda::icd
