// Render passes and draws: load and store operations, clears, subpasses, vertex and index buffers, indirect draws, texture
// variants.
#include "icd_pipeline_client.h"
#include "icd_shaders.h"

namespace pineda::test {
namespace {

constexpr VkFormat kFormat = VK_FORMAT_R8G8B8A8_UNORM;
constexpr uint32_t kSize = 40;
constexpr uint32_t kRed = 0xFF0000FF, kGreen = 0xFF00FF00, kBlue = 0xFFFF0000, kBlack = 0xFF000000;
constexpr VkClearValue kClearBlack{{{0, 0, 0, 1}}};

struct DrawFixture {
  PipelineClient client;
  VkImage image = target();
  Client::Buffer pixels = client.buffer(kSize * kSize * 4);
  // Two triangles: left half and right half of the viewport, as a list. uv runs from 0 to 1.
  Client::Buffer vertices = client.buffer(12 * 16);
  VkRect2D whole{{0, 0}, {kSize, kSize}};

  DrawFixture() {
    const auto quad = [&](int index, float x0, float x1) {
      const float corners[6][2] = {{x0, -1}, {x1, -1}, {x0, 1}, {x0, 1}, {x1, -1}, {x1, 1}};
      for (int i = 0; i < 6; ++i) {
        float* v = vertices.as<float>() + (index * 6 + i) * 4;
        v[0] = corners[i][0];
        v[1] = corners[i][1];
        v[2] = (corners[i][0] + 1) / 2;
        v[3] = (corners[i][1] + 1) / 2;
      }
    };
    quad(0, -1, 0);
    quad(1, 0, 1);
  }

  VkImage target(VkImageUsageFlags usage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT, VkFormat format = kFormat) {
    return client.image(format, {kSize, kSize, 1}, 1, 1, usage);
  }
  void bind(VkCommandBuffer cb, VkPipeline pipeline) {
    VK(client, CmdBindPipeline)(cb, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline);
    const VkViewport viewport{0, 0, kSize, kSize, 0, 1};
    VK(client, CmdSetViewport)(cb, 0, 1, &viewport);
    VK(client, CmdSetScissor)(cb, 0, 1, &whole);
    const VkDeviceSize zero = 0;
    VK(client, CmdBindVertexBuffers)(cb, 0, 1, &vertices.handle, &zero);
  }
  void color(VkCommandBuffer cb, VkPipelineLayout layout, std::array<float, 4> value) {
    VK(client, CmdPushConstants)(cb, layout, VK_SHADER_STAGE_ALL, 0, 16, value.data());
  }
  void download(VkCommandBuffer cb, VkImage from) {
    const VkBufferImageCopy region{0, 0, 0, color_layers(), {}, {kSize, kSize, 1}};
    VK(client, CmdCopyImageToBuffer)(cb, from, VK_IMAGE_LAYOUT_GENERAL, pixels.handle, 1, &region);
  }
  uint32_t at(uint32_t x, uint32_t y) const { return pixels.as<uint32_t>()[y * kSize + x]; }
};

TEST(IcdRenderPass, ClearLoadAndRenderArea) {
  DrawFixture f;
  constexpr PipelineClient::Attachment kClear[] = {{kFormat, VK_ATTACHMENT_LOAD_OP_CLEAR}},
                                       kLoad[] = {{kFormat, VK_ATTACHMENT_LOAD_OP_LOAD}};
  constexpr uint32_t kFirst[] = {0};
  const VkRenderPass clear = f.client.render_pass(kClear, kFirst), load = f.client.render_pass(kLoad, kFirst);
  const VkFramebuffer framebuffer = f.client.framebuffer(clear, {f.client.view(f.image, kFormat)}, {kSize, kSize});
  f.client.run([&](VkCommandBuffer cb) {
    f.client.begin_pass(cb, clear, framebuffer, f.whole, {{{{0, 1, 0, 1}}}});
    VK(f.client, CmdEndRenderPass)(cb);
    f.client.begin_pass(cb, clear, framebuffer, {{3, 5}, {7, 9}}, {{{{1, 0, 0, 1}}}});
    VK(f.client, CmdEndRenderPass)(cb);
    f.client.begin_pass(cb, load, framebuffer, f.whole);
    const VkClearAttachment blue{VK_IMAGE_ASPECT_COLOR_BIT, 0, {{{0, 0, 1, 1}}}};
    const VkClearRect rects[] = {{{{20, 20}, {3, 3}}, 0, 1}, {{{39, 0}, {1, 40}}, 0, 1}};
    VK(f.client, CmdClearAttachments)(cb, 1, &blue, 2, rects);
    VK(f.client, CmdEndRenderPass)(cb);
    f.download(cb, f.image);
  });
  for (uint32_t y = 0; y < kSize; ++y) {
    for (uint32_t x = 0; x < kSize; ++x) {
      const bool red = x >= 3 && x < 10 && y >= 5 && y < 14;
      const bool blue = x == 39 || (x >= 20 && x < 23 && y >= 20 && y < 23);
      ASSERT_EQ(f.at(x, y), blue ? kBlue : red ? kRed : kGreen) << x << ' ' << y;
    }
  }
}

TEST(IcdRenderPass, UnsupportedIsRefused) {
  breaks_on_purpose({"VUID-VkSubpassDescription-pColorAttachments-06868", "VUID-VkRenderPassCreateInfo-attachment-00834"});
  PipelineClient client;
  VkAttachmentDescription attachments[2]{};
  for (VkAttachmentDescription& attachment : attachments) {
    attachment.format = kFormat;
    attachment.loadOp = attachment.stencilLoadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE;
    attachment.finalLayout = VK_IMAGE_LAYOUT_GENERAL;
  }
  attachments[0].samples = VK_SAMPLE_COUNT_4_BIT;
  attachments[1].samples = VK_SAMPLE_COUNT_32_BIT;
  VkAttachmentReference references[] = {{0, VK_IMAGE_LAYOUT_GENERAL}, {1, VK_IMAGE_LAYOUT_GENERAL}};
  VkSubpassDescription subpass{};
  subpass.colorAttachmentCount = 2;
  subpass.pColorAttachments = references;
  const VkRenderPassCreateInfo info{VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO, nullptr, 0, 2, attachments, 1, &subpass};
  VkRenderPass pass;
  EXPECT_EQ(VK(client, CreateRenderPass)(client.device, &info, nullptr, &pass), VK_ERROR_FEATURE_NOT_PRESENT) << "32 samples";
  attachments[1].samples = VK_SAMPLE_COUNT_8_BIT;
  EXPECT_EQ(VK(client, CreateRenderPass)(client.device, &info, nullptr, &pass), VK_ERROR_FEATURE_NOT_PRESENT) << "4 and 8";
  attachments[1].samples = VK_SAMPLE_COUNT_4_BIT;
  references[1].attachment = 2;
  EXPECT_EQ(VK(client, CreateRenderPass)(client.device, &info, nullptr, &pass), VK_ERROR_FEATURE_NOT_PRESENT) << "no such one";
}

struct ColorPipeline {
  VkPipelineLayout layout;
  VkPipeline pipeline = VK_NULL_HANDLE;

  ColorPipeline(DrawFixture& f, VkRenderPass pass, uint32_t subpass = 0) : layout(f.client.pipeline_layout(std::nullopt, 16)) {
    const PipelineClient::Drawing drawing{.layout = layout,
                                          .pass = pass,
                                          .subpass = subpass,
                                          .vertex = f.client.module(kColorVertex),
                                          .fragment = f.client.module(kColorFragment)};
    EXPECT_EQ(f.client.graphics_pipeline(drawing, &pipeline), VK_SUCCESS);
  }
};

TEST(IcdDraw, DirectIndexedAndIndirectAgree) {
  DrawFixture f;
  constexpr PipelineClient::Attachment kClear[] = {{kFormat, VK_ATTACHMENT_LOAD_OP_CLEAR}};
  constexpr uint32_t kFirst[] = {0};
  const VkRenderPass pass = f.client.render_pass(kClear, kFirst);
  const VkFramebuffer framebuffer = f.client.framebuffer(pass, {f.client.view(f.image, kFormat)}, {kSize, kSize});
  const ColorPipeline p(f, pass);
  const auto indices = f.client.buffer(64), arguments = f.client.buffer(128);
  for (uint16_t i = 0; i < 6; ++i) indices.as<uint16_t>()[2 + i] = i;
  const VkDrawIndirectCommand indirect[] = {{6, 1, 0, 0}, {6, 1, 6, 0}};
  const VkDrawIndexedIndirectCommand indexed{6, 1, 0, 6, 0};
  std::memcpy(arguments.data, indirect, sizeof(indirect));
  std::memcpy(arguments.data + 64, &indexed, sizeof(indexed));
  for (int mode = 0; mode < 4; ++mode) {
    f.client.run([&](VkCommandBuffer cb) {
      f.client.begin_pass(cb, pass, framebuffer, f.whole, {kClearBlack});
      f.bind(cb, p.pipeline);
      VK(f.client, CmdBindIndexBuffer)(cb, indices.handle, 4, VK_INDEX_TYPE_UINT16);
      f.color(cb, p.layout, {1, 0, 0, 1});
      if (mode == 0) VK(f.client, CmdDraw)(cb, 6, 1, 0, 0);
      if (mode == 1) VK(f.client, CmdDrawIndexed)(cb, 6, 1, 0, 0, 0);
      if (mode == 2) VK(f.client, CmdDrawIndirect)(cb, arguments.handle, 0, 1, 16);
      if (mode == 3) VK(f.client, CmdDrawIndirect)(cb, arguments.handle, 0, 2, 16);
      f.color(cb, p.layout, {0, 0, 1, 1});
      if (mode == 0) VK(f.client, CmdDraw)(cb, 6, 3, 6, 0);
      if (mode == 1) VK(f.client, CmdDrawIndexed)(cb, 6, 1, 0, 6, 0);
      if (mode >= 2) VK(f.client, CmdDrawIndexedIndirect)(cb, arguments.handle, 64, 1, 20);
      VK(f.client, CmdEndRenderPass)(cb);
      f.download(cb, f.image);
    });
    for (uint32_t i = 0; i < kSize; ++i) {
      ASSERT_EQ(f.at(i, 7), i < kSize / 2 ? kRed : kBlue) << "mode " << mode << " x " << i;
    }
  }
}

TEST(IcdDraw, ScissorAndSecondaryCommandBuffer) {
  DrawFixture f;
  constexpr PipelineClient::Attachment kClear[] = {{kFormat, VK_ATTACHMENT_LOAD_OP_CLEAR}};
  constexpr uint32_t kFirst[] = {0};
  const VkRenderPass pass = f.client.render_pass(kClear, kFirst);
  const VkFramebuffer framebuffer = f.client.framebuffer(pass, {f.client.view(f.image, kFormat)}, {kSize, kSize});
  const ColorPipeline p(f, pass);
  const VkCommandBuffer secondary = f.client.command_buffer(VK_COMMAND_BUFFER_LEVEL_SECONDARY);
  const VkCommandBufferInheritanceInfo inheritance{VK_STRUCTURE_TYPE_COMMAND_BUFFER_INHERITANCE_INFO, nullptr, pass, 0,
                                                   framebuffer};
  const VkCommandBufferBeginInfo info{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO, nullptr,
                                      VK_COMMAND_BUFFER_USAGE_RENDER_PASS_CONTINUE_BIT, &inheritance};
  EXPECT_EQ(VK(f.client, BeginCommandBuffer)(secondary, &info), VK_SUCCESS);
  f.bind(secondary, p.pipeline);
  const VkRect2D scissor{{10, 10}, {20, 5}};
  VK(f.client, CmdSetScissor)(secondary, 0, 1, &scissor);
  f.color(secondary, p.layout, {0, 1, 0, 1});
  VK(f.client, CmdDraw)(secondary, 12, 1, 0, 0);
  EXPECT_EQ(VK(f.client, EndCommandBuffer)(secondary), VK_SUCCESS);
  f.client.run([&](VkCommandBuffer cb) {
    f.client.begin_pass(cb, pass, framebuffer, f.whole, {kClearBlack}, VK_SUBPASS_CONTENTS_SECONDARY_COMMAND_BUFFERS);
    VK(f.client, CmdExecuteCommands)(cb, 1, &secondary);
    VK(f.client, CmdEndRenderPass)(cb);
    f.download(cb, f.image);
  });
  for (uint32_t y = 0; y < kSize; ++y) {
    for (uint32_t x = 0; x < kSize; ++x)
      ASSERT_EQ(f.at(x, y), x >= 10 && x < 30 && y >= 10 && y < 15 ? kGreen : kBlack) << x << ' ' << y;
  }
}

// Subpass 0 and 2 draw to attachment 0, subpass 1 to attachment 1: contents live on between them.
TEST(IcdDraw, SubpassesKeepTheirAttachments) {
  DrawFixture f;
  constexpr PipelineClient::Attachment kAttachments[] = {{kFormat, VK_ATTACHMENT_LOAD_OP_CLEAR},
                                                         {kFormat, VK_ATTACHMENT_LOAD_OP_CLEAR}};
  constexpr uint32_t kOrder[] = {0, 1, 0};
  const VkRenderPass pass = f.client.render_pass(kAttachments, kOrder);
  const VkImage other = f.target();
  const VkFramebuffer framebuffer =
      f.client.framebuffer(pass, {f.client.view(f.image, kFormat), f.client.view(other, kFormat)}, {kSize, kSize});
  const ColorPipeline first(f, pass, 0), second(f, pass, 1), third(f, pass, 2);
  f.client.run([&](VkCommandBuffer cb) {
    f.client.begin_pass(cb, pass, framebuffer, f.whole, {kClearBlack, kClearBlack});
    f.bind(cb, first.pipeline);
    f.color(cb, first.layout, {1, 0, 0, 1});
    VK(f.client, CmdDraw)(cb, 6, 1, 0, 0);
    VK(f.client, CmdNextSubpass)(cb, VK_SUBPASS_CONTENTS_INLINE);
    f.bind(cb, second.pipeline);
    f.color(cb, second.layout, {0, 1, 0, 1});
    VK(f.client, CmdDraw)(cb, 12, 1, 0, 0);
    VK(f.client, CmdNextSubpass)(cb, VK_SUBPASS_CONTENTS_INLINE);
    f.bind(cb, third.pipeline);
    f.color(cb, third.layout, {0, 0, 1, 1});
    VK(f.client, CmdDraw)(cb, 6, 1, 6, 0);
    VK(f.client, CmdEndRenderPass)(cb);
    f.download(cb, f.image);
  });
  EXPECT_EQ(f.at(5, 5), kRed);
  EXPECT_EQ(f.at(30, 30), kBlue);
  f.client.run([&](VkCommandBuffer cb) { f.download(cb, other); });
  EXPECT_EQ(f.at(5, 5), kGreen);
  EXPECT_EQ(f.at(30, 30), kGreen);
}

// One pipeline, three kinds of textures in one render pass: each draw gets its own variant.
TEST(IcdDraw, TexturesSelectVariants) {
  DrawFixture f;
  constexpr PipelineClient::Attachment kClear[] = {{kFormat, VK_ATTACHMENT_LOAD_OP_CLEAR}};
  constexpr uint32_t kFirst[] = {0};
  const VkRenderPass pass = f.client.render_pass(kClear, kFirst);
  const VkFramebuffer framebuffer = f.client.framebuffer(pass, {f.client.view(f.image, kFormat)}, {kSize, kSize});
  const auto set_layout =
      f.client.set_layout({{0, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 1, VK_SHADER_STAGE_FRAGMENT_BIT, nullptr}});
  const VkPipelineLayout layout = f.client.pipeline_layout(set_layout, 16);
  VkPipeline pipeline = VK_NULL_HANDLE;
  ASSERT_EQ(f.client.graphics_pipeline({.layout = layout,
                                        .pass = pass,
                                        .vertex = f.client.module(kColorVertex),
                                        .fragment = f.client.module(kTextureFragment)},
                                       &pipeline),
            VK_SUCCESS);
  const VkImage rgba = f.target(VK_IMAGE_USAGE_SAMPLED_BIT),
                bgra = f.target(VK_IMAGE_USAGE_SAMPLED_BIT, VK_FORMAT_B8G8R8A8_UNORM);
  const VkSampler sampler = f.client.nearest_sampler();
  const VkDescriptorSet sets[] = {f.client.descriptor_set(set_layout), f.client.descriptor_set(set_layout),
                                  f.client.descriptor_set(set_layout)};
  f.client.write_image(sets[0], 0, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, f.client.view(rgba, kFormat), sampler);
  f.client.write_image(sets[1], 0, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, f.client.view(bgra, VK_FORMAT_B8G8R8A8_UNORM),
                       sampler);
  constexpr VkComponentMapping kSwapped{VK_COMPONENT_SWIZZLE_G, VK_COMPONENT_SWIZZLE_R, VK_COMPONENT_SWIZZLE_ZERO,
                                        VK_COMPONENT_SWIZZLE_ONE};
  f.client.write_image(sets[2], 0, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, f.client.view(rgba, kFormat, kSwapped), sampler);
  const auto texels = f.client.buffer(kSize * kSize * 4);
  for (uint32_t i = 0; i < kSize * kSize; ++i) texels.as<uint32_t>()[i] = i * 2654435761u;
  for (int variant = 0; variant < 3; ++variant) {
    f.client.run([&](VkCommandBuffer cb) {
      const VkBufferImageCopy upload{0, 0, 0, color_layers(), {}, {kSize, kSize, 1}};
      VK(f.client, CmdCopyBufferToImage)(cb, texels.handle, rgba, VK_IMAGE_LAYOUT_GENERAL, 1, &upload);
      VK(f.client, CmdCopyBufferToImage)(cb, texels.handle, bgra, VK_IMAGE_LAYOUT_GENERAL, 1, &upload);
      f.client.begin_pass(cb, pass, framebuffer, f.whole, {kClearBlack});
      f.bind(cb, pipeline);
      f.color(cb, layout, {});
      VK(f.client, CmdBindDescriptorSets)(cb, VK_PIPELINE_BIND_POINT_GRAPHICS, layout, 0, 1, &sets[variant], 0, nullptr);
      VK(f.client, CmdDraw)(cb, 6, 1, 0, 0);
      VK(f.client, CmdBindDescriptorSets)(cb, VK_PIPELINE_BIND_POINT_GRAPHICS, layout, 0, 1, &sets[0], 0, nullptr);
      VK(f.client, CmdDraw)(cb, 6, 1, 6, 0);
      VK(f.client, CmdEndRenderPass)(cb);
      f.download(cb, f.image);
    });
    for (uint32_t y = 0; y < kSize; ++y) {
      for (uint32_t x = 0; x < kSize; ++x) {
        const uint32_t t = texels.as<uint32_t>()[y * kSize + x];
        const uint32_t swapped = (t & 0xFF00FF00u) | (t & 0xFFu) << 16 | (t >> 16 & 0xFFu);
        const uint32_t mapped = 0xFF000000u | (t & 0xFFu) << 8 | (t >> 8 & 0xFFu);
        const uint32_t expected = x >= kSize / 2 || variant == 0 ? t : variant == 1 ? swapped : mapped;
        ASSERT_EQ(f.at(x, y), expected) << "variant " << variant << " at " << x << ' ' << y;
      }
    }
  }
}

// Depth test, clamp and bias against a D16 attachment: the depth of the quads comes by push constant.
struct DepthFixture : DrawFixture {
  explicit DepthFixture(VkFormat of = VK_FORMAT_D16_UNORM) : depth_format(of) {}

  VkFormat depth_format;
  float cleared = 1.0f;
  PipelineClient::Attachment attachments[2] = {{kFormat, VK_ATTACHMENT_LOAD_OP_CLEAR},
                                               {depth_format, VK_ATTACHMENT_LOAD_OP_CLEAR}};
  static constexpr uint32_t kFirst[] = {0};
  VkRenderPass pass = client.render_pass(attachments, kFirst, 1);
  VkImage depth = target(VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT, depth_format);
  VkFramebuffer framebuffer = client.framebuffer(
      pass, {client.view(image, kFormat), client.view(depth, depth_format, {}, VK_IMAGE_ASPECT_DEPTH_BIT)}, {kSize, kSize});
  VkPipelineLayout layout = client.pipeline_layout(std::nullopt, 20);

  PipelineClient::Drawing drawing() {
    return {.layout = layout, .pass = pass, .vertex = client.module(kDepthVertex), .fragment = client.module(kColorFragment)};
  }
  void quad(VkCommandBuffer cb, uint32_t first_vertex, uint32_t count, std::array<float, 4> value, float z) {
    color(cb, layout, value);
    VK(client, CmdPushConstants)(cb, layout, VK_SHADER_STAGE_ALL, 16, 4, &z);
    VK(client, CmdDraw)(cb, count, 1, first_vertex, 0);
  }
  // Draws over a cleared target and leaves colours in pixels; the result is the depth of two pixels of the first row.
  template <typename Texel = uint16_t, typename Draws>
  std::array<Texel, 2> depths(const PipelineClient::Drawing& with, Draws&& draws) {
    VkPipeline pipeline = VK_NULL_HANDLE;
    EXPECT_EQ(client.graphics_pipeline(with, &pipeline), VK_SUCCESS);
    const auto values = client.buffer(kSize * kSize * sizeof(Texel));
    client.run([&](VkCommandBuffer cb) {
      client.begin_pass(cb, pass, framebuffer, whole, {kClearBlack, {.depthStencil = {cleared, 0}}});
      bind(cb, pipeline);
      draws(cb);
      VK(client, CmdEndRenderPass)(cb);
      download(cb, image);
      const VkBufferImageCopy region{0, 0, 0, {VK_IMAGE_ASPECT_DEPTH_BIT, 0, 0, 1}, {}, {kSize, kSize, 1}};
      VK(client, CmdCopyImageToBuffer)(cb, depth, VK_IMAGE_LAYOUT_GENERAL, values.handle, 1, &region);
    });
    return {values.as<Texel>()[5], values.as<Texel>()[kSize - 5]};
  }
};

TEST(IcdDepth, NearerWins) {
  DepthFixture f;
  const auto depth = f.depths(f.drawing(), [&](VkCommandBuffer cb) {
    f.quad(cb, 0, 12, {1, 0, 0, 1}, 0.5f);
    f.quad(cb, 0, 6, {0, 1, 0, 1}, 0.75f);
    f.quad(cb, 6, 6, {0, 0, 1, 1}, 0.25f);
  });
  EXPECT_EQ(f.at(5, 5), kRed);
  EXPECT_EQ(f.at(35, 5), kBlue);
  EXPECT_EQ(depth[0], 32768);  // 0.5 * 65535 = 32767.5, to even
  EXPECT_EQ(depth[1], 16384);  // 0.25 * 65535 = 16383.75
}

// Without depthClamp z > w is clipped away; with it the fragments have the depth of the viewport's far end.
TEST(IcdDepth, ClampInsteadOfClip) {
  DepthFixture f;
  PipelineClient::Drawing drawing = f.drawing();
  drawing.depth_compare = VK_COMPARE_OP_ALWAYS;
  const auto draw = [&](VkCommandBuffer cb) {
    const VkViewport near_half{0, 0, kSize, kSize, 0, 0.5f};
    VK(f.client, CmdSetViewport)(cb, 0, 1, &near_half);
    f.quad(cb, 0, 12, {0, 1, 0, 1}, 1.5f);
  };
  EXPECT_EQ(f.depths(drawing, draw)[0], 65535);
  EXPECT_EQ(f.at(5, 5), kBlack);
  drawing.depth_clamp = true;
  EXPECT_EQ(f.depths(drawing, draw)[0], 32768);
  EXPECT_EQ(f.at(5, 5), kGreen);
}

// VK_EXT_depth_range_unrestricted: a viewport's range, clear values and depths of float formats may be anywhere; depths of
// fixed-point formats are clamped. z = 0.75 is at -2 + 0.75 * 5 = 1.75, z = 0.125 at -1.375.
TEST(IcdDepth, UnrestrictedRange) {
  const auto draw = [](DepthFixture& f) {
    return [&f](VkCommandBuffer cb) {
      const VkViewport wide{0, 0, kSize, kSize, -2, 3};
      VK(f.client, CmdSetViewport)(cb, 0, 1, &wide);
      f.quad(cb, 0, 12, {0, 1, 0, 1}, 0.75f);
      f.quad(cb, 6, 6, {0, 0, 1, 1}, 0.125f);
      f.quad(cb, 0, 12, {1, 0, 0, 1}, 0.875f);  // at 2.375: behind
    };
  };
  for (const VkBool32 clamp : {VK_FALSE, VK_TRUE}) {
    DepthFixture f(VK_FORMAT_D32_SFLOAT);
    f.cleared = 5;
    PipelineClient::Drawing drawing = f.drawing();
    drawing.depth_clamp = clamp;
    EXPECT_EQ(f.depths<float>(drawing, draw(f)), (std::array{1.75f, -1.375f}));
    EXPECT_EQ(f.at(5, 5), kGreen);
    EXPECT_EQ(f.at(35, 5), kBlue);
  }
  DepthFixture fixed;
  PipelineClient::Drawing drawing = fixed.drawing();
  drawing.depth_compare = VK_COMPARE_OP_LESS_OR_EQUAL;
  EXPECT_EQ(fixed.depths(drawing, draw(fixed)), (std::array<uint16_t, 2>{65535, 0}));
  EXPECT_EQ(fixed.at(5, 5), kRed) << "both at 1";
  EXPECT_EQ(fixed.at(35, 5), kBlue);
}

// A constant factor of 16384 is 16384 * 2^-16 for D16 (the minimum resolvable difference); the clamp stops it at 1/8.
TEST(IcdDepth, BiasAndItsClamp) {
  DepthFixture f;
  PipelineClient::Drawing drawing = f.drawing();
  drawing.depth_bias = 16384;
  const auto draw = [&](VkCommandBuffer cb) { f.quad(cb, 0, 12, {0, 1, 0, 1}, 0.25f); };
  EXPECT_NEAR(f.depths(drawing, draw)[0], 32768, 1);
  drawing.depth_bias_clamp = 0.125f;
  EXPECT_NEAR(f.depths(drawing, draw)[0], 24576, 1);
}

// VK_KHR_maintenance1: a negative height flips y, and with it the winding.
TEST(IcdDraw, NegativeViewportHeight) {
  DrawFixture f;
  constexpr PipelineClient::Attachment kClear[] = {{kFormat, VK_ATTACHMENT_LOAD_OP_CLEAR}};
  constexpr uint32_t kFirst[] = {0};
  const VkRenderPass pass = f.client.render_pass(kClear, kFirst);
  const VkFramebuffer framebuffer = f.client.framebuffer(pass, {f.client.view(f.image, kFormat)}, {kSize, kSize});
  const VkPipelineLayout layout = f.client.pipeline_layout(std::nullopt, 16);
  for (const VkCullModeFlags cull : {VK_CULL_MODE_FRONT_BIT, VK_CULL_MODE_BACK_BIT}) {
    VkPipeline pipeline = VK_NULL_HANDLE;
    ASSERT_EQ(f.client.graphics_pipeline({.layout = layout,
                                          .pass = pass,
                                          .vertex = f.client.module(kColorVertex),
                                          .fragment = f.client.module(kColorFragment),
                                          .cull = cull},
                                         &pipeline),
              VK_SUCCESS);
    f.client.run([&](VkCommandBuffer cb) {
      f.client.begin_pass(cb, pass, framebuffer, f.whole, {kClearBlack});
      f.bind(cb, pipeline);
      f.color(cb, layout, {1, 0, 0, 1});
      const VkViewport top{0, 0, kSize, kSize / 2, 0, 1}, bottom_up{0, kSize, kSize, -float(kSize / 2), 0, 1};
      VK(f.client, CmdSetViewport)(cb, 0, 1, &top);
      VK(f.client, CmdDraw)(cb, 12, 1, 0, 0);
      VK(f.client, CmdSetViewport)(cb, 0, 1, &bottom_up);
      VK(f.client, CmdDraw)(cb, 12, 1, 0, 0);
      VK(f.client, CmdEndRenderPass)(cb);
      f.download(cb, f.image);
    });
    // The quads are clockwise in framebuffer space (y down), that is back-facing; flipped they face front.
    EXPECT_EQ(f.at(5, 5), cull == VK_CULL_MODE_FRONT_BIT ? kRed : kBlack);
    EXPECT_EQ(f.at(5, 35), cull == VK_CULL_MODE_BACK_BIT ? kRed : kBlack);
  }
}

// Each covered pixel adds one, also where the colour is overdrawn later; helper lanes and pixels outside the scissor add nothing.
TEST(IcdDraw, FragmentAtomicsCountPixels) {
  DrawFixture f;
  constexpr PipelineClient::Attachment kClear[] = {{kFormat, VK_ATTACHMENT_LOAD_OP_CLEAR}};
  constexpr uint32_t kFirst[] = {0};
  const VkRenderPass pass = f.client.render_pass(kClear, kFirst);
  const VkFramebuffer framebuffer = f.client.framebuffer(pass, {f.client.view(f.image, kFormat)}, {kSize, kSize});
  const auto set_layout = f.client.set_layout({{0, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, VK_SHADER_STAGE_FRAGMENT_BIT, nullptr}});
  const VkPipelineLayout layout = f.client.pipeline_layout(set_layout, 16);
  const VkDescriptorSet set = f.client.descriptor_set(set_layout);
  const auto count = f.client.buffer(16);
  f.client.write_buffer(set, 0, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, {count.handle, 0, 4});
  VkPipeline pipeline = VK_NULL_HANDLE;
  ASSERT_EQ(
      f.client.graphics_pipeline(
          {.layout = layout, .pass = pass, .vertex = f.client.module(kColorVertex), .fragment = f.client.module(kCountFragment)},
          &pipeline),
      VK_SUCCESS);
  f.client.run([&](VkCommandBuffer cb) {
    f.client.begin_pass(cb, pass, framebuffer, f.whole, {kClearBlack});
    f.bind(cb, pipeline);
    VK(f.client, CmdBindDescriptorSets)(cb, VK_PIPELINE_BIND_POINT_GRAPHICS, layout, 0, 1, &set, 0, nullptr);
    f.color(cb, layout, {1, 0, 0, 1});
    VK(f.client, CmdDraw)(cb, 12, 1, 0, 0);
    VK(f.client, CmdDraw)(cb, 12, 2, 0, 0);
    const VkRect2D scissor{{3, 3}, {7, 5}};
    VK(f.client, CmdSetScissor)(cb, 0, 1, &scissor);
    VK(f.client, CmdDraw)(cb, 12, 1, 0, 0);
    VK(f.client, CmdEndRenderPass)(cb);
  });
  EXPECT_EQ(count.as<uint32_t>()[0], 3 * kSize * kSize + 35);
}

// maxFramebufferWidth and -Height are promises about the rasterizer's arithmetic, too: the seam between the quads is exact at
// 16384.
TEST(IcdDraw, LargestFramebuffer) {
  constexpr uint32_t kLong = 16384, kShort = 3;
  DrawFixture f;
  constexpr PipelineClient::Attachment kClear[] = {{kFormat, VK_ATTACHMENT_LOAD_OP_CLEAR}};
  constexpr uint32_t kFirst[] = {0};
  const VkRenderPass pass = f.client.render_pass(kClear, kFirst);
  const ColorPipeline p(f, pass);
  const auto out = f.client.buffer(kLong * kShort * 4);
  for (const VkExtent3D extent : {VkExtent3D{kLong, kShort, 1}, VkExtent3D{kShort, kLong, 1}}) {
    const VkImage image = f.client.image(kFormat, extent, 1, 1, VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT);
    const VkFramebuffer framebuffer = f.client.framebuffer(pass, {f.client.view(image, kFormat)}, {extent.width, extent.height});
    f.client.run([&](VkCommandBuffer cb) {
      const VkRect2D all{{0, 0}, {extent.width, extent.height}};
      f.client.begin_pass(cb, pass, framebuffer, all, {kClearBlack});
      f.bind(cb, p.pipeline);
      const VkViewport viewport{0, 0, float(extent.width), float(extent.height), 0, 1};
      VK(f.client, CmdSetViewport)(cb, 0, 1, &viewport);
      VK(f.client, CmdSetScissor)(cb, 0, 1, &all);
      f.color(cb, p.layout, {1, 0, 0, 1});
      VK(f.client, CmdDraw)(cb, 6, 1, 0, 0);
      f.color(cb, p.layout, {0, 0, 1, 1});
      VK(f.client, CmdDraw)(cb, 6, 1, 6, 0);
      VK(f.client, CmdEndRenderPass)(cb);
      const VkBufferImageCopy region{0, 0, 0, color_layers(), {}, extent};
      VK(f.client, CmdCopyImageToBuffer)(cb, image, VK_IMAGE_LAYOUT_GENERAL, out.handle, 1, &region);
    });
    for (uint32_t i = 0; i < kLong * kShort; ++i) {
      // A column whose centre is on the seam (odd widths) belongs to the right quad: its left edge is the covering one.
      const bool left = 2 * (i % extent.width) + 1 < extent.width;
      ASSERT_EQ(out.as<uint32_t>()[i], left ? kRed : kBlue)
          << extent.width << ": " << i % extent.width << ' ' << i / extent.width;
    }
  }
}

// Invalid, but not a crash: a pipeline whose kernels store texels of another size, an attachment smaller than the framebuffer.
TEST(IcdDraw, IncompatibleAttachmentsAreHarmless) {
  breaks_on_purpose({"VUID-VkFramebufferCreateInfo-flags-04533", "VUID-VkFramebufferCreateInfo-flags-04534",
                     "VUID-VkRenderPassBeginInfo-pNext-02850", "VUID-vkCmdDraw-renderPass-02684"});
  loses_device();
  DrawFixture f;
  constexpr VkFormat kWide = VK_FORMAT_R32G32B32A32_SFLOAT;
  constexpr PipelineClient::Attachment kNarrowClear[] = {{kFormat, VK_ATTACHMENT_LOAD_OP_CLEAR}};
  constexpr PipelineClient::Attachment kWideClear[] = {{kWide, VK_ATTACHMENT_LOAD_OP_CLEAR}};
  constexpr uint32_t kFirst[] = {0};
  const VkRenderPass narrow = f.client.render_pass(kNarrowClear, kFirst), wide = f.client.render_pass(kWideClear, kFirst);
  const VkFramebuffer too_large = f.client.framebuffer(narrow, {f.client.view(f.image, kFormat)}, {8 * kSize, 8 * kSize});
  f.client.run([&](VkCommandBuffer cb) {
    f.client.begin_pass(cb, narrow, too_large, {{-3, 0}, {8 * kSize, 8 * kSize}}, {kClearBlack});
    VK(f.client, CmdEndRenderPass)(cb);
    f.download(cb, f.image);
  });
  EXPECT_EQ(f.at(kSize - 1, kSize - 1), kBlack);
  const ColorPipeline p(f, wide);
  const VkFramebuffer framebuffer = f.client.framebuffer(narrow, {f.client.view(f.image, kFormat)}, {kSize, kSize});
  const VkCommandBuffer cb = f.client.command_buffer();
  f.client.begin(cb);
  f.client.begin_pass(cb, narrow, framebuffer, f.whole, {kClearBlack});
  f.bind(cb, p.pipeline);
  f.color(cb, p.layout, {1, 0, 0, 1});
  VK(f.client, CmdDraw)(cb, 12, 1, 0, 0);
  VK(f.client, CmdEndRenderPass)(cb);
  EXPECT_EQ(VK(f.client, EndCommandBuffer)(cb), VK_SUCCESS);
  EXPECT_EQ(f.client.submit(cb), VK_ERROR_DEVICE_LOST);
}

TEST(IcdDraw, UnsupportedTopologyIsRefused) {
  breaks_on_purpose(
      {"VUID-VkGraphicsPipelineCreateInfo-topology-00737", "VUID-VkPipelineInputAssemblyStateCreateInfo-topology-00430"});
  DrawFixture f;
  constexpr PipelineClient::Attachment kClear[] = {{kFormat, VK_ATTACHMENT_LOAD_OP_CLEAR}};
  constexpr uint32_t kFirst[] = {0};
  const VkRenderPass pass = f.client.render_pass(kClear, kFirst);
  VkPipeline pipeline;
  EXPECT_EQ(f.client.graphics_pipeline({.layout = f.client.pipeline_layout(std::nullopt, 16),
                                        .pass = pass,
                                        .vertex = f.client.module(kColorVertex),
                                        .fragment = f.client.module(kColorFragment),
                                        .topology = VK_PRIMITIVE_TOPOLOGY_PATCH_LIST},
                                       &pipeline),
            VK_ERROR_FEATURE_NOT_PRESENT);
  EXPECT_EQ(pipeline, VkPipeline(VK_NULL_HANDLE));
}

}  // namespace
}  // namespace pineda::test
