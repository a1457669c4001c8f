// VkCommandBuffer: a list of commands (command_list.h) and an estimate of their cost.
//
// vkCmd* return nothing: the first failure is kept and given by vkEndCommandBuffer, as the specification says for out-of-memory;
// commands that the driver does not support fail the same way.
#pragma once

#include <utility>

#include "icd/arena.h"
#include "icd/command_list.h"
#include "icd/object.h"

namespace pineda::icd {

// What commands cost, roughly; decides only on which thread a submission runs (queue.h).
namespace cost {
inline constexpr uint64_t kCommand_ns = 50;
inline constexpr uint64_t kDraw_ns = 1000;
inline constexpr uint64_t kVertex_ns = 10;
inline constexpr uint64_t kInvocation_ns = 10;
inline constexpr uint64_t kPixelsPer_ns = 2;  // of the render area, by each draw
inline constexpr uint64_t kBytesPer_ns = 8;   // copies and fills
inline constexpr uint64_t kBlitTexel_ns = 20;
inline constexpr uint64_t kUnknown_ns = 1'000'000;  // sizes that only execution shows
}  // namespace cost

class CommandBuffer : public Dispatchable, public Object {
 public:
  CommandBuffer(const Allocator& from, CommandPool& owner, VkCommandBufferLevel level);

  CommandPool& pool;
  const VkCommandBufferLevel level;
  CommandBuffer* previous = nullptr;  // of the pool's list
  CommandBuffer* next = nullptr;

  VkResult begin(const VkCommandBufferBeginInfo& info);
  VkResult end();
  void reset(bool release_memory);

  // Runs the body of a vkCmd*; an exception becomes the buffer's error.
  template <typename Body>
  void record(Body&& body) noexcept {
    if (error_ != VK_SUCCESS) return;
    const VkResult result = guarded([&] {
      body();
      return VK_SUCCESS;
    });
    if (result != VK_SUCCESS) fail(result);
  }

  // For use inside record().
  template <typename Command>
  void append(const Command& command) {
    auto* node = static_cast<CommandNode<Command>*>(arena_.allocate(sizeof(CommandNode<Command>), alignof(CommandNode<Command>)));
    new (node) CommandNode<Command>{{nullptr, CommandTypeOf<Command>::kType}, command};
    *tail_ = node;
    tail_ = &node->next;
    cost_ns_ += cost::kCommand_ns;
  }
  template <typename T>
  std::span<const T> copy(const T* data, size_t count) {
    return arena_.copy(data, count);
  }
  void add_cost(uint64_t ns) { cost_ns_ += ns; }
  void fail(VkResult result) {
    if (error_ == VK_SUCCESS) error_ = result;
  }

  const CommandHeader* commands() const { return head_; }
  bool executable() const { return executable_; }
  uint64_t cost_ns() const { return cost_ns_; }
  bool waits_for_host() const { return waits_for_host_; }
  void inherit_from(const CommandBuffer& secondary);
  void set_waits_for_host() { waits_for_host_ = true; }

  // Recording state that the cost estimate needs.
  uint64_t area_px = 0;                 // of the render area; 0 outside a render pass
  uint64_t workgroup_invocations = 64;  // of the compute pipeline bound last

 private:
  Arena arena_;
  const CommandHeader* head_ = nullptr;
  const CommandHeader** tail_ = &head_;
  VkResult error_ = VK_SUCCESS;
  bool executable_ = false;
  bool waits_for_host_ = false;
  uint64_t cost_ns_ = 0;
};

}  // namespace pineda::icd
