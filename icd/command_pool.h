// VkCommandPool: owns command buffers; each has an arena of its own, which a reset keeps.
#pragma once

#include "icd/command_buffer.h"
#include "icd/object.h"

namespace pineda::icd {

class CommandPool : public Object {
 public:
  CommandPool(const Allocator& from, Device& owner, const VkCommandPoolCreateInfo&) : Object(from), device(owner) {}
  ~CommandPool();

  Device& device;

  CommandBuffer* allocate(VkCommandBufferLevel level);  // throws std::bad_alloc
  void release(CommandBuffer* command_buffer);
  void reset(bool release_memory);

 private:
  CommandBuffer* first_ = nullptr;
};

}  // namespace pineda::icd
