#include "icd/command_pool.h"

#include "icd/api.h"
#include "icd/device.h"

namespace pineda::icd {

CommandPool::~CommandPool() {
  while (first_) release(first_);
}

CommandBuffer* CommandPool::allocate(VkCommandBufferLevel level) {
  CommandBuffer* command_buffer =
      make_object<CommandBuffer>(allocator, VK_SYSTEM_ALLOCATION_SCOPE_OBJECT, *this, level).release();
  command_buffer->next = first_;
  if (first_) first_->previous = command_buffer;
  first_ = command_buffer;
  return command_buffer;
}

void CommandPool::release(CommandBuffer* command_buffer) {
  if (!command_buffer) return;
  (command_buffer->previous ? command_buffer->previous->next : first_) = command_buffer->next;
  if (command_buffer->next) command_buffer->next->previous = command_buffer->previous;
  device.forget_name(reinterpret_cast<uint64_t>(command_buffer));
  command_buffer->allocator = allocator;  // vkDestroyCommandPool may have brought other callbacks
  release_object(command_buffer);
}

void CommandPool::reset(bool release_memory) {
  for (CommandBuffer* command_buffer = first_; command_buffer; command_buffer = command_buffer->next) {
    command_buffer->reset(release_memory);
  }
}

VkResult api::CreateCommandPool(VkDevice device, const VkCommandPoolCreateInfo* info, const VkAllocationCallbacks* callbacks,
                                VkCommandPool* out) {
  return create_device_object<CommandPool>(device, info, callbacks, out);
}

void api::DestroyCommandPool(VkDevice device, VkCommandPool pool, const VkAllocationCallbacks* callbacks) {
  destroy_device_object(device, pool, callbacks);
}

VkResult api::ResetCommandPool(VkDevice, VkCommandPool pool, VkCommandPoolResetFlags flags) {
  from(pool)->reset((flags & VK_COMMAND_POOL_RESET_RELEASE_RESOURCES_BIT) != 0);
  return VK_SUCCESS;
}

// Recorded commands stay where they are; unused blocks go when a command buffer is reset with RELEASE_RESOURCES.
void api::TrimCommandPool(VkDevice, VkCommandPool, VkCommandPoolTrimFlags) {}

VkResult api::AllocateCommandBuffers(VkDevice, const VkCommandBufferAllocateInfo* info, VkCommandBuffer* out) {
  CommandPool& pool = *from(info->commandPool);
  for (uint32_t i = 0; i < info->commandBufferCount; ++i) out[i] = VK_NULL_HANDLE;
  const VkResult result = guarded([&] {
    for (uint32_t i = 0; i < info->commandBufferCount; ++i) out[i] = to_handle(pool.allocate(info->level));
    return VK_SUCCESS;
  });
  if (result == VK_SUCCESS) return result;
  for (uint32_t i = 0; i < info->commandBufferCount; ++i) {  // all or nothing
    pool.release(from(out[i]));
    out[i] = VK_NULL_HANDLE;
  }
  return result;
}

void api::FreeCommandBuffers(VkDevice, VkCommandPool pool, uint32_t count, const VkCommandBuffer* command_buffers) {
  for (uint32_t i = 0; i < count; ++i) from(pool)->release(from(command_buffers[i]));
}

}  // namespace pineda::icd
