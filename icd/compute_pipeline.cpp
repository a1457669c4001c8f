#include "icd/compute_pipeline.h"

#include "base/config.h"
#include "base/float_environment.h"
#include "icd/api.h"
#include "icd/create_pipelines.h"
#include "icd/device.h"
#include "icd/explain.h"
#include "icd/limits.h"

namespace pineda::icd {
namespace {

// What a shader asks for is untrusted: beyond the limits it would size buffers and loops of the executor.
bool within_limits(const spirv::ModuleInfo& info) {
  uint64_t invocations = 1;
  for (int i = 0; i < 3; ++i) {
    if (info.local_size[i] == 0 || info.local_size[i] > kLimits.maxComputeWorkGroupSize[i]) return false;
    invocations *= info.local_size[i];
  }
  return invocations <= kLimits.maxComputeWorkGroupInvocations && info.shared_memory_bytes <= kLimits.maxComputeSharedMemorySize;
}

}  // namespace

ComputePipeline::~ComputePipeline() { device.background.cancel(this); }

VkResult ComputePipeline::init(const VkComputePipelineCreateInfo& info, compiler::CodeStore* store) {
  const PipelineLayout& layout = *from(info.layout);
  layout_ = layout.compiler_layout();
  if (info.stage.stage != VK_SHADER_STAGE_COMPUTE_BIT) return not_supported("vkCreateComputePipelines: not a compute stage");
  if (const VkResult result = parse_stage(device, info.stage, &module_); result != VK_SUCCESS) return result;
  if (!within_limits(spirv::info(*module_))) {
    report(Severity::kError, "vkCreateComputePipelines: the workgroup is larger than the limits allow");
    return kShaderRejected;
  }
  if (!textures_.add(*module_, layout)) return kShaderRejected;
  name_ = device.name_of(reinterpret_cast<uint64_t>(info.stage.module));
  if (name_.empty()) name_ = "compute";
  if (const VkSpecializationInfo* given = info.stage.pSpecializationInfo; debug(kDebugExplain) && given && given->mapEntryCount) {
    VkPipelineShaderStageCreateInfo stage = info.stage;
    stage.pSpecializationInfo = nullptr;
    spirv::ModulePtr module;
    if (parse_stage(device, stage, &module) == VK_SUCCESS) unspecialized_ = {std::move(module), given->mapEntryCount};
  }
  const compiler::CodeGenerator generator = code_generator(device);
  general_ = compile({}, store, generator ? &generator : nullptr);
  return general_ ? VK_SUCCESS : kShaderRejected;
}

uint32_t ComputePipeline::invocations() const {
  const auto& size = spirv::info(*module_).local_size;
  return size[0] * size[1] * size[2];
}

// Null (reported) when it fails.
std::unique_ptr<const compiler::ComputeKernel> ComputePipeline::compile(std::span<const compiler::TextureUse> textures,
                                                                        compiler::CodeStore* store,
                                                                        const compiler::CodeGenerator* generator) const {
  const ScopedFloatEnvironment environment;  // constant folding
  auto compiled = compiler::compile_compute({.module = module_.get(),
                                             .layout = layout_.get(),
                                             .textures = textures,
                                             .name = name_,
                                             .store = store,
                                             .generator = generator});
  if (compiled && debug(kDebugExplain)) explain(textures);
  if (compiled) return std::make_unique<const compiler::ComputeKernel>(std::move(*compiled));
  report(Severity::kError, "pipeline '" + name_ + "': " + compiled.error().text);
  return nullptr;
}

void ComputePipeline::explain(std::span<const compiler::TextureUse> textures) const {
  const auto measure = [&](const spirv::Module& module) {
    return compiler::measure_compute({.module = &module, .layout = layout_.get(), .textures = textures, .name = name_});
  };
  const auto sizes = measure(*module_);
  if (!sizes) return;
  std::optional<Unspecialized> unspecialized;
  if (unspecialized_) {
    if (const auto own = measure(*unspecialized_->module)) unspecialized = {unspecialized_->given, *own};
  }
  say_once(
      explain_compute_pipeline(name_ + form_text(samples(), !textures.empty()), spirv::info(*module_), *sizes, unspecialized));
}

const compiler::ComputeKernel* ComputePipeline::kernel(const DescriptorSet* const* sets) const {
  if (samples()) {
    const auto* variant =
        variants_.find(device, this, textures_, sets, [this](auto textures) { return compile(textures, nullptr, nullptr); });
    if (variant) return variant;
  }
  return finish(*general_->kernel) ? general_.get() : nullptr;
}

VkResult api::CreateComputePipelines(VkDevice device, VkPipelineCache cache, uint32_t count,
                                     const VkComputePipelineCreateInfo* infos, const VkAllocationCallbacks* callbacks,
                                     VkPipeline* out) {
  return guarded([&] { return create_pipelines<ComputePipeline>(device, cache, count, infos, callbacks, out); });
}

}  // namespace pineda::icd
