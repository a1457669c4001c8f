// Input attachments: read from an earlier subpass, with one sample and many, and what a barrier in a subpass makes readable.
#include "icd_pipeline_client.h"
#include "icd_shaders.h"

namespace pineda::test {
namespace {

constexpr VkFormat kFormat = VK_FORMAT_R8G8B8A8_UNORM;
constexpr uint32_t kSize = 24;
constexpr VkRect2D kWhole{{0, 0}, {kSize, kSize}};

struct SubpassFixture {
  PipelineClient client;
  VkRenderPass pass = VK_NULL_HANDLE;
  VkFramebuffer frame = VK_NULL_HANDLE;
  VkDescriptorSetLayout set_layout;
  VkPipelineLayout layout;
  VkDescriptorSet set;
  Client::Buffer vertices = client.buffer(12 * 16), pixels = client.buffer(kSize * kSize * 4);

  SubpassFixture() {
    set_layout = client.set_layout({{0, VK_DESCRIPTOR_TYPE_INPUT_ATTACHMENT, 1, VK_SHADER_STAGE_FRAGMENT_BIT, nullptr}});
    layout = client.pipeline_layout(set_layout, 16);
    const VkDescriptorPoolSize size{VK_DESCRIPTOR_TYPE_INPUT_ATTACHMENT, 1};
    const VkDescriptorPoolCreateInfo info{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO, nullptr, 0, 1, 1, &size};
    VkDescriptorPool pool = VK_NULL_HANDLE;
    EXPECT_EQ(VK(client, CreateDescriptorPool)(client.device, &info, nullptr, &pool), VK_SUCCESS);
    client.defer([this, pool] { VK(client, DestroyDescriptorPool)(client.device, pool, nullptr); });
    const VkDescriptorSetAllocateInfo allocate{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO, nullptr, pool, 1, &set_layout};
    EXPECT_EQ(VK(client, AllocateDescriptorSets)(client.device, &allocate, &set), VK_SUCCESS);
    // The left half, then everything.
    constexpr float kCorners[6][2] = {{-1, -1}, {0, -1}, {-1, 1}, {-1, 1}, {0, -1}, {0, 1}};
    for (int i = 0; i < 6; ++i) {
      for (int axis = 0; axis < 2; ++axis) {
        vertices.as<float>()[i * 4 + axis] = kCorners[i][axis];
        vertices.as<float>()[(6 + i) * 4 + axis] = axis == 0 ? kCorners[i][0] * 2 + 1 : kCorners[i][1];
      }
    }
  }

  VkImage image(uint32_t samples) {
    VkImageCreateInfo create{VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO};
    create.imageType = VK_IMAGE_TYPE_2D;
    create.format = kFormat;
    create.extent = {kSize, kSize, 1};
    create.mipLevels = create.arrayLayers = 1;
    create.samples = static_cast<VkSampleCountFlagBits>(samples);
    create.usage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_INPUT_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT;
    VkImage out = VK_NULL_HANDLE;
    EXPECT_EQ(VK(client, CreateImage)(client.device, &create, nullptr, &out), VK_SUCCESS);
    VkMemoryRequirements requirements;
    VK(client, GetImageMemoryRequirements)(client.device, out, &requirements);
    EXPECT_EQ(VK(client, BindImageMemory)(client.device, out, client.memory(requirements.size), 0), VK_SUCCESS);
    client.defer([this, out] { VK(client, DestroyImage)(client.device, out, nullptr); });
    return out;
  }

  void create_pass(std::vector<VkAttachmentDescription> attachments, std::vector<VkSubpassDescription> subpasses,
                   std::vector<VkImageView> views, std::vector<VkSubpassDependency> dependencies) {
    const VkRenderPassCreateInfo info{VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO,
                                      nullptr,
                                      0,
                                      static_cast<uint32_t>(attachments.size()),
                                      attachments.data(),
                                      static_cast<uint32_t>(subpasses.size()),
                                      subpasses.data(),
                                      static_cast<uint32_t>(dependencies.size()),
                                      dependencies.data()};
    EXPECT_EQ(VK(client, CreateRenderPass)(client.device, &info, nullptr, &pass), VK_SUCCESS);
    client.defer([this] { VK(client, DestroyRenderPass)(client.device, pass, nullptr); });
    frame = client.framebuffer(pass, views, {kSize, kSize});
    client.write_image(set, 0, VK_DESCRIPTOR_TYPE_INPUT_ATTACHMENT, views[0]);
  }

  VkPipeline pipeline(uint32_t subpass, std::span<const uint32_t> fragment, uint32_t samples = 1) {
    PipelineClient::Drawing drawing{.layout = layout,
                                    .pass = pass,
                                    .subpass = subpass,
                                    .vertex = client.module(kColorVertex),
                                    .fragment = client.module(fragment)};
    drawing.samples = samples;
    VkPipeline out = VK_NULL_HANDLE;
    EXPECT_EQ(client.graphics_pipeline(drawing, &out), VK_SUCCESS);
    return out;
  }

  void draw(VkCommandBuffer cb, VkPipeline with, uint32_t first, std::array<float, 4> color) {
    VK(client, CmdBindPipeline)(cb, VK_PIPELINE_BIND_POINT_GRAPHICS, with);
    const VkViewport viewport{0, 0, kSize, kSize, 0, 1};
    VK(client, CmdSetViewport)(cb, 0, 1, &viewport);
    VK(client, CmdSetScissor)(cb, 0, 1, &kWhole);
    const VkDeviceSize zero = 0;
    VK(client, CmdBindVertexBuffers)(cb, 0, 1, &vertices.handle, &zero);
    VK(client, CmdBindDescriptorSets)(cb, VK_PIPELINE_BIND_POINT_GRAPHICS, layout, 0, 1, &set, 0, nullptr);
    VK(client, CmdPushConstants)(cb, layout, VK_SHADER_STAGE_ALL, 0, 16, color.data());
    VK(client, CmdDraw)(cb, 6, 1, first, 0);
  }
  void download(VkCommandBuffer cb, VkImage from) {
    const VkBufferImageCopy region{0, 0, 0, color_layers(), {}, {kSize, kSize, 1}};
    VK(client, CmdCopyImageToBuffer)(cb, from, VK_IMAGE_LAYOUT_GENERAL, pixels.handle, 1, &region);
  }
};

VkAttachmentDescription description(uint32_t samples) {
  return {0,
          kFormat,
          static_cast<VkSampleCountFlagBits>(samples),
          VK_ATTACHMENT_LOAD_OP_CLEAR,
          VK_ATTACHMENT_STORE_OP_STORE,
          VK_ATTACHMENT_LOAD_OP_DONT_CARE,
          VK_ATTACHMENT_STORE_OP_DONT_CARE,
          VK_IMAGE_LAYOUT_UNDEFINED,
          VK_IMAGE_LAYOUT_GENERAL};
}

constexpr VkAttachmentReference kFirst{0, VK_IMAGE_LAYOUT_GENERAL}, kSecond{1, VK_IMAGE_LAYOUT_GENERAL};

TEST(IcdSubpass, InputAttachmentsOfEarlierSubpasses) {
  for (const uint32_t samples : {1u, 4u}) {
    SubpassFixture f;
    const VkImage from = f.image(samples), to = f.image(1);
    VkSubpassDescription first{}, second{};
    first.colorAttachmentCount = second.colorAttachmentCount = second.inputAttachmentCount = 1;
    first.pColorAttachments = second.pInputAttachments = &kFirst;
    second.pColorAttachments = &kSecond;
    f.create_pass({description(samples), description(1)}, {first, second},
                  {f.client.view(from, kFormat), f.client.view(to, kFormat)}, dependencies_of(2));
    const VkPipeline write = f.pipeline(0, kColorFragment, samples);
    const VkPipeline read =
        f.pipeline(1, samples > 1 ? std::span<const uint32_t>(kSubpassInputMsFragment) : kSubpassInputFragment);
    f.client.run([&](VkCommandBuffer cb) {
      f.client.begin_pass(cb, f.pass, f.frame, kWhole, {{{{0, 1, 0, 0}}}, {}});
      f.draw(cb, write, 0, {1, 0, 0, 1});
      VK(f.client, CmdNextSubpass)(cb, VK_SUBPASS_CONTENTS_INLINE);
      f.draw(cb, read, 6, {});
      VK(f.client, CmdEndRenderPass)(cb);
      f.download(cb, to);
    });
    for (uint32_t i = 0; i < kSize * kSize; ++i) {
      const bool left = i % kSize < kSize / 2;
      const uint32_t as_is = left ? 0xFF0000FFu : 0x0000FF00u;  // alpha, blue, green, red
      // bgra / 2 + 1/4: 0 -> 64, 1 -> 191.
      const uint32_t changed = left ? 0xBFBF4040u : 0x4040BF40u;
      ASSERT_EQ(f.pixels.as<uint32_t>()[i], samples > 1 ? as_is : changed) << i << " of " << samples;
    }
  }
}

TEST(IcdSubpass, BarrierMakesTheOwnAttachmentReadable) {
  SubpassFixture f;
  const VkImage both = f.image(1);
  VkSubpassDescription subpass{};
  subpass.colorAttachmentCount = subpass.inputAttachmentCount = 1;
  subpass.pColorAttachments = subpass.pInputAttachments = &kFirst;
  std::vector<VkSubpassDependency> dependencies = dependencies_of(1);
  dependencies.push_back({0, 0, VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT, VK_PIPELINE_STAGE_FRAGMENT_SHADER_BIT,
                          VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT, VK_ACCESS_INPUT_ATTACHMENT_READ_BIT,
                          VK_DEPENDENCY_BY_REGION_BIT});
  f.create_pass({description(1)}, {subpass}, {f.client.view(both, kFormat)}, dependencies);
  const VkPipeline write = f.pipeline(0, kColorFragment), read = f.pipeline(0, kSubpassInputFragment);
  f.client.run([&](VkCommandBuffer cb) {
    f.client.begin_pass(cb, f.pass, f.frame, kWhole, {{{{0, 1, 0, 0}}}});
    f.draw(cb, write, 0, {1, 0, 0, 1});
    const VkMemoryBarrier barrier{VK_STRUCTURE_TYPE_MEMORY_BARRIER, nullptr, VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT,
                                  VK_ACCESS_INPUT_ATTACHMENT_READ_BIT};
    VK(f.client, CmdPipelineBarrier)
    (cb, VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT, VK_PIPELINE_STAGE_FRAGMENT_SHADER_BIT, VK_DEPENDENCY_BY_REGION_BIT, 1,
     &barrier, 0, nullptr, 0, nullptr);
    f.draw(cb, read, 6, {});
    VK(f.client, CmdEndRenderPass)(cb);
    f.download(cb, both);
  });
  for (uint32_t i = 0; i < kSize * kSize; ++i)
    ASSERT_EQ(f.pixels.as<uint32_t>()[i], i % kSize < kSize / 2 ? 0xBFBF4040u : 0x4040BF40u) << i;
}

}  // namespace
}  // namespace pineda::test
