#include "tools/errors/probe.h"

#include <cstring>
#include <vector>

#include "shaders/measured_comp.h"
#include "shaders/measured_double_comp.h"
#include "shaders/measured_half_comp.h"

namespace pineda::tools {
namespace {

constexpr uint32_t kGroupSize = 64;  // as in measured.comp
constexpr size_t kBytes = SharedBlock::kElements * sizeof(float);

// As MeasuredFunction::number says.
Spirv shader_of(uint32_t function) {
  if (function < 128) return measured_comp;
  if (function < 192) return measured_half_comp;
  return measured_double_comp;
}

}  // namespace

ErrorProbe::ErrorProbe(VkContext& context, const std::string& path, uint32_t drivers, uint32_t driver)
    : context_(context), shared_(path, drivers), driver_(driver), descriptors_(context, 1, kBuffers) {
  std::vector<Binding> bindings;
  for (uint32_t i = 0; i < kBuffers; ++i) {
    buffers_[i] = create_buffer(context, kBytes, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
    bindings.push_back({i, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, VK_SHADER_STAGE_COMPUTE_BIT});
  }
  set_layout_ = create_set_layout(context, bindings);
  set_ = descriptors_.allocate(set_layout_);
  for (uint32_t i = 0; i < kBuffers; ++i) descriptors_.write_buffer(set_, i, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, buffers_[i]);
  const VkDescriptorSetLayout set_layout = set_layout_;
  layout_ = create_pipeline_layout(context, {&set_layout, 1}, {});
}

ErrorProbe::~ErrorProbe() {
  if (commands_) context_.release(commands_);
}

void ErrorProbe::select(uint32_t function, uint32_t operands) {
  operands_ = operands;
  const VkSpecializationMapEntry entry{.constantID = 0, .offset = 0, .size = sizeof function};
  const VkSpecializationInfo specialization{1, &entry, sizeof function, &function};
  if (commands_) context_.release(commands_);
  pipeline_ = create_compute_pipeline(context_, shader_of(function), layout_, &specialization);
  commands_ = context_.record([&](VkCommandBuffer commands) {
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline_);
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout_, 0, 1, &set_, 0, nullptr);
    vkCmdDispatch(commands, SharedBlock::kElements / kGroupSize, 1, 1);
    make_visible_to_host(commands, buffers_[3], VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_ACCESS_SHADER_WRITE_BIT);
  });
}

void ErrorProbe::run(uint32_t slot) {
  for (uint32_t i = 0; i < operands_; ++i) std::memcpy(buffers_[i].mapped, shared_.operands(slot, i), kBytes);
  context_.submit_and_wait(commands_);
  std::memcpy(shared_.results(slot, driver_), buffers_[3].mapped, kBytes);
}

}  // namespace pineda::tools
