// VkPipeline for dispatches.
#pragma once

#include <optional>

#include "icd/pipeline.h"

namespace pineda::icd {

class ComputePipeline : public Pipeline {
 public:
  ComputePipeline(const Allocator& from, Device& owner) : Pipeline(from, owner, VK_PIPELINE_BIND_POINT_COMPUTE) {}
  ~ComputePipeline() override;
  VkResult init(const VkComputePipelineCreateInfo& info, compiler::CodeStore* store);  // `store` may be null

  bool samples() const { return !textures_.empty(); }
  uint32_t invocations() const;  // of a workgroup
  const std::string& name() const { return name_; }

  // As GraphicsPipeline::kernels.
  const compiler::ComputeKernel* kernel(const DescriptorSet* const* sets) const;

 private:
  std::unique_ptr<const compiler::ComputeKernel> compile(std::span<const compiler::TextureUse> textures,
                                                         compiler::CodeStore* store,
                                                         const compiler::CodeGenerator* generator) const;
  void explain(std::span<const compiler::TextureUse> textures) const;

  std::shared_ptr<const compiler::PipelineLayout> layout_;
  spirv::ModulePtr module_;
  PipelineTextures textures_;
  std::string name_;
  struct OwnValues {  // for PINEDA_DEBUG=explain: the shader without specialisation
    spirv::ModulePtr module;
    uint32_t given;  // constants that the application specialised
  };
  std::optional<OwnValues> unspecialized_;
  std::unique_ptr<const compiler::ComputeKernel> general_;
  mutable Variants<compiler::ComputeKernel> variants_;
};

}  // namespace pineda::icd
