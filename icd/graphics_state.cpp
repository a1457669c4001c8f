#include "icd/graphics_state.h"

#include <algorithm>
#include <bit>

#include "base/config.h"
#include "base/format.h"
#include "base/sample_locations.h"
#include "icd/chain.h"
#include "icd/device.h"
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
  if (info.topology >= VK_PRIMITIVE_TOPOLOGY_PATCH_LIST) {
    return not_supported("vkCreateGraphicsPipelines: patches need tessellationShader, which is not supported");
  }
  out.topology = info.topology;
  out.primitive_restart = info.primitiveRestartEnable;
  return VK_SUCCESS;
}

VkResult translate_lines(const VkPipelineRasterizationLineStateCreateInfoEXT& info, GraphicsState& out) {
  switch (info.lineRasterizationMode) {
    case VK_LINE_RASTERIZATION_MODE_DEFAULT_EXT:
    case VK_LINE_RASTERIZATION_MODE_RECTANGULAR_EXT:
      break;
    case VK_LINE_RASTERIZATION_MODE_BRESENHAM_EXT:
      out.line.mode = raster::LineMode::kBresenham;
      break;
    case VK_LINE_RASTERIZATION_MODE_RECTANGULAR_SMOOTH_EXT:
      out.line.mode = raster::LineMode::kSmooth;
      break;
    default:
      return not_supported("vkCreateGraphicsPipelines: this lineRasterizationMode is not supported");
  }
  out.line.stippled = info.stippledLineEnable;
  out.values.stipple_factor = info.lineStippleFactor;
  out.values.stipple_pattern = info.lineStipplePattern;
  return VK_SUCCESS;
}

VkResult translate_rasterization(const VkPipelineRasterizationStateCreateInfo& info, GraphicsState& out) {
  out.rasterizes = !info.rasterizerDiscardEnable;
  if (info.polygonMode > VK_POLYGON_MODE_POINT)
    return not_supported("vkCreateGraphicsPipelines: this polygonMode is not supported");
  out.polygon_mode = info.polygonMode;
  out.values.line_width = info.lineWidth;
  if (const auto* provoking = find_in_chain<VkPipelineRasterizationProvokingVertexStateCreateInfoEXT>(
          info.pNext, VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_PROVOKING_VERTEX_STATE_CREATE_INFO_EXT)) {
    out.provoking_last = provoking->provokingVertexMode == VK_PROVOKING_VERTEX_MODE_LAST_VERTEX_EXT;
  }
  if (const auto* line = find_in_chain<VkPipelineRasterizationLineStateCreateInfoEXT>(
          info.pNext, VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_LINE_STATE_CREATE_INFO_EXT)) {
    if (const VkResult result = translate_lines(*line, out); result != VK_SUCCESS) return result;
  }
  out.cull = info.cullMode;
  out.front_face = info.frontFace;
  out.fragment.depth_clamp = info.depthClampEnable;
  out.depth_clip = !info.depthClampEnable;
  if (const auto* clip = find_in_chain<VkPipelineRasterizationDepthClipStateCreateInfoEXT>(
          info.pNext, VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_DEPTH_CLIP_STATE_CREATE_INFO_EXT)) {
    out.depth_clip = clip->depthClipEnable;
  }
  out.depth_bias = info.depthBiasEnable;
  out.values.depth_bias_constant = info.depthBiasConstantFactor;
  out.values.depth_bias_clamp = info.depthBiasClamp;
  out.values.depth_bias_slope = info.depthBiasSlopeFactor;
  return VK_SUCCESS;
}

void translate_viewport(const VkPipelineViewportStateCreateInfo& info, GraphicsState& out) {
  out.viewport_count = std::clamp(info.viewportCount, 1u, kMaxViewports);
  if (info.pViewports && !(out.dynamic_mask & dynamic_bit(VK_DYNAMIC_STATE_VIEWPORT))) {
    std::copy_n(info.pViewports, std::min(info.viewportCount, kMaxViewports), out.values.viewports.begin());
  }
  if (info.pScissors && !(out.dynamic_mask & dynamic_bit(VK_DYNAMIC_STATE_SCISSOR))) {
    std::copy_n(info.pScissors, std::min(info.scissorCount, kMaxViewports), out.values.scissors.begin());
  }
}

VkResult translate_multisample(const VkPipelineMultisampleStateCreateInfo& info, const Subpass& subpass, GraphicsState& out) {
  compiler::FragmentState& fragment = out.fragment;
  const auto samples = static_cast<uint32_t>(info.rasterizationSamples);
  if (!std::has_single_bit(samples) || !(samples & kSampleCounts)) {
    return not_supported("vkCreateGraphicsPipelines: this number of samples is not supported");
  }
  if (subpass.samples != 0 && subpass.samples != samples) {
    return not_supported("vkCreateGraphicsPipelines: rasterizationSamples differs from the attachments' samples");
  }
  fragment.samples = samples;
  fragment.equal_samples = !debug(kDebugNoEqualSamples);
  if (info.pSampleMask) fragment.sample_mask = info.pSampleMask[0] & 0xFFFF;
  fragment.sample_shading = info.sampleShadingEnable && info.minSampleShading * static_cast<float>(samples) > 1;
  fragment.alpha_to_coverage = info.alphaToCoverageEnable;
  fragment.alpha_to_one = info.alphaToOneEnable;
  return VK_SUCCESS;
}

compiler::StencilFace stencil_face(const VkStencilOpState& info) {
  return {.fail = info.failOp, .pass = info.passOp, .depth_fail = info.depthFailOp, .compare = info.compareOp};
}

void translate_stencil(const VkPipelineDepthStencilStateCreateInfo& info, GraphicsState& out) {
  compiler::StencilState& stencil = out.fragment.stencil;
  stencil.test_enable = true;
  stencil.front = stencil_face(info.front);
  stencil.back = stencil_face(info.back);
  out.values.stencil_compare_mask = {info.front.compareMask, info.back.compareMask};
  out.values.stencil_write_mask = {info.front.writeMask, info.back.writeMask};
  out.values.stencil_reference = {info.front.reference, info.back.reference};
}

// A test without its attachment passes and writes nothing.
void translate_depth(const VkPipelineDepthStencilStateCreateInfo& info, const Subpass& subpass, GraphicsState& out) {
  out.depth_stencil_format = subpass.depth.format;
  compiler::DepthState& depth = out.fragment.depth;
  depth.format = aspect_format(subpass.depth.format, VK_IMAGE_ASPECT_DEPTH_BIT);
  if (depth.format != VK_FORMAT_UNDEFINED) {
    depth.bounds_test = info.depthBoundsTestEnable;
    out.values.depth_bounds = {info.minDepthBounds, info.maxDepthBounds};
    if (info.depthTestEnable) {  // writes need the test, too
      depth.test_enable = true;
      depth.write_enable = info.depthWriteEnable;
      depth.compare = info.depthCompareOp;
    }
  }
  const bool has_stencil = aspect_format(subpass.depth.format, VK_IMAGE_ASPECT_STENCIL_BIT) != VK_FORMAT_UNDEFINED;
  if (has_stencil && info.stencilTestEnable) translate_stencil(info, out);
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

// "pColorBlendState is ignored if [...] the subpass does not use any color attachments"
bool uses_colour(const Subpass& subpass) {
  return std::any_of(subpass.color.begin(), subpass.color.begin() + subpass.color_count,
                     [](const auto& attachment) { return attachment.format != VK_FORMAT_UNDEFINED; });
}

VkResult translate_blend(const VkPipelineColorBlendStateCreateInfo* info, const Subpass& subpass, GraphicsState& out) {
  out.fragment.color_count = subpass.color_count;
  if (uses_colour(subpass) && !info) return not_supported("vkCreateGraphicsPipelines: no colour blend state");
  if (info && info->logicOpEnable) out.fragment.logic_op = info->logicOp;
  for (uint32_t i = 0; i < subpass.color_count; ++i) {
    compiler::BlendState& attachment = out.fragment.color[i];
    attachment.format = subpass.color[i].format;  // UNDEFINED for VK_ATTACHMENT_UNUSED
    if (info && i < info->attachmentCount) translate_attachment(info->pAttachments[i], attachment);
  }
  if (info) std::ranges::copy(info->blendConstants, out.values.blend_constants.begin());
  return VK_SUCCESS;
}

VkResult translate_dynamic(const VkPipelineDynamicStateCreateInfo* info, GraphicsState& out) {
  for (uint32_t i = 0; info && i < info->dynamicStateCount; ++i) {
    if (dynamic_bit(info->pDynamicStates[i]) == 0) {
      return not_supported("vkCreateGraphicsPipelines: a dynamic state of an extension is not supported");
    }
    out.dynamic_mask |= dynamic_bit(info->pDynamicStates[i]);
  }
  return VK_SUCCESS;
}

}  // namespace

// Structures that the specification says are ignored (rasterization disabled, no such attachment) may be dangling pointers: not
// read then.
VkResult translate_graphics_state(const Device& device, const VkGraphicsPipelineCreateInfo& info, GraphicsState* out) {
  const RenderPass& render_pass = *from(info.renderPass);
  if (info.subpass >= render_pass.subpass_count()) return not_supported("vkCreateGraphicsPipelines: no such subpass");
  const Subpass& subpass = render_pass.subpass(info.subpass);
  VkResult result = translate_stages(info);
  if (result == VK_SUCCESS) result = translate_dynamic(info.pDynamicState, *out);
  if (result == VK_SUCCESS) result = translate_vertex_input(*info.pVertexInputState, *out);
  if (result == VK_SUCCESS) result = translate_input_assembly(*info.pInputAssemblyState, *out);
  if (result == VK_SUCCESS) result = translate_rasterization(*info.pRasterizationState, *out);
  if (result != VK_SUCCESS || info.pRasterizationState->rasterizerDiscardEnable) return result;
  out->fragment.smooth_lines = out->line.mode == raster::LineMode::kSmooth && out->draws_lines();
  translate_viewport(*info.pViewportState, *out);
  result = translate_multisample(*info.pMultisampleState, subpass, *out);
  if (subpass.depth.format != VK_FORMAT_UNDEFINED) translate_depth(*info.pDepthStencilState, subpass, *out);
  out->fragment.depth.unrestricted = device.has(Gate::kDepthRangeUnrestricted);
  if (result == VK_SUCCESS) result = translate_blend(uses_colour(subpass) ? info.pColorBlendState : nullptr, subpass, *out);
  return result;
}

void apply_static_state(const GraphicsState& from, DynamicState& to) {
  const auto is_static = [&](VkDynamicState state) { return !(from.dynamic_mask & dynamic_bit(state)); };
  const DynamicState& values = from.values;
  if (is_static(VK_DYNAMIC_STATE_VIEWPORT)) std::copy_n(values.viewports.begin(), from.viewport_count, to.viewports.begin());
  if (is_static(VK_DYNAMIC_STATE_SCISSOR)) std::copy_n(values.scissors.begin(), from.viewport_count, to.scissors.begin());
  if (is_static(VK_DYNAMIC_STATE_LINE_WIDTH)) to.line_width = values.line_width;
  if (is_static(VK_DYNAMIC_STATE_LINE_STIPPLE_EXT)) {
    to.stipple_factor = values.stipple_factor;
    to.stipple_pattern = values.stipple_pattern;
  }
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
