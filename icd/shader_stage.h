// Parsing a shader stage of a pipeline.
#pragma once

#include "compiler/spirv/translate.h"
#include "icd/object.h"

namespace pineda::icd {

// The result has its own copy of what it needs: the VkShaderModule may be destroyed. Errors are reported with the pipeline's
// kind, the entry point and the module's name.
VkResult parse_stage(const Device& device, const VkPipelineShaderStageCreateInfo& info, spirv::ModulePtr* out);

// What pipeline creation returns when a shader does not compile. The registered code, VK_ERROR_INVALID_SHADER_NV, belongs to an
// extension that may not be enabled, and VK_ERROR_INITIALIZATION_FAILED is not among the codes of vkCreate*Pipelines.
// VK_ERROR_UNKNOWN may come from every command and means "the application has provided invalid input, or an implementation
// failure has occurred" (Return Codes): exactly this. report() says which and why.
inline constexpr VkResult kShaderRejected = VK_ERROR_UNKNOWN;

}  // namespace pineda::icd
