// A client for tests of images: shaders from GLSL, images of every kind, one call for a dispatch and one for a draw that covers
// an attachment. Expected values come from cts-subset/reference, which is written from the specification and knows no driver.
#pragma once

#include <map>
#include <string>
#include <variant>

#include "base/format.h"
#include "cts-subset/harness/shader.h"
#include "cts-subset/reference/formats.h"
#include "icd_pipeline_client.h"

namespace pineda::test {

struct ImageInfo {
  VkFormat format = VK_FORMAT_R8G8B8A8_UNORM;
  VkExtent3D extent{1, 1, 1};
  VkImageType type = VK_IMAGE_TYPE_2D;
  uint32_t levels = 1, layers = 1, samples = 1;
  VkImageUsageFlags usage = VK_IMAGE_USAGE_SAMPLED_BIT;  // transfers are added
  VkImageCreateFlags flags = 0;
  VkImageTiling tiling = VK_IMAGE_TILING_OPTIMAL;
};

// One element of a binding.
struct Resource {
  VkDescriptorType type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
  VkDescriptorImageInfo image{};
  VkDescriptorBufferInfo buffer{};
  VkBufferView texels = VK_NULL_HANDLE;
};

inline Resource storage_buffer(const Client::Buffer& buffer) {
  return {.type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, .buffer = {buffer.handle, 0, VK_WHOLE_SIZE}};
}
inline Resource storage_image(VkImageView view) {
  return {.type = VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, .image = {VK_NULL_HANDLE, view, VK_IMAGE_LAYOUT_GENERAL}};
}
inline Resource sampled_image(VkImageView view, VkSampler sampler) {
  return {.type = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, .image = {sampler, view, VK_IMAGE_LAYOUT_GENERAL}};
}

class ImageClient : public PipelineClient {
 public:
  using PipelineClient::PipelineClient;
  using PipelineClient::view;

  // ---- objects
  VkShaderModule shader(VkShaderStageFlagBits stage, const std::string& glsl) {
    const std::vector<uint32_t> words = cts::compile_glsl(stage, glsl, 0);
    return module(words);
  }

  VkImage make(const ImageInfo& of, uint8_t** mapped = nullptr) {
    VkImageCreateInfo info{VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO};
    info.flags = of.flags;
    info.imageType = of.type;
    info.format = of.format;
    info.extent = of.extent;
    info.mipLevels = of.levels;
    info.arrayLayers = of.layers;
    info.samples = static_cast<VkSampleCountFlagBits>(of.samples);
    info.tiling = of.tiling;
    info.usage = of.usage | VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT;
    VkImage image = VK_NULL_HANDLE;
    EXPECT_EQ(VK(*this, CreateImage)(device, &info, nullptr, &image), VK_SUCCESS) << "format " << of.format;
    if (!image) return image;
    VkMemoryRequirements requirements;
    VK(*this, GetImageMemoryRequirements)(device, image, &requirements);
    void* data = nullptr;
    EXPECT_EQ(VK(*this, BindImageMemory)(device, image, memory(requirements.size, &data), 0), VK_SUCCESS);
    if (mapped) *mapped = static_cast<uint8_t*>(data);
    defer([this, image] { VK(*this, DestroyImage)(device, image, nullptr); });
    to_general(image, of.format);
    return image;
  }

  VkImageView view(VkImage image, VkFormat format, VkImageViewType type, const VkImageSubresourceRange& range,
                   const void* chain = nullptr) {
    const VkImageViewCreateInfo info{VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO, chain, 0, image, type, format, {}, range};
    VkImageView out = VK_NULL_HANDLE;
    EXPECT_EQ(VK(*this, CreateImageView)(device, &info, nullptr, &out), VK_SUCCESS) << "format " << format;
    defer([this, out] { VK(*this, DestroyImageView)(device, out, nullptr); });
    return out;
  }
  static constexpr VkImageSubresourceRange all(VkImageAspectFlags aspect = VK_IMAGE_ASPECT_COLOR_BIT) {
    return {aspect, 0, VK_REMAINING_MIP_LEVELS, 0, VK_REMAINING_ARRAY_LAYERS};
  }

  VkSampler sampler(VkSamplerCreateInfo info) {
    info.sType = VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO;
    VkSampler out = VK_NULL_HANDLE;
    EXPECT_EQ(VK(*this, CreateSampler)(device, &info, nullptr, &out), VK_SUCCESS);
    defer([this, out] { VK(*this, DestroySampler)(device, out, nullptr); });
    return out;
  }

  // A buffer for uniform texels alone: whoever allows storage texels too needs a format that has both.
  Buffer uniform_texels(VkDeviceSize size_bytes) {
    VkBufferCreateInfo info{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
    info.size = size_bytes;
    info.usage = VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT;
    Buffer out;
    EXPECT_EQ(VK(*this, CreateBuffer)(device, &info, nullptr, &out.handle), VK_SUCCESS);
    VkMemoryRequirements requirements;
    VK(*this, GetBufferMemoryRequirements)(device, out.handle, &requirements);
    void* mapped = nullptr;
    EXPECT_EQ(VK(*this, BindBufferMemory)(device, out.handle, memory(requirements.size, &mapped), 0), VK_SUCCESS);
    out.data = static_cast<uint8_t*>(mapped);
    defer([this, handle = out.handle] { VK(*this, DestroyBuffer)(device, handle, nullptr); });
    return out;
  }

  Resource texel_buffer(VkDescriptorType type, const Buffer& buffer, VkFormat format, VkDeviceSize offset = 0,
                        VkDeviceSize range = VK_WHOLE_SIZE) {
    const VkBufferViewCreateInfo info{
        VK_STRUCTURE_TYPE_BUFFER_VIEW_CREATE_INFO, nullptr, 0, buffer.handle, format, offset, range};
    VkBufferView out = VK_NULL_HANDLE;
    EXPECT_EQ(VK(*this, CreateBufferView)(device, &info, nullptr, &out), VK_SUCCESS) << "format " << format;
    defer([this, out] { VK(*this, DestroyBufferView)(device, out, nullptr); });
    return {.type = type, .texels = out};
  }

  // ---- work
  // Binding b holds bindings[b]: one resource, or several for an array.
  using Bindings = std::vector<std::vector<Resource>>;

  // `push` is at offset 0 of the push constants. Pipelines are kept for the next call with the same text.
  void dispatch(const std::string& glsl, const Bindings& bindings, uint32_t groups, std::vector<uint32_t> push = {}) {
    const Interface& io = interface(bindings);
    VkPipeline& pipeline = pipelines_[glsl];
    if (!pipeline) {
      EXPECT_EQ(compute_pipeline(io.layout, shader(VK_SHADER_STAGE_COMPUTE_BIT, glsl), nullptr, &pipeline), VK_SUCCESS) << glsl;
    }
    const Set set(*this, io, bindings);
    run([&](VkCommandBuffer cb) {
      VK(*this, CmdBindPipeline)(cb, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline);
      bind(cb, VK_PIPELINE_BIND_POINT_COMPUTE, io, set, push);
      VK(*this, CmdDispatch)(cb, groups, 1, 1);
    });
  }

  struct Draw {
    std::string vertex = kCoverAll, fragment;
    Bindings bindings;
    std::vector<uint32_t> push;
    VkImageView color = VK_NULL_HANDLE, resolve = VK_NULL_HANDLE, depth = VK_NULL_HANDLE;
    VkFormat color_format = VK_FORMAT_UNDEFINED, depth_format = VK_FORMAT_UNDEFINED;
    uint32_t samples = 1;
    VkExtent2D extent{};
    VkPipelineColorBlendAttachmentState blend{.colorWriteMask = 0xF};
    VkFormat attribute = VK_FORMAT_UNDEFINED;  // location 0, from `vertices`
    VkBuffer vertices = VK_NULL_HANDLE;
    uint32_t stride_bytes = 0, vertex_count = 3;
    bool points = false;  // which are not rasterized
  };
  static constexpr const char* kCoverAll = R"(
    void main() { gl_Position = vec4(gl_VertexIndex == 1 ? 3 : -1, gl_VertexIndex == 2 ? 3 : -1, 0.5, 1); })";

  void draw(const Draw& d);

  // Everything of one level and layers, rows without gaps.
  void upload(VkImage image, const std::vector<uint8_t>& data, VkImageSubresourceLayers layers, VkExtent3D extent) {
    const Buffer in = buffer(data.size());
    std::memcpy(in.data, data.data(), data.size());
    run([&](VkCommandBuffer cb) {
      const VkBufferImageCopy region{0, 0, 0, layers, {}, extent};
      VK(*this, CmdCopyBufferToImage)(cb, in.handle, image, VK_IMAGE_LAYOUT_GENERAL, 1, &region);
    });
  }
  std::vector<uint8_t> download(VkImage image, size_t bytes, VkImageSubresourceLayers layers, VkExtent3D extent) {
    const Buffer out = buffer(bytes);
    run([&](VkCommandBuffer cb) {
      const VkBufferImageCopy region{0, 0, 0, layers, {}, extent};
      VK(*this, CmdCopyImageToBuffer)(cb, image, VK_IMAGE_LAYOUT_GENERAL, out.handle, 1, &region);
    });
    return {out.data, out.data + bytes};
  }

  VkFormatProperties format_properties(VkFormat format) {
    VkFormatProperties properties;
    VK(*this, GetPhysicalDeviceFormatProperties)(physical, format, &properties);
    return properties;
  }

 private:
  struct Interface {
    VkDescriptorSetLayout set_layout = VK_NULL_HANDLE;
    VkPipelineLayout layout = VK_NULL_HANDLE;
  };

  const Interface& interface(const Bindings& bindings) {
    std::vector<VkDescriptorSetLayoutBinding> entries;
    std::string key;
    for (const std::vector<Resource>& binding : bindings) {
      const auto index = static_cast<uint32_t>(entries.size());
      entries.push_back({index, binding[0].type, static_cast<uint32_t>(binding.size()), VK_SHADER_STAGE_ALL, nullptr});
      key += std::to_string(binding[0].type) + "x" + std::to_string(binding.size()) + " ";
    }
    Interface& io = interfaces_[key];
    if (!io.layout) {
      io.set_layout = set_layout(entries);
      io.layout = pipeline_layout(io.set_layout, 64);
    }
    return io;
  }

  struct Set {
    Set(ImageClient& of, const Interface& io, const Bindings& bindings) : client(of) {
      std::vector<VkDescriptorPoolSize> sizes{{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1}};
      for (const std::vector<Resource>& b : bindings) sizes.push_back({b[0].type, static_cast<uint32_t>(b.size())});
      const VkDescriptorPoolCreateInfo info{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO, nullptr,     0, 1,
                                            static_cast<uint32_t>(sizes.size()),           sizes.data()};
      EXPECT_EQ(VK(client, CreateDescriptorPool)(client.device, &info, nullptr, &pool), VK_SUCCESS);
      const VkDescriptorSetAllocateInfo allocate{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO, nullptr, pool, 1,
                                                 &io.set_layout};
      EXPECT_EQ(VK(client, AllocateDescriptorSets)(client.device, &allocate, &set), VK_SUCCESS);
      for (uint32_t b = 0; b < bindings.size(); ++b) {
        for (uint32_t i = 0; i < bindings[b].size(); ++i) {
          const Resource& r = bindings[b][i];
          const VkWriteDescriptorSet write{
              VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET, nullptr, set, b, i, 1, r.type, &r.image, &r.buffer, &r.texels};
          VK(client, UpdateDescriptorSets)(client.device, 1, &write, 0, nullptr);
        }
      }
    }
    ~Set() { VK(client, DestroyDescriptorPool)(client.device, pool, nullptr); }
    ImageClient& client;
    VkDescriptorPool pool = VK_NULL_HANDLE;
    VkDescriptorSet set = VK_NULL_HANDLE;
  };

  void bind(VkCommandBuffer cb, VkPipelineBindPoint point, const Interface& io, const Set& set, std::vector<uint32_t> push) {
    VK(*this, CmdBindDescriptorSets)(cb, point, io.layout, 0, 1, &set.set, 0, nullptr);
    push.resize(16);
    VK(*this, CmdPushConstants)(cb, io.layout, VK_SHADER_STAGE_ALL, 0, 64, push.data());
  }

  VkRenderPass pass_for(const Draw& d);
  VkPipeline pipeline_for(const Draw& d, VkPipelineLayout layout, VkRenderPass pass);

  std::map<std::string, Interface> interfaces_;
  std::map<std::string, VkPipeline> pipelines_;
  std::map<std::string, VkShaderModule> modules_;
};

inline VkRenderPass ImageClient::pass_for(const Draw& d) {
  std::vector<VkAttachmentDescription> attachments;
  const auto reference = [&](VkImageView view, VkFormat format, uint32_t samples) -> VkAttachmentReference {
    if (!view) return {VK_ATTACHMENT_UNUSED, VK_IMAGE_LAYOUT_GENERAL};
    attachments.push_back({0, format, static_cast<VkSampleCountFlagBits>(samples), VK_ATTACHMENT_LOAD_OP_LOAD,
                           VK_ATTACHMENT_STORE_OP_STORE, VK_ATTACHMENT_LOAD_OP_LOAD, VK_ATTACHMENT_STORE_OP_STORE,
                           VK_IMAGE_LAYOUT_GENERAL, VK_IMAGE_LAYOUT_GENERAL});
    return {static_cast<uint32_t>(attachments.size() - 1), VK_IMAGE_LAYOUT_GENERAL};
  };
  const VkAttachmentReference color = reference(d.color, d.color_format, d.samples),
                              resolve = reference(d.resolve, d.color_format, 1),
                              depth = reference(d.depth, d.depth_format, d.samples);
  VkSubpassDescription subpass{};
  subpass.colorAttachmentCount = 1;
  subpass.pColorAttachments = &color;
  subpass.pResolveAttachments = d.resolve ? &resolve : nullptr;
  subpass.pDepthStencilAttachment = &depth;
  const VkRenderPassCreateInfo info{VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO,
                                    nullptr,
                                    0,
                                    static_cast<uint32_t>(attachments.size()),
                                    attachments.data(),
                                    1,
                                    &subpass};
  VkRenderPass out = VK_NULL_HANDLE;
  EXPECT_EQ(VK(*this, CreateRenderPass)(device, &info, nullptr, &out), VK_SUCCESS);
  defer([this, out] { VK(*this, DestroyRenderPass)(device, out, nullptr); });
  return out;
}

inline VkPipeline ImageClient::pipeline_for(const Draw& d, VkPipelineLayout layout, VkRenderPass pass) {
  const auto module_for = [&](VkShaderStageFlagBits stage, const std::string& glsl) {
    VkShaderModule& out = modules_[glsl];
    if (!out) out = shader(stage, glsl);
    return out;
  };
  const VkPipelineShaderStageCreateInfo stages[] = {
      {VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO, nullptr, 0, VK_SHADER_STAGE_VERTEX_BIT,
       module_for(VK_SHADER_STAGE_VERTEX_BIT, d.vertex), "main", nullptr},
      {VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO, nullptr, 0, VK_SHADER_STAGE_FRAGMENT_BIT,
       d.points ? VK_NULL_HANDLE : module_for(VK_SHADER_STAGE_FRAGMENT_BIT, d.fragment), "main", nullptr}};
  const VkVertexInputBindingDescription binding{0, d.stride_bytes, VK_VERTEX_INPUT_RATE_VERTEX};
  const VkVertexInputAttributeDescription attribute{0, 0, d.attribute, 0};
  const uint32_t inputs = d.attribute != VK_FORMAT_UNDEFINED;
  const VkPipelineVertexInputStateCreateInfo input{
      VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO, nullptr, 0, inputs, &binding, inputs, &attribute};
  const VkPipelineInputAssemblyStateCreateInfo assembly{
      VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO, nullptr, 0,
      d.points ? VK_PRIMITIVE_TOPOLOGY_POINT_LIST : VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST, VK_FALSE};
  const VkViewport viewport{0, 0, static_cast<float>(d.extent.width), static_cast<float>(d.extent.height), 0, 1};
  const VkRect2D scissor{{}, d.extent};
  const VkPipelineViewportStateCreateInfo viewports{
      VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO, nullptr, 0, 1, &viewport, 1, &scissor};
  VkPipelineRasterizationStateCreateInfo rasterization{VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO};
  rasterization.lineWidth = 1;
  rasterization.rasterizerDiscardEnable = d.points;
  VkPipelineMultisampleStateCreateInfo multisample{VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO};
  multisample.rasterizationSamples = static_cast<VkSampleCountFlagBits>(d.samples);
  VkPipelineDepthStencilStateCreateInfo depth{VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO};
  depth.depthTestEnable = depth.depthWriteEnable = d.depth != VK_NULL_HANDLE;
  depth.depthCompareOp = VK_COMPARE_OP_ALWAYS;
  VkPipelineColorBlendStateCreateInfo blend{VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO};
  blend.attachmentCount = 1;
  blend.pAttachments = &d.blend;
  VkGraphicsPipelineCreateInfo info{VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO};
  info.stageCount = d.points ? 1 : 2;
  info.pStages = stages;
  info.pVertexInputState = &input;
  info.pInputAssemblyState = &assembly;
  info.pViewportState = &viewports;
  info.pRasterizationState = &rasterization;
  info.pMultisampleState = &multisample;
  info.pDepthStencilState = &depth;
  info.pColorBlendState = &blend;
  info.layout = layout;
  info.renderPass = pass;
  VkPipeline out = VK_NULL_HANDLE;
  EXPECT_EQ(VK(*this, CreateGraphicsPipelines)(device, VK_NULL_HANDLE, 1, &info, nullptr, &out), VK_SUCCESS) << d.color_format;
  defer([this, out] { VK(*this, DestroyPipeline)(device, out, nullptr); });
  return out;
}

inline void ImageClient::draw(const Draw& d) {
  const Interface& io = interface(d.bindings);
  const VkRenderPass pass = pass_for(d);
  std::vector<VkImageView> views;
  for (const VkImageView view : {d.color, d.resolve, d.depth}) {
    if (view) views.push_back(view);
  }
  const VkFramebuffer frame = framebuffer(pass, views, d.extent);
  const VkPipeline pipeline = pipeline_for(d, io.layout, pass);
  const Set set(*this, io, d.bindings);
  run([&](VkCommandBuffer cb) {
    begin_pass(cb, pass, frame, {{}, d.extent});
    VK(*this, CmdBindPipeline)(cb, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline);
    bind(cb, VK_PIPELINE_BIND_POINT_GRAPHICS, io, set, d.push);
    const VkDeviceSize zero = 0;
    if (d.vertices) VK(*this, CmdBindVertexBuffers)(cb, 0, 1, &d.vertices, &zero);
    VK(*this, CmdDraw)(cb, d.vertex_count, 1, 0, 0);
    VK(*this, CmdEndRenderPass)(cb);
  });
}

}  // namespace pineda::test
