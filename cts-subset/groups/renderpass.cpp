// renderpass.*: load and store operations of every kind of attachment, render areas, subpasses with input attachments.
#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <optional>

#include "cts-subset/groups/groups.h"
#include "cts-subset/harness/case.h"
#include "cts-subset/harness/pipelines.h"
#include "cts-subset/reference/compare.h"
#include "cts-subset/reference/formats.h"

namespace pineda::cts {
namespace {

constexpr uint32_t kSize = 20;

// One subpass, described by hand: what Pass does not vary.
struct PassDesc {
  std::vector<VkAttachmentDescription> attachments;
  std::vector<VkSubpassDescription> subpasses;
  std::vector<VkSubpassDependency> dependencies;
};

RenderPass create_render_pass(Device& device, const PassDesc& desc) {
  VkRenderPassCreateInfo info{VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO};
  info.attachmentCount = static_cast<uint32_t>(desc.attachments.size());
  info.pAttachments = desc.attachments.data();
  info.subpassCount = static_cast<uint32_t>(desc.subpasses.size());
  info.pSubpasses = desc.subpasses.data();
  info.dependencyCount = static_cast<uint32_t>(desc.dependencies.size());
  info.pDependencies = desc.dependencies.data();
  return make<VkRenderPass, vkDestroyRenderPass>(device, vkCreateRenderPass, info, "vkCreateRenderPass");
}

Framebuffer create_framebuffer(Device& device, VkRenderPass pass, const std::vector<VkImageView>& views) {
  VkFramebufferCreateInfo info{VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO};
  info.renderPass = pass;
  info.attachmentCount = static_cast<uint32_t>(views.size());
  info.pAttachments = views.data();
  info.width = info.height = kSize;
  info.layers = 1;
  return make<VkFramebuffer, vkDestroyFramebuffer>(device, vkCreateFramebuffer, info, "vkCreateFramebuffer");
}

Pipeline create_pipeline(Device& device, const Spirv& vertex, const Spirv& fragment, VkPipelineLayout layout, VkRenderPass pass,
                         uint32_t subpass) {
  const auto module_of = [&](const Spirv& code) {
    VkShaderModuleCreateInfo info{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
    info.codeSize = code.size() * 4;
    info.pCode = code.data();
    return make<VkShaderModule, vkDestroyShaderModule>(device, vkCreateShaderModule, info, "vkCreateShaderModule");
  };
  const auto vertex_module = module_of(vertex), fragment_module = module_of(fragment);
  const VkPipelineShaderStageCreateInfo stages[] = {{VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO, nullptr, 0,
                                                     VK_SHADER_STAGE_VERTEX_BIT, vertex_module, "main", nullptr},
                                                    {VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO, nullptr, 0,
                                                     VK_SHADER_STAGE_FRAGMENT_BIT, fragment_module, "main", nullptr}};
  const VkPipelineVertexInputStateCreateInfo input{VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO};
  VkPipelineInputAssemblyStateCreateInfo assembly{VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO};
  assembly.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
  const VkViewport viewport{0, 0, kSize, kSize, 0, 1};
  const VkRect2D scissor{{0, 0}, {kSize, kSize}};
  VkPipelineViewportStateCreateInfo viewports{VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO};
  viewports.viewportCount = viewports.scissorCount = 1;
  viewports.pViewports = &viewport;
  viewports.pScissors = &scissor;
  const DrawState defaults;
  VkPipelineColorBlendAttachmentState blend{};
  blend.colorWriteMask = 15;
  VkPipelineColorBlendStateCreateInfo blending{VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO};
  blending.attachmentCount = 1;
  blending.pAttachments = &blend;
  VkGraphicsPipelineCreateInfo info{VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO};
  info.stageCount = 2;
  info.pStages = stages;
  info.pVertexInputState = &input;
  info.pInputAssemblyState = &assembly;
  info.pViewportState = &viewports;
  info.pRasterizationState = &defaults.rasterization;
  info.pMultisampleState = &defaults.multisample;
  info.pDepthStencilState = &defaults.depth_stencil;
  info.pColorBlendState = &blending;
  info.layout = layout;
  info.renderPass = pass;
  info.subpass = subpass;
  VkPipeline handle = VK_NULL_HANDLE;
  check(vkCreateGraphicsPipelines(device.handle(), VK_NULL_HANDLE, 1, &info, nullptr, &handle), "vkCreateGraphicsPipelines");
  return {device.handle(), handle};
}

void begin(VkCommandBuffer commands, VkRenderPass pass, VkFramebuffer framebuffer, const std::vector<VkClearValue>& clears,
           const VkRect2D& area) {
  VkRenderPassBeginInfo info{VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO};
  info.renderPass = pass;
  info.framebuffer = framebuffer;
  info.renderArea = area;
  info.clearValueCount = static_cast<uint32_t>(clears.size());
  info.pClearValues = clears.data();
  vkCmdBeginRenderPass(commands, &info, VK_SUBPASS_CONTENTS_INLINE);
}

VkClearColorValue colour_value(const FormatInfo& info, double value) {
  VkClearColorValue result{};
  for (int i = 0; i < 4; ++i) {
    if (info.is_integer()) {
      result.uint32[i] = value > 0.5 ? 1 : 0;
    } else {
      result.float32[i] = static_cast<float>(value);
    }
  }
  return result;
}
Colour as_colour(const FormatInfo& info, double value) {
  const double v = info.is_integer() ? (value > 0.5 ? 1 : 0) : static_cast<float>(value);
  return {v, v, v, v};
}

// An empty pass over part of the image: loads keep, clears clear, within the render area only.
void run_load_store(Device& device, const FormatInfo& info, VkAttachmentLoadOp load, const VkRect2D& area) {
  require(device.format(info.format).optimalTilingFeatures & VK_FORMAT_FEATURE_COLOR_ATTACHMENT_BIT, "rendering to this format");
  ImageDesc desc;
  desc.format = info.format;
  desc.extent = {kSize, kSize, 1};
  desc.usage |= VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT;
  const Image image = create_image(device, desc);
  const VkClearColorValue before = colour_value(info, 0.25);
  PassDesc pass_desc;
  pass_desc.attachments = {{0, info.format, VK_SAMPLE_COUNT_1_BIT, load, VK_ATTACHMENT_STORE_OP_STORE,
                            VK_ATTACHMENT_LOAD_OP_DONT_CARE, VK_ATTACHMENT_STORE_OP_DONT_CARE,
                            VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL}};
  const VkAttachmentReference reference{0, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
  VkSubpassDescription subpass{};
  subpass.colorAttachmentCount = 1;
  subpass.pColorAttachments = &reference;
  pass_desc.subpasses = {subpass};
  const RenderPass pass = create_render_pass(device, pass_desc);
  const Framebuffer framebuffer = create_framebuffer(device, pass, {image.view});
  device.run([&](VkCommandBuffer commands) {
    const VkImageSubresourceRange whole{VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
    transition(commands, image, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
    vkCmdClearColorImage(commands, image.handle, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, &before, 1, &whole);
    full_barrier(commands);
    begin(commands, pass, framebuffer, {{.color = colour_value(info, 0.75)}}, area);
    vkCmdEndRenderPass(commands);
    full_barrier(commands);
  });
  const std::vector<std::byte> got = download(device, image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
  for (uint32_t y = 0; y < kSize; ++y) {
    for (uint32_t x = 0; x < kSize; ++x) {
      const bool inside = x >= static_cast<uint32_t>(area.offset.x) && x < area.offset.x + area.extent.width &&
                          y >= static_cast<uint32_t>(area.offset.y) && y < area.offset.y + area.extent.height;
      const bool cleared = inside && load == VK_ATTACHMENT_LOAD_OP_CLEAR;
      expect_colour(info, got.data() + (y * kSize + x) * info.bytes, as_colour(info, cleared ? 0.75 : 0.25),
                    info.is_integer() ? 0 : 1, fmt::format("{}, {}", x, y));
    }
  }
}

// A chain of subpasses: each reads the one before as an input attachment and adds its number, alternating two attachments.
void run_subpass_chain(Device& device, uint32_t count, VkFormat format) {
  const FormatInfo& info = info_of(format);
  ImageDesc desc;
  desc.format = format;
  desc.extent = {kSize, kSize, 1};
  desc.usage |= VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_INPUT_ATTACHMENT_BIT;
  const Image images[2] = {create_image(device, desc), create_image(device, desc)};
  PassDesc pass_desc;
  pass_desc.attachments.assign(2, {0, format, VK_SAMPLE_COUNT_1_BIT, VK_ATTACHMENT_LOAD_OP_CLEAR, VK_ATTACHMENT_STORE_OP_STORE,
                                   VK_ATTACHMENT_LOAD_OP_DONT_CARE, VK_ATTACHMENT_STORE_OP_DONT_CARE, VK_IMAGE_LAYOUT_UNDEFINED,
                                   VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL});
  const VkAttachmentReference colours[2] = {{0, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL},
                                            {1, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL}};
  const VkAttachmentReference inputs[2] = {{0, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL},
                                           {1, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL}};
  for (uint32_t i = 0; i < count; ++i) {
    VkSubpassDescription subpass{};
    subpass.colorAttachmentCount = 1;
    subpass.pColorAttachments = &colours[i % 2];
    subpass.inputAttachmentCount = 1;
    subpass.pInputAttachments = &inputs[(i + 1) % 2];
    pass_desc.subpasses.push_back(subpass);
    if (i) {
      pass_desc.dependencies.push_back(
          {i - 1, i, VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT | VK_PIPELINE_STAGE_FRAGMENT_SHADER_BIT,
           VK_PIPELINE_STAGE_FRAGMENT_SHADER_BIT | VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT,
           VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT, VK_ACCESS_INPUT_ATTACHMENT_READ_BIT | VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT,
           VK_DEPENDENCY_BY_REGION_BIT});
    }
  }
  const RenderPass pass = create_render_pass(device, pass_desc);
  const Framebuffer framebuffer = create_framebuffer(device, pass, {images[0].view, images[1].view});
  std::vector<Resources> resources(2);
  for (uint32_t i = 0; i < 2; ++i) {
    resources[i].descriptors = {{0,
                                 VK_DESCRIPTOR_TYPE_INPUT_ATTACHMENT,
                                 {},
                                 {{VK_NULL_HANDLE, images[i].view, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL}},
                                 {}}};
    resources[i].push_constants = to_bytes(0.0f);
  }
  const Bindings bindings[2] = {{device, resources[0], VK_SHADER_STAGE_FRAGMENT_BIT},
                                {device, resources[1], VK_SHADER_STAGE_FRAGMENT_BIT}};
  const Spirv vertex = fullscreen_vertex();
  const Spirv fragment =
      compile_glsl(VK_SHADER_STAGE_FRAGMENT_BIT,
                   "layout(input_attachment_index = 0, binding = 0) uniform subpassInput i;\n"
                   "layout(push_constant) uniform P { float k; }; layout(location = 0) out vec4 c;\n"
                   "void main() { c = subpassLoad(i) + vec4(k, gl_FragCoord.x, gl_FragCoord.y, 1.0) / 256.0; }");
  std::vector<Pipeline> pipelines;
  for (uint32_t i = 0; i < count; ++i)
    pipelines.push_back(create_pipeline(device, vertex, fragment, bindings[(i + 1) % 2].layout(), pass, i));
  device.run([&](VkCommandBuffer commands) {
    begin(commands, pass, framebuffer, {VkClearValue{}, VkClearValue{}}, {{0, 0}, {kSize, kSize}});
    for (uint32_t i = 0; i < count; ++i) {
      if (i) vkCmdNextSubpass(commands, VK_SUBPASS_CONTENTS_INLINE);
      vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipelines[i]);
      Resources& r = resources[(i + 1) % 2];
      r.push_constants = to_bytes(static_cast<float>(i + 1));
      bindings[(i + 1) % 2].bind(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, r);
      vkCmdDraw(commands, 3, 1, 0, 0);
    }
    vkCmdEndRenderPass(commands);
    full_barrier(commands);
  });
  const std::vector<std::byte> got = download(device, images[(count - 1) % 2], VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
  for (uint32_t i = 0; i < kSize * kSize; ++i) {
    Colour want{};
    for (uint32_t k = 1; k <= count; ++k) {
      const double step[4] = {static_cast<double>(k), i % kSize + 0.5, i / kSize + 0.5, 1.0};
      for (size_t c = 0; c < 4; ++c) want[c] += step[c] / 256;
    }
    expect_colour(info, got.data() + i * info.bytes, want, count, fmt::format("{}, {}", i % kSize, i / kSize));
  }
}

// Attachments with stores that are not wanted keep nothing that the pass must not write elsewhere; a third one is preserved.
void run_preserve(Device& device) {
  ImageDesc desc;
  desc.format = VK_FORMAT_R32_UINT;
  desc.extent = {kSize, kSize, 1};
  desc.usage |= VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT;
  const Image a = create_image(device, desc), b = create_image(device, desc);
  PassDesc pass_desc;
  pass_desc.attachments.assign(
      2, {0, VK_FORMAT_R32_UINT, VK_SAMPLE_COUNT_1_BIT, VK_ATTACHMENT_LOAD_OP_CLEAR, VK_ATTACHMENT_STORE_OP_STORE,
          VK_ATTACHMENT_LOAD_OP_DONT_CARE, VK_ATTACHMENT_STORE_OP_DONT_CARE, VK_IMAGE_LAYOUT_UNDEFINED,
          VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL});
  const VkAttachmentReference references[2] = {{0, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL},
                                               {1, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL}};
  const uint32_t preserved = 0;
  VkSubpassDescription first{}, second{};
  first.colorAttachmentCount = second.colorAttachmentCount = 1;
  first.pColorAttachments = &references[0];
  second.pColorAttachments = &references[1];
  second.preserveAttachmentCount = 1;
  second.pPreserveAttachments = &preserved;
  pass_desc.subpasses = {first, second};
  const RenderPass pass = create_render_pass(device, pass_desc);
  const Framebuffer framebuffer = create_framebuffer(device, pass, {a.view, b.view});
  const Resources none;
  const Bindings bindings(device, none, VK_SHADER_STAGE_FRAGMENT_BIT);
  const Spirv fragment =
      compile_glsl(VK_SHADER_STAGE_FRAGMENT_BIT,
                   "layout(location = 0) out uint c; void main() { c = uint(gl_FragCoord.x) * 1000u + uint(gl_FragCoord.y); }");
  const Pipeline pipeline = create_pipeline(device, fullscreen_vertex(), fragment, bindings.layout(), pass, 0);
  device.run([&](VkCommandBuffer commands) {
    begin(commands, pass, framebuffer, {{.color = {.uint32 = {5, 0, 0, 0}}}, {.color = {.uint32 = {6, 0, 0, 0}}}},
          {{0, 0}, {kSize, kSize}});
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline);
    vkCmdDraw(commands, 3, 1, 0, 0);
    vkCmdNextSubpass(commands, VK_SUBPASS_CONTENTS_INLINE);
    vkCmdEndRenderPass(commands);
    full_barrier(commands);
  });
  const auto first_words = download_as<uint32_t>(device, a, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
  const auto second_words = download_as<uint32_t>(device, b, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
  for (uint32_t i = 0; i < kSize * kSize; ++i) {
    expect(first_words[i] == i % kSize * 1000 + i / kSize, fmt::format("the preserved attachment, pixel {}", i));
    expect(second_words[i] == 6, fmt::format("the attachment of an empty subpass, pixel {}", i));
  }
}

}  // namespace

void register_renderpass() {
  static constexpr VkRect2D kAreas[] = {{{0, 0}, {kSize, kSize}}, {{3, 2}, {7, 11}}, {{19, 19}, {1, 1}}};
  for (const FormatInfo& info : colour_formats()) {
    for (const VkAttachmentLoadOp load : {VK_ATTACHMENT_LOAD_OP_LOAD, VK_ATTACHMENT_LOAD_OP_CLEAR}) {
      const bool clear = load == VK_ATTACHMENT_LOAD_OP_CLEAR;
      add_case("renderpass.load_store", fmt::format("{}_{}", info.name, clear ? "clear" : "load"), "8.1 Render Pass Creation",
               [&info, load](Device& device) { run_load_store(device, info, load, kAreas[0]); });
    }
  }
  for (const VkFormat format : {VK_FORMAT_R8G8B8A8_UNORM, VK_FORMAT_R32_UINT, VK_FORMAT_R16G16B16A16_SFLOAT}) {
    for (size_t area = 1; area < std::size(kAreas); ++area) {
      for (const VkAttachmentLoadOp load : {VK_ATTACHMENT_LOAD_OP_LOAD, VK_ATTACHMENT_LOAD_OP_CLEAR}) {
        add_case("renderpass.render_area",
                 fmt::format("{}_{}_{}", info_of(format).name, area, load == VK_ATTACHMENT_LOAD_OP_CLEAR ? "clear" : "load"),
                 "8.4 Render Pass Commands",
                 [=](Device& device) { run_load_store(device, info_of(format), load, kAreas[area]); });
      }
    }
  }
  for (const uint32_t count : {1u, 2u, 3u, 7u}) {
    for (const VkFormat format : {VK_FORMAT_R8G8B8A8_UNORM, VK_FORMAT_R32G32B32A32_SFLOAT, VK_FORMAT_R16G16B16A16_SFLOAT}) {
      add_case("renderpass.subpasses", fmt::format("chain_of_{}_{}", count, info_of(format).name), "8.1 Render Pass Creation",
               [=](Device& device) { run_subpass_chain(device, count, format); });
    }
  }
  add_case("renderpass.subpasses", "preserved_attachment", "8.1 Render Pass Creation", run_preserve);
}

}  // namespace pineda::cts
