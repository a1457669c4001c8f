#include "tools/extreme/rig.h"

#include <algorithm>
#include <cstdint>

#include "shaders/extreme_flat_frag.h"
#include "shaders/extreme_flat_vert.h"

namespace pineda::tools {
namespace {

VkPipelineColorBlendAttachmentState blend_state(const std::optional<RigBlend>& blend) {
  const RigBlend with = blend.value_or(RigBlend{});
  return {.blendEnable = blend.has_value(),
          .srcColorBlendFactor = with.source,
          .dstColorBlendFactor = with.destination,
          .colorBlendOp = with.operation,
          .srcAlphaBlendFactor = with.source,
          .dstAlphaBlendFactor = with.destination,
          .alphaBlendOp = with.operation,
          .colorWriteMask = 0xF};
}

}  // namespace

std::vector<RigVertex> rectangle(float x0, float y0, float x1, float y1, float z, std::array<float, 4> data) {
  const auto at = [&](float x, float y) { return RigVertex{{x, y, z, 1}, data}; };
  return {at(x0, y0), at(x1, y0), at(x0, y1), at(x0, y1), at(x1, y0), at(x1, y1)};
}

bool ExtremeRig::has_format(VkFormat format, VkFormatFeatureFlags features) const {
  VkFormatProperties properties;
  vkGetPhysicalDeviceFormatProperties(context_.physical_device(), format, &properties);
  return (properties.optimalTilingFeatures & features) == features;
}

VkPhysicalDeviceFeatures ExtremeRig::features() const {
  VkPhysicalDeviceFeatures features;
  vkGetPhysicalDeviceFeatures(context_.physical_device(), &features);
  return features;
}

VkPhysicalDeviceLimits ExtremeRig::limits() const {
  VkPhysicalDeviceProperties properties;
  vkGetPhysicalDeviceProperties(context_.physical_device(), &properties);
  return properties.limits;
}

RenderPassHandle ExtremeRig::create_render_pass(const RigTarget& target) {
  std::vector<VkAttachmentDescription> attachments{{.format = target.colour,
                                                    .samples = VK_SAMPLE_COUNT_1_BIT,
                                                    .loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR,
                                                    .storeOp = VK_ATTACHMENT_STORE_OP_STORE,
                                                    .stencilLoadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE,
                                                    .stencilStoreOp = VK_ATTACHMENT_STORE_OP_DONT_CARE,
                                                    .initialLayout = VK_IMAGE_LAYOUT_UNDEFINED,
                                                    .finalLayout = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL}};
  if (target.depth) {
    attachments.push_back(attachments[0]);
    attachments[1].format = target.depth;
    attachments[1].storeOp = VK_ATTACHMENT_STORE_OP_DONT_CARE;
    attachments[1].finalLayout = VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL;
  }
  const VkAttachmentReference colour{0, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
  const VkAttachmentReference depth{1, VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL};
  const VkSubpassDescription subpass{.pipelineBindPoint = VK_PIPELINE_BIND_POINT_GRAPHICS,
                                     .colorAttachmentCount = 1,
                                     .pColorAttachments = &colour,
                                     .pDepthStencilAttachment = target.depth ? &depth : nullptr};
  const VkSubpassDependency dependency{.srcSubpass = 0,
                                       .dstSubpass = VK_SUBPASS_EXTERNAL,
                                       .srcStageMask = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT,
                                       .dstStageMask = VK_PIPELINE_STAGE_TRANSFER_BIT,
                                       .srcAccessMask = VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT,
                                       .dstAccessMask = VK_ACCESS_TRANSFER_READ_BIT};
  const VkRenderPassCreateInfo info{.sType = VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO,
                                    .attachmentCount = static_cast<uint32_t>(attachments.size()),
                                    .pAttachments = attachments.data(),
                                    .subpassCount = 1,
                                    .pSubpasses = &subpass,
                                    .dependencyCount = 1,
                                    .pDependencies = &dependency};
  VkRenderPass pass = VK_NULL_HANDLE;
  check(vkCreateRenderPass(context_.device(), &info, nullptr, &pass), "vkCreateRenderPass");
  return {context_.device(), pass};
}

PipelineHandle ExtremeRig::create_pipeline(const RigTarget& target, VkRenderPass pass, VkPipelineLayout layout,
                                           const RigDraw& draw) {
  const ShaderModuleHandle vertex = create_shader_module(context_, extreme_flat_vert);
  const ShaderModuleHandle fragment =
      create_shader_module(context_, draw.fragment.empty() ? Spirv(extreme_flat_frag) : draw.fragment);
  const auto stage = [](VkShaderStageFlagBits bit, VkShaderModule module) {
    return VkPipelineShaderStageCreateInfo{
        .sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO, .stage = bit, .module = module, .pName = "main"};
  };
  const VkPipelineShaderStageCreateInfo stages[] = {stage(VK_SHADER_STAGE_VERTEX_BIT, vertex),
                                                    stage(VK_SHADER_STAGE_FRAGMENT_BIT, fragment)};
  const VkVertexInputBindingDescription binding{0, sizeof(RigVertex), VK_VERTEX_INPUT_RATE_VERTEX};
  const VkVertexInputAttributeDescription attributes[] = {{0, 0, VK_FORMAT_R32G32B32A32_SFLOAT, offsetof(RigVertex, place)},
                                                          {1, 0, VK_FORMAT_R32G32B32A32_SFLOAT, offsetof(RigVertex, data)}};
  const VkPipelineVertexInputStateCreateInfo vertex_input{.sType = VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO,
                                                          .vertexBindingDescriptionCount = 1,
                                                          .pVertexBindingDescriptions = &binding,
                                                          .vertexAttributeDescriptionCount = 2,
                                                          .pVertexAttributeDescriptions = attributes};
  const VkPipelineInputAssemblyStateCreateInfo assembly{.sType = VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO,
                                                        .topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST};
  const VkExtent2D extent = target.extent;
  const VkViewport viewport =
      target.viewport.value_or(VkViewport{0, 0, static_cast<float>(extent.width), static_cast<float>(extent.height), 0, 1});
  const VkRect2D scissor{{0, 0}, extent};
  const VkPipelineViewportStateCreateInfo viewport_state{.sType = VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO,
                                                         .viewportCount = 1,
                                                         .pViewports = &viewport,
                                                         .scissorCount = 1,
                                                         .pScissors = &scissor};
  const VkPipelineRasterizationStateCreateInfo rasterization{.sType = VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO,
                                                             .depthBiasEnable = draw.bias_constant != 0 || draw.bias_slope != 0,
                                                             .depthBiasConstantFactor = draw.bias_constant,
                                                             .depthBiasSlopeFactor = draw.bias_slope,
                                                             .lineWidth = 1};
  const VkPipelineMultisampleStateCreateInfo multisample{.sType = VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO,
                                                         .rasterizationSamples = VK_SAMPLE_COUNT_1_BIT};
  const VkPipelineDepthStencilStateCreateInfo depth{.sType = VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO,
                                                    .depthTestEnable = draw.depth_test,
                                                    .depthWriteEnable = draw.depth_test,
                                                    .depthCompareOp = draw.compare};
  const VkPipelineColorBlendAttachmentState attachment = blend_state(draw.blend);
  const VkPipelineColorBlendStateCreateInfo blend{
      .sType = VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO, .attachmentCount = 1, .pAttachments = &attachment};
  const VkGraphicsPipelineCreateInfo info{.sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO,
                                          .stageCount = 2,
                                          .pStages = stages,
                                          .pVertexInputState = &vertex_input,
                                          .pInputAssemblyState = &assembly,
                                          .pViewportState = &viewport_state,
                                          .pRasterizationState = &rasterization,
                                          .pMultisampleState = &multisample,
                                          .pDepthStencilState = &depth,
                                          .pColorBlendState = &blend,
                                          .layout = layout,
                                          .renderPass = pass};
  VkPipeline pipeline = VK_NULL_HANDLE;
  check(vkCreateGraphicsPipelines(context_.device(), VK_NULL_HANDLE, 1, &info, nullptr, &pipeline), "vkCreateGraphicsPipelines");
  return {context_.device(), pipeline};
}

std::vector<std::byte> ExtremeRig::draw(const RigTarget& target, std::span<const RigDraw> draws) {
  const Image2D colour = create_image(context_, target.extent, 1, target.colour,
                                      VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT);
  const Image2D depth = target.depth
                            ? create_image(context_, target.extent, 1, target.depth, VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT)
                            : Image2D{};
  const RenderPassHandle pass = create_render_pass(target);
  const VkImageView views[] = {colour.view, depth.view};
  const VkFramebufferCreateInfo framebuffer_info{.sType = VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO,
                                                 .renderPass = pass,
                                                 .attachmentCount = target.depth ? 2u : 1u,
                                                 .pAttachments = views,
                                                 .width = target.extent.width,
                                                 .height = target.extent.height,
                                                 .layers = 1};
  VkFramebuffer framebuffer_handle = VK_NULL_HANDLE;
  check(vkCreateFramebuffer(context_.device(), &framebuffer_info, nullptr, &framebuffer_handle), "vkCreateFramebuffer");
  const FramebufferHandle framebuffer(context_.device(), framebuffer_handle);
  const PipelineLayoutHandle layout = create_pipeline_layout(context_, {}, {});
  std::vector<PipelineHandle> pipelines;
  std::vector<Buffer> buffers;
  for (const RigDraw& draw : draws) {
    pipelines.push_back(create_pipeline(target, pass, layout, draw));
    buffers.push_back(create_buffer(context_, draw.vertices, VK_BUFFER_USAGE_VERTEX_BUFFER_BIT));
  }
  context_.run_once([&](VkCommandBuffer commands) {
    VkClearValue clears[2];
    std::copy(target.clear_colour.begin(), target.clear_colour.end(), clears[0].color.float32);
    clears[1].depthStencil = {target.clear_depth, 0};
    const VkRenderPassBeginInfo begin{.sType = VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO,
                                      .renderPass = pass,
                                      .framebuffer = framebuffer,
                                      .renderArea = {{0, 0}, target.extent},
                                      .clearValueCount = target.depth ? 2u : 1u,
                                      .pClearValues = clears};
    vkCmdBeginRenderPass(commands, &begin, VK_SUBPASS_CONTENTS_INLINE);
    for (size_t i = 0; i < draws.size(); ++i) {
      const VkDeviceSize offset = 0;
      const VkBuffer buffer = buffers[i].handle;
      vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipelines[i]);
      vkCmdBindVertexBuffers(commands, 0, 1, &buffer, &offset);
      vkCmdDraw(commands, static_cast<uint32_t>(draws[i].vertices.size()), 1, 0, 0);
    }
    vkCmdEndRenderPass(commands);
  });
  return read_back_bytes(context_, colour, target.bytes_per_pixel);
}

std::vector<std::byte> ExtremeRig::compute(Spirv shader, std::span<const std::byte> input, size_t output_bytes, uint32_t groups,
                                           const RigTexture* texture) {
  const Buffer in = create_buffer(context_, input, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
  const Buffer out = create_buffer(context_, output_bytes, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
  std::memset(out.mapped, 0, output_bytes);
  std::vector<Binding> bindings{{0, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, VK_SHADER_STAGE_COMPUTE_BIT},
                                {1, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, VK_SHADER_STAGE_COMPUTE_BIT}};
  if (texture) bindings.push_back({2, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, VK_SHADER_STAGE_COMPUTE_BIT});
  const DescriptorSetLayoutHandle set_layout = create_set_layout(context_, bindings);
  const VkDescriptorSetLayout set_layouts[] = {set_layout};
  const PipelineLayoutHandle layout = create_pipeline_layout(context_, set_layouts, {});
  const PipelineHandle pipeline = create_compute_pipeline(context_, shader, layout);
  DescriptorAllocator allocator(context_, 1, 2);
  const VkDescriptorSet set = allocator.allocate(set_layout);
  allocator.write_buffer(set, 0, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, in);
  allocator.write_buffer(set, 1, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, out);
  if (texture) {
    const VkDescriptorImageInfo image{texture->sampler, texture->texture.view, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
    const VkWriteDescriptorSet write{.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                     .dstSet = set,
                                     .dstBinding = 2,
                                     .descriptorCount = 1,
                                     .descriptorType = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER,
                                     .pImageInfo = &image};
    vkUpdateDescriptorSets(context_.device(), 1, &write, 0, nullptr);
  }
  context_.run_once([&](VkCommandBuffer commands) {
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline);
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout, 0, 1, &set, 0, nullptr);
    vkCmdDispatch(commands, groups, 1, 1);
    make_visible_to_host(commands, out, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_ACCESS_SHADER_WRITE_BIT);
  });
  return {out.mapped, out.mapped + output_bytes};
}

}  // namespace pineda::tools
