#include <fmt/format.h>

#include "cts-subset/harness/pipelines.h"

namespace pineda::cts {
namespace {

Owned<VkShaderModule, vkDestroyShaderModule> create_module(Device& device, const Spirv& words) {
  VkShaderModuleCreateInfo info{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
  info.codeSize = words.size() * 4;
  info.pCode = words.data();
  return make<VkShaderModule, vkDestroyShaderModule>(device, vkCreateShaderModule, info, "vkCreateShaderModule");
}

VkAttachmentDescription describe(const Image& image, VkAttachmentLoadOp load, VkImageLayout while_drawn) {
  VkAttachmentDescription description{};
  description.format = image.desc.format;
  description.samples = image.desc.samples;
  description.loadOp = description.stencilLoadOp = load;
  description.storeOp = description.stencilStoreOp = VK_ATTACHMENT_STORE_OP_STORE;
  description.initialLayout =
      load == VK_ATTACHMENT_LOAD_OP_LOAD ? VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL : VK_IMAGE_LAYOUT_UNDEFINED;
  description.finalLayout = while_drawn == VK_IMAGE_LAYOUT_UNDEFINED ? while_drawn : VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL;
  return description;
}

}  // namespace

DrawState::DrawState() {
  rasterization.polygonMode = VK_POLYGON_MODE_FILL;
  rasterization.lineWidth = 1.0f;
  rasterization.frontFace = VK_FRONT_FACE_CLOCKWISE;
  multisample.rasterizationSamples = VK_SAMPLE_COUNT_1_BIT;
  depth_stencil.depthCompareOp = VK_COMPARE_OP_ALWAYS;
  depth_stencil.maxDepthBounds = 1.0f;
}

Pass::Pass(Device& device, const Target& target) : device_(device), target_(target) {
  const Image* any = !target.colours.empty() ? target.colours[0].image
                     : target.depth_stencil  ? target.depth_stencil->image
                                             : nullptr;
  if (!any) throw std::logic_error("a pass without attachments");
  extent_ = {any->desc.extent.width, any->desc.extent.height};
  create_render_pass();
  create_framebuffer();
}

void Pass::create_render_pass() {
  std::vector<VkAttachmentDescription> attachments;
  std::vector<VkAttachmentReference> colours, resolves;
  VkAttachmentReference depth_stencil{};
  for (const Attachment& colour : target_.colours) {
    colours.push_back({static_cast<uint32_t>(attachments.size()), VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL});
    attachments.push_back(describe(*colour.image, colour.load, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL));
  }
  if (target_.depth_stencil) {
    depth_stencil = {static_cast<uint32_t>(attachments.size()), VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL};
    attachments.push_back(
        describe(*target_.depth_stencil->image, target_.depth_stencil->load, VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL));
  }
  for (const Image* resolve : target_.resolves) {
    resolves.push_back({static_cast<uint32_t>(attachments.size()), VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL});
    attachments.push_back(describe(*resolve, VK_ATTACHMENT_LOAD_OP_DONT_CARE, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL));
  }
  VkSubpassDescription subpass{};
  subpass.pipelineBindPoint = VK_PIPELINE_BIND_POINT_GRAPHICS;
  subpass.colorAttachmentCount = static_cast<uint32_t>(colours.size());
  subpass.pColorAttachments = colours.data();
  subpass.pResolveAttachments = resolves.empty() ? nullptr : resolves.data();
  subpass.pDepthStencilAttachment = target_.depth_stencil ? &depth_stencil : nullptr;
  const VkSubpassDependency after{0,
                                  VK_SUBPASS_EXTERNAL,
                                  VK_PIPELINE_STAGE_ALL_COMMANDS_BIT,
                                  VK_PIPELINE_STAGE_ALL_COMMANDS_BIT,
                                  VK_ACCESS_MEMORY_WRITE_BIT,
                                  VK_ACCESS_MEMORY_READ_BIT,
                                  0};
  VkRenderPassCreateInfo info{VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO};
  info.attachmentCount = static_cast<uint32_t>(attachments.size());
  info.pAttachments = attachments.data();
  info.subpassCount = 1;
  info.pSubpasses = &subpass;
  info.dependencyCount = 1;
  info.pDependencies = &after;
  render_pass_ = make<VkRenderPass, vkDestroyRenderPass>(device_, vkCreateRenderPass, info, "vkCreateRenderPass");
}

void Pass::create_framebuffer() {
  std::vector<VkImageView> views;
  for (const Attachment& colour : target_.colours) views.push_back(colour.image->view);
  if (target_.depth_stencil) views.push_back(target_.depth_stencil->image->view);
  for (const Image* resolve : target_.resolves) views.push_back(resolve->view);
  VkFramebufferCreateInfo info{VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO};
  info.renderPass = render_pass_;
  info.attachmentCount = static_cast<uint32_t>(views.size());
  info.pAttachments = views.data();
  info.width = extent_.width;
  info.height = extent_.height;
  info.layers = 1;
  framebuffer_ = make<VkFramebuffer, vkDestroyFramebuffer>(device_, vkCreateFramebuffer, info, "vkCreateFramebuffer");
}

Pipeline Pass::create_pipeline(const DrawState& state, VkPipelineLayout layout) {
  const auto vertex = create_module(device_, state.vertex);
  Owned<VkShaderModule, vkDestroyShaderModule> fragment;
  if (!state.fragment.empty()) fragment = create_module(device_, state.fragment);
  const Resources& resources = state.resources;
  const VkSpecializationInfo specialization{static_cast<uint32_t>(resources.specialization_entries.size()),
                                            resources.specialization_entries.data(), resources.specialization_data.size(),
                                            resources.specialization_data.data()};
  const std::array<VkPipelineShaderStageCreateInfo, 2> stages{
      {{VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO, nullptr, 0, VK_SHADER_STAGE_VERTEX_BIT, vertex, "main",
        &specialization},
       {VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO, nullptr, 0, VK_SHADER_STAGE_FRAGMENT_BIT, fragment, "main",
        &specialization}}};
  VkPipelineVertexInputStateCreateInfo input{VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO};
  input.vertexBindingDescriptionCount = static_cast<uint32_t>(state.input.bindings.size());
  input.pVertexBindingDescriptions = state.input.bindings.data();
  input.vertexAttributeDescriptionCount = static_cast<uint32_t>(state.input.attributes.size());
  input.pVertexAttributeDescriptions = state.input.attributes.data();
  VkPipelineInputAssemblyStateCreateInfo assembly{VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO};
  assembly.topology = state.topology;
  assembly.primitiveRestartEnable = state.primitive_restart;
  const std::vector<VkViewport> viewports = state.viewports.value_or(
      std::vector<VkViewport>{{0, 0, static_cast<float>(extent_.width), static_cast<float>(extent_.height), 0, 1}});
  const std::vector<VkRect2D> scissors = state.scissors.value_or(std::vector<VkRect2D>(viewports.size(), {{0, 0}, extent_}));
  VkPipelineViewportStateCreateInfo viewport{VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO};
  viewport.viewportCount = static_cast<uint32_t>(viewports.size());
  viewport.pViewports = viewports.data();
  viewport.scissorCount = static_cast<uint32_t>(scissors.size());
  viewport.pScissors = scissors.data();
  VkPipelineColorBlendAttachmentState write_all{};
  write_all.colorWriteMask = 0xF;
  std::vector<VkPipelineColorBlendAttachmentState> blend = state.blend;
  blend.resize(target_.colours.size(), write_all);
  VkPipelineColorBlendStateCreateInfo colour_blend{VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO};
  colour_blend.logicOpEnable = state.logic_op.has_value();
  colour_blend.logicOp = state.logic_op.value_or(VK_LOGIC_OP_COPY);
  colour_blend.attachmentCount = static_cast<uint32_t>(blend.size());
  colour_blend.pAttachments = blend.data();
  for (size_t i = 0; i < 4; ++i) colour_blend.blendConstants[i] = state.blend_constants[i];

  VkGraphicsPipelineCreateInfo info{VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO};
  info.stageCount = state.fragment.empty() ? 1 : 2;
  info.pStages = stages.data();
  info.pVertexInputState = &input;
  info.pInputAssemblyState = &assembly;
  info.pViewportState = &viewport;
  info.pRasterizationState = &state.rasterization;
  info.pMultisampleState = &state.multisample;
  info.pDepthStencilState = &state.depth_stencil;
  info.pColorBlendState = &colour_blend;
  info.layout = layout;
  info.renderPass = render_pass_;
  VkPipeline handle = VK_NULL_HANDLE;
  check(vkCreateGraphicsPipelines(device_.handle(), VK_NULL_HANDLE, 1, &info, nullptr, &handle), "vkCreateGraphicsPipelines");
  return {device_.handle(), handle};
}

void Pass::add(const DrawState& state) {
  Bindings bindings(device_, state.resources, VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT);
  Pipeline pipeline = create_pipeline(state, bindings.layout());
  draws_.push_back({state, std::move(bindings), std::move(pipeline)});
}

void Pass::record_draw(VkCommandBuffer commands, const Draw& draw) const {
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, draw.pipeline);
  draw.bindings.bind(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, draw.state.resources);
  for (size_t i = 0; i < draw.state.input.buffers.size(); ++i) {
    const VkBuffer buffer = draw.state.input.buffers[i]->handle;
    const VkDeviceSize offset = 0;
    vkCmdBindVertexBuffers(commands, draw.state.input.bindings[i].binding, 1, &buffer, &offset);
  }
  if (draw.state.draw) {
    draw.state.draw(commands);
  } else {
    vkCmdDraw(commands, draw.state.vertices, draw.state.instances, 0, 0);
  }
}

void Pass::run(const std::function<void(VkCommandBuffer, const std::function<void()>&)>& around) {
  std::vector<VkClearValue> clears;
  for (const Attachment& colour : target_.colours) clears.push_back(colour.clear);
  if (target_.depth_stencil) clears.push_back(target_.depth_stencil->clear);
  VkRenderPassBeginInfo begin{VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO};
  begin.renderPass = render_pass_;
  begin.framebuffer = framebuffer_;
  begin.renderArea = {{0, 0}, extent_};
  begin.clearValueCount = static_cast<uint32_t>(clears.size());
  begin.pClearValues = clears.data();
  device_.run([&](VkCommandBuffer commands) {
    const auto record = [&] {
      vkCmdBeginRenderPass(commands, &begin, VK_SUBPASS_CONTENTS_INLINE);
      for (const Draw& draw : draws_) record_draw(commands, draw);
      vkCmdEndRenderPass(commands);
    };
    if (around) {
      around(commands, record);
    } else {
      record();
    }
    full_barrier(commands);
  });
}

std::vector<std::byte> draw_once(Device& device, const DrawState& state, VkExtent2D extent, VkFormat format,
                                 VkClearColorValue clear) {
  ImageDesc desc;
  desc.format = format;
  desc.extent = {extent.width, extent.height, 1};
  desc.usage |= VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT;
  const Image image = create_image(device, desc);
  Target target;
  target.colours.push_back({&image, VK_ATTACHMENT_LOAD_OP_CLEAR, {.color = clear}});
  Pass pass(device, target);
  pass.add(state);
  pass.run();
  return download(device, image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
}

Spirv fullscreen_vertex(float z) {
  return compile_glsl(
      VK_SHADER_STAGE_VERTEX_BIT,
      fmt::format("void main() {{ gl_Position = vec4(vec2(gl_VertexIndex & 1, gl_VertexIndex >> 1) * 4.0 - 1.0, {:.9f}, 1.0); }}",
                  z));
}

}  // namespace pineda::cts
