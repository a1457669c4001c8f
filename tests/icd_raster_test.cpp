// Extensions and features of drawing, through the API: counts in buffers, exported stencil references, resolves of depth and
// stencil, queries that secondary command buffers inherit, numbers of samples that vary in a subpass.
#include <algorithm>

#include "icd_raster_client.h"

namespace pineda::test {
namespace {

constexpr auto kRenderPass2 = VK_KHR_CREATE_RENDERPASS_2_EXTENSION_NAME;

TEST(IcdRaster, DrawCountsComeFromBuffers) {
  breaks_on_purpose(
      {"VUID-vkCmdDrawIndexedIndirectCount-countBufferOffset-04129", "VUID-vkCmdDrawIndirectCount-countBufferOffset-04129"});
  RasterClient client({}, {kRenderPass2, VK_KHR_DRAW_INDIRECT_COUNT_EXTENSION_NAME});
  // Draw i covers row i.
  std::vector<std::array<float, 4>> corners;
  for (int i = 0; i < 4; ++i) {
    const auto y = static_cast<float>(i);
    for (const auto& [cx, cy] : {std::pair{0, 0}, {32, 0}, {0, 1}}) {
      corners.push_back({static_cast<float>(cx), y + static_cast<float>(cy), 0, 0});
    }
  }
  client.set_vertices(corners);
  const VkPipeline pipeline = client.pipeline({}, kColorVertex, kColorFragment);
  const auto commands = client.buffer(512), indices = client.buffer(64);
  for (uint32_t i = 0; i < 12; ++i) indices.as<uint16_t>()[i] = static_cast<uint16_t>(i);
  for (uint32_t i = 0; i < 4; ++i) {
    const VkDrawIndirectCommand plain{3, 1, i * 3, 0};
    const VkDrawIndexedIndirectCommand indexed{3, 1, i * 3, 0, 0};
    std::memcpy(commands.data + i * 32, &plain, sizeof(plain));
    std::memcpy(commands.data + 256 + i * 20, &indexed, sizeof(indexed));
  }
  struct Case {
    uint32_t in_buffer, most, drawn;
    VkDeviceSize offset;
  };
  for (const bool is_indexed : {false, true}) {
    for (const Case& c : {Case{3, 4, 3, 200}, Case{0, 4, 0, 200}, Case{100, 4, 4, 204}, Case{4, 2, 2, 200}, Case{4, 4, 0, 512}}) {
      if (c.offset < 512) std::memcpy(commands.data + c.offset, &c.in_buffer, 4);  // past the end: nothing
      client.run([&](VkCommandBuffer cb) {
        client.begin(cb);
        client.bind(cb, pipeline, {1, 1, 1, 1});
        if (is_indexed) {
          VK(client, CmdBindIndexBuffer)(cb, indices.handle, 0, VK_INDEX_TYPE_UINT16);
          VK(client, CmdDrawIndexedIndirectCountKHR)(cb, commands.handle, 256, commands.handle, c.offset, c.most, 20);
        } else {
          VK(client, CmdDrawIndirectCountKHR)(cb, commands.handle, 0, commands.handle, c.offset, c.most, 32);
        }
        client.end(cb);
        client.download(cb, client.color);
      });
      for (uint32_t y = 0; y < 16; ++y)
        EXPECT_EQ(client.at(0, y), y < c.drawn ? ~0u : 0u) << y << " count " << c.in_buffer << " of " << c.most;
    }
  }
}

// The exported value, modulo 256, is the reference of both the test and REPLACE.
TEST(IcdRaster, StencilReferencesFromTheFragmentShader) {
  for (const uint32_t samples : {1u, 4u}) {
    RasterClient client({.samples = samples,
                         .depth = VK_FORMAT_D32_SFLOAT_S8_UINT,
                         .resolves = samples > 1,
                         .stencil_resolve = samples > 1 ? VK_RESOLVE_MODE_SAMPLE_ZERO_BIT : VK_RESOLVE_MODE_NONE},
                        {kRenderPass2, VK_EXT_SHADER_STENCIL_EXPORT_EXTENSION_NAME, VK_KHR_DEPTH_STENCIL_RESOLVE_EXTENSION_NAME});
    client.set_cover();
    client.clear.depthStencil = {0, 9};
    const VkStencilOpState state{.failOp = VK_STENCIL_OP_ZERO,
                                 .passOp = VK_STENCIL_OP_REPLACE,
                                 .depthFailOp = VK_STENCIL_OP_INVERT,
                                 .compareOp = VK_COMPARE_OP_LESS,  // reference < 9
                                 .compareMask = 0xFF,
                                 .writeMask = 0xFF,
                                 .reference = 0x55};
    const VkPipeline pipeline =
        client.pipeline({.depth_compare = VK_COMPARE_OP_ALWAYS, .stencil = &state}, kColorVertex, kStencilExportFragment);
    client.run([&](VkCommandBuffer cb) {
      client.begin(cb);
      client.bind(cb, pipeline);
      VK(client, CmdDraw)(cb, 3, 1, 0, 0);
      client.end(cb);
      client.download(cb, samples > 1 ? client.resolved_depth : client.depth, VK_IMAGE_ASPECT_STENCIL_BIT);
    });
    for (uint32_t y = 0; y < 16; ++y) {
      for (uint32_t x = 0; x < 16; ++x) ASSERT_EQ(client.at<uint8_t>(x, y), x < 9 ? x : 0) << x << ' ' << y;
    }
  }
}

// Two slanted planes make all samples of a pixel different; each mode against its definition over the samples as the pass of
// one more draw per sample (sample masks) cannot see them: by the formula of the plane.
TEST(IcdRaster, DepthAndStencilResolveInEveryMode) {
  constexpr uint32_t kSamples = 4;
  VkPhysicalDeviceDepthStencilResolveProperties properties{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DEPTH_STENCIL_RESOLVE_PROPERTIES};
  {
    RasterClient client({}, {kRenderPass2});
    VkPhysicalDeviceProperties2 all{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &properties};
    VK(client, GetPhysicalDeviceProperties2)(client.physical, &all);
    EXPECT_TRUE(properties.independentResolve);
    EXPECT_TRUE(properties.independentResolveNone);
  }
  constexpr VkResolveModeFlagBits kModes[] = {VK_RESOLVE_MODE_NONE, VK_RESOLVE_MODE_SAMPLE_ZERO_BIT, VK_RESOLVE_MODE_AVERAGE_BIT,
                                              VK_RESOLVE_MODE_MIN_BIT, VK_RESOLVE_MODE_MAX_BIT};
  for (const VkFormat format : {VK_FORMAT_D32_SFLOAT_S8_UINT, VK_FORMAT_D16_UNORM}) {
    for (const VkResolveModeFlagBits mode : kModes) {
      const bool has_stencil = format == VK_FORMAT_D32_SFLOAT_S8_UINT;
      const VkResolveModeFlagBits stencil_mode =
          !has_stencil || !(properties.supportedStencilResolveModes & mode) ? VK_RESOLVE_MODE_NONE : mode;
      if (mode == VK_RESOLVE_MODE_NONE) continue;
      EXPECT_TRUE(properties.supportedDepthResolveModes & mode);
      RasterClient client({.samples = kSamples, .depth = format, .depth_resolve = mode, .stencil_resolve = stencil_mode},
                          {kRenderPass2, VK_KHR_DEPTH_STENCIL_RESOLVE_EXTENSION_NAME});
      // Depth 1/32 a pixel to the right; the samples of an edge at x = 8.5 have a stencil of 7 on its left side.
      client.set_vertices({{0, 0, 0, 0}, {32, 0, 1, 0}, {0, 32, 0, 0}, {0, 0, 0, 0}, {8.5f, 0, 8.5f / 32, 0}, {0, 4096, 0, 0}});
      client.clear.depthStencil = {0, 3};
      const VkStencilOpState state{.failOp = VK_STENCIL_OP_KEEP,
                                   .passOp = VK_STENCIL_OP_REPLACE,
                                   .depthFailOp = VK_STENCIL_OP_KEEP,
                                   .compareOp = VK_COMPARE_OP_ALWAYS,
                                   .compareMask = 0xFF,
                                   .writeMask = 0xFF,
                                   .reference = 7};
      const VkPipeline slope = client.pipeline({.depth_compare = VK_COMPARE_OP_ALWAYS}, kDepthBiasVertex, kWhiteFragment);
      const VkPipeline stencil = client.pipeline({.depth_compare = VK_COMPARE_OP_ALWAYS, .stencil = &state, .depth_write = false},
                                                 kDepthBiasVertex, kWhiteFragment);
      client.run([&](VkCommandBuffer cb) {
        client.begin(cb);
        client.bind(cb, slope);
        VK(client, CmdDraw)(cb, 3, 1, 0, 0);
        client.bind(cb, stencil);
        VK(client, CmdDraw)(cb, 3, 1, 3, 0);
        client.end(cb);
        client.download(cb, client.resolved_depth, VK_IMAGE_ASPECT_DEPTH_BIT);
      });
      // x of the standard locations of 4 samples: 6, 14, 2, 10 sixteenths.
      const double at = mode == VK_RESOLVE_MODE_SAMPLE_ZERO_BIT ? 6
                        : mode == VK_RESOLVE_MODE_AVERAGE_BIT   ? 8
                        : mode == VK_RESOLVE_MODE_MIN_BIT       ? 2
                                                                : 14;
      for (uint32_t x = 0; x < 16; ++x) {
        const double want = (x + at / 16) / 32;
        if (has_stencil) {
          EXPECT_NEAR(client.at<float>(x, 5), want, 1e-6) << "mode " << mode;  // a few roundings of binary32 below 1
        } else {  // half a step, and half of one for an average of rounded depths
          EXPECT_NEAR(client.at<uint16_t>(x, 5), want * 65535, 1.001) << "mode " << mode;
        }
      }
      if (stencil_mode == VK_RESOLVE_MODE_NONE) continue;
      client.run([&](VkCommandBuffer cb) { client.download(cb, client.resolved_depth, VK_IMAGE_ASPECT_STENCIL_BIT); });
      for (uint32_t x = 0; x < 16; ++x) {  // in pixel 8: samples 0 and 2 are left of 8.5
        const uint8_t mixed = mode == VK_RESOLVE_MODE_MIN_BIT ? 3 : 7;
        EXPECT_EQ(client.at<uint8_t>(x, 5), x < 8 ? 7 : x > 8 ? 3 : mixed) << x << " mode " << mode;
      }
    }
  }
}

TEST(IcdRaster, SecondaryCommandBuffersInheritQueries) {
  RasterClient client({}, {kRenderPass2});
  client.set_cover();
  const VkPipeline pipeline = client.pipeline({}, kColorVertex, kColorFragment);
  const VkQueryPoolCreateInfo info{VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO, nullptr, 0, VK_QUERY_TYPE_OCCLUSION, 1, 0};
  VkQueryPool pool = VK_NULL_HANDLE;
  ASSERT_EQ(VK(client, CreateQueryPool)(client.device, &info, nullptr, &pool), VK_SUCCESS);
  client.defer([&client, pool] { VK(client, DestroyQueryPool)(client.device, pool, nullptr); });
  const VkCommandBuffer secondary = client.command_buffer(VK_COMMAND_BUFFER_LEVEL_SECONDARY);
  VkCommandBufferInheritanceInfo inheritance{VK_STRUCTURE_TYPE_COMMAND_BUFFER_INHERITANCE_INFO};
  inheritance.renderPass = client.pass;
  inheritance.occlusionQueryEnable = VK_TRUE;
  inheritance.queryFlags = VK_QUERY_CONTROL_PRECISE_BIT;
  const VkCommandBufferBeginInfo begin{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO, nullptr,
                                       VK_COMMAND_BUFFER_USAGE_RENDER_PASS_CONTINUE_BIT, &inheritance};
  ASSERT_EQ(VK(client, BeginCommandBuffer)(secondary, &begin), VK_SUCCESS);
  client.bind(secondary, pipeline, {1, 1, 1, 1});
  VK(client, CmdDraw)(secondary, 3, 1, 0, 0);
  ASSERT_EQ(VK(client, EndCommandBuffer)(secondary), VK_SUCCESS);
  client.run([&](VkCommandBuffer cb) {
    VK(client, CmdResetQueryPool)(cb, pool, 0, 1);
    VK(client, CmdBeginQuery)(cb, pool, 0, VK_QUERY_CONTROL_PRECISE_BIT);
    client.begin(cb, VK_SUBPASS_CONTENTS_SECONDARY_COMMAND_BUFFERS);
    VK(client, CmdExecuteCommands)(cb, 1, &secondary);
    client.end(cb);
    VK(client, CmdEndQuery)(cb, pool, 0);
  });
  uint64_t samples = 0;
  EXPECT_EQ(VK(client, GetQueryPoolResults)(client.device, pool, 0, 1, 8, &samples, 8, VK_QUERY_RESULT_64_BIT), VK_SUCCESS);
  EXPECT_EQ(samples, 256u);
}

// Without attachments each pipeline of a subpass may have its own number of samples: an occlusion query sees them.
TEST(IcdRaster, SampleCountsVaryInASubpassWithoutAttachments) {
  RasterClient client({.color = VK_FORMAT_UNDEFINED}, {kRenderPass2});
  client.set_cover();
  const VkQueryPoolCreateInfo info{VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO, nullptr, 0, VK_QUERY_TYPE_OCCLUSION, 3, 0};
  VkQueryPool pool = VK_NULL_HANDLE;
  ASSERT_EQ(VK(client, CreateQueryPool)(client.device, &info, nullptr, &pool), VK_SUCCESS);
  client.defer([&client, pool] { VK(client, DestroyQueryPool)(client.device, pool, nullptr); });
  constexpr uint32_t kCounts[] = {1, 8, 4};
  VkPipeline pipelines[3];
  for (uint32_t i = 0; i < 3; ++i) {
    pipelines[i] = client.pipeline({.samples = kCounts[i]}, kColorVertex, kColorFragment);
  }
  client.run([&](VkCommandBuffer cb) {
    VK(client, CmdResetQueryPool)(cb, pool, 0, 3);
    client.begin(cb);
    for (uint32_t i = 0; i < 3; ++i) {
      VK(client, CmdBeginQuery)(cb, pool, i, VK_QUERY_CONTROL_PRECISE_BIT);
      client.bind(cb, pipelines[i], {1, 1, 1, 1});
      VK(client, CmdDraw)(cb, 3, 1, 0, 0);
      VK(client, CmdEndQuery)(cb, pool, i);
    }
    client.end(cb);
  });
  uint64_t samples[3] = {};
  EXPECT_EQ(VK(client, GetQueryPoolResults)(client.device, pool, 0, 3, 24, samples, 8, VK_QUERY_RESULT_64_BIT), VK_SUCCESS);
  for (uint32_t i = 0; i < 3; ++i) EXPECT_EQ(samples[i], 256u * kCounts[i]);
}

// ---- conservative depth -----------------------------------------------------------------------------------------------------

// A shader that moves depths by the push constant's w, away from the viewer or towards it, and promises which. Whatever early
// tests make of the promise, what is stored is as if there were none; a shader that breaks its promise is held to it.
TEST(IcdRaster, ConservativeDepthChangesNoBit) {
  for (const bool greater : {true, false}) {
    const std::span<const uint32_t> promises = greater ? std::span<const uint32_t>(kDepthGreaterFragment) : kDepthLessFragment;
    for (const VkCompareOp op :
         {VK_COMPARE_OP_LESS, VK_COMPARE_OP_LESS_OR_EQUAL, VK_COMPARE_OP_GREATER, VK_COMPARE_OP_GREATER_OR_EQUAL}) {
      for (const float step : {0.125f, 0.0f, -0.125f}) {  // the last one breaks the promise
        for (const float stored : {0.25f, 0.5f, 0.5625f, 0.75f}) {
          RasterClient client({.width = 40, .height = 24, .depth = VK_FORMAT_D32_SFLOAT}, {kRenderPass2});
          client.set_cover();
          client.clear.depthStencil.depth = stored;
          const VkPipeline pipeline = client.pipeline({.depth_compare = op}, kColorVertex, promises);
          client.run([&](VkCommandBuffer cb) {
            client.begin(cb);
            client.bind(cb, pipeline, {1, 1, 1, step});
            VK(client, CmdDraw)(cb, 3, 1, 0, 0);
            client.end(cb);
            client.download(cb, client.depth, VK_IMAGE_ASPECT_DEPTH_BIT);
          });
          const float moved = 0.5f + (greater ? 1.0f : -1.0f) * std::max(step, 0.0f);
          const bool less = op == VK_COMPARE_OP_LESS || op == VK_COMPARE_OP_LESS_OR_EQUAL;
          const bool equal = op == VK_COMPARE_OP_LESS_OR_EQUAL || op == VK_COMPARE_OP_GREATER_OR_EQUAL;
          const bool passes = moved == stored ? equal : (moved < stored) == less;
          for (uint32_t y = 0; y < 24; ++y) {
            for (uint32_t x = 0; x < 40; ++x)
              ASSERT_EQ(client.at<float>(x, y), passes ? moved : stored)
                  << "op " << op << " step " << step << " stored " << stored;
          }
        }
      }
    }
  }
}

// ---- depth bias -------------------------------------------------------------------------------------------------------------

// The constant factor counts steps of the format; the clamp stops it.
TEST(IcdRaster, DepthBiasOfEveryFormat) {
  struct Format {
    VkFormat format;
    double resolvable;  // at depth 0.5
  };
  for (const Format& f : {Format{VK_FORMAT_D16_UNORM, 0x1p-16}, Format{VK_FORMAT_X8_D24_UNORM_PACK32, 0x1p-24},
                          Format{VK_FORMAT_D24_UNORM_S8_UINT, 0x1p-24}, Format{VK_FORMAT_D32_SFLOAT, 0x1p-24}}) {
    for (const float clamp : {0.0f, 0.001f, -0.001f}) {
      for (const float constant : {256.0f, -256.0f, 70000.0f}) {
        RasterClient client({.depth = f.format}, {kRenderPass2});
        client.set_cover();
        client.clear.depthStencil.depth = 0.125f;
        const VkPipeline pipeline =
            client.pipeline({.depth_bias = constant, .depth_bias_clamp = clamp, .depth_compare = VK_COMPARE_OP_ALWAYS},
                            kColorVertex, kColorFragment);
        client.run([&](VkCommandBuffer cb) {
          client.begin(cb);
          client.bind(cb, pipeline);
          VK(client, CmdDraw)(cb, 3, 1, 0, 0);
          client.end(cb);
          client.download(cb, client.depth, VK_IMAGE_ASPECT_DEPTH_BIT);
        });
        double bias = f.resolvable * constant;
        if (clamp > 0) bias = std::min(bias, double{clamp});
        if (clamp < 0) bias = std::max(bias, double{clamp});
        const double want = std::clamp(0.5 + bias, 0.0, 1.0);
        const double got = f.format == VK_FORMAT_D16_UNORM    ? client.at<uint16_t>(3, 3) / 65535.0
                           : f.format == VK_FORMAT_D32_SFLOAT ? double{client.at<float>(3, 3)}
                                                              : (client.at(3, 3) & 0xFFFFFF) / 16777215.0;
        // Half a step of the format, and the roundings of binary32 at 0.5.
        EXPECT_NEAR(got, want, f.format == VK_FORMAT_D16_UNORM ? 0.51 / 65535 : 0x1p-23)
            << "format " << f.format << " " << constant;
      }
    }
  }
}

// ---- lines ------------------------------------------------------------------------------------------------------------------

// A horizontal smooth line whose sides cut pixels at known parts: alpha times the part, blended over black. With several samples
// all of them have the same.
TEST(IcdRaster, SmoothLinesMultiplyAlphaByTheirArea) {
  for (const uint32_t samples : {1u, 4u}) {
    for (const bool stippled : {false, true}) {
      RasterClient client({.samples = samples, .resolves = samples > 1},
                          {kRenderPass2, VK_EXT_LINE_RASTERIZATION_EXTENSION_NAME});
      VkPipelineRasterizationLineStateCreateInfoEXT line{VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_LINE_STATE_CREATE_INFO_EXT};
      line.lineRasterizationMode = VK_LINE_RASTERIZATION_MODE_RECTANGULAR_SMOOTH_EXT;
      line.stippledLineEnable = stippled;
      line.lineStippleFactor = 2;
      line.lineStipplePattern = 0x5555;
      client.set_vertices({{2.5f, 6.25f, 0, 0}, {12.25f, 6.25f, 0, 0}});  // 2 px wide: y from 5.25 to 7.25
      const VkPipeline pipeline = client.pipeline(
          {.topology = VK_PRIMITIVE_TOPOLOGY_LINE_LIST, .rasterization_next = &line, .line_width = 2, .blend_over = true},
          kColorVertex, kColorFragment);
      client.run([&](VkCommandBuffer cb) {
        client.begin(cb);
        client.bind(cb, pipeline, {1, 0, 0, 0.75f});
        VK(client, CmdDraw)(cb, 2, 1, 0, 0);
        client.end(cb);
        client.download(cb, samples > 1 ? client.resolved : client.color);
      });
      for (uint32_t y = 0; y < 16; ++y) {
        for (uint32_t x = 0; x < 16; ++x) {
          const auto overlap = [](double a0, double a1, double b0, double b1) {
            return std::max(0.0, std::min(a1, b1) - std::max(a0, b0));
          };
          double along = overlap(x, x + 1, 2.5, 12.25);
          if (stippled) {  // two units drawn, two left out
            along = 0;
            for (int u = 0; u < 10; u += 4) along += overlap(x, x + 1, 2.5 + u, std::min(2.5 + u + 2, 12.25));
          }
          const double want = 255 * 0.75 * along * overlap(y, y + 1, 5.25, 7.25);
          // Half a step of UNORM8 and the area's own rounding.
          ASSERT_NEAR(client.at(x, y) & 0xFF, want, 0.51) << x << ' ' << y << " samples " << samples << " stippled " << stippled;
        }
      }
    }
  }
}

}  // namespace
}  // namespace pineda::test
