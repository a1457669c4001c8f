// VkPipeline for drawing.
#pragma once

#include "icd/graphics_state.h"
#include "icd/pipeline.h"

namespace pineda::icd {

class GraphicsPipeline : public Pipeline {
 public:
  GraphicsPipeline(const Allocator& from, Device& owner) : Pipeline(from, owner, VK_PIPELINE_BIND_POINT_GRAPHICS) {}
  // Parses the stages and, when nothing is sampled, compiles.
  VkResult init(const VkGraphicsPipelineCreateInfo& info);

  const GraphicsState& state() const { return state_; }
  bool samples() const { return !textures_.empty(); }

  // Kernels for what the sets hold; compiled now if this combination is new. Null (reported) when that fails. Only for the thread
  // that executes for the queue.
  const compiler::GraphicsKernels* kernels(const DescriptorSet* const* sets) const;

 private:
  using Cache = Variants<compiler::GraphicsKernels>;
  const Cache::Entry* compile(std::span<const TextureIds> key) const;

  GraphicsState state_;
  std::shared_ptr<const compiler::PipelineLayout> layout_;
  spirv::ModulePtr vertex_, fragment_;  // fragment_ is null without a fragment stage
  PipelineTextures textures_;
  std::string name_;
  mutable Cache variants_;
  mutable std::vector<TextureIds> key_;  // scratch
};

}  // namespace pineda::icd
