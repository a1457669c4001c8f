#include "icd/shader_stage.h"

#include "icd/debug_utils.h"
#include "icd/device.h"
#include "icd/shader_module.h"

namespace pineda::icd {
namespace {

const char* stage_name(VkShaderStageFlagBits stage) {
  switch (stage) {
    case VK_SHADER_STAGE_VERTEX_BIT:
      return "vertex";
    case VK_SHADER_STAGE_FRAGMENT_BIT:
      return "fragment";
    case VK_SHADER_STAGE_COMPUTE_BIT:
      return "compute";
    default:
      return "unsupported";
  }
}

std::vector<spirv::SpecializationConstant> specialization(const VkSpecializationInfo* info) {
  std::vector<spirv::SpecializationConstant> constants;
  for (uint32_t i = 0; info && i < info->mapEntryCount; ++i) {
    const VkSpecializationMapEntry& entry = info->pMapEntries[i];
    if (entry.offset > info->dataSize || entry.size > info->dataSize - entry.offset)
      continue;  // invalid usage: keeps its default
    const auto* bytes = static_cast<const uint8_t*>(info->pData) + entry.offset;
    constants.push_back({entry.constantID, {bytes, bytes + entry.size}});
  }
  return constants;
}

}  // namespace

VkResult parse_stage(const Device& device, const VkPipelineShaderStageCreateInfo& info, spirv::ModulePtr* out) {
  const auto constants = specialization(info.pSpecializationInfo);
  auto module = spirv::parse(
      {.words = from(info.module)->words(), .entry_point = info.pName, .stage = info.stage, .specialization = constants});
  if (!module) {
    const std::string name = device.name_of(reinterpret_cast<uint64_t>(info.module));
    const MessageScope scope(device, VK_OBJECT_TYPE_SHADER_MODULE, reinterpret_cast<uint64_t>(info.module));
    report(Severity::kError, std::string(stage_name(info.stage)) + " shader " + (name.empty() ? "" : "'" + name + "' ") +
                                 "(entry point '" + info.pName + "'), SPIR-V word " + std::to_string(module.error().word) + ": " +
                                 module.error().text);
    return kShaderRejected;
  }
  *out = std::move(*module);
  return VK_SUCCESS;
}

}  // namespace pineda::icd
