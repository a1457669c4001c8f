// Pipelines, descriptor sets and render passes for the driver's tests, on top of icd_client.h.
#pragma once

#include <array>
#include <optional>

#include "icd_client.h"

namespace pineda::test {

// What comes before a render pass, its subpasses in turn, and what follows: each sees what those before it wrote, subpasses pixel
// by pixel.
inline std::vector<VkSubpassDependency> dependencies_of(uint32_t subpasses) {
  constexpr VkPipelineStageFlags kAll = VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, kDraws = VK_PIPELINE_STAGE_ALL_GRAPHICS_BIT;
  std::vector<VkSubpassDependency> out;
  for (uint32_t to = 0; to < subpasses; ++to) {
    out.push_back({VK_SUBPASS_EXTERNAL, to, kAll, kDraws, kAnyAccess, kAnyAccess, 0});
    out.push_back({to, VK_SUBPASS_EXTERNAL, kDraws, kAll, kAnyAccess, kAnyAccess, 0});
    for (uint32_t from = 0; from < to; ++from) {
      out.push_back({from, to, kDraws, kDraws, kAnyAccess, kAnyAccess, VK_DEPENDENCY_BY_REGION_BIT});
    }
  }
  return out;
}

// The same for the second version of the command.
inline std::vector<VkSubpassDependency2> dependencies2_of(uint32_t subpasses) {
  std::vector<VkSubpassDependency2> out;
  for (const VkSubpassDependency& d : dependencies_of(subpasses)) {
    out.push_back({VK_STRUCTURE_TYPE_SUBPASS_DEPENDENCY_2, nullptr, d.srcSubpass, d.dstSubpass, d.srcStageMask, d.dstStageMask,
                   d.srcAccessMask, d.dstAccessMask, d.dependencyFlags, 0});
  }
  return out;
}

class PipelineClient : public Client {
 public:
  using Client::Client;

  VkShaderModule module(std::span<const uint32_t> words) {
    VkShaderModuleCreateInfo info{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
    info.codeSize = words.size_bytes();
    info.pCode = words.data();
    VkShaderModule out = VK_NULL_HANDLE;
    EXPECT_EQ(VK(*this, CreateShaderModule)(device, &info, nullptr, &out), VK_SUCCESS);
    defer([this, out] { VK(*this, DestroyShaderModule)(device, out, nullptr); });
    return out;
  }

  VkDescriptorSetLayout set_layout(std::vector<VkDescriptorSetLayoutBinding> bindings) {
    const VkDescriptorSetLayoutCreateInfo info{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO, nullptr, 0,
                                               static_cast<uint32_t>(bindings.size()), bindings.data()};
    VkDescriptorSetLayout out = VK_NULL_HANDLE;
    EXPECT_EQ(VK(*this, CreateDescriptorSetLayout)(device, &info, nullptr, &out), VK_SUCCESS);
    defer([this, out] { VK(*this, DestroyDescriptorSetLayout)(device, out, nullptr); });
    return out;
  }

  VkPipelineLayout pipeline_layout(std::optional<VkDescriptorSetLayout> set, uint32_t push_bytes) {
    const VkPushConstantRange range{VK_SHADER_STAGE_ALL, 0, push_bytes};
    VkPipelineLayoutCreateInfo info{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
    info.setLayoutCount = set ? 1 : 0;
    info.pSetLayouts = set ? &*set : nullptr;
    info.pushConstantRangeCount = push_bytes ? 1 : 0;
    info.pPushConstantRanges = &range;
    VkPipelineLayout out = VK_NULL_HANDLE;
    EXPECT_EQ(VK(*this, CreatePipelineLayout)(device, &info, nullptr, &out), VK_SUCCESS);
    defer([this, out] { VK(*this, DestroyPipelineLayout)(device, out, nullptr); });
    return out;
  }

  VkDescriptorSet descriptor_set(VkDescriptorSetLayout layout) {
    const VkDescriptorPoolSize sizes[] = {{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 4},
                                          {VK_DESCRIPTOR_TYPE_STORAGE_BUFFER_DYNAMIC, 4},
                                          {VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 4},
                                          {VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, 4},
                                          {VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, 4}};
    const VkDescriptorPoolCreateInfo info{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO, nullptr, 0, 1, 5, sizes};
    VkDescriptorPool descriptors = VK_NULL_HANDLE;
    EXPECT_EQ(VK(*this, CreateDescriptorPool)(device, &info, nullptr, &descriptors), VK_SUCCESS);
    defer([this, descriptors] { VK(*this, DestroyDescriptorPool)(device, descriptors, nullptr); });
    const VkDescriptorSetAllocateInfo allocate{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO, nullptr, descriptors, 1, &layout};
    VkDescriptorSet out = VK_NULL_HANDLE;
    EXPECT_EQ(VK(*this, AllocateDescriptorSets)(device, &allocate, &out), VK_SUCCESS);
    return out;
  }

  void write_buffer(VkDescriptorSet set, uint32_t binding, VkDescriptorType type, VkDescriptorBufferInfo info,
                    uint32_t element = 0) {
    const VkWriteDescriptorSet write{
        VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET, nullptr, set, binding, element, 1, type, nullptr, &info};
    VK(*this, UpdateDescriptorSets)(device, 1, &write, 0, nullptr);
  }
  void write_image(VkDescriptorSet set, uint32_t binding, VkDescriptorType type, VkImageView view,
                   VkSampler sampler = VK_NULL_HANDLE) {
    const VkDescriptorImageInfo info{sampler, view, VK_IMAGE_LAYOUT_GENERAL};
    const VkWriteDescriptorSet write{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET, nullptr, set, binding, 0, 1, type, &info};
    VK(*this, UpdateDescriptorSets)(device, 1, &write, 0, nullptr);
  }

  VkImageView view(VkImage image, VkFormat format, VkComponentMapping components = {},
                   VkImageAspectFlags aspect = VK_IMAGE_ASPECT_COLOR_BIT) {
    const VkImageViewCreateInfo info{VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
                                     nullptr,
                                     0,
                                     image,
                                     VK_IMAGE_VIEW_TYPE_2D,
                                     format,
                                     components,
                                     {aspect, 0, 1, 0, 1}};
    VkImageView out = VK_NULL_HANDLE;
    EXPECT_EQ(VK(*this, CreateImageView)(device, &info, nullptr, &out), VK_SUCCESS);
    defer([this, out] { VK(*this, DestroyImageView)(device, out, nullptr); });
    return out;
  }

  VkSampler nearest_sampler() {
    VkSamplerCreateInfo info{VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO};
    info.addressModeU = info.addressModeV = info.addressModeW = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
    VkSampler out = VK_NULL_HANDLE;
    EXPECT_EQ(VK(*this, CreateSampler)(device, &info, nullptr, &out), VK_SUCCESS);
    defer([this, out] { VK(*this, DestroySampler)(device, out, nullptr); });
    return out;
  }

  VkResult compute_pipeline(VkPipelineLayout layout, VkShaderModule shader, const VkSpecializationInfo* specialization,
                            VkPipeline* out, VkPipelineCreateFlags flags = 0) {
    VkComputePipelineCreateInfo info{VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO};
    info.flags = flags;
    info.stage = {VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                  nullptr,
                  0,
                  VK_SHADER_STAGE_COMPUTE_BIT,
                  shader,
                  "main",
                  specialization};
    info.layout = layout;
    const VkResult result = VK(*this, CreateComputePipelines)(device, VK_NULL_HANDLE, 1, &info, nullptr, out);
    defer([this, pipeline = *out] { VK(*this, DestroyPipeline)(device, pipeline, nullptr); });
    return result;
  }

  // One colour attachment in each subpass, and in all the depth attachment when one is given.
  struct Attachment {
    VkFormat format;
    VkAttachmentLoadOp load;
  };
  VkRenderPass render_pass(std::span<const Attachment> attachments, std::span<const uint32_t> subpass_attachment,
                           uint32_t depth_attachment = VK_ATTACHMENT_UNUSED) {
    std::vector<VkAttachmentDescription> descriptions;
    for (const Attachment& attachment : attachments) {
      descriptions.push_back({0, attachment.format, VK_SAMPLE_COUNT_1_BIT, attachment.load, VK_ATTACHMENT_STORE_OP_STORE,
                              VK_ATTACHMENT_LOAD_OP_DONT_CARE, VK_ATTACHMENT_STORE_OP_DONT_CARE,
                              attachment.load == VK_ATTACHMENT_LOAD_OP_LOAD ? VK_IMAGE_LAYOUT_GENERAL : VK_IMAGE_LAYOUT_UNDEFINED,
                              VK_IMAGE_LAYOUT_GENERAL});
    }
    std::vector<VkAttachmentReference> references;
    for (uint32_t index : subpass_attachment) references.push_back({index, VK_IMAGE_LAYOUT_GENERAL});
    const VkAttachmentReference depth{depth_attachment, VK_IMAGE_LAYOUT_GENERAL};
    std::vector<VkSubpassDescription> subpasses(references.size());
    for (size_t i = 0; i < subpasses.size(); ++i) {
      subpasses[i].colorAttachmentCount = 1;
      subpasses[i].pColorAttachments = &references[i];
      subpasses[i].pDepthStencilAttachment = &depth;
    }
    VkRenderPassCreateInfo info{VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO};
    info.attachmentCount = static_cast<uint32_t>(descriptions.size());
    info.pAttachments = descriptions.data();
    info.subpassCount = static_cast<uint32_t>(subpasses.size());
    info.pSubpasses = subpasses.data();
    const std::vector<VkSubpassDependency> dependencies = dependencies_of(info.subpassCount);
    info.dependencyCount = static_cast<uint32_t>(dependencies.size());
    info.pDependencies = dependencies.data();
    VkRenderPass out = VK_NULL_HANDLE;
    EXPECT_EQ(VK(*this, CreateRenderPass)(device, &info, nullptr, &out), VK_SUCCESS);
    defer([this, out] { VK(*this, DestroyRenderPass)(device, out, nullptr); });
    return out;
  }

  VkFramebuffer framebuffer(VkRenderPass pass, std::vector<VkImageView> views, VkExtent2D extent) {
    const VkFramebufferCreateInfo info{VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO,
                                       nullptr,
                                       0,
                                       pass,
                                       static_cast<uint32_t>(views.size()),
                                       views.data(),
                                       extent.width,
                                       extent.height,
                                       1};
    VkFramebuffer out = VK_NULL_HANDLE;
    EXPECT_EQ(VK(*this, CreateFramebuffer)(device, &info, nullptr, &out), VK_SUCCESS);
    defer([this, out] { VK(*this, DestroyFramebuffer)(device, out, nullptr); });
    return out;
  }

  void begin_pass(VkCommandBuffer cb, VkRenderPass pass, VkFramebuffer framebuffer, VkRect2D area,
                  std::vector<VkClearValue> clears = {}, VkSubpassContents contents = VK_SUBPASS_CONTENTS_INLINE) {
    const VkRenderPassBeginInfo info{VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO, nullptr,      pass, framebuffer, area,
                                     static_cast<uint32_t>(clears.size()),     clears.data()};
    VK(*this, CmdBeginRenderPass)(cb, &info, contents);
  }

  // Vertex: vec2 position, vec2 uv in one binding. Viewport and scissor are dynamic.
  struct Drawing {
    VkPipelineLayout layout = VK_NULL_HANDLE;
    VkRenderPass pass = VK_NULL_HANDLE;
    uint32_t subpass = 0;
    VkShaderModule vertex = VK_NULL_HANDLE, fragment = VK_NULL_HANDLE;
    VkPrimitiveTopology topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
    VkCullModeFlags cull = VK_CULL_MODE_NONE;
    bool depth_clamp = false;
    float depth_bias = 0, depth_bias_clamp = 0;      // constant factor; 0: no bias
    VkCompareOp depth_compare = VK_COMPARE_OP_LESS;  // when the subpass has a depth attachment
    VkPolygonMode polygon_mode = VK_POLYGON_MODE_FILL;
    const void* rasterization_next = nullptr;  // pNext of the rasterization state
    uint32_t samples = 1;
    const VkStencilOpState* stencil = nullptr;  // of both faces; null: no test
    uint32_t viewports = 1;
    bool depth_write = true;
    float depth_bias_slope = 0, line_width = 1;
    bool blend_over = false;  // source alpha over
    bool reads_vertices = true;
  };
  VkResult graphics_pipeline(const Drawing& drawing, VkPipeline* out);
};

inline VkResult PipelineClient::graphics_pipeline(const Drawing& drawing, VkPipeline* out) {
  const VkPipelineShaderStageCreateInfo stages[] = {{VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO, nullptr, 0,
                                                     VK_SHADER_STAGE_VERTEX_BIT, drawing.vertex, "main", nullptr},
                                                    {VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO, nullptr, 0,
                                                     VK_SHADER_STAGE_FRAGMENT_BIT, drawing.fragment, "main", nullptr}};
  const VkVertexInputBindingDescription binding{0, 16, VK_VERTEX_INPUT_RATE_VERTEX};
  const VkVertexInputAttributeDescription attributes[] = {{0, 0, VK_FORMAT_R32G32_SFLOAT, 0}, {1, 0, VK_FORMAT_R32G32_SFLOAT, 8}};
  const VkPipelineVertexInputStateCreateInfo input{VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO,
                                                   nullptr,
                                                   0,
                                                   drawing.reads_vertices ? 1u : 0u,
                                                   &binding,
                                                   drawing.reads_vertices ? 2u : 0u,
                                                   attributes};
  const VkPipelineInputAssemblyStateCreateInfo assembly{VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO, nullptr, 0,
                                                        drawing.topology, VK_FALSE};
  VkPipelineViewportStateCreateInfo viewport{VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO};
  viewport.viewportCount = viewport.scissorCount = drawing.viewports;
  VkPipelineRasterizationStateCreateInfo rasterization{VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO};
  rasterization.pNext = drawing.rasterization_next;
  rasterization.polygonMode = drawing.polygon_mode;
  rasterization.lineWidth = drawing.line_width;
  rasterization.cullMode = drawing.cull;
  rasterization.depthClampEnable = drawing.depth_clamp;
  rasterization.depthBiasEnable = drawing.depth_bias != 0 || drawing.depth_bias_slope != 0;
  rasterization.depthBiasSlopeFactor = drawing.depth_bias_slope;
  rasterization.depthBiasConstantFactor = drawing.depth_bias;
  rasterization.depthBiasClamp = drawing.depth_bias_clamp;
  VkPipelineDepthStencilStateCreateInfo depth{VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO};
  depth.depthTestEnable = VK_TRUE;
  depth.depthWriteEnable = drawing.depth_write;
  depth.depthCompareOp = drawing.depth_compare;
  depth.stencilTestEnable = drawing.stencil != nullptr;
  if (drawing.stencil) depth.front = depth.back = *drawing.stencil;
  VkPipelineMultisampleStateCreateInfo multisample{VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO};
  multisample.rasterizationSamples = static_cast<VkSampleCountFlagBits>(drawing.samples);
  VkPipelineColorBlendAttachmentState blend_attachment{};
  blend_attachment.colorWriteMask = 0xF;
  blend_attachment.blendEnable = drawing.blend_over;
  blend_attachment.srcColorBlendFactor = VK_BLEND_FACTOR_SRC_ALPHA;
  blend_attachment.dstColorBlendFactor = VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA;
  blend_attachment.srcAlphaBlendFactor = VK_BLEND_FACTOR_ONE;
  blend_attachment.dstAlphaBlendFactor = VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA;
  VkPipelineColorBlendStateCreateInfo blend{VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO};
  blend.attachmentCount = 1;
  blend.pAttachments = &blend_attachment;
  const VkDynamicState dynamics[] = {VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR};
  const VkPipelineDynamicStateCreateInfo dynamic{VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO, nullptr, 0, 2, dynamics};
  VkGraphicsPipelineCreateInfo info{VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO};
  info.stageCount = 2;
  info.pStages = stages;
  info.pVertexInputState = &input;
  info.pInputAssemblyState = &assembly;
  info.pViewportState = &viewport;
  info.pRasterizationState = &rasterization;
  info.pMultisampleState = &multisample;
  info.pDepthStencilState = &depth;
  info.pColorBlendState = &blend;
  info.pDynamicState = &dynamic;
  info.layout = drawing.layout;
  info.renderPass = drawing.pass;
  info.subpass = drawing.subpass;
  const VkResult result = VK(*this, CreateGraphicsPipelines)(device, VK_NULL_HANDLE, 1, &info, nullptr, out);
  defer([this, pipeline = *out] { VK(*this, DestroyPipeline)(device, pipeline, nullptr); });
  return result;
}

}  // namespace pineda::test
