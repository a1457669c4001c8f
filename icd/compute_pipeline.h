// VkPipeline for dispatches.
#pragma once

#include "icd/pipeline.h"

namespace pineda::icd {

class ComputePipeline : public Pipeline {
 public:
  ComputePipeline(const Allocator& from, Device& owner) : Pipeline(from, owner, VK_PIPELINE_BIND_POINT_COMPUTE) {}
  ~ComputePipeline() override;
  VkResult init(const VkComputePipelineCreateInfo& info, compiler::CodeStore* store);  // `store` may be null

  bool samples() const { return !textures_.empty(); }
  uint32_t invocations() const;  // of a workgroup

  // As GraphicsPipeline::kernels.
  const compiler::ComputeKernel* kernel(const DescriptorSet* const* sets) const;

 private:
  std::unique_ptr<const compiler::ComputeKernel> compile(std::span<const compiler::TextureUse> textures,
                                                         compiler::CodeStore* store,
                                                         const compiler::CodeGenerator* generator) const;

  std::shared_ptr<const compiler::PipelineLayout> layout_;
  spirv::ModulePtr module_;
  PipelineTextures textures_;
  std::string name_;
  std::unique_ptr<const compiler::ComputeKernel> general_;
  mutable Variants<compiler::ComputeKernel> variants_;
};

}  // namespace pineda::icd
