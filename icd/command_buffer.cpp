#include "icd/command_buffer.h"

#include "icd/api.h"
#include "icd/command_pool.h"
#include "icd/device.h"
#include "icd/framebuffer.h"

namespace pineda::icd {

CommandBuffer::CommandBuffer(const Allocator& from, CommandPool& owner, VkCommandBufferLevel buffer_level)
    : Object(from), pool(owner), level(buffer_level), arena_(allocator, VK_SYSTEM_ALLOCATION_SCOPE_OBJECT) {}

VkResult CommandBuffer::begin(const VkCommandBufferBeginInfo& info) {
  reset(false);  // implicit reset
  const VkCommandBufferInheritanceInfo* inheritance = info.pInheritanceInfo;
  const bool continues =
      level == VK_COMMAND_BUFFER_LEVEL_SECONDARY && (info.flags & VK_COMMAND_BUFFER_USAGE_RENDER_PASS_CONTINUE_BIT);
  if (continues && inheritance && inheritance->framebuffer) {
    const VkExtent2D extent = from(inheritance->framebuffer)->extent();
    area_px = uint64_t(extent.width) * extent.height;
  }
  return VK_SUCCESS;
}

VkResult CommandBuffer::end() {
  executable_ = error_ == VK_SUCCESS;
  return error_;
}

void CommandBuffer::reset(bool release_memory) {
  if (release_memory) {
    arena_.release();
  } else {
    arena_.reset();
  }
  head_ = nullptr;
  tail_ = &head_;
  error_ = VK_SUCCESS;
  executable_ = false;
  waits_for_host_ = false;
  cost_ns_ = 0;
  area_px = 0;
}

void CommandBuffer::inherit_from(const CommandBuffer& secondary) {
  cost_ns_ += secondary.cost_ns_;
  waits_for_host_ |= secondary.waits_for_host_;
}

VkResult api::BeginCommandBuffer(VkCommandBuffer command_buffer, const VkCommandBufferBeginInfo* info) {
  return from(command_buffer)->begin(*info);
}

VkResult api::EndCommandBuffer(VkCommandBuffer command_buffer) { return from(command_buffer)->end(); }

VkResult api::ResetCommandBuffer(VkCommandBuffer command_buffer, VkCommandBufferResetFlags flags) {
  from(command_buffer)->reset((flags & VK_COMMAND_BUFFER_RESET_RELEASE_RESOURCES_BIT) != 0);
  return VK_SUCCESS;
}

}  // namespace pineda::icd
