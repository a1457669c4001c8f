#include "icd/graphics_state.h"

#include "icd/render_pass.h"

namespace pineda::icd {
namespace {

VkResult translate_stages(const VkGraphicsPipelineCreateInfo& info) {
  constexpr VkShaderStageFlags kSupported = VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT;
  VkShaderStageFlags stages = 0;
  for (uint32_t i = 0; i < info.stageCount; ++i) stages |= info.pStages[i].stage;
  if (stages & ~kSupported) return not_supported("vkCreateGraphicsPipelines: only vertex and fragment stages are supported");
  if (!(stages & VK_SHADER_STAGE_VERTEX_BIT)) return not_supported("vkCreateGraphicsPipelines: no vertex stage");
  return VK_SUCCESS;
}

VkResult translate_vertex_input(const VkPipelineVertexInputStateCreateInfo& info, GraphicsState& out) {
  for (uint32_t i = 0; i < info.vertexBindingDescriptionCount; ++i) {
    const VkVertexInputBindingDescription& binding = info.pVertexBindingDescriptions[i];
    if (binding.binding >= kMaxVertexBindings) return not_supported("vkCreateGraphicsPipelines: vertex binding beyond the limit");
    out.vertex_input.bindings.push_back({binding.binding, binding.stride, binding.inputRate});
  }
  for (uint32_t i = 0; i < info.vertexAttributeDescriptionCount; ++i) {
    const VkVertexInputAttributeDescription& attribute = info.pVertexAttributeDescriptions[i];
    if (attribute.binding >= kMaxVertexBindings || attribute.location >= kMaxVertexAttributes) {
      return not_supported("vkCreateGraphicsPipelines: vertex attribute beyond the limits");
    }
    out.vertex_input.attributes.push_back({attribute.location, attribute.binding, attribute.format, attribute.offset});
  }
  return VK_SUCCESS;
}

VkResult translate_input_assembly(const VkPipelineInputAssemblyStateCreateInfo& info, GraphicsState& out) {
  switch (info.topology) {
    case VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST:
    case VK_PRIMITIVE_TOPOLOGY_TRIANGLE_STRIP:
    case VK_PRIMITIVE_TOPOLOGY_TRIANGLE_FAN:
      break;
    default:
      return not_supported("vkCreateGraphicsPipelines: only triangle lists, strips and fans are supported");
  }
  out.topology = info.topology;
  out.primitive_restart = info.primitiveRestartEnable;
  return VK_SUCCESS;
}

VkResult translate_rasterization(const VkPipelineRasterizationStateCreateInfo& info, GraphicsState& out) {
  out.rasterizes = !info.rasterizerDiscardEnable;
  if (info.polygonMode != VK_POLYGON_MODE_FILL)
    return not_supported("vkCreateGraphicsPipelines: fillModeNonSolid is not supported");
  out.cull = info.cullMode;
  out.front_face = info.frontFace;
  out.fragment.depth_clamp = info.depthClampEnable;
  out.depth_clip = !info.depthClampEnable;
  out.depth_bias = info.depthBiasEnable;
  out.values.depth_bias_constant = info.depthBiasConstantFactor;
  out.values.depth_bias_clamp = info.depthBiasClamp;
  out.values.depth_bias_slope = info.depthBiasSlopeFactor;
  return VK_SUCCESS;
}

void translate_viewport(const VkPipelineViewportStateCreateInfo& info, GraphicsState& out) {
  if (info.pViewports && info.viewportCount > 0 && !(out.dynamic_mask & dynamic_bit(VK_DYNAMIC_STATE_VIEWPORT))) {
    out.values.viewport = info.pViewports[0];
  }
  if (info.pScissors && info.scissorCount > 0 && !(out.dynamic_mask & dynamic_bit(VK_DYNAMIC_STATE_SCISSOR))) {
    out.values.scissor = info.pScissors[0];
  }
}

VkResult translate_multisample(const VkPipelineMultisampleStateCreateInfo& info, GraphicsState& out) {
  if (info.rasterizationSamples != VK_SAMPLE_COUNT_1_BIT) return not_supported("vkCreateGraphicsPipelines: one sample a pixel");
  if (info.sampleShadingEnable || info.alphaToOneEnable || info.alphaToCoverageEnable) {
    return not_supported("vkCreateGraphicsPipelines: sample shading, alpha to coverage and alpha to one are not supported");
  }
  if (info.pSampleMask && !(info.pSampleMask[0] & 1)) out.rasterizes = false;
  return VK_SUCCESS;
}

VkResult translate_depth(const VkPipelineDepthStencilStateCreateInfo& info, const Subpass& subpass, GraphicsState& out) {
  if (info.depthBoundsTestEnable) return not_supported("vkCreateGraphicsPipelines: depthBounds is not supported");
  // No format has a stencil aspect: "if there is no stencil framebuffer attachment, the test always passes" and nothing is
  // written.
  compiler::DepthState& depth = out.fragment.depth;
  depth.format = subpass.depth.format;
  if (depth.format == VK_FORMAT_UNDEFINED || !info.depthTestEnable) return VK_SUCCESS;  // writes need the test, too
  depth.test_enable = true;
  depth.write_enable = info.depthWriteEnable;
  depth.compare = info.depthCompareOp;
  return VK_SUCCESS;
}

void translate_attachment(const VkPipelineColorBlendAttachmentState& info, compiler::BlendState& out) {
  out.write_mask = info.colorWriteMask;
  out.blend_enable = info.blendEnable;
  if (!info.blendEnable) return;  // factors keep their defaults, so that equal behaviour is equal state
  out.src_color = info.srcColorBlendFactor;
  out.dst_color = info.dstColorBlendFactor;
  out.color_op = info.colorBlendOp;
  out.src_alpha = info.srcAlphaBlendFactor;
  out.dst_alpha = info.dstAlphaBlendFactor;
  out.alpha_op = info.alphaBlendOp;
}

VkResult translate_blend(const VkPipelineColorBlendStateCreateInfo* info, const Subpass& subpass, GraphicsState& out) {
  out.fragment.color_count = subpass.color_count;
  if (subpass.color_count > 0 && !info) return not_supported("vkCreateGraphicsPipelines: no colour blend state");
  if (info && info->logicOpEnable) return not_supported("vkCreateGraphicsPipelines: logicOp is not supported");
  for (uint32_t i = 0; i < subpass.color_count; ++i) {
    compiler::BlendState& attachment = out.fragment.color[i];
    attachment.format = subpass.color[i].format;  // UNDEFINED for VK_ATTACHMENT_UNUSED
    if (i < info->attachmentCount) translate_attachment(info->pAttachments[i], attachment);
  }
  if (info) std::ranges::copy(info->blendConstants, out.values.blend_constants.begin());
  return VK_SUCCESS;
}

VkResult translate_dynamic(const VkPipelineDynamicStateCreateInfo* info, GraphicsState& out) {
  for (uint32_t i = 0; info && i < info->dynamicStateCount; ++i) {
    if (info->pDynamicStates[i] > VK_DYNAMIC_STATE_STENCIL_REFERENCE) {
      return not_supported("vkCreateGraphicsPipelines: a dynamic state of an extension is not supported");
    }
    out.dynamic_mask |= dynamic_bit(info->pDynamicStates[i]);
  }
  return VK_SUCCESS;
}

}  // namespace

// Structures that the specification says are ignored (rasterization disabled, no such attachment) may be dangling pointers: not
// read then.
VkResult translate_graphics_state(const VkGraphicsPipelineCreateInfo& info, GraphicsState* out) {
  const RenderPass& render_pass = *from(info.renderPass);
  if (info.subpass >= render_pass.subpass_count()) return not_supported("vkCreateGraphicsPipelines: no such subpass");
  const Subpass& subpass = render_pass.subpass(info.subpass);
  VkResult result = translate_stages(info);
  if (result == VK_SUCCESS) result = translate_dynamic(info.pDynamicState, *out);
  if (result == VK_SUCCESS) result = translate_vertex_input(*info.pVertexInputState, *out);
  if (result == VK_SUCCESS) result = translate_input_assembly(*info.pInputAssemblyState, *out);
  if (result == VK_SUCCESS) result = translate_rasterization(*info.pRasterizationState, *out);
  if (result != VK_SUCCESS || info.pRasterizationState->rasterizerDiscardEnable) return result;
  translate_viewport(*info.pViewportState, *out);
  result = translate_multisample(*info.pMultisampleState, *out);
  if (result == VK_SUCCESS && subpass.depth.format != VK_FORMAT_UNDEFINED) {
    result = translate_depth(*info.pDepthStencilState, subpass, *out);
  }
  if (result == VK_SUCCESS) result = translate_blend(subpass.color_count > 0 ? info.pColorBlendState : nullptr, subpass, *out);
  return result;
}

void apply_static_state(const GraphicsState& from, DynamicState& to) {
  const auto is_static = [&](VkDynamicState state) { return !(from.dynamic_mask & dynamic_bit(state)); };
  const DynamicState& values = from.values;
  if (is_static(VK_DYNAMIC_STATE_VIEWPORT)) to.viewport = values.viewport;
  if (is_static(VK_DYNAMIC_STATE_SCISSOR)) to.scissor = values.scissor;
  if (is_static(VK_DYNAMIC_STATE_DEPTH_BIAS)) {
    to.depth_bias_constant = values.depth_bias_constant;
    to.depth_bias_clamp = values.depth_bias_clamp;
    to.depth_bias_slope = values.depth_bias_slope;
  }
  if (is_static(VK_DYNAMIC_STATE_BLEND_CONSTANTS)) to.blend_constants = values.blend_constants;
  if (is_static(VK_DYNAMIC_STATE_DEPTH_BOUNDS)) to.depth_bounds = values.depth_bounds;
  if (is_static(VK_DYNAMIC_STATE_STENCIL_COMPARE_MASK)) to.stencil_compare_mask = values.stencil_compare_mask;
  if (is_static(VK_DYNAMIC_STATE_STENCIL_WRITE_MASK)) to.stencil_write_mask = values.stencil_write_mask;
  if (is_static(VK_DYNAMIC_STATE_STENCIL_REFERENCE)) to.stencil_reference = values.stencil_reference;
}

}  // namespace pineda::icd
