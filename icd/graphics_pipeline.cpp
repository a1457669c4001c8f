#include "icd/graphics_pipeline.h"

#include "base/config.h"
#include "base/float_environment.h"
#include "icd/api.h"
#include "icd/create_pipelines.h"
#include "icd/device.h"
#include "icd/explain.h"

namespace pineda::icd {

GraphicsPipeline::~GraphicsPipeline() { device.background.cancel(this); }

VkResult GraphicsPipeline::init(const VkGraphicsPipelineCreateInfo& info, compiler::CodeStore* store) {
  if (const VkResult result = translate_graphics_state(device, info, &state_); result != VK_SUCCESS) return result;
  const PipelineLayout& layout = *from(info.layout);
  layout_ = layout.compiler_layout();
  for (uint32_t i = 0; i < info.stageCount; ++i) {
    const VkPipelineShaderStageCreateInfo& stage = info.pStages[i];
    const bool is_vertex = stage.stage == VK_SHADER_STAGE_VERTEX_BIT;
    if (!is_vertex && !state_.rasterizes) continue;  // a fragment shader that never runs
    spirv::ModulePtr& parsed = is_vertex ? vertex_ : fragment_;
    if (const VkResult result = parse_stage(device, stage, &parsed); result != VK_SUCCESS) return result;
    if (!textures_.add(*parsed, layout)) return kShaderRejected;
    const std::string module_name = device.name_of(reinterpret_cast<uint64_t>(stage.module));
    if (!module_name.empty()) name_ += (name_.empty() ? "" : "+") + module_name;
  }
  if (name_.empty()) name_ = "graphics";
  const compiler::CodeGenerator generator = code_generator(device);
  general_ = compile({}, store, generator ? &generator : nullptr);
  return general_ ? VK_SUCCESS : kShaderRejected;
}

// Null (reported) when it fails.
std::unique_ptr<const compiler::GraphicsKernels> GraphicsPipeline::compile(std::span<const compiler::TextureUse> textures,
                                                                           compiler::CodeStore* store,
                                                                           const compiler::CodeGenerator* generator) const {
  const ScopedFloatEnvironment environment;  // constant folding
  auto compiled = compiler::compile_graphics({.vertex = vertex_.get(),
                                              .fragment = fragment_.get(),
                                              .layout = layout_.get(),
                                              .vertex_input = state_.vertex_input,
                                              .state = state_.fragment,
                                              .draws_points = state_.draws_points(),
                                              .textures = textures,
                                              .name = name_,
                                              .store = store,
                                              .generator = generator});
  if (compiled && debug(kDebugExplain)) explain(*compiled, textures);
  if (compiled) return std::make_unique<const compiler::GraphicsKernels>(std::move(*compiled));
  report(Severity::kError, "pipeline '" + name_ + "': " + compiled.error().text);
  return nullptr;
}

void GraphicsPipeline::explain(const compiler::GraphicsKernels& compiled, std::span<const compiler::TextureUse> textures) const {
  const auto sizes = compiler::measure_graphics({.vertex = vertex_.get(),
                                                 .fragment = fragment_.get(),
                                                 .layout = layout_.get(),
                                                 .vertex_input = state_.vertex_input,
                                                 .state = state_.fragment,
                                                 .draws_points = state_.draws_points(),
                                                 .textures = textures,
                                                 .name = name_});
  if (!sizes) return;
  say_once(explain_pipeline(name_ + form_text(samples(), !textures.empty()), spirv::info(*vertex_),
                            fragment_ ? &spirv::info(*fragment_) : nullptr, state_.fragment, compiled, *sizes));
}

const compiler::GraphicsKernels* GraphicsPipeline::kernels(const DescriptorSet* const* sets) const {
  if (samples()) {
    const auto* variant =
        variants_.find(device, this, textures_, sets, [this](auto textures) { return compile(textures, nullptr, nullptr); });
    if (variant) return variant;
  }
  return finish(*general_->vertex) && finish(*general_->fragment) ? general_.get() : nullptr;
}

VkResult api::CreateGraphicsPipelines(VkDevice device, VkPipelineCache cache, uint32_t count,
                                      const VkGraphicsPipelineCreateInfo* infos, const VkAllocationCallbacks* callbacks,
                                      VkPipeline* out) {
  return guarded([&] { return create_pipelines<GraphicsPipeline>(device, cache, count, infos, callbacks, out); });
}

}  // namespace pineda::icd
