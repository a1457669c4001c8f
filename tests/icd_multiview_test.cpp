// Multiview, imageless framebuffers, and the parameters of draws.
#include "icd_pipeline_client.h"
#include "icd_shaders_driver.h"

namespace pineda::test {
namespace {

constexpr VkFormat kFormat = VK_FORMAT_R8G8B8A8_UNORM;
constexpr uint32_t kSize = 8, kLayers = 3;
constexpr uint32_t kClear = 0xFF000033;                                                  // of clear colour (0.2, 0, 0, 1)
constexpr uint32_t view_color(uint32_t view) { return 0xFF000000u | view << 9 | view; }  // kViewFragment

// Layers of an image, and two quads: vertices 0..5 cover the left half, 6..11 the right one.
struct ViewsFixture {
  PipelineClient client;
  VkImage image = client.image(kFormat, {kSize, kSize, 1}, 1, kLayers, VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT);
  VkImageView view = VK_NULL_HANDLE;
  Client::Buffer pixels = client.buffer(kSize * kSize * 4 * kLayers);
  Client::Buffer vertices = client.buffer(12 * 16);

  explicit ViewsFixture(std::initializer_list<const char*> extensions = {}) : client(nullptr, {}, extensions) {
    VkImageViewCreateInfo info{VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO};
    info.image = image;
    info.viewType = VK_IMAGE_VIEW_TYPE_2D_ARRAY;
    info.format = kFormat;
    info.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, kLayers};
    EXPECT_EQ(VK(client, CreateImageView)(client.device, &info, nullptr, &view), VK_SUCCESS);
    client.defer([this] { VK(client, DestroyImageView)(client.device, view, nullptr); });
    for (int quad = 0; quad < 2; ++quad) {
      const float x0 = float(quad) - 1, x1 = float(quad);
      const float corners[6][2] = {{x0, -1}, {x1, -1}, {x0, 1}, {x0, 1}, {x1, -1}, {x1, 1}};
      for (int i = 0; i < 6; ++i) std::memcpy(vertices.data + (quad * 6 + i) * 16, corners[i], 8);
    }
  }

  void draw(VkCommandBuffer cb, VkPipeline pipeline, uint32_t first_vertex) {
    VK(client, CmdBindPipeline)(cb, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline);
    const VkViewport viewport{0, 0, kSize, kSize, 0, 1};
    const VkRect2D scissor{{0, 0}, {kSize, kSize}};
    VK(client, CmdSetViewport)(cb, 0, 1, &viewport);
    VK(client, CmdSetScissor)(cb, 0, 1, &scissor);
    const VkDeviceSize zero = 0;
    VK(client, CmdBindVertexBuffers)(cb, 0, 1, &vertices.handle, &zero);
    VK(client, CmdDraw)(cb, 6, 1, first_vertex, 0);
  }
  void download(VkCommandBuffer cb) {
    const VkBufferImageCopy region{0, 0, 0, color_layers(0, 0, kLayers), {}, {kSize, kSize, 1}};
    VK(client, CmdCopyImageToBuffer)(cb, image, VK_IMAGE_LAYOUT_GENERAL, pixels.handle, 1, &region);
  }
  void expect(uint32_t layer, uint32_t left, uint32_t right) {
    for (uint32_t i = 0; i < kSize * kSize; ++i) {
      ASSERT_EQ(pixels.as<uint32_t>()[layer * kSize * kSize + i], i % kSize < kSize / 2 ? left : right)
          << "layer " << layer << " pixel " << i;
    }
  }

  // Two subpasses with the views 0 and 2, and 0 and 1; made by either version of the command.
  VkRenderPass render_pass(bool second_version) {
    constexpr uint32_t kMasks[] = {0b101, 0b011};
    VkRenderPass out = VK_NULL_HANDLE;
    const std::vector<VkSubpassDependency> dependencies = dependencies_of(2);
    if (!second_version) {
      const VkAttachmentDescription attachment{0,
                                               kFormat,
                                               VK_SAMPLE_COUNT_1_BIT,
                                               VK_ATTACHMENT_LOAD_OP_CLEAR,
                                               VK_ATTACHMENT_STORE_OP_STORE,
                                               VK_ATTACHMENT_LOAD_OP_DONT_CARE,
                                               VK_ATTACHMENT_STORE_OP_DONT_CARE,
                                               VK_IMAGE_LAYOUT_UNDEFINED,
                                               VK_IMAGE_LAYOUT_GENERAL};
      const VkAttachmentReference color{0, VK_IMAGE_LAYOUT_GENERAL};
      VkSubpassDescription subpasses[2]{};
      for (VkSubpassDescription& subpass : subpasses) {
        subpass.colorAttachmentCount = 1;
        subpass.pColorAttachments = &color;
      }
      const VkRenderPassMultiviewCreateInfo views{
          VK_STRUCTURE_TYPE_RENDER_PASS_MULTIVIEW_CREATE_INFO, nullptr, 2, kMasks, 0, nullptr, 0, nullptr};
      const VkRenderPassCreateInfo info{VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO,
                                        &views,
                                        0,
                                        1,
                                        &attachment,
                                        2,
                                        subpasses,
                                        static_cast<uint32_t>(dependencies.size()),
                                        dependencies.data()};
      EXPECT_EQ(VK(client, CreateRenderPass)(client.device, &info, nullptr, &out), VK_SUCCESS);
    } else {
      VkAttachmentDescription2 attachment{VK_STRUCTURE_TYPE_ATTACHMENT_DESCRIPTION_2};
      attachment.format = kFormat;
      attachment.samples = VK_SAMPLE_COUNT_1_BIT;
      attachment.loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR;
      attachment.finalLayout = VK_IMAGE_LAYOUT_GENERAL;
      const VkAttachmentReference2 color{VK_STRUCTURE_TYPE_ATTACHMENT_REFERENCE_2, nullptr, 0, VK_IMAGE_LAYOUT_GENERAL,
                                         VK_IMAGE_ASPECT_COLOR_BIT};
      VkSubpassDescription2 subpasses[2]{};
      for (int i = 0; i < 2; ++i) {
        subpasses[i].sType = VK_STRUCTURE_TYPE_SUBPASS_DESCRIPTION_2;
        subpasses[i].viewMask = kMasks[i];
        subpasses[i].colorAttachmentCount = 1;
        subpasses[i].pColorAttachments = &color;
      }
      VkRenderPassCreateInfo2 info{VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO_2};
      info.attachmentCount = 1;
      info.pAttachments = &attachment;
      info.subpassCount = 2;
      info.pSubpasses = subpasses;
      const std::vector<VkSubpassDependency2> second_dependencies = dependencies2_of(2);
      info.dependencyCount = static_cast<uint32_t>(second_dependencies.size());
      info.pDependencies = second_dependencies.data();
      EXPECT_EQ(VK(client, CreateRenderPass2KHR)(client.device, &info, nullptr, &out), VK_SUCCESS);
    }
    client.defer([this, out] { VK(client, DestroyRenderPass)(client.device, out, nullptr); });
    return out;
  }
  VkPipeline pipeline(VkRenderPass pass, uint32_t subpass, std::span<const uint32_t> vertex, std::span<const uint32_t> fragment,
                      VkPipelineLayout layout = VK_NULL_HANDLE) {
    VkPipeline out = VK_NULL_HANDLE;
    EXPECT_EQ(client.graphics_pipeline({.layout = layout ? layout : client.pipeline_layout({}, 0),
                                        .pass = pass,
                                        .subpass = subpass,
                                        .vertex = client.module(vertex),
                                        .fragment = client.module(fragment)},
                                       &out),
              VK_SUCCESS);
    return out;
  }
};

class IcdMultiview : public testing::TestWithParam<bool> {};

// Views 0 and 2 get the left quad, views 0 and 1 the right one; each view is cleared where it is first used. An occlusion query
// uses one query for each view. With the second version of the commands, the framebuffer is imageless.
TEST_P(IcdMultiview, EachViewDrawsToItsLayer) {
  const bool second_version = GetParam();
  ViewsFixture f({VK_KHR_CREATE_RENDERPASS_2_EXTENSION_NAME, VK_KHR_IMAGELESS_FRAMEBUFFER_EXTENSION_NAME});
  ASSERT_EQ(f.client.result, VK_SUCCESS);
  const VkRenderPass pass = f.render_pass(second_version);
  const VkPipeline left = f.pipeline(pass, 0, kViewVertex, kViewFragment),
                   right = f.pipeline(pass, 1, kViewVertex, kViewFragment);
  VkFramebufferAttachmentImageInfo image_info{VK_STRUCTURE_TYPE_FRAMEBUFFER_ATTACHMENT_IMAGE_INFO};
  image_info.usage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT;
  image_info.width = image_info.height = kSize;
  image_info.layerCount = kLayers;
  image_info.viewFormatCount = 1;
  image_info.pViewFormats = &kFormat;
  const VkFramebufferAttachmentsCreateInfo attachments{VK_STRUCTURE_TYPE_FRAMEBUFFER_ATTACHMENTS_CREATE_INFO, nullptr, 1,
                                                       &image_info};
  VkFramebufferCreateInfo framebuffer_info{VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO, second_version ? &attachments : nullptr};
  framebuffer_info.flags = second_version ? VkFramebufferCreateFlags(VK_FRAMEBUFFER_CREATE_IMAGELESS_BIT) : 0;
  framebuffer_info.renderPass = pass;
  framebuffer_info.attachmentCount = 1;
  framebuffer_info.pAttachments = second_version ? nullptr : &f.view;
  framebuffer_info.width = framebuffer_info.height = kSize;
  framebuffer_info.layers = 1;
  VkFramebuffer framebuffer = VK_NULL_HANDLE;
  ASSERT_EQ(VK(f.client, CreateFramebuffer)(f.client.device, &framebuffer_info, nullptr, &framebuffer), VK_SUCCESS);
  f.client.defer([&] { VK(f.client, DestroyFramebuffer)(f.client.device, framebuffer, nullptr); });
  const VkQueryPoolCreateInfo query_info{VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO, nullptr, 0, VK_QUERY_TYPE_OCCLUSION, 3, 0};
  VkQueryPool queries = VK_NULL_HANDLE;
  ASSERT_EQ(VK(f.client, CreateQueryPool)(f.client.device, &query_info, nullptr, &queries), VK_SUCCESS);
  f.client.defer([&] { VK(f.client, DestroyQueryPool)(f.client.device, queries, nullptr); });

  f.client.run([&](VkCommandBuffer cb) {
    VK(f.client, CmdResetQueryPool)(cb, queries, 0, 3);
    const VkClearValue clear{{{0.2f, 0, 0, 1}}};
    const VkRenderPassAttachmentBeginInfo views{VK_STRUCTURE_TYPE_RENDER_PASS_ATTACHMENT_BEGIN_INFO, nullptr, 1, &f.view};
    const VkRenderPassBeginInfo begin{VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO,
                                      second_version ? &views : nullptr,
                                      pass,
                                      framebuffer,
                                      {{0, 0}, {kSize, kSize}},
                                      1,
                                      &clear};
    const VkSubpassBeginInfo contents{VK_STRUCTURE_TYPE_SUBPASS_BEGIN_INFO, nullptr, VK_SUBPASS_CONTENTS_INLINE};
    const VkSubpassEndInfo end{VK_STRUCTURE_TYPE_SUBPASS_END_INFO};
    if (second_version) {
      VK(f.client, CmdBeginRenderPass2KHR)(cb, &begin, &contents);
    } else {
      VK(f.client, CmdBeginRenderPass)(cb, &begin, VK_SUBPASS_CONTENTS_INLINE);
    }
    VK(f.client, CmdBeginQuery)(cb, queries, 0, 0);
    f.draw(cb, left, 0);
    VK(f.client, CmdEndQuery)(cb, queries, 0);
    if (second_version) {
      VK(f.client, CmdNextSubpass2KHR)(cb, &contents, &end);
    } else {
      VK(f.client, CmdNextSubpass)(cb, VK_SUBPASS_CONTENTS_INLINE);
    }
    f.draw(cb, right, 6);
    second_version ? VK(f.client, CmdEndRenderPass2KHR)(cb, &end) : VK(f.client, CmdEndRenderPass)(cb);
    f.download(cb);
  });
  f.expect(0, view_color(0), view_color(0));
  f.expect(1, kClear, view_color(1));
  f.expect(2, view_color(2), kClear);
  uint32_t samples[2] = {};
  EXPECT_EQ(VK(f.client, GetQueryPoolResults)(f.client.device, queries, 0, 2, sizeof(samples), samples, 4, 0), VK_SUCCESS);
  EXPECT_NE(samples[0], 0u);
  EXPECT_NE(samples[1], 0u);
}

INSTANTIATE_TEST_SUITE_P(Icd, IcdMultiview, testing::Bool(),
                         [](const auto& info) { return std::string(info.param ? "second_version" : "first_version"); });

// gl_DrawID, gl_BaseVertex and gl_BaseInstance of an indirect draw of two.
TEST(IcdDrawParameters, ReachTheShader) {
  ViewsFixture f;
  ASSERT_EQ(f.client.result, VK_SUCCESS);
  constexpr PipelineClient::Attachment kAttachment[] = {{kFormat, VK_ATTACHMENT_LOAD_OP_CLEAR}};
  constexpr uint32_t kSubpass[] = {0};
  const VkRenderPass pass = f.client.render_pass(kAttachment, kSubpass);
  const VkFramebuffer framebuffer = f.client.framebuffer(pass, {f.view}, {kSize, kSize});
  const VkPipeline pipeline = f.pipeline(pass, 0, kDrawParametersVertex, kDrawParametersFragment);
  // Both quads over the whole width, which the shader halves and moves by gl_DrawID.
  for (int i = 0; i < 12; ++i) {
    const float corners[6][2] = {{-1, -1}, {1, -1}, {-1, 1}, {-1, 1}, {1, -1}, {1, 1}};
    std::memcpy(f.vertices.data + i * 16, corners[i % 6], 8);
  }
  const auto indirect = f.client.buffer(2 * sizeof(VkDrawIndirectCommand));
  indirect.as<VkDrawIndirectCommand>()[0] = {6, 1, 0, 5};
  indirect.as<VkDrawIndirectCommand>()[1] = {6, 1, 6, 9};
  f.client.run([&](VkCommandBuffer cb) {
    f.client.begin_pass(cb, pass, framebuffer, {{0, 0}, {kSize, kSize}}, {VkClearValue{}});
    f.draw(cb, pipeline, 0);  // binds; drawn over below
    VK(f.client, CmdDrawIndirect)(cb, indirect.handle, 0, 2, sizeof(VkDrawIndirectCommand));
    VK(f.client, CmdEndRenderPass)(cb);
    f.download(cb);
  });
  f.expect(0, 0xFF050000, 0xFF090601);
}

// vertexPipelineStoresAndAtomics: every vertex that is drawn runs at least once, and no other.
TEST(IcdVertexStores, ReachTheBuffer) {
  ViewsFixture f;
  VkPhysicalDeviceFeatures features;
  VK(f.client, GetPhysicalDeviceFeatures)(f.client.physical, &features);
  ASSERT_TRUE(features.vertexPipelineStoresAndAtomics);
  constexpr PipelineClient::Attachment kAttachment[] = {{kFormat, VK_ATTACHMENT_LOAD_OP_CLEAR}};
  constexpr uint32_t kSubpass[] = {0};
  const VkRenderPass pass = f.client.render_pass(kAttachment, kSubpass);
  const VkFramebuffer framebuffer = f.client.framebuffer(pass, {f.view}, {kSize, kSize});
  const VkDescriptorSetLayout set_layout =
      f.client.set_layout({{0, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, VK_SHADER_STAGE_VERTEX_BIT, nullptr}});
  const VkPipelineLayout layout = f.client.pipeline_layout(set_layout, 0);
  const VkDescriptorSet set = f.client.descriptor_set(set_layout);
  const auto buffer = f.client.buffer(512);
  f.client.write_buffer(set, 0, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, {buffer.handle, 0, VK_WHOLE_SIZE});
  const VkPipeline pipeline = f.pipeline(pass, 0, kStoresVertex, kDrawParametersFragment, layout);
  f.client.run([&](VkCommandBuffer cb) {
    f.client.begin_pass(cb, pass, framebuffer, {{0, 0}, {kSize, kSize}}, {VkClearValue{}});
    VK(f.client, CmdBindDescriptorSets)(cb, VK_PIPELINE_BIND_POINT_GRAPHICS, layout, 0, 1, &set, 0, nullptr);
    f.draw(cb, pipeline, 3);
    VK(f.client, CmdEndRenderPass)(cb);
  });
  for (uint32_t i = 0; i < 12; ++i) EXPECT_EQ(buffer.as<uint32_t>()[i], i >= 3 && i < 9 ? i * 3 + 1 : 0) << i;
  EXPECT_EQ(buffer.as<uint32_t>()[100], 0x1F8u);
}

}  // namespace
}  // namespace pineda::test
