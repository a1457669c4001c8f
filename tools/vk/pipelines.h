// Pipelines and descriptor sets with the few choices that scenes make.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "tools/vk/context.h"
#include "tools/vk/resources.h"

namespace pineda::tools {

using Spirv = std::span<const uint32_t>;

struct Binding {  // one descriptor: a buffer, or an image with a sampler
  uint32_t number = 0;
  VkDescriptorType type = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
  VkShaderStageFlags stages = 0;
};

DescriptorSetLayoutHandle create_set_layout(VkContext& context, std::span<const Binding> bindings);
PipelineLayoutHandle create_pipeline_layout(VkContext& context, std::span<const VkDescriptorSetLayout> sets,
                                            std::span<const VkPushConstantRange> push_constants);

// A pool for sets of uniform buffers, storage buffers, combined image samplers and input
// attachments.
class DescriptorAllocator {
 public:
  DescriptorAllocator(VkContext& context, uint32_t max_sets, uint32_t descriptors_per_type);
  VkDescriptorSet allocate(VkDescriptorSetLayout layout);
  void write_buffer(VkDescriptorSet set, uint32_t binding, VkDescriptorType type, const Buffer& buffer);
  void write_texture(VkDescriptorSet set, uint32_t binding, const Image2D& texture, VkSampler sampler);
  void write_input_attachment(VkDescriptorSet set, uint32_t binding, const Image2D& image);

 private:
  void write_image(VkDescriptorSet set, uint32_t binding, VkDescriptorType type, const Image2D& image, VkSampler sampler);
  VkDevice device_;
  DescriptorPoolHandle pool_;
};

// The parts of a pipeline's state that scenes adjust.
struct PipelineParts {
  VkPipelineInputAssemblyStateCreateInfo& assembly;
  VkPipelineRasterizationStateCreateInfo& rasterization;
  VkPipelineRasterizationLineStateCreateInfoEXT& line;  // chained to the above by who wants it
  VkPipelineDepthStencilStateCreateInfo& depth;
  VkPipelineColorBlendAttachmentState& blend;
};

struct GraphicsPipelineDesc {
  Spirv vertex_shader, fragment_shader;  // no fragment shader: depth only
  std::vector<VkVertexInputBindingDescription> vertex_bindings;
  std::vector<VkVertexInputAttributeDescription> vertex_attributes;
  bool depth_test = false, depth_write = false;
  bool alpha_blend = false;
  VkCullModeFlags cull_mode = VK_CULL_MODE_NONE;
  VkPipelineLayout layout = VK_NULL_HANDLE;
  const VkSpecializationInfo* specialization = nullptr;  // of the fragment shader
  const VkSpecializationInfo* vertex_specialization = nullptr;
  VkPrimitiveTopology topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
  VkPolygonMode polygon_mode = VK_POLYGON_MODE_FILL;
  float line_width = 1;
  VkPipelineCache cache = VK_NULL_HANDLE;
  std::vector<VkViewport> viewports;  // with a scissor for each; empty: one, the whole target
  std::vector<VkRect2D> scissors;
  std::function<void(const PipelineParts&)> adjust;  // has the last word
};

ShaderModuleHandle create_shader_module(VkContext& context, Spirv words);

// What a pipeline has to know of what it draws to.
struct PipelineTarget {
  VkRenderPass render_pass = VK_NULL_HANDLE;
  uint32_t subpass = 0;
  VkExtent2D extent{};
  VkSampleCountFlagBits samples = VK_SAMPLE_COUNT_1_BIT;
  uint32_t colour_count = 1;  // all blended alike
};

PipelineHandle create_graphics_pipeline(VkContext& context, const PipelineTarget& target, const GraphicsPipelineDesc& desc);
PipelineHandle create_graphics_pipeline(VkContext& context, const RenderTarget& target, const GraphicsPipelineDesc& desc);
PipelineHandle create_compute_pipeline(VkContext& context, Spirv shader, VkPipelineLayout layout,
                                       const VkSpecializationInfo* specialization = nullptr,
                                       VkPipelineCache cache = VK_NULL_HANDLE);

// A pipeline and the one descriptor set that it takes.
struct BoundPipeline {
  std::optional<DescriptorAllocator> descriptors;
  DescriptorSetLayoutHandle set_layout;
  VkDescriptorSet set = VK_NULL_HANDLE;
  PipelineLayoutHandle layout;
  PipelineHandle pipeline;
};

}  // namespace pineda::tools
