// Kinds of primitives through the API: points, lines, polygon modes, clip distances, provoking vertices, 8-bit indices. What
// exactly each covers is raster/line_test.cpp's matter.
#include "icd_pipeline_client.h"
#include "icd_shaders.h"

namespace pineda::test {
namespace {

constexpr VkFormat kFormat = VK_FORMAT_R8G8B8A8_UNORM;
constexpr uint32_t kSize = 32;
constexpr uint32_t kBlack = 0xFF000000;

struct Vertex {
  float x_px, y_px, u, v;
};

// Draws vertices (positions in pixels) to a black picture.
struct PrimitivesFixture {
  PipelineClient client{nullptr,
                        {},
                        {VK_EXT_LINE_RASTERIZATION_EXTENSION_NAME, VK_EXT_PROVOKING_VERTEX_EXTENSION_NAME,
                         VK_EXT_INDEX_TYPE_UINT8_EXTENSION_NAME, VK_EXT_DEPTH_CLIP_ENABLE_EXTENSION_NAME}};
  VkImage image = client.image(kFormat, {kSize, kSize, 1}, 1, 1, VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT);
  Client::Buffer pixels = client.buffer(kSize * kSize * 4), vertices = client.buffer(64 * 16), indices = client.buffer(64);
  VkRenderPass pass = make_pass();

  VkRenderPass make_pass() {
    constexpr PipelineClient::Attachment kClear[] = {{kFormat, VK_ATTACHMENT_LOAD_OP_CLEAR}};
    constexpr uint32_t kFirst[] = {0};
    return client.render_pass(kClear, kFirst);
  }

  void draw(PipelineClient::Drawing drawing, std::vector<Vertex> list, std::vector<uint8_t> index = {},
            std::span<const uint32_t> fragment = kFlatFragment) {
    for (size_t i = 0; i < list.size(); ++i) {
      float* v = vertices.as<float>() + i * 4;
      v[0] = list[i].x_px / (kSize / 2) - 1;
      v[1] = list[i].y_px / (kSize / 2) - 1;
      v[2] = list[i].u;
      v[3] = list[i].v;
    }
    std::ranges::copy(index, indices.as<uint8_t>());
    drawing.layout = client.pipeline_layout(std::nullopt, 0);
    drawing.pass = pass;
    drawing.vertex = client.module(kPrimitivesVertex);
    drawing.fragment = client.module(fragment);
    VkPipeline pipeline = VK_NULL_HANDLE;
    ASSERT_EQ(client.graphics_pipeline(drawing, &pipeline), VK_SUCCESS);
    const VkFramebuffer framebuffer = client.framebuffer(pass, {client.view(image, kFormat)}, {kSize, kSize});
    client.run([&](VkCommandBuffer cb) {
      client.begin_pass(cb, pass, framebuffer, {{0, 0}, {kSize, kSize}}, {{{{0, 0, 0, 1}}}});
      VK(client, CmdBindPipeline)(cb, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline);
      const VkViewport viewport{0, 0, kSize, kSize, 0, 1};
      const VkRect2D whole{{0, 0}, {kSize, kSize}};
      VK(client, CmdSetViewport)(cb, 0, 1, &viewport);
      VK(client, CmdSetScissor)(cb, 0, 1, &whole);
      const VkDeviceSize zero = 0;
      VK(client, CmdBindVertexBuffers)(cb, 0, 1, &vertices.handle, &zero);
      if (index.empty()) {
        VK(client, CmdDraw)(cb, static_cast<uint32_t>(list.size()), 1, 0, 0);
      } else {
        VK(client, CmdBindIndexBuffer)(cb, indices.handle, 0, VK_INDEX_TYPE_UINT8_EXT);
        VK(client, CmdDrawIndexed)(cb, static_cast<uint32_t>(index.size()), 1, 0, 0, 0);
      }
      VK(client, CmdEndRenderPass)(cb);
      const VkBufferImageCopy region{0, 0, 0, color_layers(), {}, {kSize, kSize, 1}};
      VK(client, CmdCopyImageToBuffer)(cb, image, VK_IMAGE_LAYOUT_GENERAL, pixels.handle, 1, &region);
    });
  }
  uint32_t at(uint32_t x, uint32_t y) const { return pixels.as<uint32_t>()[y * kSize + x]; }
  uint32_t drawn() const {
    uint32_t count = 0;
    for (uint32_t i = 0; i < kSize * kSize; ++i) count += pixels.as<uint32_t>()[i] != kBlack;
    return count;
  }
};

TEST(IcdPrimitives, PointsHaveASizeAndCoordinates) {
  PrimitivesFixture f;
  f.draw({.topology = VK_PRIMITIVE_TOPOLOGY_POINT_LIST}, {{16, 16, 1, 0}}, {}, kPointCoordFragment);
  EXPECT_EQ(f.drawn(), 64u);
  for (uint32_t i = 0; i < 8; ++i) {  // (i + 1/2) / 8 of 255, rounded
    const auto expected = static_cast<uint32_t>((2 * i + 1) * 255.0 / 16 + 0.5);
    EXPECT_EQ(f.at(12 + i, 12) & 0xFF, expected);
    EXPECT_EQ(f.at(12, 12 + i) >> 8 & 0xFF, expected);
  }
}

TEST(IcdPrimitives, BresenhamLinesAndTheLastProvokingVertex) {
  PrimitivesFixture f;
  VkPipelineRasterizationLineStateCreateInfoEXT line{VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_LINE_STATE_CREATE_INFO_EXT};
  line.lineRasterizationMode = VK_LINE_RASTERIZATION_MODE_BRESENHAM_EXT;
  VkPipelineRasterizationProvokingVertexStateCreateInfoEXT provoking{
      VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_PROVOKING_VERTEX_STATE_CREATE_INFO_EXT, &line};
  for (const bool last : {false, true}) {
    provoking.provokingVertexMode = last ? VK_PROVOKING_VERTEX_MODE_LAST_VERTEX_EXT : VK_PROVOKING_VERTEX_MODE_FIRST_VERTEX_EXT;
    f.draw({.topology = VK_PRIMITIVE_TOPOLOGY_LINE_STRIP, .rasterization_next = &provoking},
           {{2.5f, 5.5f, 1, 0}, {12.5f, 5.5f, 1, 1}});
    EXPECT_EQ(f.drawn(), 10u);
    for (uint32_t x = 2; x < 12; ++x) EXPECT_EQ(f.at(x, 5), last ? 0xFF00FFFFu : 0xFF0000FFu);
  }
}

TEST(IcdPrimitives, PolygonModesDrawTheOutline) {
  PrimitivesFixture f;
  const std::vector<Vertex> triangle{{4.5f, 4.5f, 1, 0}, {24.5f, 4.5f, 1, 0}, {4.5f, 24.5f, 1, 0}};
  f.draw({.polygon_mode = VK_POLYGON_MODE_LINE}, triangle);
  EXPECT_NE(f.at(10, 4), kBlack);
  EXPECT_NE(f.at(4, 10), kBlack);
  EXPECT_EQ(f.at(8, 8), kBlack);
  f.draw({.polygon_mode = VK_POLYGON_MODE_POINT}, triangle);  // of 8 px
  EXPECT_EQ(f.drawn(), 3 * 64u);
}

TEST(IcdPrimitives, ClipDistancesCut) {
  PrimitivesFixture f;
  f.draw({.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_STRIP}, {{0, 0, 0, 0}, {32, 0, 1, 0}, {0, 32, 0, 0}, {32, 32, 1, 0}});
  uint32_t left = 0;  // flat colours: u of the provoking vertices is 0 and 1
  for (uint32_t x = 0; x < kSize; ++x) left += f.at(x, 30) == kBlack;
  EXPECT_EQ(left, 8u);
}

TEST(IcdPrimitives, EightBitIndices) {
  PrimitivesFixture f;
  const std::vector<Vertex> corners{{0, 0, 1, 1}, {32, 0, 1, 1}, {0, 32, 1, 1}, {32, 32, 1, 1}};
  f.draw({}, corners, {0, 1, 2, 2, 1, 3});
  EXPECT_EQ(f.drawn(), kSize * kSize);
}

}  // namespace
}  // namespace pineda::test
