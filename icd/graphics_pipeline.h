// VkPipeline for drawing.
#pragma once

#include "icd/graphics_state.h"
#include "icd/pipeline.h"

namespace pineda::icd {

class GraphicsPipeline : public Pipeline {
 public:
  GraphicsPipeline(const Allocator& from, Device& owner) : Pipeline(from, owner, VK_PIPELINE_BIND_POINT_GRAPHICS) {}
  ~GraphicsPipeline() override;
  // Parses the stages and compiles.
  VkResult init(const VkGraphicsPipelineCreateInfo& info, compiler::CodeStore* store);  // `store` may be null

  const GraphicsState& state() const { return state_; }
  bool samples() const { return !textures_.empty(); }

  // Kernels for what the sets hold. Only for the thread that executes for the queue.
  const compiler::GraphicsKernels* kernels(const DescriptorSet* const* sets) const;

 private:
  std::unique_ptr<const compiler::GraphicsKernels> compile(std::span<const compiler::TextureUse> textures,
                                                           compiler::CodeStore* store,
                                                           const compiler::CodeGenerator* generator) const;
  void explain(const compiler::GraphicsKernels& compiled, std::span<const compiler::TextureUse> textures) const;

  GraphicsState state_;
  std::shared_ptr<const compiler::PipelineLayout> layout_;
  spirv::ModulePtr vertex_, fragment_;  // fragment_ is null without a fragment stage
  PipelineTextures textures_;
  std::string name_;
  std::unique_ptr<const compiler::GraphicsKernels> general_;
  mutable Variants<compiler::GraphicsKernels> variants_;
};

}  // namespace pineda::icd
