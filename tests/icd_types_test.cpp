// Numbers of 8, 16 and 64 bits, their storage in every layout, and variable pointers, through the whole driver.
#include <bit>
#include <cstddef>

#include "icd_pipeline_client.h"
#include "icd_types_shaders.h"

namespace pineda::test {
namespace {

constexpr VkDescriptorType kStorage = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;

struct TypesClient : PipelineClient {
  TypesClient()
      : PipelineClient(nullptr, {},
                       {VK_KHR_8BIT_STORAGE_EXTENSION_NAME, VK_KHR_SHADER_FLOAT16_INT8_EXTENSION_NAME,
                        VK_EXT_SCALAR_BLOCK_LAYOUT_EXTENSION_NAME, VK_KHR_UNIFORM_BUFFER_STANDARD_LAYOUT_EXTENSION_NAME}) {}
};

struct Std430 {  // the natural alignment of C++
  int8_t d;
  double b;
  uint16_t e[4];
  uint64_t a;
  int16_t c;
};
static_assert(sizeof(Std430) == 40 && offsetof(Std430, a) == 24 && offsetof(Std430, c) == 32);
struct Scalar {
  int8_t d;
  double b;
  uint16_t e[3];
  uint64_t a;
  int16_t c;
};
static_assert(offsetof(Scalar, a) == 24 && sizeof(Scalar) == 40);

struct Uniforms {
  uint8_t one[4];
  int16_t two;
  int64_t three;
  double four;
};

// Halves that are small whole numbers and their halves.
uint16_t half(float v) {
  if (v == 0) return 0;
  const auto bits = std::bit_cast<uint32_t>(v);
  return static_cast<uint16_t>((bits >> 16 & 0x8000) | ((bits >> 23 & 0xff) - 112) << 10 | (bits >> 13 & 0x3ff));
}

TEST(IcdTypes, EveryWidthAndLayout) {
  TypesClient client;
  ASSERT_EQ(client.result, VK_SUCCESS);
  const auto layout_of_set = client.set_layout({{0, kStorage, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr},
                                                {1, kStorage, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr},
                                                {2, VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr}});
  const VkPipelineLayout layout = client.pipeline_layout(layout_of_set, 8);
  const VkDescriptorSet set = client.descriptor_set(layout_of_set);
  const auto in = client.buffer(1024), out = client.buffer(1024), uniform = client.buffer(64);
  for (int i = 0; i < 16; ++i) {
    in.as<Std430>()[i] = {static_cast<int8_t>(i * 17),
                          i * 1e100,
                          {half(1.0f + i), half(-0.5f * i), half(3), 0},
                          0x123456789abcdefull * static_cast<uint64_t>(i),
                          static_cast<int16_t>(1000 * i - 7)};
  }
  *uniform.as<Uniforms>() = {{1, 2, 250, 4}, -3, -5000000000, 8};
  client.write_buffer(set, 0, kStorage, {in.handle, 0, VK_WHOLE_SIZE});
  client.write_buffer(set, 1, kStorage, {out.handle, 0, VK_WHOLE_SIZE});
  client.write_buffer(set, 2, VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, {uniform.handle, 0, VK_WHOLE_SIZE});
  const int64_t factor = -9;
  const VkSpecializationMapEntry entry{3, 0, 8};
  const VkSpecializationInfo specialization{1, &entry, 8, &factor};
  VkPipeline pipeline = VK_NULL_HANDLE;
  ASSERT_EQ(client.compute_pipeline(layout, client.module(kMixedTypes), &specialization, &pipeline), VK_SUCCESS);
  const struct {
    uint8_t p = 200;
    int16_t q = -2;
    uint16_t h = half(2);
    uint16_t unused = 0;  // to whole words
  } push;
  client.run([&](VkCommandBuffer cb) {
    VK(client, CmdBindPipeline)(cb, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline);
    VK(client, CmdBindDescriptorSets)(cb, VK_PIPELINE_BIND_POINT_COMPUTE, layout, 0, 1, &set, 0, nullptr);
    VK(client, CmdPushConstants)(cb, layout, VK_SHADER_STAGE_ALL, 0, sizeof(push), &push);
    VK(client, CmdDispatch)(cb, 1, 1, 1);
  });
  for (int i = 0; i < 16; ++i) {
    const Std430& a = in.as<Std430>()[i];
    const Scalar& r = out.as<Scalar>()[i];
    EXPECT_EQ(r.a, a.a * static_cast<uint64_t>(factor) + static_cast<uint64_t>(-5000000000)) << i;
    EXPECT_EQ(r.b, a.b / 8 + 2) << i;
    EXPECT_EQ(r.c, static_cast<int16_t>(a.c * -3 + 200)) << i;
    EXPECT_EQ(r.d, static_cast<int8_t>(a.d - uniform.as<Uniforms>()->one[i % 4])) << i;
    EXPECT_EQ(r.e[0], half(2 * (1.0f + i) + 0.5f)) << i;
    EXPECT_EQ(r.e[1], half(0.5f - i)) << i;
    EXPECT_EQ(r.e[2], half(6.5f)) << i;
  }
}

TEST(IcdTypes, VariablePointers) {
  TypesClient client;
  ASSERT_EQ(client.result, VK_SUCCESS);
  const auto layout_of_set = client.set_layout(
      {{0, kStorage, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr}, {1, kStorage, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr}});
  const VkPipelineLayout layout = client.pipeline_layout(layout_of_set, 0);
  const VkDescriptorSet set = client.descriptor_set(layout_of_set);
  const auto in = client.buffer(256), out = client.buffer(64);
  for (uint32_t i = 0; i < 64; ++i) in.as<uint32_t>()[i] = 100 + i;
  client.write_buffer(set, 0, kStorage, {in.handle, 0, 64});  // in[16] is outside: it reads zero
  client.write_buffer(set, 1, kStorage, {out.handle, 0, VK_WHOLE_SIZE});
  VkPipeline pipeline = VK_NULL_HANDLE;
  ASSERT_EQ(client.compute_pipeline(layout, client.module(kVariablePointers), nullptr, &pipeline), VK_SUCCESS);
  client.run([&](VkCommandBuffer cb) {
    VK(client, CmdBindPipeline)(cb, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline);
    VK(client, CmdBindDescriptorSets)(cb, VK_PIPELINE_BIND_POINT_COMPUTE, layout, 0, 1, &set, 0, nullptr);
    VK(client, CmdDispatch)(cb, 1, 1, 1);
  });
  for (uint32_t i = 0; i < 16; ++i) EXPECT_EQ(out.as<uint32_t>()[i], i == 15 ? 0 : 100 + i + i % 2) << i;
}

// Two indirect draws, left and right: what each knows of itself reaches the pixels as halves, shorts and doubles.
TEST(IcdTypes, DrawParametersAndNarrowVaryings) {
  constexpr VkFormat kFormat = VK_FORMAT_R8G8B8A8_UNORM;
  constexpr uint32_t kSize = 8;
  TypesClient client;
  ASSERT_EQ(client.result, VK_SUCCESS);
  const VkImage image = client.image(kFormat, {kSize, kSize, 1}, 1, 1, VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT);
  constexpr PipelineClient::Attachment kClear[] = {{kFormat, VK_ATTACHMENT_LOAD_OP_CLEAR}};
  constexpr uint32_t kFirst[] = {0};
  const VkRenderPass pass = client.render_pass(kClear, kFirst);
  const VkFramebuffer framebuffer = client.framebuffer(pass, {client.view(image, kFormat)}, {kSize, kSize});
  VkPipeline pipeline = VK_NULL_HANDLE;
  ASSERT_EQ(client.graphics_pipeline({.layout = client.pipeline_layout(std::nullopt, 0),
                                      .pass = pass,
                                      .vertex = client.module(kNarrowVaryingsVertex),
                                      .fragment = client.module(kNarrowVaryingsFragment)},
                                     &pipeline),
            VK_SUCCESS);
  const auto pixels = client.buffer(kSize * kSize * 4), vertices = client.buffer(256), indirect = client.buffer(64);
  const VkDrawIndirectCommand draws[] = {{6, 1, 4, 20}, {6, 1, 9, 30}};
  std::memcpy(indirect.data, draws, sizeof(draws));
  client.run([&](VkCommandBuffer cb) {
    client.begin_pass(cb, pass, framebuffer, {{0, 0}, {kSize, kSize}}, {{{{0, 0, 0, 0}}}});
    VK(client, CmdBindPipeline)(cb, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline);
    const VkViewport viewport{0, 0, kSize, kSize, 0, 1};
    const VkRect2D whole{{0, 0}, {kSize, kSize}};
    const VkDeviceSize zero = 0;
    VK(client, CmdSetViewport)(cb, 0, 1, &viewport);
    VK(client, CmdSetScissor)(cb, 0, 1, &whole);
    VK(client, CmdBindVertexBuffers)(cb, 0, 1, &vertices.handle, &zero);
    VK(client, CmdDrawIndirect)(cb, indirect.handle, 0, 2, sizeof(VkDrawIndirectCommand));
    VK(client, CmdEndRenderPass)(cb);
    const VkBufferImageCopy region{0, 0, 0, color_layers(), {}, {kSize, kSize, 1}};
    VK(client, CmdCopyImageToBuffer)(cb, image, VK_IMAGE_LAYOUT_GENERAL, pixels.handle, 1, &region);
  });
  for (uint32_t x = 0; x < kSize; ++x) {
    const uint32_t draw = x / 4;  // 0.3 more than the base vertex rounds away; 1e300 / 1e298 = 100
    const uint32_t want = (10 * draw + 5) | (draw ? 30u : 20u) << 8 | (draw ? 9u : 4u) << 16 | 100 * draw << 24;
    EXPECT_EQ(pixels.as<uint32_t>()[3 * kSize + x], want) << x;
  }
}

}  // namespace
}  // namespace pineda::test
