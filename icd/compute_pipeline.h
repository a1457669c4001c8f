// VkPipeline for dispatches.
#pragma once

#include "icd/pipeline.h"

namespace pineda::icd {

class ComputePipeline : public Pipeline {
 public:
  ComputePipeline(const Allocator& from, Device& owner) : Pipeline(from, owner, VK_PIPELINE_BIND_POINT_COMPUTE) {}
  VkResult init(const VkComputePipelineCreateInfo& info);

  bool samples() const { return !textures_.empty(); }
  uint32_t invocations() const;  // of a workgroup

  // As GraphicsPipeline::kernels.
  const compiler::ComputeKernel* kernel(const DescriptorSet* const* sets) const;

 private:
  using Cache = Variants<compiler::ComputeKernel>;
  const Cache::Entry* compile(std::span<const TextureIds> key) const;

  std::shared_ptr<const compiler::PipelineLayout> layout_;
  spirv::ModulePtr module_;
  PipelineTextures textures_;
  std::string name_;
  mutable Cache variants_;
  mutable std::vector<TextureIds> key_;  // scratch
};

}  // namespace pineda::icd
