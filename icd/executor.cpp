#include "icd/executor.h"

#include <algorithm>
#include <utility>

#include "base/srgb.h"
#include "icd/command_buffer.h"
#include "icd/descriptor_set.h"
#include "icd/device.h"

namespace pineda::icd {

namespace {

// Whether a command neither sees nor changes what render passes before it may still have to do. Those of render passes decide on
// their own (exec_pass.cpp).
bool lets_passes_wait(CommandType type) {
  switch (type) {
    case CommandType::kBindPipeline:
    case CommandType::kSetViewport:
    case CommandType::kSetScissor:
    case CommandType::kSetLineWidth:
    case CommandType::kSetLineStippleEXT:
    case CommandType::kSetDepthBias:
    case CommandType::kSetBlendConstants:
    case CommandType::kSetDepthBounds:
    case CommandType::kSetStencilCompareMask:
    case CommandType::kSetStencilWriteMask:
    case CommandType::kSetStencilReference:
    case CommandType::kBindDescriptorSets:
    case CommandType::kBindIndexBuffer:
    case CommandType::kBindVertexBuffers:
    case CommandType::kPushConstants:
    case CommandType::kDraw:
    case CommandType::kDrawIndexed:
    case CommandType::kDrawIndirect:
    case CommandType::kDrawIndexedIndirect:
    case CommandType::kDrawIndirectCountKHR:
    case CommandType::kDrawIndexedIndirectCountKHR:
    case CommandType::kClearAttachments:
    case CommandType::kPipelineBarrier:
    case CommandType::kBeginRenderPass:
    case CommandType::kNextSubpass:
    case CommandType::kEndRenderPass:
    case CommandType::kExecuteCommands:
    case CommandType::kBeginDebugUtilsLabelEXT:
    case CommandType::kEndDebugUtilsLabelEXT:
    case CommandType::kInsertDebugUtilsLabelEXT:
      return true;
    default:
      return false;
  }
}

}  // namespace

Executor::Executor(Device& device) : device_(device), arena_(device.allocator, VK_SYSTEM_ALLOCATION_SCOPE_DEVICE) {
  reset_state();
}

void Executor::reset_state() {
  graphics_ = {};
  std::ranges::fill(graphics_.context.sets, device_.unbound_set.memory());
  set_srgb_tables(graphics_.context);
  graphics_.context.sample = device_.sample_functions.handle();
  if (addresses_) {
    graphics_.context.address_ranges = addresses_->data();
    graphics_.context.address_range_count = static_cast<uint32_t>(addresses_->size());
  }
  compute_ = graphics_;
  pipeline_ = nullptr;
  compute_pipeline_ = nullptr;
  kernels_ = nullptr;
  compute_kernel_ = nullptr;
  dynamic_ = {};
  index_ = {};
  dirty_ = kAll;
  pristine_ = true;
}

// Memory may have been allocated since: at the start of a command buffer and of each dispatch is soon enough, as what a command
// sees must have been there before it was submitted or signalled.
void Executor::update_addresses() {
  const uint64_t version = device_.addresses.version();
  if (version == addresses_version_) return;
  addresses_ = device_.addresses.snapshot();
  addresses_version_ = version;
  for (BindPoint* point : {&graphics_, &compute_}) {
    point->context.address_ranges = addresses_->data();
    point->context.address_range_count = static_cast<uint32_t>(addresses_->size());
  }
  dirty_ |= kContext;
}

void Executor::run(const CommandBuffer& command_buffer) {
  if (!pristine_) reset_state();  // a few kilobytes: most of what an empty submission would cost
  update_addresses();
  occlusion_ = statistics_ = {};
  walk(command_buffer);
  if (pass_) end_subpass();  // a primary that lacks vkCmdEndRenderPass is invalid, but its draws point into the arena
  finish_passes();
  labels_.clear();
}

void Executor::walk(const CommandBuffer& command_buffer) {
  if (!command_buffer.executable()) {
    device_.lose("a command buffer was submitted that has not been recorded completely");
    return;
  }
  if (command_buffer.commands()) pristine_ = false;
  const bool is_primary = command_buffer.level == VK_COMMAND_BUFFER_LEVEL_PRIMARY;  // render passes begin and end there
  for (const CommandHeader* header = command_buffer.commands(); header && !device_.lost(); header = header->next) {
    if (is_primary) current_ = header;
    execute(*header);
    if (is_primary && replay_from_) header = std::exchange(replay_from_, nullptr);
  }
}

void Executor::execute(const CommandHeader& header) {
  if (!waiting_.empty() && !lets_passes_wait(header.type)) finish_passes();
  switch (header.type) {
#define PINEDA_COMMAND(name) \
  case CommandType::k##name: \
    return execute(static_cast<const CommandNode<cmd::name>&>(header).command);
#include "icd/commands.inc"
  }
}

void Executor::abandon() {
  pass_.reset();
  waiting_.clear();
  start_.reset();
  replay_from_ = nullptr;
  begin_ = nullptr;
  ended_.clear();
  labels_.clear();
}

// The state of primary and secondary are undefined to each other; only the render pass goes on.
void Executor::execute(const cmd::ExecuteCommands& command) {
  for (VkCommandBuffer secondary : command.command_buffers) {
    reset_state();
    walk(*from(secondary));
  }
  reset_state();
}

}  // namespace pineda::icd
