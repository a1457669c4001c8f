// Short render passes that run beside each other: they draw what they draw one after the other, and every dependency between them
// holds: memory barriers, dependencies of render passes and layouts, shared attachments, transfers, queries.
#include <cmath>

#include "icd_pipeline_client.h"
#include "icd_shaders.h"

namespace pineda::test {
namespace {

constexpr VkFormat kFormat = VK_FORMAT_R8G8B8A8_UNORM;
constexpr uint32_t kSize = 48, kPixels = kSize * kSize, kTargets = 24;
constexpr VkRect2D kWhole{{0, 0}, {kSize, kSize}};
constexpr VkImageLayout kTargetLayout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
constexpr VkPipelineStageFlags kOutput = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT,
                               kFragment = VK_PIPELINE_STAGE_FRAGMENT_SHADER_BIT, kTransfer = VK_PIPELINE_STAGE_TRANSFER_BIT;

struct OverlapClient : PipelineClient {
  struct Target {
    VkImage image = VK_NULL_HANDLE;
    VkFramebuffer frame = VK_NULL_HANDLE;
    VkDescriptorSet sampled = VK_NULL_HANDLE;
  };
  VkRenderPass pass;  // without dependencies nothing that follows is told to read
  VkDescriptorSetLayout set_layout;
  VkPipelineLayout layout;
  VkSampler sampler;
  std::vector<Target> targets;
  VkPipeline paint, add, sample;
  Buffer vertices = buffer(64 * 16), pixels = buffer(size_t{kTargets} * kPixels * 4);

  // Passes that are begun instead of `pass` need the same dependencies ("Render Pass Compatibility").
  explicit OverlapClient(const std::vector<VkSubpassDependency>& dependencies = {}, VkImageLayout final_layout = kTargetLayout) {
    EXPECT_EQ(result, VK_SUCCESS);
    pass = render_pass(VK_ATTACHMENT_LOAD_OP_CLEAR, dependencies, final_layout);
    set_layout =
        PipelineClient::set_layout({{0, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 1, VK_SHADER_STAGE_FRAGMENT_BIT, nullptr}});
    layout = pipeline_layout(set_layout, 16);
    sampler = nearest_sampler();
    for (uint32_t i = 0; i < kTargets; ++i) targets.push_back(target());
    // The left half; everything, with coordinates of a texture.
    constexpr float kCorners[6][2] = {{-1, -1}, {0, -1}, {-1, 1}, {-1, 1}, {0, -1}, {0, 1}};
    for (int i = 0; i < 6; ++i) {
      const float x = kCorners[i][0], y = kCorners[i][1];
      const float half[4] = {x, y, 0, 0}, whole[4] = {2 * x + 1, y, x + 1, (y + 1) / 2};
      std::memcpy(vertices.data + i * 16, half, 16);
      std::memcpy(vertices.data + (6 + i) * 16, whole, 16);
    }
    paint = pipeline(kColorFragment, false);
    add = pipeline(kColorFragment, true);
    sample = pipeline(kTextureFragment, false);
  }

  VkRenderPass render_pass(VkAttachmentLoadOp load, const std::vector<VkSubpassDependency>& dependencies,
                           VkImageLayout final_layout = kTargetLayout) {
    const VkAttachmentDescription description{0,
                                              kFormat,
                                              VK_SAMPLE_COUNT_1_BIT,
                                              load,
                                              VK_ATTACHMENT_STORE_OP_STORE,
                                              VK_ATTACHMENT_LOAD_OP_DONT_CARE,
                                              VK_ATTACHMENT_STORE_OP_DONT_CARE,
                                              load == VK_ATTACHMENT_LOAD_OP_LOAD ? kTargetLayout : VK_IMAGE_LAYOUT_UNDEFINED,
                                              final_layout};
    const VkAttachmentReference reference{0, kTargetLayout};
    VkSubpassDescription subpass{};
    subpass.colorAttachmentCount = 1;
    subpass.pColorAttachments = &reference;
    VkRenderPassCreateInfo info{VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO, nullptr, 0, 1, &description, 1, &subpass};
    info.dependencyCount = static_cast<uint32_t>(dependencies.size());
    info.pDependencies = dependencies.data();
    VkRenderPass out = VK_NULL_HANDLE;
    EXPECT_EQ(VK(*this, CreateRenderPass)(device, &info, nullptr, &out), VK_SUCCESS);
    defer([this, out] { VK(*this, DestroyRenderPass)(device, out, nullptr); });
    return out;
  }

  Target target() {
    VkImageCreateInfo create{VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO};
    create.imageType = VK_IMAGE_TYPE_2D;
    create.format = kFormat;
    create.extent = {kSize, kSize, 1};
    create.mipLevels = create.arrayLayers = 1;
    create.samples = VK_SAMPLE_COUNT_1_BIT;
    create.usage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT |
                   VK_IMAGE_USAGE_TRANSFER_DST_BIT;
    Target out;
    EXPECT_EQ(VK(*this, CreateImage)(device, &create, nullptr, &out.image), VK_SUCCESS);
    VkMemoryRequirements requirements;
    VK(*this, GetImageMemoryRequirements)(device, out.image, &requirements);
    EXPECT_EQ(VK(*this, BindImageMemory)(device, out.image, memory(requirements.size), 0), VK_SUCCESS);
    defer([this, image = out.image] { VK(*this, DestroyImage)(device, image, nullptr); });
    const VkImageView whole = view(out.image, kFormat);
    out.frame = framebuffer(pass, {whole}, {kSize, kSize});
    out.sampled = descriptor_set(set_layout);
    const VkDescriptorImageInfo image{sampler, whole, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
    const VkWriteDescriptorSet write{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,    nullptr, out.sampled, 0, 0, 1,
                                     VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, &image};
    VK(*this, UpdateDescriptorSets)(device, 1, &write, 0, nullptr);
    return out;
  }

  VkPipeline pipeline(std::span<const uint32_t> fragment, bool blend) {
    Drawing drawing{.layout = layout, .pass = pass, .vertex = module(kColorVertex), .fragment = module(fragment)};
    drawing.blend_over = blend;
    VkPipeline out = VK_NULL_HANDLE;
    EXPECT_EQ(graphics_pipeline(drawing, &out), VK_SUCCESS);
    return out;
  }

  void draw(VkCommandBuffer cb, VkPipeline with, uint32_t first, std::array<float, 4> color,
            VkDescriptorSet set = VK_NULL_HANDLE) {
    VK(*this, CmdBindPipeline)(cb, VK_PIPELINE_BIND_POINT_GRAPHICS, with);
    const VkViewport viewport{0, 0, kSize, kSize, 0, 1};
    VK(*this, CmdSetViewport)(cb, 0, 1, &viewport);
    VK(*this, CmdSetScissor)(cb, 0, 1, &kWhole);
    const VkDeviceSize zero = 0;
    VK(*this, CmdBindVertexBuffers)(cb, 0, 1, &vertices.handle, &zero);
    if (set) VK(*this, CmdBindDescriptorSets)(cb, VK_PIPELINE_BIND_POINT_GRAPHICS, layout, 0, 1, &set, 0, nullptr);
    VK(*this, CmdPushConstants)(cb, layout, VK_SHADER_STAGE_ALL, 0, 16, color.data());
    VK(*this, CmdDraw)(cb, 6, 1, first, 0);
  }
  using Client::begin;
  void begin(VkCommandBuffer cb, VkRenderPass with, uint32_t i) { begin_pass(cb, with, targets[i].frame, kWhole, {{}}); }
  void end(VkCommandBuffer cb) { VK(*this, CmdEndRenderPass)(cb); }

  void barrier(VkCommandBuffer cb, VkPipelineStageFlags from, VkAccessFlags written, VkPipelineStageFlags to, VkAccessFlags read,
               uint32_t of, VkImageLayout old_layout, VkImageLayout new_layout) {
    const VkImageMemoryBarrier image{VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER,
                                     nullptr,
                                     written,
                                     read,
                                     old_layout,
                                     new_layout,
                                     VK_QUEUE_FAMILY_IGNORED,
                                     VK_QUEUE_FAMILY_IGNORED,
                                     targets[of].image,
                                     {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1}};
    VK(*this, CmdPipelineBarrier)(cb, from, to, 0, 0, nullptr, 0, nullptr, 1, &image);
  }
  void to_sampled(VkCommandBuffer cb, uint32_t i) {
    barrier(cb, kOutput, VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT, kFragment, VK_ACCESS_SHADER_READ_BIT, i, kTargetLayout,
            VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
  }
  void download(VkCommandBuffer cb, uint32_t i, VkImageLayout from = kTargetLayout) {
    barrier(cb, kOutput, VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT, kTransfer, VK_ACCESS_TRANSFER_READ_BIT, i, from,
            VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
    const VkBufferImageCopy region{VkDeviceSize{i} * kPixels * 4, 0, 0, color_layers(), {}, {kSize, kSize, 1}};
    VK(*this, CmdCopyImageToBuffer)(cb, targets[i].image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, pixels.handle, 1, &region);
  }
  uint32_t at(uint32_t i, bool left) const { return pixels.as<uint32_t>()[i * kPixels + kPixels / 2 + (left ? 3 : kSize - 3)]; }
};

std::array<float, 4> grey(uint32_t level) {
  const float v = static_cast<float>(level) / 255;
  return {v, v, v, 1};
}
constexpr uint32_t grey_texel(uint32_t level) { return level * 0x010101u | 0xFF000000u; }

// Each has state of its own, and two draws whose order shows. Barriers that wait for nothing are no obstacle.
TEST(IcdOverlap, IndependentPassesDrawWhatTheyWould) {
  OverlapClient c;
  c.run([&](VkCommandBuffer cb) {
    for (uint32_t i = 0; i < kTargets; ++i) {
      if (i % 5 == 1) {
        c.barrier(cb, VK_PIPELINE_STAGE_TOP_OF_PIPE_BIT, 0, kOutput, VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT, i,
                  VK_IMAGE_LAYOUT_UNDEFINED, kTargetLayout);
      }
      c.begin(cb, c.pass, i);
      c.draw(cb, c.paint, 6, grey(i));
      c.draw(cb, c.paint, 0, grey(100 + i));
      c.end(cb);
    }
    for (uint32_t i = 0; i < kTargets; ++i) c.download(cb, i);
  });
  for (uint32_t i = 0; i < kTargets; ++i) {
    EXPECT_EQ(c.at(i, true), grey_texel(100 + i));
    EXPECT_EQ(c.at(i, false), grey_texel(i));
  }
}

// Target i is a copy of target i - 1 whose left half is painted, so that an order that is lost shows at the end.
enum class Order { kBarrier, kDependencyAfter, kDependencyBefore, kLayout, kChain };
class OverlapOrder : public testing::TestWithParam<Order> {};

TEST_P(OverlapOrder, SamplesWhatWasDrawn) {
  const Order order = GetParam();
  // Layout transitions of these passes that nothing orders with what is next to them: applications get away with them.
  if (order == Order::kDependencyBefore || order == Order::kLayout) breaks_on_purpose({"SYNC-HAZARD-READ-AFTER-WRITE"});
  if (order == Order::kDependencyBefore || order == Order::kChain) breaks_on_purpose({"SYNC-HAZARD-WRITE-AFTER-WRITE"});
  const VkSubpassDependency after{
      0, VK_SUBPASS_EXTERNAL, kOutput, kFragment, VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT, VK_ACCESS_SHADER_READ_BIT};
  const VkSubpassDependency before{VK_SUBPASS_EXTERNAL,      0, kOutput, kFragment, VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT,
                                   VK_ACCESS_SHADER_READ_BIT};
  const VkSubpassDependency to_transfer{
      0, VK_SUBPASS_EXTERNAL, kOutput, kTransfer, VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT, VK_ACCESS_TRANSFER_READ_BIT};
  const VkImageLayout read_only = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;
  std::vector<VkSubpassDependency> dependencies;
  if (order == Order::kDependencyAfter) dependencies = {after};
  if (order == Order::kDependencyBefore) dependencies = {before};
  if (order == Order::kChain) dependencies = {to_transfer};
  const VkImageLayout final_layout = order == Order::kBarrier || order == Order::kChain ? kTargetLayout : read_only;
  OverlapClient c(dependencies, final_layout);
  c.run([&](VkCommandBuffer cb) {
    for (uint32_t i = 0; i < kTargets; ++i) {
      c.begin(cb, c.pass, i);
      if (i == 0) {
        c.draw(cb, c.paint, 6, grey(77));
      } else {
        c.draw(cb, c.sample, 6, {}, c.targets[i - 1].sampled);
      }
      c.draw(cb, c.paint, 0, grey(i));
      c.end(cb);
      if (order == Order::kBarrier) c.to_sampled(cb, i);
      if (order == Order::kChain) {  // goes on where the render pass's own dependency ends
        c.barrier(cb, kTransfer, 0, kFragment, VK_ACCESS_SHADER_READ_BIT, i, kTargetLayout, read_only);
      }
    }
    c.download(cb, kTargets - 1, read_only);
  });
  EXPECT_EQ(c.at(kTargets - 1, true), grey_texel(kTargets - 1));
  EXPECT_EQ(c.at(kTargets - 1, false), grey_texel(77));
}

std::string order_name(const testing::TestParamInfo<Order>& info) {
  constexpr const char* kNames[] = {"Barrier", "DependencyAfter", "DependencyBefore", "Layout", "Chain"};
  return kNames[static_cast<size_t>(info.param)];
}
INSTANTIATE_TEST_SUITE_P(Ways, OverlapOrder,
                         testing::Values(Order::kBarrier, Order::kDependencyAfter, Order::kDependencyBefore, Order::kLayout,
                                         Order::kChain),
                         order_name);

// Passes over one image in the order of their dependency between attachments, among others that do not matter to them.
TEST(IcdOverlap, SharedAttachmentsStayInOrder) {
  const VkAccessFlags access = VK_ACCESS_COLOR_ATTACHMENT_READ_BIT | VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT;
  const VkSubpassDependency same{VK_SUBPASS_EXTERNAL, 0, kOutput, kOutput, VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT, access};
  OverlapClient c({same});
  const VkRenderPass load = c.render_pass(VK_ATTACHMENT_LOAD_OP_LOAD, {same}), clear = c.pass;
  uint32_t expected = 0;
  c.run([&](VkCommandBuffer cb) {
    for (uint32_t i = 0; i < kTargets; ++i) {
      c.begin(cb, i == 0 ? clear : load, 0);
      const float level = static_cast<float>(i * 10) / 255;
      c.draw(cb, c.add, 6, {level, level, level, 0.5f});
      for (int k = 0; k < 40; ++k) c.draw(cb, c.add, 6, {});  // changes nothing, and lasts: who does not wait is too early
      c.end(cb);
      if (i == 0) continue;
      c.begin(cb, clear, i);
      c.draw(cb, c.paint, 6, grey(i));
      c.end(cb);
    }
    for (uint32_t i = 0; i < kTargets; ++i) c.download(cb, i);
  });
  for (uint32_t i = 0; i < kTargets; ++i) {  // source * a + target * (1 - a), rounded to 8 bits
    expected = static_cast<uint32_t>(std::floor((i * 10 + expected) * 0.5 + 0.5));
    if (i == 0) continue;
    EXPECT_EQ(c.at(i, false), grey_texel(i));
  }
  EXPECT_NEAR(c.at(0, false) & 0xFF, expected, 1);  // a half may be rounded to either side
}

// A transfer between two passes sees the first and not the second; a vertex buffer changes between them.
TEST(IcdOverlap, TransfersComeBetweenPasses) {
  breaks_on_purpose({"SYNC-HAZARD-WRITE-AFTER-READ"});
  OverlapClient c;
  const auto away = c.buffer(6 * 16);
  for (int i = 0; i < 24; ++i) away.as<float>()[i] = 5;  // nothing to be seen
  c.run([&](VkCommandBuffer cb) {
    c.begin(cb, c.pass, 0);
    c.draw(cb, c.paint, 6, grey(50));
    c.end(cb);
    c.download(cb, 0);
    c.begin(cb, c.pass, 0);  // nothing lets it wait for the copy
    c.draw(cb, c.paint, 6, grey(60));
    c.end(cb);
    c.begin(cb, c.pass, 1);
    c.draw(cb, c.paint, 6, grey(70));
    c.end(cb);
    const VkBufferCopy copy{0, 6 * 16, 6 * 16};
    VK(c, CmdPipelineBarrier)
    (cb, VK_PIPELINE_STAGE_VERTEX_INPUT_BIT, kTransfer, 0, 0, nullptr, 0, nullptr, 0, nullptr);
    VK(c, CmdCopyBuffer)(cb, away.handle, c.vertices.handle, 1, &copy);
    const VkMemoryBarrier visible{VK_STRUCTURE_TYPE_MEMORY_BARRIER, nullptr, VK_ACCESS_TRANSFER_WRITE_BIT,
                                  VK_ACCESS_VERTEX_ATTRIBUTE_READ_BIT};
    VK(c, CmdPipelineBarrier)(cb, kTransfer, VK_PIPELINE_STAGE_VERTEX_INPUT_BIT, 0, 1, &visible, 0, nullptr, 0, nullptr);
    c.begin(cb, c.pass, 2);
    c.draw(cb, c.paint, 6, grey(80));
    c.end(cb);
    c.download(cb, 1);
    c.download(cb, 2);
  });
  EXPECT_EQ(c.at(0, true), grey_texel(50));
  EXPECT_EQ(c.at(1, true), grey_texel(70));
  EXPECT_EQ(c.at(2, true), 0u);
}

// Each query counts its passes: one inside of a pass, one around two passes, none for the passes between.
TEST(IcdOverlap, QueriesCountTheirPassesOnly) {
  OverlapClient c;
  for (const VkQueryType type : {VK_QUERY_TYPE_OCCLUSION, VK_QUERY_TYPE_PIPELINE_STATISTICS}) {
    VkQueryPoolCreateInfo info{VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO, nullptr, 0, type, 2};
    if (type == VK_QUERY_TYPE_PIPELINE_STATISTICS)
      info.pipelineStatistics = VK_QUERY_PIPELINE_STATISTIC_FRAGMENT_SHADER_INVOCATIONS_BIT;
    VkQueryPool queries = VK_NULL_HANDLE;
    ASSERT_EQ(VK(c, CreateQueryPool)(c.device, &info, nullptr, &queries), VK_SUCCESS);
    c.defer([&c, queries] { VK(c, DestroyQueryPool)(c.device, queries, nullptr); });
    c.run([&](VkCommandBuffer cb) {
      VK(c, CmdResetQueryPool)(cb, queries, 0, 2);
      const auto pass = [&](uint32_t i) {
        c.begin(cb, c.pass, i);
        c.draw(cb, c.paint, 6, grey(i));
        c.end(cb);
      };
      pass(0);
      c.begin(cb, c.pass, 1);
      c.draw(cb, c.paint, 6, grey(1));
      VK(c, CmdBeginQuery)(cb, queries, 0, 0);
      c.draw(cb, c.paint, 0, grey(2));
      VK(c, CmdEndQuery)(cb, queries, 0);
      c.end(cb);
      pass(2);
      VK(c, CmdBeginQuery)(cb, queries, 1, 0);
      pass(3);
      pass(4);
      VK(c, CmdEndQuery)(cb, queries, 1);
      pass(5);
    });
    uint64_t counts[2] = {};
    ASSERT_EQ(VK(c, GetQueryPoolResults)(c.device, queries, 0, 2, sizeof counts, counts, 8, VK_QUERY_RESULT_64_BIT), VK_SUCCESS);
    EXPECT_EQ(counts[0], kPixels / 2u);
    EXPECT_EQ(counts[1], kPixels * 2u);
  }
}

}  // namespace
}  // namespace pineda::test
