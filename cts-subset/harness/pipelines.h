// One dispatch or one draw, described by what differs from the plainest one.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "cts-subset/harness/resources.h"
#include "cts-subset/harness/shader.h"

namespace pineda::cts {

using RenderPass = Owned<VkRenderPass, vkDestroyRenderPass>;
using Framebuffer = Owned<VkFramebuffer, vkDestroyFramebuffer>;
using Sampler = Owned<VkSampler, vkDestroySampler>;
using Pipeline = Owned<VkPipeline, vkDestroyPipeline>;
using BufferView = Owned<VkBufferView, vkDestroyBufferView>;
using QueryPool = Owned<VkQueryPool, vkDestroyQueryPool>;

struct Descriptor {
  uint32_t binding = 0;
  VkDescriptorType type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
  std::vector<VkDescriptorBufferInfo> buffers;  // one of the three; its size is the array's
  std::vector<VkDescriptorImageInfo> images;
  std::vector<VkBufferView> views;
};
Descriptor storage_buffer(uint32_t binding, const Buffer& buffer, VkDeviceSize offset = 0, VkDeviceSize range = VK_WHOLE_SIZE);
Descriptor uniform_buffer(uint32_t binding, const Buffer& buffer, VkDeviceSize offset = 0, VkDeviceSize range = VK_WHOLE_SIZE);
Descriptor sampled_image(uint32_t binding, const Image& image, VkSampler sampler);  // combined, SHADER_READ_ONLY
Descriptor storage_image(uint32_t binding, const Image& image);                     // GENERAL

struct Resources {  // what a pipeline layout needs, and its one descriptor set
  std::vector<Descriptor> descriptors;
  std::vector<std::byte> push_constants;
  std::vector<VkSpecializationMapEntry> specialization_entries;
  std::vector<std::byte> specialization_data;
};

template <typename T>
std::vector<std::byte> to_bytes(const T& value) {
  const auto* first = reinterpret_cast<const std::byte*>(&value);
  return {first, first + sizeof(T)};
}
void add_specialization(Resources& resources, uint32_t id, uint32_t value);

// Layout, pool and set of a Resources.
class Bindings {
 public:
  Bindings(Device& device, const Resources& resources, VkShaderStageFlags stages);
  void bind(VkCommandBuffer commands, VkPipelineBindPoint point, const Resources& resources) const;
  VkPipelineLayout layout() const { return layout_; }

 private:
  VkShaderStageFlags stages_;
  Owned<VkDescriptorSetLayout, vkDestroyDescriptorSetLayout> set_layout_;
  Owned<VkPipelineLayout, vkDestroyPipelineLayout> layout_;
  Owned<VkDescriptorPool, vkDestroyDescriptorPool> pool_;
  VkDescriptorSet set_ = VK_NULL_HANDLE;
};

Pipeline create_compute_pipeline(Device& device, const Spirv& shader, VkPipelineLayout layout, const Resources& resources);
void dispatch(Device& device, const Spirv& shader, const Resources& resources, std::array<uint32_t, 3> groups = {1, 1, 1});

Sampler create_sampler(Device& device, const std::function<void(VkSamplerCreateInfo&)>& adjust = {});

QueryPool create_query_pool(Device& device, VkQueryType type, uint32_t count, VkQueryPipelineStatisticFlags statistics = 0);

struct VertexInput {
  std::vector<VkVertexInputBindingDescription> bindings;
  std::vector<VkVertexInputAttributeDescription> attributes;
  std::vector<const Buffer*> buffers;  // one per binding
};

// The state of a graphics pipeline. The defaults draw triangles that cover what they cover, without depth, blending or culling.
struct DrawState {
  Spirv vertex, fragment;
  VertexInput input;
  VkPrimitiveTopology topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
  bool primitive_restart = false;
  VkPipelineRasterizationStateCreateInfo rasterization{VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO};
  VkPipelineMultisampleStateCreateInfo multisample{VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO};
  VkPipelineDepthStencilStateCreateInfo depth_stencil{VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO};
  std::vector<VkPipelineColorBlendAttachmentState> blend;  // empty: write all, for each attachment
  std::array<float, 4> blend_constants{};
  std::optional<VkLogicOp> logic_op;
  std::optional<std::vector<VkViewport>> viewports;  // default: the whole target
  std::optional<std::vector<VkRect2D>> scissors;
  Resources resources;
  std::function<void(VkCommandBuffer)> draw;  // default: vkCmdDraw(vertices, instances)
  uint32_t vertices = 3, instances = 1;

  DrawState();
};

struct Attachment {
  const Image* image = nullptr;
  VkAttachmentLoadOp load = VK_ATTACHMENT_LOAD_OP_CLEAR;
  VkClearValue clear{};
};

// Colour attachments, at most one depth-stencil one, at most one resolve per colour attachment. Every image ends as
// TRANSFER_SRC_OPTIMAL; those that are loaded start so, too.
struct Target {
  std::vector<Attachment> colours;
  std::optional<Attachment> depth_stencil;
  std::vector<const Image*> resolves;
};

// A render pass over a target with one subpass, and draws in it.
class Pass {
 public:
  Pass(Device& device, const Target& target);
  void add(const DrawState& state);
  // `around` may wrap the pass: it is called with the command buffer and a function that records the pass.
  void run(const std::function<void(VkCommandBuffer, const std::function<void()>&)>& around = {});
  VkRenderPass render_pass() const { return render_pass_; }

 private:
  struct Draw {
    DrawState state;
    Bindings bindings;
    Pipeline pipeline;
  };
  void create_render_pass();
  void create_framebuffer();
  Pipeline create_pipeline(const DrawState& state, VkPipelineLayout layout);
  void record_draw(VkCommandBuffer commands, const Draw& draw) const;

  Device& device_;
  Target target_;
  VkExtent2D extent_{};
  RenderPass render_pass_;
  Framebuffer framebuffer_;
  std::vector<Draw> draws_;
};

// The usual case: one draw into one new colour image of `format`, cleared to `clear`; gives the image's bytes.
std::vector<std::byte> draw_once(Device& device, const DrawState& state, VkExtent2D extent = {16, 16},
                                 VkFormat format = VK_FORMAT_R8G8B8A8_UNORM, VkClearColorValue clear = {});

// A triangle that covers the target, without vertex buffers; depth z.
Spirv fullscreen_vertex(float z = 0.5f);

}  // namespace pineda::cts
