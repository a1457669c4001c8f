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

// A pool for sets of uniform buffers, storage buffers and combined image samplers.
class DescriptorAllocator {
 public:
  DescriptorAllocator(VkContext& context, uint32_t max_sets, uint32_t descriptors_per_type);
  VkDescriptorSet allocate(VkDescriptorSetLayout layout);
  void write_buffer(VkDescriptorSet set, uint32_t binding, VkDescriptorType type, const Buffer& buffer);
  void write_texture(VkDescriptorSet set, uint32_t binding, const Image2D& texture, VkSampler sampler);

 private:
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
  std::function<void(const PipelineParts&)> adjust;  // has the last word
};

ShaderModuleHandle create_shader_module(VkContext& context, Spirv words);
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
