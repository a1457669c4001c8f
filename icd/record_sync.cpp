// Recording of events, queries and barriers.
#include "icd/api.h"
#include "icd/buffer.h"
#include "icd/command_buffer.h"
#include "icd/event.h"
#include "icd/query_pool.h"

namespace pineda::icd {

// Commands execute one after another and memory is coherent: every dependency holds without a command, but for what a render pass
// keeps in tiles, and for render passes that wait to run beside others.
void api::CmdPipelineBarrier(VkCommandBuffer handle, VkPipelineStageFlags source_stages, VkPipelineStageFlags, VkDependencyFlags,
                             uint32_t, const VkMemoryBarrier*, uint32_t, const VkBufferMemoryBarrier*, uint32_t,
                             const VkImageMemoryBarrier*) {
  CommandBuffer& cb = *from(handle);
  cb.record([&] { cb.append(cmd::PipelineBarrier{source_stages}); });
}

void api::CmdSetEvent(VkCommandBuffer handle, VkEvent event, VkPipelineStageFlags) {
  CommandBuffer& cb = *from(handle);
  cb.record([&] { cb.append(cmd::SetEvent{from(event)}); });
}

void api::CmdResetEvent(VkCommandBuffer handle, VkEvent event, VkPipelineStageFlags) {
  CommandBuffer& cb = *from(handle);
  cb.record([&] { cb.append(cmd::ResetEvent{from(event)}); });
}

void api::CmdWaitEvents(VkCommandBuffer handle, uint32_t count, const VkEvent* events, VkPipelineStageFlags source_stages,
                        VkPipelineStageFlags, uint32_t, const VkMemoryBarrier*, uint32_t, const VkBufferMemoryBarrier*, uint32_t,
                        const VkImageMemoryBarrier*) {
  CommandBuffer& cb = *from(handle);
  cb.record([&] {
    cb.append(cmd::WaitEvents{cb.copy(events, count)});
    // Only an event that the host sets can be unset here: commands before this one have run.
    if (source_stages & VK_PIPELINE_STAGE_HOST_BIT) cb.set_waits_for_host();
  });
}

void api::CmdBeginQuery(VkCommandBuffer handle, VkQueryPool pool, uint32_t query, VkQueryControlFlags) {
  CommandBuffer& cb = *from(handle);  // every count is precise
  cb.record([&] { cb.append(cmd::BeginQuery{from(pool), query}); });
}

void api::CmdEndQuery(VkCommandBuffer handle, VkQueryPool pool, uint32_t query) {
  CommandBuffer& cb = *from(handle);
  cb.record([&] { cb.append(cmd::EndQuery{from(pool), query}); });
}

void api::CmdResetQueryPool(VkCommandBuffer handle, VkQueryPool pool, uint32_t first, uint32_t count) {
  CommandBuffer& cb = *from(handle);
  cb.record([&] { cb.append(cmd::ResetQueryPool{from(pool), first, count}); });
}

void api::CmdWriteTimestamp(VkCommandBuffer handle, VkPipelineStageFlagBits, VkQueryPool pool, uint32_t query) {
  CommandBuffer& cb = *from(handle);
  cb.record([&] { cb.append(cmd::WriteTimestamp{from(pool), query}); });
}

void api::CmdCopyQueryPoolResults(VkCommandBuffer handle, VkQueryPool pool, uint32_t first, uint32_t count, VkBuffer destination,
                                  VkDeviceSize offset, VkDeviceSize stride, VkQueryResultFlags flags) {
  CommandBuffer& cb = *from(handle);
  cb.record([&] { cb.append(cmd::CopyQueryPoolResults{from(pool), first, count, from(destination), offset, stride, flags}); });
}

}  // namespace pineda::icd
