// Multisampled render passes, resolves, stencil and queries through the API, against exact integer coverage.
#include <cmath>

#include "base/sample_locations.h"
#include "icd_pipeline_client.h"
#include "icd_shaders.h"

namespace pineda::test {
namespace {

constexpr VkFormat kColor = VK_FORMAT_R8G8B8A8_UNORM;
constexpr uint32_t kSize = 40;
constexpr VkRect2D kWhole{{0, 0}, {kSize, kSize}};

struct Corner {
  int x_fx8, y_fx8;
};
// A clockwise triangle, in 1/256 px.
constexpr Corner kTriangle[3] = {{900, 577}, {9400, 2437}, {2816, 9472}};

// Whether (x, y), in 1/256 px, is inside by the top-left rule.
bool inside(int x, int y) {
  for (int k = 0; k < 3; ++k) {
    const Corner &p = kTriangle[k], &q = kTriangle[(k + 1) % 3];
    const int64_t dx = q.x_fx8 - p.x_fx8, dy = q.y_fx8 - p.y_fx8;
    const int64_t e = dx * (y - p.y_fx8) - dy * (x - p.x_fx8);
    const bool top_left = dy < 0 || (dy == 0 && dx > 0);
    if (e < 0 || (e == 0 && !top_left)) return false;
  }
  return true;
}

uint32_t covered_samples(uint32_t x, uint32_t y, uint32_t samples) {
  uint32_t count = 0;
  for (uint32_t s = 0; s < samples; ++s) {
    const SampleLocation at = sample_locations(samples)[s];
    count += inside(static_cast<int>(x * 256 + at.x * 16), static_cast<int>(y * 256 + at.y * 16));
  }
  return count;
}

uint32_t all_covered_samples(uint32_t samples) {
  uint32_t sum = 0;
  for (uint32_t y = 0; y < kSize; ++y)
    for (uint32_t x = 0; x < kSize; ++x) sum += covered_samples(x, y, samples);
  return sum;
}

struct PassInfo {
  uint32_t samples = 1;
  VkFormat depth_stencil = VK_FORMAT_UNDEFINED;
  bool resolves = false;
};

class SampleClient : public PipelineClient {
 public:
  explicit SampleClient(const PassInfo& pass_info) : info(pass_info) {
    const auto count = static_cast<VkSampleCountFlagBits>(info.samples);
    std::vector<VkAttachmentDescription> descriptions{description(kColor, count)};
    color = ms_image(kColor, count, VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT);
    std::vector<VkImageView> views{view(color, kColor)};
    const VkAttachmentReference color_reference{0, VK_IMAGE_LAYOUT_GENERAL};
    VkAttachmentReference resolve_reference{VK_ATTACHMENT_UNUSED, VK_IMAGE_LAYOUT_GENERAL};
    VkAttachmentReference depth_reference{VK_ATTACHMENT_UNUSED, VK_IMAGE_LAYOUT_GENERAL};
    if (info.resolves) {
      resolve_reference.attachment = static_cast<uint32_t>(descriptions.size());
      descriptions.push_back(description(kColor, VK_SAMPLE_COUNT_1_BIT));
      resolved = ms_image(kColor, VK_SAMPLE_COUNT_1_BIT, VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT);
      views.push_back(view(resolved, kColor));
    }
    if (info.depth_stencil != VK_FORMAT_UNDEFINED) {
      depth_reference.attachment = static_cast<uint32_t>(descriptions.size());
      descriptions.push_back(description(info.depth_stencil, count));
      depth = ms_image(info.depth_stencil, count, VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT);
      const bool only_stencil = info.depth_stencil == VK_FORMAT_S8_UINT;
      views.push_back(view(depth, info.depth_stencil, {},
                           VK_IMAGE_ASPECT_STENCIL_BIT | (only_stencil ? 0u : uint32_t{VK_IMAGE_ASPECT_DEPTH_BIT})));
    }
    VkSubpassDescription subpass{};
    subpass.colorAttachmentCount = 1;
    subpass.pColorAttachments = &color_reference;
    subpass.pResolveAttachments = &resolve_reference;
    subpass.pDepthStencilAttachment = &depth_reference;
    const std::vector<VkSubpassDependency> dependencies = dependencies_of(1);
    const VkRenderPassCreateInfo create{VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO,
                                        nullptr,
                                        0,
                                        static_cast<uint32_t>(descriptions.size()),
                                        descriptions.data(),
                                        1,
                                        &subpass,
                                        static_cast<uint32_t>(dependencies.size()),
                                        dependencies.data()};
    EXPECT_EQ(VK(*this, CreateRenderPass)(device, &create, nullptr, &pass), VK_SUCCESS);
    defer([this] { VK(*this, DestroyRenderPass)(device, pass, nullptr); });
    frame = framebuffer(pass, views, {kSize, kSize});
    layout = pipeline_layout(std::nullopt, 16);
    pixels = buffer(kSize * kSize * 4);
    vertices = buffer(6 * 16);
    for (int i = 0; i < 3; ++i) {
      vertices.as<float>()[i * 4] = static_cast<float>(kTriangle[i].x_fx8) / 256 / (kSize / 2) - 1;
      vertices.as<float>()[i * 4 + 1] = static_cast<float>(kTriangle[i].y_fx8) / 256 / (kSize / 2) - 1;
    }
    constexpr float kCover[3][2] = {{-1, -1}, {3, -1}, {-1, 3}};
    for (int i = 0; i < 3; ++i) {
      float* v = vertices.as<float>() + (3 + i) * 4;
      std::copy_n(kCover[i], 2, v);
      for (int axis = 0; axis < 2; ++axis) v[2 + axis] = (kCover[i][axis] + 1) / 2;  // 0 to 1 over the framebuffer
    }
  }

  static VkAttachmentDescription description(VkFormat format, VkSampleCountFlagBits samples) {
    return {0,
            format,
            samples,
            VK_ATTACHMENT_LOAD_OP_CLEAR,
            VK_ATTACHMENT_STORE_OP_STORE,
            VK_ATTACHMENT_LOAD_OP_CLEAR,
            VK_ATTACHMENT_STORE_OP_STORE,
            VK_IMAGE_LAYOUT_UNDEFINED,
            VK_IMAGE_LAYOUT_GENERAL};
  }

  VkImage ms_image(VkFormat format, VkSampleCountFlagBits samples, VkImageUsageFlags usage) {
    VkImageCreateInfo create{VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO};
    create.imageType = VK_IMAGE_TYPE_2D;
    create.format = format;
    create.extent = {kSize, kSize, 1};
    create.mipLevels = create.arrayLayers = 1;
    create.samples = samples;
    create.usage = usage | VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT;
    VkImage out = VK_NULL_HANDLE;
    EXPECT_EQ(VK(*this, CreateImage)(device, &create, nullptr, &out), VK_SUCCESS);
    VkMemoryRequirements requirements;
    VK(*this, GetImageMemoryRequirements)(device, out, &requirements);
    EXPECT_EQ(VK(*this, BindImageMemory)(device, out, memory(requirements.size), 0), VK_SUCCESS);
    defer([this, out] { VK(*this, DestroyImage)(device, out, nullptr); });
    return out;
  }

  VkPipeline pipeline(const VkStencilOpState* stencil = nullptr, std::span<const uint32_t> fragment = kColorFragment) {
    Drawing drawing{.layout = layout, .pass = pass, .vertex = module(kColorVertex), .fragment = module(fragment)};
    drawing.samples = info.samples;
    drawing.stencil = stencil;
    drawing.depth_compare = VK_COMPARE_OP_ALWAYS;
    VkPipeline out = VK_NULL_HANDLE;
    EXPECT_EQ(graphics_pipeline(drawing, &out), VK_SUCCESS);
    return out;
  }

  void begin(VkCommandBuffer cb) {
    VkClearValue clear{};
    begin_pass(cb, pass, frame, kWhole, {clear, clear, clear});
  }
  // `first`: 0 the triangle, 3 all pixels.
  void draw(VkCommandBuffer cb, VkPipeline with, uint32_t first, std::array<float, 4> value) {
    VK(*this, CmdBindPipeline)(cb, VK_PIPELINE_BIND_POINT_GRAPHICS, with);
    const VkViewport viewport{0, 0, kSize, kSize, 0, 1};
    VK(*this, CmdSetViewport)(cb, 0, 1, &viewport);
    VK(*this, CmdSetScissor)(cb, 0, 1, &kWhole);
    const VkDeviceSize zero = 0;
    VK(*this, CmdBindVertexBuffers)(cb, 0, 1, &vertices.handle, &zero);
    VK(*this, CmdPushConstants)(cb, layout, VK_SHADER_STAGE_ALL, 0, 16, value.data());
    VK(*this, CmdDraw)(cb, 3, 1, first, 0);
  }
  void end(VkCommandBuffer cb) { VK(*this, CmdEndRenderPass)(cb); }
  void download(VkCommandBuffer cb, VkImage from, VkImageAspectFlags aspect = VK_IMAGE_ASPECT_COLOR_BIT) {
    const VkBufferImageCopy region{0, 0, 0, {aspect, 0, 0, 1}, {}, {kSize, kSize, 1}};
    VK(*this, CmdCopyImageToBuffer)(cb, from, VK_IMAGE_LAYOUT_GENERAL, pixels.handle, 1, &region);
  }

  const PassInfo info;
  VkImage color = VK_NULL_HANDLE, resolved = VK_NULL_HANDLE, depth = VK_NULL_HANDLE;
  VkRenderPass pass = VK_NULL_HANDLE;
  VkFramebuffer frame = VK_NULL_HANDLE;
  VkPipelineLayout layout = VK_NULL_HANDLE;
  Buffer pixels, vertices;
};

TEST(IcdSamples, TriangleResolvesToItsExactCoverage) {
  for (const uint32_t samples : {2u, 4u, 8u, 16u}) {
    SampleClient client({.samples = samples, .resolves = true});
    const VkPipeline pipeline = client.pipeline();
    const VkImage copied = client.image(kColor, {kSize, kSize, 1});
    for (const bool in_pass : {true, false}) {
      client.run([&](VkCommandBuffer cb) {
        client.begin(cb);
        client.draw(cb, pipeline, 0, {1, 1, 1, 1});
        client.end(cb);
        if (!in_pass) {
          const VkImageResolve region{color_layers(), {}, color_layers(), {}, {kSize, kSize, 1}};
          VK(client, CmdResolveImage)(cb, client.color, VK_IMAGE_LAYOUT_GENERAL, copied, VK_IMAGE_LAYOUT_GENERAL, 1, &region);
          client.barrier(cb);
        }
        client.download(cb, in_pass ? client.resolved : copied);
      });
      for (uint32_t y = 0; y < kSize; ++y) {
        for (uint32_t x = 0; x < kSize; ++x) {
          const double mean = 255.0 * covered_samples(x, y, samples) / samples;
          const auto want = static_cast<uint32_t>(std::nearbyint(mean)) * 0x01010101u;
          ASSERT_EQ(client.pixels.as<uint32_t>()[y * kSize + x], want)
              << x << ' ' << y << " of " << samples << (in_pass ? " in the pass" : " by command");
        }
      }
    }
  }
}

TEST(IcdSamples, InterpolationFunctions) {
  constexpr uint32_t kSamples = 4;
  SampleClient client({.samples = kSamples, .resolves = true});
  const VkPipeline pipeline = client.pipeline(nullptr, kInterpolateAtFragment);
  for (uint32_t s = 0; s < kSamples; ++s) {
    const std::array<float, 4> at{-0.25f, 0.375f, static_cast<float>(s), 0};
    client.run([&](VkCommandBuffer cb) {
      client.begin(cb);
      client.draw(cb, pipeline, 3, at);
      client.end(cb);
      client.download(cb, client.resolved);
    });
    for (uint32_t y = 0; y < kSize; ++y) {
      for (uint32_t x = 0; x < kSize; ++x) {
        const double want[4] = {x + 0.5 - 0.25, y + 0.5 + 0.375, x + 0.5, y + sample_locations(kSamples)[s].y / 16.0};
        for (uint32_t c = 0; c < 4; ++c)
          ASSERT_NEAR(client.pixels.data[(y * kSize + x) * 4 + c], 255.0 * want[c] / kSize, 0.501) << x << ' ' << y << ' ' << c;
      }
    }
  }
}

// The mask is drawn into the stencil buffer, then shown.
TEST(IcdStencil, MaskOfEveryFormatAndSampleCount) {
  for (const VkFormat format : {VK_FORMAT_S8_UINT, VK_FORMAT_D24_UNORM_S8_UINT, VK_FORMAT_D32_SFLOAT_S8_UINT}) {
    for (const uint32_t samples : {1u, 4u}) {
      SampleClient client({.samples = samples, .depth_stencil = format, .resolves = samples > 1});
      const VkStencilOpState write{.failOp = VK_STENCIL_OP_KEEP,
                                   .passOp = VK_STENCIL_OP_REPLACE,
                                   .depthFailOp = VK_STENCIL_OP_KEEP,
                                   .compareOp = VK_COMPARE_OP_ALWAYS,
                                   .compareMask = 0xFF,
                                   .writeMask = 0x3C,
                                   .reference = 0xFF};
      VkStencilOpState show = write;
      show.passOp = VK_STENCIL_OP_KEEP;
      show.compareOp = VK_COMPARE_OP_EQUAL;
      show.compareMask = 0x1C;
      const VkPipeline mask = client.pipeline(&write), fill = client.pipeline(&show);
      client.run([&](VkCommandBuffer cb) {
        client.begin(cb);
        client.draw(cb, mask, 0, {0, 0, 0, 0});
        client.draw(cb, fill, 3, {1, 1, 1, 1});
        client.end(cb);
        client.download(cb, samples > 1 ? client.resolved : client.color);
      });
      for (uint32_t y = 0; y < kSize; ++y) {
        for (uint32_t x = 0; x < kSize; ++x) {
          const uint32_t covered = samples > 1 ? covered_samples(x, y, samples) : inside(int(x) * 256 + 128, int(y) * 256 + 128);
          const auto want = static_cast<uint32_t>(std::nearbyint(255.0 * covered / samples)) * 0x01010101u;
          ASSERT_EQ(client.pixels.as<uint32_t>()[y * kSize + x], want) << x << ' ' << y << " format " << format;
        }
      }
      if (samples > 1) continue;
      client.run([&](VkCommandBuffer cb) { client.download(cb, client.depth, VK_IMAGE_ASPECT_STENCIL_BIT); });
      for (uint32_t i = 0; i < kSize * kSize; ++i) {
        const bool covered = inside(int(i % kSize) * 256 + 128, int(i / kSize) * 256 + 128);
        ASSERT_EQ(client.pixels.data[i], covered ? 0x3C : 0);
      }
    }
  }
}

TEST(IcdQuery, OcclusionCountsSamplesExactly) {
  for (const uint32_t samples : {1u, 4u, 16u}) {
    SampleClient client({.samples = samples});
    const VkPipeline pipeline = client.pipeline();
    const VkQueryPoolCreateInfo info{VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO, nullptr, 0, VK_QUERY_TYPE_OCCLUSION, 3, 0};
    VkQueryPool pool = VK_NULL_HANDLE;
    ASSERT_EQ(VK(client, CreateQueryPool)(client.device, &info, nullptr, &pool), VK_SUCCESS);
    client.defer([&client, pool] { VK(client, DestroyQueryPool)(client.device, pool, nullptr); });
    const auto copied = client.buffer(16);
    client.run([&](VkCommandBuffer cb) {
      VK(client, CmdResetQueryPool)(cb, pool, 0, 3);
      client.begin(cb);
      VK(client, CmdBeginQuery)(cb, pool, 0, VK_QUERY_CONTROL_PRECISE_BIT);
      client.draw(cb, pipeline, 0, {1, 1, 1, 1});
      client.draw(cb, pipeline, 0, {1, 1, 1, 1});
      VK(client, CmdEndQuery)(cb, pool, 0);
      client.draw(cb, pipeline, 3, {1, 1, 1, 1});  // covers everything, but what was drawn under it counts
      VK(client, CmdBeginQuery)(cb, pool, 1, 0);
      VK(client, CmdEndQuery)(cb, pool, 1);
      client.end(cb);
      VK(client, CmdCopyQueryPoolResults)(cb, pool, 0, 2, copied.handle, 0, 8, VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT);
    });
    uint32_t covered = 0;
    for (uint32_t i = 0; samples == 1 && i < kSize * kSize; ++i)
      covered += inside(int(i % kSize) * 256 + 128, int(i / kSize) * 256 + 128);
    if (samples > 1) covered = all_covered_samples(samples);
    EXPECT_EQ(copied.as<uint64_t>()[0], 2 * covered);
    EXPECT_EQ(copied.as<uint64_t>()[1], 0u);
    uint32_t values[6] = {};
    EXPECT_EQ(VK(client, GetQueryPoolResults)(client.device, pool, 0, 3, sizeof(values), values, 8,
                                              VK_QUERY_RESULT_WITH_AVAILABILITY_BIT),
              VK_NOT_READY);
    EXPECT_EQ(values[0], 2 * covered);
    EXPECT_EQ(values[1], 1u);
    EXPECT_EQ(values[3], 1u);
    EXPECT_EQ(values[5], 0u);
  }
}

TEST(IcdQuery, PipelineStatistics) {
  SampleClient client({});
  const VkPipeline pipeline = client.pipeline();
  const VkQueryPoolCreateInfo info{
      VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO,
      nullptr,
      0,
      VK_QUERY_TYPE_PIPELINE_STATISTICS,
      1,
      VK_QUERY_PIPELINE_STATISTIC_INPUT_ASSEMBLY_VERTICES_BIT | VK_QUERY_PIPELINE_STATISTIC_INPUT_ASSEMBLY_PRIMITIVES_BIT |
          VK_QUERY_PIPELINE_STATISTIC_VERTEX_SHADER_INVOCATIONS_BIT | VK_QUERY_PIPELINE_STATISTIC_CLIPPING_INVOCATIONS_BIT |
          VK_QUERY_PIPELINE_STATISTIC_FRAGMENT_SHADER_INVOCATIONS_BIT};
  VkQueryPool pool = VK_NULL_HANDLE;
  ASSERT_EQ(VK(client, CreateQueryPool)(client.device, &info, nullptr, &pool), VK_SUCCESS);
  client.defer([&client, pool] { VK(client, DestroyQueryPool)(client.device, pool, nullptr); });
  client.run([&](VkCommandBuffer cb) {
    VK(client, CmdResetQueryPool)(cb, pool, 0, 1);
    client.begin(cb);
    client.draw(cb, pipeline, 3, {1, 0, 0, 1});
    VK(client, CmdBeginQuery)(cb, pool, 0, 0);
    client.draw(cb, pipeline, 0, {0, 1, 0, 1});
    VK(client, CmdEndQuery)(cb, pool, 0);
    client.end(cb);
    client.download(cb, client.color);
  });
  uint64_t values[5] = {};
  EXPECT_EQ(
      VK(client, GetQueryPoolResults)(client.device, pool, 0, 1, sizeof(values), values, sizeof(values), VK_QUERY_RESULT_64_BIT),
      VK_SUCCESS);
  uint32_t covered = 0;
  for (uint32_t i = 0; i < kSize * kSize; ++i) {
    const bool is = inside(int(i % kSize) * 256 + 128, int(i / kSize) * 256 + 128);
    covered += is;
    ASSERT_EQ(client.pixels.as<uint32_t>()[i], is ? 0xFF00FF00u : 0xFF0000FFu) << "the subpass was split";
  }
  EXPECT_EQ(values[0], 3u);
  EXPECT_EQ(values[1], 1u);
  EXPECT_EQ(values[2], 3u);
  EXPECT_EQ(values[3], 1u);
  EXPECT_EQ(values[4], covered);
}

}  // namespace
}  // namespace pineda::test
