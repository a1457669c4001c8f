#include "tools/vk/pipelines.h"

namespace pineda::tools {
namespace {

VkPipelineShaderStageCreateInfo stage_info(VkShaderStageFlagBits stage, VkShaderModule module,
                                           const VkSpecializationInfo* specialization) {
  return {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
          .stage = stage,
          .module = module,
          .pName = "main",
          .pSpecializationInfo = specialization};
}

VkPipelineColorBlendAttachmentState blend_state(bool alpha_blend) {
  return {.blendEnable = alpha_blend,
          .srcColorBlendFactor = VK_BLEND_FACTOR_SRC_ALPHA,
          .dstColorBlendFactor = VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA,
          .colorBlendOp = VK_BLEND_OP_ADD,
          .srcAlphaBlendFactor = VK_BLEND_FACTOR_ONE,
          .dstAlphaBlendFactor = VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA,
          .alphaBlendOp = VK_BLEND_OP_ADD,
          .colorWriteMask =
              VK_COLOR_COMPONENT_R_BIT | VK_COLOR_COMPONENT_G_BIT | VK_COLOR_COMPONENT_B_BIT | VK_COLOR_COMPONENT_A_BIT};
}

}  // namespace

ShaderModuleHandle create_shader_module(VkContext& context, Spirv words) {
  const VkShaderModuleCreateInfo info{
      .sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO, .codeSize = words.size_bytes(), .pCode = words.data()};
  VkShaderModule module = VK_NULL_HANDLE;
  check(vkCreateShaderModule(context.device(), &info, nullptr, &module), "vkCreateShaderModule");
  return {context.device(), module};
}

DescriptorSetLayoutHandle create_set_layout(VkContext& context, std::span<const Binding> bindings) {
  std::vector<VkDescriptorSetLayoutBinding> descriptions;
  for (const Binding& binding : bindings) {
    descriptions.push_back(
        {.binding = binding.number, .descriptorType = binding.type, .descriptorCount = 1, .stageFlags = binding.stages});
  }
  const VkDescriptorSetLayoutCreateInfo info{.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO,
                                             .bindingCount = static_cast<uint32_t>(descriptions.size()),
                                             .pBindings = descriptions.data()};
  VkDescriptorSetLayout layout = VK_NULL_HANDLE;
  check(vkCreateDescriptorSetLayout(context.device(), &info, nullptr, &layout), "vkCreateDescriptorSetLayout");
  return {context.device(), layout};
}

PipelineLayoutHandle create_pipeline_layout(VkContext& context, std::span<const VkDescriptorSetLayout> sets,
                                            std::span<const VkPushConstantRange> push_constants) {
  const VkPipelineLayoutCreateInfo info{.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                        .setLayoutCount = static_cast<uint32_t>(sets.size()),
                                        .pSetLayouts = sets.data(),
                                        .pushConstantRangeCount = static_cast<uint32_t>(push_constants.size()),
                                        .pPushConstantRanges = push_constants.data()};
  VkPipelineLayout layout = VK_NULL_HANDLE;
  check(vkCreatePipelineLayout(context.device(), &info, nullptr, &layout), "vkCreatePipelineLayout");
  return {context.device(), layout};
}

DescriptorAllocator::DescriptorAllocator(VkContext& context, uint32_t max_sets, uint32_t descriptors_per_type)
    : device_(context.device()) {
  const std::array<VkDescriptorPoolSize, 4> sizes{
      VkDescriptorPoolSize{VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, descriptors_per_type},
      VkDescriptorPoolSize{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, descriptors_per_type},
      VkDescriptorPoolSize{VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, descriptors_per_type},
      VkDescriptorPoolSize{VK_DESCRIPTOR_TYPE_INPUT_ATTACHMENT, descriptors_per_type}};
  const VkDescriptorPoolCreateInfo info{.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
                                        .maxSets = max_sets,
                                        .poolSizeCount = static_cast<uint32_t>(sizes.size()),
                                        .pPoolSizes = sizes.data()};
  VkDescriptorPool pool = VK_NULL_HANDLE;
  check(vkCreateDescriptorPool(device_, &info, nullptr, &pool), "vkCreateDescriptorPool");
  pool_ = {device_, pool};
}

VkDescriptorSet DescriptorAllocator::allocate(VkDescriptorSetLayout layout) {
  const VkDescriptorSetAllocateInfo info{.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                         .descriptorPool = pool_,
                                         .descriptorSetCount = 1,
                                         .pSetLayouts = &layout};
  VkDescriptorSet set = VK_NULL_HANDLE;
  check(vkAllocateDescriptorSets(device_, &info, &set), "vkAllocateDescriptorSets");
  return set;
}

void DescriptorAllocator::write_buffer(VkDescriptorSet set, uint32_t binding, VkDescriptorType type, const Buffer& buffer) {
  const VkDescriptorBufferInfo buffer_info{.buffer = buffer.handle, .offset = 0, .range = VK_WHOLE_SIZE};
  const VkWriteDescriptorSet write{.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                   .dstSet = set,
                                   .dstBinding = binding,
                                   .descriptorCount = 1,
                                   .descriptorType = type,
                                   .pBufferInfo = &buffer_info};
  vkUpdateDescriptorSets(device_, 1, &write, 0, nullptr);
}

void DescriptorAllocator::write_texture(VkDescriptorSet set, uint32_t binding, const Image2D& texture, VkSampler sampler) {
  write_image(set, binding, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, texture, sampler);
}

void DescriptorAllocator::write_input_attachment(VkDescriptorSet set, uint32_t binding, const Image2D& image) {
  write_image(set, binding, VK_DESCRIPTOR_TYPE_INPUT_ATTACHMENT, image, VK_NULL_HANDLE);
}

void DescriptorAllocator::write_image(VkDescriptorSet set, uint32_t binding, VkDescriptorType type, const Image2D& image,
                                      VkSampler sampler) {
  const VkDescriptorImageInfo image_info{
      .sampler = sampler, .imageView = image.view, .imageLayout = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
  const VkWriteDescriptorSet write{.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                   .dstSet = set,
                                   .dstBinding = binding,
                                   .descriptorCount = 1,
                                   .descriptorType = type,
                                   .pImageInfo = &image_info};
  vkUpdateDescriptorSets(device_, 1, &write, 0, nullptr);
}

PipelineHandle create_graphics_pipeline(VkContext& context, const RenderTarget& target, const GraphicsPipelineDesc& desc) {
  const PipelineTarget known{target.render_pass(), 0, target.extent(), target.samples(), target.has_colour() ? 1u : 0u};
  return create_graphics_pipeline(context, known, desc);
}

PipelineHandle create_graphics_pipeline(VkContext& context, const PipelineTarget& target, const GraphicsPipelineDesc& desc) {
  const ShaderModuleHandle vertex_module = create_shader_module(context, desc.vertex_shader);
  std::vector<VkPipelineShaderStageCreateInfo> stages{
      stage_info(VK_SHADER_STAGE_VERTEX_BIT, vertex_module, desc.vertex_specialization)};
  ShaderModuleHandle fragment_module;
  if (!desc.fragment_shader.empty()) {
    fragment_module = create_shader_module(context, desc.fragment_shader);
    stages.push_back(stage_info(VK_SHADER_STAGE_FRAGMENT_BIT, fragment_module, desc.specialization));
  }
  const VkPipelineVertexInputStateCreateInfo vertex_input{
      .sType = VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO,
      .vertexBindingDescriptionCount = static_cast<uint32_t>(desc.vertex_bindings.size()),
      .pVertexBindingDescriptions = desc.vertex_bindings.data(),
      .vertexAttributeDescriptionCount = static_cast<uint32_t>(desc.vertex_attributes.size()),
      .pVertexAttributeDescriptions = desc.vertex_attributes.data()};
  VkPipelineInputAssemblyStateCreateInfo assembly{.sType = VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO,
                                                  .topology = desc.topology};
  const VkViewport viewport{0, 0, static_cast<float>(target.extent.width), static_cast<float>(target.extent.height), 0, 1};
  const VkRect2D scissor{{0, 0}, target.extent};
  const bool has_viewports = !desc.viewports.empty();
  const auto viewport_count = has_viewports ? static_cast<uint32_t>(desc.viewports.size()) : 1;
  const VkPipelineViewportStateCreateInfo viewport_state{.sType = VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO,
                                                         .viewportCount = viewport_count,
                                                         .pViewports = has_viewports ? desc.viewports.data() : &viewport,
                                                         .scissorCount = viewport_count,
                                                         .pScissors = has_viewports ? desc.scissors.data() : &scissor};
  VkPipelineRasterizationStateCreateInfo rasterization{.sType = VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO,
                                                       .polygonMode = desc.polygon_mode,
                                                       .cullMode = desc.cull_mode,
                                                       .frontFace = VK_FRONT_FACE_COUNTER_CLOCKWISE,
                                                       .lineWidth = desc.line_width};
  const VkPipelineMultisampleStateCreateInfo multisample{.sType = VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO,
                                                         .rasterizationSamples = target.samples};
  VkPipelineDepthStencilStateCreateInfo depth{.sType = VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO,
                                              .depthTestEnable = desc.depth_test,
                                              .depthWriteEnable = desc.depth_write,
                                              .depthCompareOp = VK_COMPARE_OP_LESS_OR_EQUAL};
  VkPipelineColorBlendAttachmentState attachment = blend_state(desc.alpha_blend);
  VkPipelineRasterizationLineStateCreateInfoEXT line{.sType =
                                                         VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_LINE_STATE_CREATE_INFO_EXT};
  if (desc.adjust) desc.adjust({assembly, rasterization, line, depth, attachment});
  const std::vector<VkPipelineColorBlendAttachmentState> attachments(target.colour_count, attachment);
  const VkPipelineColorBlendStateCreateInfo blend{.sType = VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO,
                                                  .attachmentCount = target.colour_count,
                                                  .pAttachments = attachments.data(),
                                                  .blendConstants = {0.25f, 0.5f, 0.75f, 0.375f}};
  const VkGraphicsPipelineCreateInfo info{.sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO,
                                          .stageCount = static_cast<uint32_t>(stages.size()),
                                          .pStages = stages.data(),
                                          .pVertexInputState = &vertex_input,
                                          .pInputAssemblyState = &assembly,
                                          .pViewportState = &viewport_state,
                                          .pRasterizationState = &rasterization,
                                          .pMultisampleState = &multisample,
                                          .pDepthStencilState = &depth,
                                          .pColorBlendState = &blend,
                                          .layout = desc.layout,
                                          .renderPass = target.render_pass,
                                          .subpass = target.subpass};
  VkPipeline pipeline = VK_NULL_HANDLE;
  check(vkCreateGraphicsPipelines(context.device(), desc.cache, 1, &info, nullptr, &pipeline), "vkCreateGraphicsPipelines");
  return {context.device(), pipeline};
}

PipelineHandle create_compute_pipeline(VkContext& context, Spirv shader, VkPipelineLayout layout,
                                       const VkSpecializationInfo* specialization, VkPipelineCache cache) {
  const ShaderModuleHandle module = create_shader_module(context, shader);
  const VkComputePipelineCreateInfo info{.sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO,
                                         .stage = stage_info(VK_SHADER_STAGE_COMPUTE_BIT, module, specialization),
                                         .layout = layout};
  VkPipeline pipeline = VK_NULL_HANDLE;
  check(vkCreateComputePipelines(context.device(), cache, 1, &info, nullptr, &pipeline), "vkCreateComputePipelines");
  return {context.device(), pipeline};
}

}  // namespace pineda::tools
