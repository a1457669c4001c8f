// The worker's side of `pineda errors`: one function on one driver, block by block.
#pragma once

#include <array>
#include <memory>
#include <string>

#include "tools/errors/shared_block.h"
#include "tools/vk/pipelines.h"

namespace pineda::tools {

class ErrorProbe {
 public:
  // `driver`: index of this worker's results.
  ErrorProbe(VkContext& context, const std::string& path, uint32_t drivers, uint32_t driver);
  ~ErrorProbe();

  void select(uint32_t function, uint32_t operands);
  void run(uint32_t slot);

 private:
  static constexpr uint32_t kBuffers = 4;  // operands, results

  VkContext& context_;
  SharedBlock shared_;
  const uint32_t driver_;
  uint32_t operands_ = 0;
  DescriptorAllocator descriptors_;
  std::array<Buffer, kBuffers> buffers_;
  DescriptorSetLayoutHandle set_layout_;
  VkDescriptorSet set_ = VK_NULL_HANDLE;
  PipelineLayoutHandle layout_;
  PipelineHandle pipeline_;
  VkCommandBuffer commands_ = VK_NULL_HANDLE;
};

}  // namespace pineda::tools
