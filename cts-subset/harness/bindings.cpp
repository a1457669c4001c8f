#include <cstring>
#include <map>

#include "cts-subset/harness/pipelines.h"

namespace pineda::cts {

Descriptor storage_buffer(uint32_t binding, const Buffer& buffer, VkDeviceSize offset, VkDeviceSize range) {
  return {binding, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, {{buffer.handle, offset, range}}, {}, {}};
}

Descriptor uniform_buffer(uint32_t binding, const Buffer& buffer, VkDeviceSize offset, VkDeviceSize range) {
  return {binding, VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, {{buffer.handle, offset, range}}, {}, {}};
}

Descriptor sampled_image(uint32_t binding, const Image& image, VkSampler sampler) {
  return {binding,
          VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER,
          {},
          {{sampler, image.view, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL}},
          {}};
}

Descriptor storage_image(uint32_t binding, const Image& image) {
  return {binding, VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, {}, {{VK_NULL_HANDLE, image.view, VK_IMAGE_LAYOUT_GENERAL}}, {}};
}

void add_specialization(Resources& resources, uint32_t id, uint32_t value) {
  resources.specialization_entries.push_back({id, static_cast<uint32_t>(resources.specialization_data.size()), 4});
  const std::vector<std::byte> bytes = to_bytes(value);
  resources.specialization_data.insert(resources.specialization_data.end(), bytes.begin(), bytes.end());
}

Bindings::Bindings(Device& device, const Resources& resources, VkShaderStageFlags stages) : stages_(stages) {
  std::vector<VkDescriptorSetLayoutBinding> bindings;
  std::map<VkDescriptorType, uint32_t> counts;
  const auto count_of = [](const Descriptor& d) {
    return static_cast<uint32_t>(d.buffers.size() + d.images.size() + d.views.size());
  };
  for (const Descriptor& d : resources.descriptors) {
    bindings.push_back({d.binding, d.type, count_of(d), stages, nullptr});
    counts[d.type] += count_of(d);
  }
  VkDescriptorSetLayoutCreateInfo set_info{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO};
  set_info.bindingCount = static_cast<uint32_t>(bindings.size());
  set_info.pBindings = bindings.data();
  set_layout_ = make<VkDescriptorSetLayout, vkDestroyDescriptorSetLayout>(device, vkCreateDescriptorSetLayout, set_info,
                                                                          "vkCreateDescriptorSetLayout");
  const VkPushConstantRange range{stages, 0, static_cast<uint32_t>(resources.push_constants.size())};
  VkPipelineLayoutCreateInfo layout_info{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
  const VkDescriptorSetLayout set_layout = set_layout_;
  layout_info.setLayoutCount = 1;
  layout_info.pSetLayouts = &set_layout;
  layout_info.pushConstantRangeCount = range.size ? 1 : 0;
  layout_info.pPushConstantRanges = &range;
  layout_ =
      make<VkPipelineLayout, vkDestroyPipelineLayout>(device, vkCreatePipelineLayout, layout_info, "vkCreatePipelineLayout");
  if (bindings.empty()) return;

  std::vector<VkDescriptorPoolSize> sizes;
  for (const auto& [type, count] : counts) sizes.push_back({type, count});
  VkDescriptorPoolCreateInfo pool_info{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
  pool_info.maxSets = 1;
  pool_info.poolSizeCount = static_cast<uint32_t>(sizes.size());
  pool_info.pPoolSizes = sizes.data();
  pool_ = make<VkDescriptorPool, vkDestroyDescriptorPool>(device, vkCreateDescriptorPool, pool_info, "vkCreateDescriptorPool");
  VkDescriptorSetAllocateInfo allocate{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO};
  allocate.descriptorPool = pool_;
  allocate.descriptorSetCount = 1;
  allocate.pSetLayouts = &set_layout;
  check(vkAllocateDescriptorSets(device.handle(), &allocate, &set_), "vkAllocateDescriptorSets");
  std::vector<VkWriteDescriptorSet> writes;
  for (const Descriptor& d : resources.descriptors) {
    VkWriteDescriptorSet write{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
    write.dstSet = set_;
    write.dstBinding = d.binding;
    write.descriptorCount = count_of(d);
    write.descriptorType = d.type;
    write.pBufferInfo = d.buffers.data();
    write.pImageInfo = d.images.data();
    write.pTexelBufferView = d.views.data();
    writes.push_back(write);
  }
  vkUpdateDescriptorSets(device.handle(), static_cast<uint32_t>(writes.size()), writes.data(), 0, nullptr);
}

void Bindings::bind(VkCommandBuffer commands, VkPipelineBindPoint point, const Resources& resources) const {
  if (set_) vkCmdBindDescriptorSets(commands, point, layout_, 0, 1, &set_, 0, nullptr);
  if (!resources.push_constants.empty()) {
    vkCmdPushConstants(commands, layout_, stages_, 0, static_cast<uint32_t>(resources.push_constants.size()),
                       resources.push_constants.data());
  }
}

Pipeline create_compute_pipeline(Device& device, const Spirv& shader, VkPipelineLayout layout, const Resources& resources) {
  VkShaderModuleCreateInfo module_info{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
  module_info.codeSize = shader.size() * 4;
  module_info.pCode = shader.data();
  const auto module =
      make<VkShaderModule, vkDestroyShaderModule>(device, vkCreateShaderModule, module_info, "vkCreateShaderModule");
  const VkSpecializationInfo specialization{static_cast<uint32_t>(resources.specialization_entries.size()),
                                            resources.specialization_entries.data(), resources.specialization_data.size(),
                                            resources.specialization_data.data()};
  VkComputePipelineCreateInfo info{VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO};
  info.stage = {VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                nullptr,
                0,
                VK_SHADER_STAGE_COMPUTE_BIT,
                module,
                "main",
                &specialization};
  info.layout = layout;
  VkPipeline handle = VK_NULL_HANDLE;
  check(vkCreateComputePipelines(device.handle(), VK_NULL_HANDLE, 1, &info, nullptr, &handle), "vkCreateComputePipelines");
  return {device.handle(), handle};
}

void dispatch(Device& device, const Spirv& shader, const Resources& resources, std::array<uint32_t, 3> groups) {
  const Bindings bindings(device, resources, VK_SHADER_STAGE_COMPUTE_BIT);
  const Pipeline pipeline = create_compute_pipeline(device, shader, bindings.layout(), resources);
  device.run([&](VkCommandBuffer commands) {
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline);
    bindings.bind(commands, VK_PIPELINE_BIND_POINT_COMPUTE, resources);
    vkCmdDispatch(commands, groups[0], groups[1], groups[2]);
    full_barrier(commands);
  });
}

Sampler create_sampler(Device& device, const std::function<void(VkSamplerCreateInfo&)>& adjust) {
  VkSamplerCreateInfo info{VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO};
  info.maxLod = VK_LOD_CLAMP_NONE;
  if (adjust) adjust(info);
  return make<VkSampler, vkDestroySampler>(device, vkCreateSampler, info, "vkCreateSampler");
}

QueryPool create_query_pool(Device& device, VkQueryType type, uint32_t count, VkQueryPipelineStatisticFlags statistics) {
  VkQueryPoolCreateInfo info{VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO};
  info.queryType = type;
  info.queryCount = count;
  info.pipelineStatistics = statistics;
  return make<VkQueryPool, vkDestroyQueryPool>(device, vkCreateQueryPool, info, "vkCreateQueryPool");
}

}  // namespace pineda::cts
