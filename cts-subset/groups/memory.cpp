// memory.*: requirements, mapping, sub-allocation, aliasing, dedicated and lazily allocated memory.
#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "cts-subset/groups/groups.h"
#include "cts-subset/harness/case.h"
#include "cts-subset/harness/pipelines.h"
#include "cts-subset/reference/random.h"

namespace pineda::cts {
namespace {

using Memory = Owned<VkDeviceMemory, vkFreeMemory>;
using RawBuffer = Owned<VkBuffer, vkDestroyBuffer>;
using RawImage = Owned<VkImage, vkDestroyImage>;

RawBuffer create_raw_buffer(Device& device, VkDeviceSize size, VkBufferUsageFlags usage = kAnyBuffer) {
  VkBufferCreateInfo info{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
  info.size = size;
  info.usage = usage;
  return make<VkBuffer, vkDestroyBuffer>(device, vkCreateBuffer, info, "vkCreateBuffer");
}

Memory allocate(Device& device, VkDeviceSize size, uint32_t type) {
  VkMemoryAllocateInfo info{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO};
  info.allocationSize = size;
  info.memoryTypeIndex = type;
  return make<VkDeviceMemory, vkFreeMemory>(device, vkAllocateMemory, info, "vkAllocateMemory");
}

constexpr VkMemoryPropertyFlags kCoherent = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;

void run_requirements(Device& device, VkBufferUsageFlags usage, VkDeviceSize size) {
  const RawBuffer buffer = create_raw_buffer(device, size, usage);
  VkMemoryRequirements got;
  vkGetBufferMemoryRequirements(device.handle(), buffer, &got);
  expect(got.size >= size, "the size is below the buffer's");
  expect(got.alignment && !(got.alignment & (got.alignment - 1)),
         fmt::format("the alignment, {}, is no power of two", got.alignment));
  expect(got.memoryTypeBits != 0, "no memory type is allowed");
  device.memory_type(got.memoryTypeBits, kCoherent);  // buffers can always be bound to such a type
  const VkPhysicalDeviceLimits& limits = device.limits();
  const auto multiple_of = [&](VkDeviceSize alignment, const char* what) {
    expect(got.alignment % std::max<VkDeviceSize>(alignment, 1) == 0, fmt::format("the alignment is no multiple of {}", what));
  };
  if (usage & VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT)
    multiple_of(limits.minUniformBufferOffsetAlignment, "minUniformBufferOffsetAlignment");
  if (usage & VK_BUFFER_USAGE_STORAGE_BUFFER_BIT)
    multiple_of(limits.minStorageBufferOffsetAlignment, "minStorageBufferOffsetAlignment");
  if (usage & (VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT | VK_BUFFER_USAGE_STORAGE_TEXEL_BUFFER_BIT))
    multiple_of(limits.minTexelBufferOffsetAlignment, "minTexelBufferOffsetAlignment");
  const RawBuffer twin = create_raw_buffer(device, size, usage);
  VkMemoryRequirements again;
  vkGetBufferMemoryRequirements(device.handle(), twin, &again);
  expect(again.size == got.size && again.alignment == got.alignment && again.memoryTypeBits == got.memoryTypeBits,
         "an equal buffer has other requirements");
}

// Mapped pointers: aligned, with an offset, again after unmapping, with the content that was written.
void run_map(Device& device, uint32_t type, VkDeviceSize offset, VkDeviceSize size) {
  require(type < device.caps().memory.memoryTypeCount, "the type");
  const VkMemoryPropertyFlags flags = device.caps().memory.memoryTypes[type].propertyFlags;
  require(flags & VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT, "mapping this type");
  constexpr VkDeviceSize kBytes = 65536;
  const Memory memory = allocate(device, kBytes, type);
  void* pointer = nullptr;
  check(vkMapMemory(device.handle(), memory, 0, VK_WHOLE_SIZE, 0, &pointer), "vkMapMemory");
  expect(reinterpret_cast<uintptr_t>(pointer) % device.limits().minMemoryMapAlignment == 0, "the pointer is not aligned");
  for (size_t i = 0; i < kBytes; ++i) static_cast<uint8_t*>(pointer)[i] = static_cast<uint8_t>(i * 7 + i / 256);
  VkMappedMemoryRange range{VK_STRUCTURE_TYPE_MAPPED_MEMORY_RANGE, nullptr, memory, 0, VK_WHOLE_SIZE};
  check(vkFlushMappedMemoryRanges(device.handle(), 1, &range), "vkFlushMappedMemoryRanges");
  vkUnmapMemory(device.handle(), memory);
  check(vkMapMemory(device.handle(), memory, offset, size, 0, &pointer), "vkMapMemory");
  expect((reinterpret_cast<uintptr_t>(pointer) - offset) % device.limits().minMemoryMapAlignment == 0,
         "the offset pointer is not aligned");
  check(vkInvalidateMappedMemoryRanges(device.handle(), 1, &range), "vkInvalidateMappedMemoryRanges");
  for (size_t i = 0; i < (size == VK_WHOLE_SIZE ? kBytes - offset : size); ++i) {
    expect(static_cast<uint8_t*>(pointer)[i] == static_cast<uint8_t>((offset + i) * 7 + (offset + i) / 256),
           fmt::format("byte {}", i));
  }
  vkUnmapMemory(device.handle(), memory);
}

// Many buffers in one allocation: each keeps its content.
void run_suballocation(Device& device, uint32_t count, VkDeviceSize size) {
  std::vector<RawBuffer> buffers;
  VkMemoryRequirements need{};
  for (uint32_t i = 0; i < count; ++i) {
    buffers.push_back(create_raw_buffer(device, size));
    vkGetBufferMemoryRequirements(device.handle(), buffers.back(), &need);
  }
  const VkDeviceSize stride = (need.size + need.alignment - 1) / need.alignment * need.alignment;
  const Memory memory = allocate(device, stride * count, device.memory_type(need.memoryTypeBits, kCoherent));
  for (uint32_t i = 0; i < count; ++i)
    check(vkBindBufferMemory(device.handle(), buffers[i], memory, stride * i), "vkBindBufferMemory");
  device.run([&](VkCommandBuffer commands) {
    for (uint32_t i = 0; i < count; ++i)
      vkCmdFillBuffer(commands, buffers[(i * 7) % count], 0, VK_WHOLE_SIZE, (i * 7) % count + 1);
    full_barrier(commands);
  });
  void* pointer = nullptr;
  check(vkMapMemory(device.handle(), memory, 0, VK_WHOLE_SIZE, 0, &pointer), "vkMapMemory");
  for (uint32_t i = 0; i < count; ++i) {
    for (VkDeviceSize at = 0; at + 4 <= size; at += 4) {
      uint32_t word;
      std::memcpy(&word, static_cast<std::byte*>(pointer) + stride * i + at, 4);
      expect(word == i + 1, fmt::format("buffer {} holds {}", i, word));
    }
  }
}

// Two buffers over the same memory at different offsets; what one writes the other reads.
void run_alias(Device& device, bool linear_image) {
  VkMemoryRequirements need{};
  const RawBuffer buffer = create_raw_buffer(device, 4096);
  vkGetBufferMemoryRequirements(device.handle(), buffer, &need);
  RawBuffer other;
  RawImage image;
  VkDeviceSize row_bytes = 0;
  if (linear_image) {
    VkImageCreateInfo info{VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO};
    info.imageType = VK_IMAGE_TYPE_2D;
    info.format = VK_FORMAT_R8G8B8A8_UNORM;
    info.extent = {16, 8, 1};
    info.mipLevels = info.arrayLayers = 1;
    info.samples = VK_SAMPLE_COUNT_1_BIT;
    info.tiling = VK_IMAGE_TILING_LINEAR;
    info.usage = VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT;
    info.initialLayout = VK_IMAGE_LAYOUT_PREINITIALIZED;
    image = make<VkImage, vkDestroyImage>(device, vkCreateImage, info, "vkCreateImage");
    VkMemoryRequirements image_need;
    vkGetImageMemoryRequirements(device.handle(), image, &image_need);
    need.size = std::max(need.size, image_need.size);
    need.memoryTypeBits &= image_need.memoryTypeBits;
    const VkImageSubresource subresource{VK_IMAGE_ASPECT_COLOR_BIT, 0, 0};
    VkSubresourceLayout layout;
    vkGetImageSubresourceLayout(device.handle(), image, &subresource, &layout);
    expect(layout.rowPitch >= 64 && layout.size >= layout.rowPitch * 7 + 64, "the layout of a linear image");
    row_bytes = layout.rowPitch;
    expect(layout.offset == 0, "the only subresource does not start at 0");
  } else {
    other = create_raw_buffer(device, 4096);
  }
  const Memory memory = allocate(device, need.size, device.memory_type(need.memoryTypeBits, kCoherent));
  check(vkBindBufferMemory(device.handle(), buffer, memory, 0), "vkBindBufferMemory");
  if (linear_image) {
    check(vkBindImageMemory(device.handle(), image, memory, 0), "vkBindImageMemory");
  } else {
    check(vkBindBufferMemory(device.handle(), other, memory, 0), "vkBindBufferMemory");
  }
  void* pointer = nullptr;
  check(vkMapMemory(device.handle(), memory, 0, VK_WHOLE_SIZE, 0, &pointer), "vkMapMemory");
  for (size_t i = 0; i < 4096; ++i) static_cast<uint8_t*>(pointer)[i] = static_cast<uint8_t>(i * 31 + i / 64);
  const Buffer out = create_buffer(device, 4096);
  device.run([&](VkCommandBuffer commands) {
    if (linear_image) {
      VkImageMemoryBarrier barrier{VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER};
      barrier.srcAccessMask = VK_ACCESS_HOST_WRITE_BIT;
      barrier.dstAccessMask = VK_ACCESS_TRANSFER_READ_BIT;
      barrier.oldLayout = VK_IMAGE_LAYOUT_PREINITIALIZED;
      barrier.newLayout = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL;
      barrier.srcQueueFamilyIndex = barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
      barrier.image = image;
      barrier.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
      vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_HOST_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT, 0, 0, nullptr, 0, nullptr, 1,
                           &barrier);
      const VkBufferImageCopy copy{0, 0, 0, {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1}, {0, 0, 0}, {16, 8, 1}};
      vkCmdCopyImageToBuffer(commands, image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, out.handle, 1, &copy);
    } else {
      const VkBufferCopy copy{0, 0, 4096};
      vkCmdCopyBuffer(commands, other, out.handle, 1, &copy);
    }
    full_barrier(commands);
  });
  const size_t rows = linear_image ? 8 : 1, bytes = linear_image ? 64 : 4096;
  for (size_t y = 0; y < rows; ++y) {
    expect(!std::memcmp(out.mapped + y * bytes, static_cast<std::byte*>(pointer) + y * row_bytes, bytes),
           fmt::format("row {}", y));
  }
}

void run_many_allocations(Device& device, VkDeviceSize size) {
  std::vector<Memory> all;
  for (uint32_t i = 0; i < 1000; ++i) all.push_back(allocate(device, size, device.memory_type(~0u, kCoherent)));
  for (size_t i = 0; i < all.size(); i += 99) {
    void* pointer = nullptr;
    check(vkMapMemory(device.handle(), all[i], 0, VK_WHOLE_SIZE, 0, &pointer), "vkMapMemory");
    std::memset(pointer, 1, size);
  }
}

void run_too_much(Device& device) {
  for (uint32_t i = 0; i < device.caps().memory.memoryTypeCount; ++i) {
    VkMemoryAllocateInfo info{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO};
    info.allocationSize = VkDeviceSize{1} << 60;
    info.memoryTypeIndex = i;
    VkDeviceMemory memory = VK_NULL_HANDLE;
    const VkResult result = vkAllocateMemory(device.handle(), &info, nullptr, &memory);
    expect(result == VK_ERROR_OUT_OF_DEVICE_MEMORY || result == VK_ERROR_OUT_OF_HOST_MEMORY,
           fmt::format("2^60 bytes of type {}: result {}", i, static_cast<int>(result)));
  }
}

void run_lazy(Device& device) {
  for (uint32_t i = 0; i < device.caps().memory.memoryTypeCount; ++i) {
    if (!(device.caps().memory.memoryTypes[i].propertyFlags & VK_MEMORY_PROPERTY_LAZILY_ALLOCATED_BIT)) continue;
    const Memory memory = allocate(device, 1 << 20, i);
    VkDeviceSize committed = ~VkDeviceSize{0};
    vkGetDeviceMemoryCommitment(device.handle(), memory, &committed);
    expect(committed <= 1 << 20, fmt::format("{} bytes are committed", committed));
    return;
  }
  throw NotSupported("lazily allocated memory");
}

}  // namespace

void register_memory() {
  static constexpr std::pair<VkBufferUsageFlags, const char*> kUsages[] = {
      {VK_BUFFER_USAGE_TRANSFER_SRC_BIT, "transfer_src"},
      {VK_BUFFER_USAGE_TRANSFER_DST_BIT, "transfer_dst"},
      {VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT, "uniform"},
      {VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, "storage"},
      {VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT, "uniform_texel"},
      {VK_BUFFER_USAGE_STORAGE_TEXEL_BUFFER_BIT, "storage_texel"},
      {VK_BUFFER_USAGE_INDEX_BUFFER_BIT, "index"},
      {VK_BUFFER_USAGE_VERTEX_BUFFER_BIT, "vertex"},
      {VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT, "indirect"},
      {kAnyBuffer, "all"}};
  for (const auto& [usage, name] : kUsages) {
    for (const VkDeviceSize size : {VkDeviceSize{1}, VkDeviceSize{63}, VkDeviceSize{4096}, VkDeviceSize{1000001}}) {
      add_case("memory.requirements", fmt::format("{}_{}", name, size), "12.7 Resource Memory Association",
               [usage = usage, size](Device& device) { run_requirements(device, usage, size); });
    }
  }
  for (uint32_t type = 0; type < 4; ++type) {
    for (const auto& [offset, size] :
         {std::pair<VkDeviceSize, VkDeviceSize>{0, VK_WHOLE_SIZE}, {0, 1}, {64, 4096}, {65535, 1}, {1000, VK_WHOLE_SIZE}}) {
      add_case("memory.mapping", fmt::format("type_{}_offset_{}_size_{}", type, offset, size == VK_WHOLE_SIZE ? 0 : size),
               "11.2.13 Host Access to Device Memory Objects",
               [=, offset = offset, size = size](Device& device) { run_map(device, type, offset, size); });
    }
  }
  for (const uint32_t count : {2u, 16u, 200u}) {
    for (const VkDeviceSize size : {4u, 100u, 4096u}) {
      add_case("memory.binding", fmt::format("suballocate_{}_of_{}", count, size), "12.7 Resource Memory Association",
               [=](Device& device) { run_suballocation(device, count, size); });
    }
  }
  add_case("memory.binding", "aliased_buffers", "12.8 Memory Aliasing", [](Device& device) { run_alias(device, false); });
  add_case("memory.binding", "aliased_linear_image", "12.8 Memory Aliasing", [](Device& device) { run_alias(device, true); });
  for (const VkDeviceSize size : {64u, 65536u}) {
    add_case("memory.allocation", fmt::format("thousand_of_{}", size), "11.2 Device Memory",
             [size](Device& device) { run_many_allocations(device, size); });
  }
  add_case("memory.allocation", "more_than_there_is", "11.2 Device Memory", run_too_much);
  add_case("memory.allocation", "lazily_allocated_commitment", "11.2.14 Lazily Allocated Memory", run_lazy);
}

}  // namespace pineda::cts
