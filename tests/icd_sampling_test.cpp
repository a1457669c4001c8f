// Sampling through the API: arrays of descriptors indexed by values that differ between lanes, cubes, volumes, texel buffers,
// descriptors that were never written; and that the general kernel and the specialised one give the same bits.
#include <thread>

#include "icd_pipeline_client.h"
#include "icd_sampling_shaders.h"

namespace pineda::test {
namespace {

constexpr VkDescriptorType kCombined = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
constexpr VkDescriptorType kUniformTexels = VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER;
constexpr VkDescriptorType kStorageTexels = VK_DESCRIPTOR_TYPE_STORAGE_TEXEL_BUFFER;
constexpr VkDescriptorType kStorage = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;

struct SamplingClient : PipelineClient {
  using PipelineClient::PipelineClient;

  struct Texture {
    VkImageViewType type;
    VkExtent3D extent;
    uint32_t layers;
  };

  // An RGBA8 image whose texel n (counted through slices and layers) is `texel(n)`.
  VkImageView texture(const Texture& t, const std::function<uint32_t(uint32_t)>& texel) {
    VkImageCreateInfo info{VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO};
    if (t.type == VK_IMAGE_VIEW_TYPE_CUBE) info.flags = VK_IMAGE_CREATE_CUBE_COMPATIBLE_BIT;
    info.imageType = t.type == VK_IMAGE_VIEW_TYPE_3D ? VK_IMAGE_TYPE_3D : VK_IMAGE_TYPE_2D;
    info.format = VK_FORMAT_R8G8B8A8_UNORM;
    info.extent = t.extent;
    info.mipLevels = 1;
    info.arrayLayers = t.layers;
    info.samples = VK_SAMPLE_COUNT_1_BIT;
    info.usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT;
    VkImage image = VK_NULL_HANDLE;
    EXPECT_EQ(VK(*this, CreateImage)(device, &info, nullptr, &image), VK_SUCCESS);
    VkMemoryRequirements requirements;
    VK(*this, GetImageMemoryRequirements)(device, image, &requirements);
    EXPECT_EQ(VK(*this, BindImageMemory)(device, image, memory(requirements.size), 0), VK_SUCCESS);
    defer([this, image] { VK(*this, DestroyImage)(device, image, nullptr); });
    to_general(image, info.format);
    const uint32_t count = t.extent.width * t.extent.height * t.extent.depth * t.layers;
    const Buffer staging = buffer(4 * count);
    for (uint32_t i = 0; i < count; ++i) staging.as<uint32_t>()[i] = texel(i);
    run([&](VkCommandBuffer cb) {
      const VkBufferImageCopy region{0, 0, 0, color_layers(0, 0, t.layers), {}, t.extent};
      VK(*this, CmdCopyBufferToImage)(cb, staging.handle, image, VK_IMAGE_LAYOUT_GENERAL, 1, &region);
    });
    const VkImageViewCreateInfo view_info{
        VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,      nullptr, 0, image, t.type, info.format, {},
        {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, t.layers}};
    VkImageView out = VK_NULL_HANDLE;
    EXPECT_EQ(VK(*this, CreateImageView)(device, &view_info, nullptr, &out), VK_SUCCESS);
    defer([this, out] { VK(*this, DestroyImageView)(device, out, nullptr); });
    return out;
  }

  VkBufferView texel_view(const Buffer& of, VkFormat format, VkDeviceSize offset, VkDeviceSize range) {
    const VkBufferViewCreateInfo info{VK_STRUCTURE_TYPE_BUFFER_VIEW_CREATE_INFO, nullptr, 0, of.handle, format, offset, range};
    VkBufferView out = VK_NULL_HANDLE;
    EXPECT_EQ(VK(*this, CreateBufferView)(device, &info, nullptr, &out), VK_SUCCESS);
    defer([this, out] { VK(*this, DestroyBufferView)(device, out, nullptr); });
    return out;
  }

  void write(VkDescriptorSet set, uint32_t binding, uint32_t element, VkImageView view, VkSampler sampler) {
    const VkDescriptorImageInfo info{sampler, view, VK_IMAGE_LAYOUT_GENERAL};
    const VkWriteDescriptorSet write{
        VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET, nullptr, set, binding, element, 1, kCombined, &info, nullptr, nullptr};
    VK(*this, UpdateDescriptorSets)(device, 1, &write, 0, nullptr);
  }
  void write(VkDescriptorSet set, uint32_t binding, uint32_t element, VkDescriptorType type, VkBufferView view) {
    const VkWriteDescriptorSet write{
        VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET, nullptr, set, binding, element, 1, type, nullptr, nullptr, &view};
    VK(*this, UpdateDescriptorSets)(device, 1, &write, 0, nullptr);
  }

  VkDescriptorSet set_for(VkDescriptorSetLayout layout) {
    const VkDescriptorPoolSize sizes[] = {{kCombined, 8}, {kUniformTexels, 4}, {kStorageTexels, 4}, {kStorage, 4}};
    const VkDescriptorPoolCreateInfo info{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO, nullptr, 0, 1, 4, sizes};
    VkDescriptorPool descriptors = VK_NULL_HANDLE;
    EXPECT_EQ(VK(*this, CreateDescriptorPool)(device, &info, nullptr, &descriptors), VK_SUCCESS);
    defer([this, descriptors] { VK(*this, DestroyDescriptorPool)(device, descriptors, nullptr); });
    const VkDescriptorSetAllocateInfo allocate{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO, nullptr, descriptors, 1, &layout};
    VkDescriptorSet out = VK_NULL_HANDLE;
    EXPECT_EQ(VK(*this, AllocateDescriptorSets)(device, &allocate, &out), VK_SUCCESS);
    return out;
  }
};

constexpr uint32_t gray(uint32_t value) { return value * 0x010101u | 0xFF000000u; }

TEST(IcdSampling, ArraysCubesVolumesAndTexelBuffers) {
  breaks_on_purpose({"VUID-vkCmdDispatch-None-02699"});
  SamplingClient client;
  constexpr VkShaderStageFlags kStage = VK_SHADER_STAGE_COMPUTE_BIT;
  const auto set_layout = client.set_layout({{0, kCombined, 4, kStage, nullptr},
                                             {1, kCombined, 1, kStage, nullptr},
                                             {2, kCombined, 1, kStage, nullptr},
                                             {3, kUniformTexels, 2, kStage, nullptr},
                                             {4, kStorageTexels, 2, kStage, nullptr},
                                             {5, kStorage, 1, kStage, nullptr}});
  const VkPipelineLayout layout = client.pipeline_layout(set_layout, 4);
  const VkDescriptorSet set = client.set_for(set_layout);
  const VkSampler sampler = client.nearest_sampler();
  for (uint32_t i = 0; i < 3; ++i) {  // element 3 stays unwritten
    const VkImageView view = client.texture({VK_IMAGE_VIEW_TYPE_2D, {8, 8, 1}, 1}, [&](uint32_t n) { return gray(64 * i + n); });
    client.write(set, 0, i, view, sampler);
  }
  const VkImageView cube =
      client.texture({VK_IMAGE_VIEW_TYPE_CUBE, {8, 8, 1}, 6}, [](uint32_t n) { return gray(n / 64 * 40 + n % 8); });
  client.write(set, 1, 0, cube, sampler);
  const VkImageView volume = client.texture({VK_IMAGE_VIEW_TYPE_3D, {8, 8, 4}, 1}, [](uint32_t n) { return gray(n); });
  client.write(set, 2, 0, volume, sampler);
  const auto texels = client.buffer(1024), words = client.buffer(512), out = client.buffer(64 * 4 * 16);
  for (uint32_t i = 0; i < 256; ++i) texels.as<float>()[i] = static_cast<float>(i);
  client.write(set, 3, 0, kUniformTexels, client.texel_view(texels, VK_FORMAT_R32_SFLOAT, 0, 40 * 4));
  client.write(set, 3, 1, kUniformTexels, client.texel_view(texels, VK_FORMAT_R32G32_SFLOAT, 256, VK_WHOLE_SIZE));
  client.write(set, 4, 0, kStorageTexels, client.texel_view(words, VK_FORMAT_R32_UINT, 0, 20 * 4));
  client.write(set, 4, 1, kStorageTexels, client.texel_view(words, VK_FORMAT_R32_UINT, 256, VK_WHOLE_SIZE));
  client.write_buffer(set, 5, kStorage, {out.handle, 0, VK_WHOLE_SIZE});
  VkPipeline pipeline = VK_NULL_HANDLE;
  ASSERT_EQ(client.compute_pipeline(layout, client.module(kImageArraysCompute), nullptr, &pipeline), VK_SUCCESS);
  // The first turns run the general kernel, later ones the kernel that is specialised for cube and volume.
  for (uint32_t turn = 0; turn < 8; ++turn) {
    const uint32_t flip = turn & 1;
    std::memset(out.data, 0xCD, 64 * 4 * 16);
    std::memset(words.data, 0, 512);
    client.run([&](VkCommandBuffer cb) {
      VK(client, CmdBindPipeline)(cb, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline);
      VK(client, CmdBindDescriptorSets)(cb, VK_PIPELINE_BIND_POINT_COMPUTE, layout, 0, 1, &set, 0, nullptr);
      VK(client, CmdPushConstants)(cb, layout, VK_SHADER_STAGE_ALL, 0, 4, &flip);
      VK(client, CmdDispatch)(cb, 1, 1, 1);
    });
    const auto code = [](float v) { return v * 255; };
    for (uint32_t i = 0; i < 64; ++i) {
      const float* r = out.as<float>() + i * 16;
      const uint32_t x = i % 8, y = i / 8, plane = i % 5;
      // The unwritten descriptor reads zeros; an index beyond the array is its last element.
      ASSERT_NEAR(code(r[0]), plane < 3 ? static_cast<float>(64 * plane + i) : 0, 1e-3f) << i;
      ASSERT_EQ(r[3], plane < 3 ? 1.0f : 0.0f);
      // Face +z of direction (s, t, 1): column x, as tc = -ry the rows are upside down; face -x of (-1, s, t): sc = +z.
      ASSERT_NEAR(code(r[4]), static_cast<float>(flip ? 40 + y : 160 + x), 1e-3f) << i;
      ASSERT_NEAR(code(r[8]), static_cast<float>(x / 2 * 64 + i), 1e-3f) << i;
      const bool second = i & 1;
      ASSERT_EQ(r[12], (second ? 64.0f + 2 * i : i < 40 ? i : 0.0f) + 40) << i;
      ASSERT_EQ(r[13], second ? 65.0f + 2 * i : 0.0f) << i;
    }
    for (uint32_t i = 0; i < 128; ++i) {
      const uint32_t want = i < 20 ? 3 * i : i >= 64 && i < 96 ? 3 * (i - 32) : 0;
      ASSERT_EQ(words.as<uint32_t>()[i], want) << i;
    }
    if (turn >= 3) std::this_thread::sleep_for(std::chrono::milliseconds(20));  // lets the background compile finish
  }
}

// Sixteen samples along a line, through a combined descriptor.
struct LineFixture {
  SamplingClient client;
  const Client::Buffer out = client.buffer(16 * 16);

  explicit LineFixture(std::initializer_list<const char*> extensions = {}) : client(nullptr, {}, extensions) {}

  VkSampler sampler(VkSamplerCreateInfo info) {
    info.sType = VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO;
    VkSampler sampler = VK_NULL_HANDLE;
    EXPECT_EQ(VK(client, CreateSampler)(client.device, &info, nullptr, &sampler), VK_SUCCESS);
    client.defer([this, sampler] { VK(client, DestroySampler)(client.device, sampler, nullptr); });
    return sampler;
  }

  // place: first coordinate and step. Samplers that convert YCbCr must be immutable, those with custom colours must not.
  std::array<std::array<float, 4>, 16> sample(VkImageView view, VkSampler sampler, std::array<float, 4> place,
                                              bool is_immutable = true) {
    const auto set_layout = client.set_layout({{0, kCombined, 1, VK_SHADER_STAGE_COMPUTE_BIT, is_immutable ? &sampler : nullptr},
                                               {1, kStorage, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr}});
    const VkPipelineLayout layout = client.pipeline_layout(set_layout, 16);
    const VkDescriptorSet set = client.set_for(set_layout);
    client.write(set, 0, 0, view, sampler);
    client.write_buffer(set, 1, kStorage, {out.handle, 0, VK_WHOLE_SIZE});
    VkPipeline pipeline = VK_NULL_HANDLE;
    EXPECT_EQ(client.compute_pipeline(layout, client.module(kSampleLineCompute), nullptr, &pipeline), VK_SUCCESS);
    client.run([&](VkCommandBuffer cb) {
      VK(client, CmdBindPipeline)(cb, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline);
      VK(client, CmdBindDescriptorSets)(cb, VK_PIPELINE_BIND_POINT_COMPUTE, layout, 0, 1, &set, 0, nullptr);
      VK(client, CmdPushConstants)(cb, layout, VK_SHADER_STAGE_ALL, 0, 16, place.data());
      VK(client, CmdDispatch)(cb, 1, 1, 1);
    });
    std::array<std::array<float, 4>, 16> result;
    std::memcpy(&result, out.data, sizeof(result));
    return result;
  }
};

TEST(IcdSampling, CustomBorderColors) {
  LineFixture f({VK_EXT_CUSTOM_BORDER_COLOR_EXTENSION_NAME});
  ASSERT_EQ(f.client.result, VK_SUCCESS);
  const VkImageView view = f.client.texture({VK_IMAGE_VIEW_TYPE_2D, {8, 8, 1}, 1}, [](uint32_t) { return gray(255); });
  VkSamplerCustomBorderColorCreateInfoEXT custom{VK_STRUCTURE_TYPE_SAMPLER_CUSTOM_BORDER_COLOR_CREATE_INFO_EXT};
  const float color[4] = {0.125f, 0.25f, 0.5f, 0.75f};
  std::memcpy(&custom.customBorderColor, color, sizeof(color));
  VkSamplerCreateInfo info{.pNext = &custom, .borderColor = VK_BORDER_COLOR_FLOAT_CUSTOM_EXT};
  info.addressModeU = info.addressModeV = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_BORDER;
  const auto result = f.sample(view, f.sampler(info), {-0.5f, 0.5f, 0.125f, 0}, false);
  for (size_t i = 0; i < 16; ++i) {
    for (size_t c = 0; c < 4; ++c) EXPECT_EQ(result[i][c], i < 4 || i >= 12 ? color[c] : 1.0f) << i;
  }
}

TEST(IcdSampling, MinimumAndMaximumOfAFootprint) {
  LineFixture f({VK_EXT_SAMPLER_FILTER_MINMAX_EXTENSION_NAME});
  ASSERT_EQ(f.client.result, VK_SUCCESS);
  const VkImageView view = f.client.texture({VK_IMAGE_VIEW_TYPE_2D, {8, 8, 1}, 1}, [](uint32_t n) { return gray(3 * n); });
  for (const auto mode : {VK_SAMPLER_REDUCTION_MODE_MIN, VK_SAMPLER_REDUCTION_MODE_MAX}) {
    const VkSamplerReductionModeCreateInfo reduction{VK_STRUCTURE_TYPE_SAMPLER_REDUCTION_MODE_CREATE_INFO, nullptr, mode};
    VkSamplerCreateInfo info{.pNext = &reduction, .magFilter = VK_FILTER_LINEAR, .minFilter = VK_FILTER_LINEAR};
    info.addressModeU = info.addressModeV = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
    const auto result = f.sample(view, f.sampler(info), {0.125f, 0.25f, 0.125f, 0});  // between columns i, i + 1 and rows 1, 2
    for (uint32_t i = 0; i < 7; ++i) {
      const float want = 3.0f * static_cast<float>(mode == VK_SAMPLER_REDUCTION_MODE_MIN ? 8 + i : 17 + i);
      EXPECT_NEAR(result[i][0] * 255, want, 1e-3f) << i;
    }
  }
}

// A picture of one colour in two planes, converted after BT.709 from the narrow range.
TEST(IcdSampling, YcbcrConversion) {
  LineFixture f;
  ASSERT_EQ(f.client.result, VK_SUCCESS);
  constexpr VkFormat kFormat = VK_FORMAT_G8_B8R8_2PLANE_420_UNORM;
  const VkImage image = f.client.image(kFormat, {8, 8, 1}, 1, 1, VK_IMAGE_USAGE_SAMPLED_BIT);
  const auto staging = f.client.buffer(64 + 32);
  std::memset(staging.data, 180, 64);
  for (uint32_t i = 0; i < 32; ++i) staging.data[64 + i] = i % 2 ? 150 : 100;
  f.client.run([&](VkCommandBuffer cb) {
    const VkBufferImageCopy planes[] = {{0, 0, 0, {VK_IMAGE_ASPECT_PLANE_0_BIT, 0, 0, 1}, {}, {8, 8, 1}},
                                        {64, 0, 0, {VK_IMAGE_ASPECT_PLANE_1_BIT, 0, 0, 1}, {}, {4, 4, 1}}};
    VK(f.client, CmdCopyBufferToImage)(cb, staging.handle, image, VK_IMAGE_LAYOUT_GENERAL, 2, planes);
  });
  VkSamplerYcbcrConversionCreateInfo conversion_info{VK_STRUCTURE_TYPE_SAMPLER_YCBCR_CONVERSION_CREATE_INFO};
  conversion_info.format = kFormat;
  conversion_info.ycbcrModel = VK_SAMPLER_YCBCR_MODEL_CONVERSION_YCBCR_709;
  conversion_info.ycbcrRange = VK_SAMPLER_YCBCR_RANGE_ITU_NARROW;
  conversion_info.chromaFilter = VK_FILTER_LINEAR;
  VkSamplerYcbcrConversion conversion = VK_NULL_HANDLE;
  ASSERT_EQ(VK(f.client, CreateSamplerYcbcrConversion)(f.client.device, &conversion_info, nullptr, &conversion), VK_SUCCESS);
  f.client.defer([&f, conversion] { VK(f.client, DestroySamplerYcbcrConversion)(f.client.device, conversion, nullptr); });
  const VkSamplerYcbcrConversionInfo chain{VK_STRUCTURE_TYPE_SAMPLER_YCBCR_CONVERSION_INFO, nullptr, conversion};
  const VkImageViewCreateInfo view_info{
      VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO, &chain, 0, image, VK_IMAGE_VIEW_TYPE_2D, kFormat, {},
      {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1}};
  VkImageView view = VK_NULL_HANDLE;
  ASSERT_EQ(VK(f.client, CreateImageView)(f.client.device, &view_info, nullptr, &view), VK_SUCCESS);
  f.client.defer([&f, view] { VK(f.client, DestroyImageView)(f.client.device, view, nullptr); });
  VkSamplerCreateInfo info{.pNext = &chain, .magFilter = VK_FILTER_LINEAR, .minFilter = VK_FILTER_LINEAR};
  info.addressModeU = info.addressModeV = info.addressModeW = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
  const auto result = f.sample(view, f.sampler(info), {0, 0.3f, 0.0625f, 0.04f});
  const double y = (180 - 16) / 219.0, cb = (100 - 128) / 224.0, cr = (150 - 128) / 224.0;
  const double want[3] = {y + 1.5748 * cr, y - 0.13397432 / 0.7152 * cb - 0.33480248 / 0.7152 * cr, y + 1.8556 * cb};
  for (size_t i = 0; i < 16; ++i) {
    for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(result[i][c], want[c], 1e-5) << i;
    EXPECT_EQ(result[i][3], 1.0f);
  }
}

}  // namespace
}  // namespace pineda::test
