#include "icd/pipeline_layout.h"

#include <algorithm>

#include "icd/api.h"
#include "icd/descriptor_set_layout.h"
#include "icd/device.h"

namespace pineda::icd {

VkResult PipelineLayout::check(Device&, const VkPipelineLayoutCreateInfo& info) {
  if (info.setLayoutCount > kMaxSets) return not_supported("vkCreatePipelineLayout: more than maxBoundDescriptorSets sets");
  uint32_t dynamic_count = 0;
  for (uint32_t i = 0; i < info.setLayoutCount; ++i) dynamic_count += from(info.pSetLayouts[i])->dynamic_count();
  if (dynamic_count > kMaxDynamicOffsets)
    return not_supported("vkCreatePipelineLayout: more dynamic buffers than the limits allow");
  for (uint32_t i = 0; i < info.pushConstantRangeCount; ++i) {
    const VkPushConstantRange& range = info.pPushConstantRanges[i];
    if (range.offset > kMaxPushConstantBytes || range.size > kMaxPushConstantBytes - range.offset) {
      return not_supported("vkCreatePipelineLayout: push constants beyond maxPushConstantsSize");
    }
  }
  return VK_SUCCESS;
}

PipelineLayout::PipelineLayout(const Allocator& from_allocator, Device&, const VkPipelineLayoutCreateInfo& info)
    : Object(from_allocator), textures_(HostAllocator<TextureRange>(&allocator)) {
  auto flat = std::make_shared<compiler::PipelineLayout>();
  uint32_t dynamic_base = 0;
  for (uint32_t set = 0; set < info.setLayoutCount; ++set) {
    const DescriptorSetLayout& layout = *from(info.pSetLayouts[set]);
    dynamic_base_[set] = dynamic_base;
    for (const BindingLayout& binding : layout.bindings()) {
      flat->bindings.push_back({.set = set,
                                .binding = binding.binding,
                                .type = binding.type,
                                .count = binding.count,
                                .offset_bytes = binding.offset_bytes,
                                .stride_bytes = binding.stride_bytes,
                                .dynamic_index = dynamic_base + binding.dynamic_index});
      if (has_texture_ids(binding.type)) textures_.push_back({set, binding.binding, binding.count, binding.texture_index});
    }
    dynamic_base += layout.dynamic_count();
  }
  for (uint32_t i = 0; i < info.pushConstantRangeCount; ++i) {
    const VkPushConstantRange& range = info.pPushConstantRanges[i];
    flat->push_constant_bytes = std::max(flat->push_constant_bytes, range.offset + range.size);
  }
  compiler_layout_ = std::move(flat);
}

bool PipelineLayout::find_texture(const spirv::ImageRef& ref, TextureSlot* out) const {
  for (const TextureRange& range : textures_) {
    if (range.set != ref.set || range.binding != ref.binding || ref.array_index >= range.count) continue;
    *out = {range.set, range.first_index + ref.array_index};
    return true;
  }
  return false;
}

VkResult api::CreatePipelineLayout(VkDevice device, const VkPipelineLayoutCreateInfo* info,
                                   const VkAllocationCallbacks* callbacks, VkPipelineLayout* out) {
  return create_device_object<PipelineLayout>(device, info, callbacks, out);
}

void api::DestroyPipelineLayout(VkDevice device, VkPipelineLayout layout, const VkAllocationCallbacks* callbacks) {
  destroy_device_object(device, layout, callbacks);
}

}  // namespace pineda::icd
