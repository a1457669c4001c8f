// Viewports and layers that the vertex shader chooses, through the API. Every combination's pixels are raster/layers_test.cpp's
// matter.
#include "icd_raster_client.h"

namespace pineda::test {
namespace {

constexpr uint32_t kSize = 24, kLayers = 3, kViewports = 16;

// Viewport v: a cell of 6x6 px in a grid of 4x4, whose scissor leaves out its last row.
VkViewport cell(uint32_t v) { return {static_cast<float>(v % 4 * 6), static_cast<float>(v / 4 * 6), 6, 6, 0, 1}; }
VkRect2D cell_scissor(uint32_t v) { return {{int32_t(v % 4 * 6), int32_t(v / 4 * 6)}, {6, 5}}; }

// Instances viewport + layer * kViewports of the cover of a viewport.
void draw_cells(RasterClient& client, VkCommandBuffer cb, VkPipeline pipeline, uint32_t first_layer, uint32_t layers) {
  client.bind(cb, pipeline);
  const int32_t count = kViewports;
  VK(client, CmdPushConstants)(cb, client.layout, VK_SHADER_STAGE_ALL, 0, 4, &count);
  std::array<VkViewport, kViewports> cells;
  std::array<VkRect2D, kViewports> scissors;
  for (uint32_t v = 0; v < kViewports; ++v) {
    cells[v] = cell(v);
    scissors[v] = cell_scissor(v);
  }
  VK(client, CmdSetViewport)(cb, 0, 5, cells.data());  // in pieces
  VK(client, CmdSetViewport)(cb, 5, 11, cells.data() + 5);
  VK(client, CmdSetScissor)(cb, 0, kViewports, scissors.data());
  VK(client, CmdDraw)(cb, 3, kViewports * layers, 0, kViewports * first_layer);
}

TEST(IcdLayers, SixteenViewportsInThreeLayersWithEverySampleCount) {
  for (const uint32_t samples : {1u, 4u}) {
    RasterClient client({.width = kSize, .height = kSize, .layers = kLayers, .samples = samples, .resolves = samples > 1},
                        {VK_KHR_CREATE_RENDERPASS_2_EXTENSION_NAME, VK_EXT_SHADER_VIEWPORT_INDEX_LAYER_EXTENSION_NAME});
    VkPhysicalDeviceFeatures features;
    VK(client, GetPhysicalDeviceFeatures)(client.physical, &features);
    EXPECT_TRUE(features.multiViewport);
    VkPhysicalDeviceProperties properties;
    VK(client, GetPhysicalDeviceProperties)(client.physical, &properties);
    EXPECT_EQ(properties.limits.maxViewports, kViewports);
    client.set_cover();
    client.clear.color = {{0, 1, 0, 1}};
    const VkPipeline pipeline = client.pipeline({.viewports = kViewports}, kRouteVertex, kRouteFragment);
    client.run([&](VkCommandBuffer cb) {
      client.begin(cb);
      draw_cells(client, cb, pipeline, 0, 2);  // layer 2 shows the clear alone
      const VkClearAttachment attachment{VK_IMAGE_ASPECT_COLOR_BIT, 0, {{{0, 0, 1, 1}}}};
      const VkClearRect rect{{{1, 0}, {2, 3}}, 1, 2};
      VK(client, CmdClearAttachments)(cb, 1, &attachment, 1, &rect);
      client.end(cb);
      client.download(cb, samples > 1 ? client.resolved : client.color);
    });
    for (uint32_t layer = 0; layer < kLayers; ++layer) {
      for (uint32_t y = 0; y < kSize; ++y) {
        for (uint32_t x = 0; x < kSize; ++x) {
          const uint32_t viewport = y / 6 * 4 + x / 6, instance = viewport + layer * kViewports;
          uint32_t want = 0xFF00FF00;
          if (layer < 2 && y % 6 < 5) want = 0xFF000000 | instance << 16 | viewport << 8 | layer;
          if (layer >= 1 && x >= 1 && x < 3 && y < 3) want = 0xFFFF0000;
          ASSERT_EQ(client.at(x, y, layer), want) << x << ' ' << y << " layer " << layer << " samples " << samples;
        }
      }
    }
  }
}

// A second subpass reads the first one's attachment: each layer its own.
TEST(IcdLayers, InputAttachmentsOfEveryLayer) {
  RasterClient client({.width = kSize, .height = kSize, .layers = kLayers},
                      {VK_KHR_CREATE_RENDERPASS_2_EXTENSION_NAME, VK_EXT_SHADER_VIEWPORT_INDEX_LAYER_EXTENSION_NAME});
  client.set_cover();
  RasterClient::Drawing drawing{.viewports = kViewports};
  const VkDescriptorSetLayout set_layout =
      client.set_layout({{0, VK_DESCRIPTOR_TYPE_INPUT_ATTACHMENT, 1, VK_SHADER_STAGE_FRAGMENT_BIT, nullptr}});
  const VkDescriptorPoolSize size{VK_DESCRIPTOR_TYPE_INPUT_ATTACHMENT, 1};
  const VkDescriptorPoolCreateInfo pool_info{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO, nullptr, 0, 1, 1, &size};
  VkDescriptorPool pool = VK_NULL_HANDLE;
  ASSERT_EQ(VK(client, CreateDescriptorPool)(client.device, &pool_info, nullptr, &pool), VK_SUCCESS);
  client.defer([&client, pool] { VK(client, DestroyDescriptorPool)(client.device, pool, nullptr); });
  const VkDescriptorSetAllocateInfo allocate{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO, nullptr, pool, 1, &set_layout};
  VkDescriptorSet set = VK_NULL_HANDLE;
  ASSERT_EQ(VK(client, AllocateDescriptorSets)(client.device, &allocate, &set), VK_SUCCESS);

  // Two subpasses over the client's image and another of the same shape.
  const VkImage second = client.image(client.info.color, {kSize, kSize, 1}, 1, kLayers, VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT);
  const VkImageView views[] = {client.array_view(client.color, client.info.color, VK_IMAGE_ASPECT_COLOR_BIT),
                               client.array_view(second, client.info.color, VK_IMAGE_ASPECT_COLOR_BIT)};
  const VkAttachmentDescription description{0,
                                            client.info.color,
                                            VK_SAMPLE_COUNT_1_BIT,
                                            VK_ATTACHMENT_LOAD_OP_CLEAR,
                                            VK_ATTACHMENT_STORE_OP_STORE,
                                            VK_ATTACHMENT_LOAD_OP_DONT_CARE,
                                            VK_ATTACHMENT_STORE_OP_DONT_CARE,
                                            VK_IMAGE_LAYOUT_UNDEFINED,
                                            VK_IMAGE_LAYOUT_GENERAL};
  const VkAttachmentDescription descriptions[] = {description, description};
  const VkAttachmentReference references[] = {{0, VK_IMAGE_LAYOUT_GENERAL}, {1, VK_IMAGE_LAYOUT_GENERAL}};
  VkSubpassDescription subpasses[2]{};
  for (uint32_t i = 0; i < 2; ++i) {
    subpasses[i].colorAttachmentCount = 1;
    subpasses[i].pColorAttachments = &references[i];
  }
  subpasses[1].inputAttachmentCount = 1;
  subpasses[1].pInputAttachments = &references[0];
  const std::vector<VkSubpassDependency> dependencies = dependencies_of(2);
  const VkRenderPassCreateInfo pass_info{VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO,
                                         nullptr,
                                         0,
                                         2,
                                         descriptions,
                                         2,
                                         subpasses,
                                         static_cast<uint32_t>(dependencies.size()),
                                         dependencies.data()};
  VkRenderPass pass = VK_NULL_HANDLE;
  ASSERT_EQ(VK(client, CreateRenderPass)(client.device, &pass_info, nullptr, &pass), VK_SUCCESS);
  client.defer([&client, pass] { VK(client, DestroyRenderPass)(client.device, pass, nullptr); });
  const VkFramebufferCreateInfo frame_info{
      VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO, nullptr, 0, pass, 2, views, kSize, kSize, kLayers};
  VkFramebuffer frame = VK_NULL_HANDLE;
  ASSERT_EQ(VK(client, CreateFramebuffer)(client.device, &frame_info, nullptr, &frame), VK_SUCCESS);
  client.defer([&client, frame] { VK(client, DestroyFramebuffer)(client.device, frame, nullptr); });
  client.write_image(set, 0, VK_DESCRIPTOR_TYPE_INPUT_ATTACHMENT, views[0]);
  const VkPipelineLayout reading_layout = client.pipeline_layout(set_layout, 16);
  drawing.pass = pass;
  const VkPipeline write = client.pipeline(drawing, kRouteVertex, kRouteFragment);
  drawing.layout = reading_layout;
  drawing.subpass = 1;
  drawing.vertex = client.module(kRouteVertex);
  drawing.fragment = client.module(kRouteInputFragment);
  VkPipeline read = VK_NULL_HANDLE;
  ASSERT_EQ(client.graphics_pipeline(drawing, &read), VK_SUCCESS);
  client.run([&](VkCommandBuffer cb) {
    client.begin_pass(cb, pass, frame, client.whole, std::vector<VkClearValue>(2, VkClearValue{}));
    draw_cells(client, cb, write, 0, kLayers);
    VK(client, CmdNextSubpass)(cb, VK_SUBPASS_CONTENTS_INLINE);
    VK(client, CmdBindDescriptorSets)(cb, VK_PIPELINE_BIND_POINT_GRAPHICS, reading_layout, 0, 1, &set, 0, nullptr);
    draw_cells(client, cb, read, 0, kLayers);
    client.end(cb);
    client.download(cb, second);
  });
  for (uint32_t layer = 0; layer < kLayers; ++layer) {
    for (uint32_t y = 0; y < kSize; ++y) {
      for (uint32_t x = 0; x < kSize; ++x) {
        const uint32_t viewport = y / 6 * 4 + x / 6, instance = viewport + layer * kViewports;
        const uint32_t want = y % 6 < 5 ? 0xFF000000 | (instance + 0x80) << 16 | viewport << 8 | layer : 0;
        ASSERT_EQ(client.at(x, y, layer), want) << x << ' ' << y << " layer " << layer;
      }
    }
  }
}

}  // namespace
}  // namespace pineda::test
