// One parsed shader stage of a pipeline.
#pragma once

#include <vector>

#include "compiler/spirv/translate.h"
#include "icd/object.h"

namespace pineda::icd {

struct ShaderStage {
  std::vector<uint32_t> words;  // `module` may refer to them; moving a vector keeps its storage
  spirv::ModulePtr module;
};

// Errors are reported with the pipeline's kind, the entry point and the module's name.
VkResult parse_stage(const Device& device, const VkPipelineShaderStageCreateInfo& info, ShaderStage* out);

// What pipeline creation returns when a shader does not compile. The registered code, VK_ERROR_INVALID_SHADER_NV, belongs to an extension
// that may not be enabled, and VK_ERROR_INITIALIZATION_FAILED is not among the codes of vkCreate*Pipelines. VK_ERROR_UNKNOWN may come from every
// command and means "the application has provided invalid input, or an implementation failure has occurred" (Return Codes): exactly
// this. report() says which and why.
inline constexpr VkResult kShaderRejected = VK_ERROR_UNKNOWN;

}  // namespace pineda::icd
