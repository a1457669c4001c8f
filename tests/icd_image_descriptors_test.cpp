// Descriptors of images and buffers in arrays, through the API: indexed by anything, updated after they were bound, of a count
// that each set chooses.
#include <gtest/gtest.h>

#include "image_client.h"

namespace pineda::test {
namespace {

constexpr uint32_t kCount = 64;
constexpr const char* kHead = R"(
#extension GL_EXT_nonuniform_qualifier : require
layout(local_size_x = 64) in;
)";

// Storage images, uniform buffers and storage buffers in arrays, indexed by a value that differs between the lanes of a wave, and
// by one that does not; an element that was never written is not used.
TEST(IcdImageUse, ArraysAreIndexedByAnything) {
  ImageClient client;
  std::vector<Resource> images, uniforms, storages;
  std::vector<Client::Buffer> buffers;
  std::vector<VkImage> stores;
  for (uint32_t i = 0; i < 4; ++i) {
    stores.push_back(client.make({.format = VK_FORMAT_R32_UINT, .extent = {8, 8, 1}, .usage = VK_IMAGE_USAGE_STORAGE_BIT}));
    images.push_back(storage_image(client.view(stores.back(), VK_FORMAT_R32_UINT)));
    const auto buffer = client.buffer(256);
    for (uint32_t n = 0; n < 64; ++n) buffer.as<uint32_t>()[n] = 1000 * i + n;
    uniforms.push_back({.type = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, .buffer = {buffer.handle, 0, VK_WHOLE_SIZE}});
    storages.push_back(storage_buffer(client.buffer(256)));
    buffers.push_back(buffer);
  }
  const auto out = client.buffer(kCount * 4);
  for (const uint32_t uniform_index : {4u, 0u, 3u}) {  // 4: each lane its own
    client.dispatch(std::string(kHead) + R"(layout(binding = 0, r32ui) uniform uimage2D t[4];
layout(binding = 1) uniform U { uvec4 u[16]; } us[4];
layout(std430, binding = 2) buffer S { uint s[]; } ss[4];
layout(std430, binding = 3) writeonly buffer O { uint o[]; };
layout(push_constant) uniform P { uint index; };
void main() { uint i = gl_GlobalInvocationID.x, k = index < 4 ? index : (i * 7) % 4;
  imageStore(t[nonuniformEXT(k)], ivec2(i % 8, i / 8), uvec4(i + 1));
  ss[nonuniformEXT(k)].s[i] = imageLoad(t[nonuniformEXT(k)], ivec2(i % 8, i / 8)).x;
  o[i] = us[nonuniformEXT(k)].u[i / 4][i % 4] + ss[nonuniformEXT(k)].s[i]; })",
                    {images, uniforms, storages, {storage_buffer(out)}}, 1, {uniform_index});
    for (uint32_t i = 0; i < kCount; ++i) {
      const uint32_t k = uniform_index < 4 ? uniform_index : i * 7 % 4;
      ASSERT_EQ(out.as<uint32_t>()[i], 1000 * k + i + i + 1) << i;
    }
  }
  const std::vector<uint8_t> last = client.download(stores[3], 256, color_layers(), {8, 8, 1});
  for (uint32_t i = 0; i < kCount; ++i) {
    uint32_t word;
    std::memcpy(&word, &last[size_t{i} * 4], 4);
    ASSERT_EQ(word, i + 1);  // written by the third turn
  }
}

// A set layout with flags for each binding, and a set of it with a variable count.
struct IndexingClient : ImageClient {
  VkDescriptorSetLayout flagged_layout(const std::vector<VkDescriptorSetLayoutBinding>& bindings,
                                       const std::vector<VkDescriptorBindingFlags>& flags) {
    const VkDescriptorSetLayoutBindingFlagsCreateInfo chain{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_BINDING_FLAGS_CREATE_INFO,
                                                            nullptr, static_cast<uint32_t>(flags.size()), flags.data()};
    const VkDescriptorSetLayoutCreateInfo info{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO, &chain,
                                               VK_DESCRIPTOR_SET_LAYOUT_CREATE_UPDATE_AFTER_BIND_POOL_BIT,
                                               static_cast<uint32_t>(bindings.size()), bindings.data()};
    VkDescriptorSetVariableDescriptorCountLayoutSupport variable{
        VK_STRUCTURE_TYPE_DESCRIPTOR_SET_VARIABLE_DESCRIPTOR_COUNT_LAYOUT_SUPPORT};
    VkDescriptorSetLayoutSupport support{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_SUPPORT, &variable};
    VK(*this, GetDescriptorSetLayoutSupportKHR)(device, &info, &support);
    EXPECT_TRUE(support.supported);
    most = variable.maxVariableDescriptorCount;
    VkDescriptorSetLayout out = VK_NULL_HANDLE;
    EXPECT_EQ(VK(*this, CreateDescriptorSetLayout)(device, &info, nullptr, &out), VK_SUCCESS);
    defer([this, out] { VK(*this, DestroyDescriptorSetLayout)(device, out, nullptr); });
    return out;
  }
  VkResult allocate(VkDescriptorSetLayout set_layout, std::vector<VkDescriptorPoolSize> sizes, uint32_t variable,
                    VkDescriptorSet* out) {
    const VkDescriptorPoolCreateInfo info{
        VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO, nullptr,     VK_DESCRIPTOR_POOL_CREATE_UPDATE_AFTER_BIND_BIT, 1,
        static_cast<uint32_t>(sizes.size()),           sizes.data()};
    VkDescriptorPool descriptors = VK_NULL_HANDLE;
    EXPECT_EQ(VK(*this, CreateDescriptorPool)(device, &info, nullptr, &descriptors), VK_SUCCESS);
    defer([this, descriptors] { VK(*this, DestroyDescriptorPool)(device, descriptors, nullptr); });
    const VkDescriptorSetVariableDescriptorCountAllocateInfo counts{
        VK_STRUCTURE_TYPE_DESCRIPTOR_SET_VARIABLE_DESCRIPTOR_COUNT_ALLOCATE_INFO, nullptr, 1, &variable};
    const VkDescriptorSetAllocateInfo of{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO, &counts, descriptors, 1, &set_layout};
    return VK(*this, AllocateDescriptorSets)(device, &of, out);
  }
  void write(VkDescriptorSet set, uint32_t binding, uint32_t element, const Resource& r) {
    const VkWriteDescriptorSet write{
        VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET, nullptr, set, binding, element, 1, r.type, &r.image, &r.buffer, &r.texels};
    VK(*this, UpdateDescriptorSets)(device, 1, &write, 0, nullptr);
  }
  uint32_t most = 0;
};

// Descriptors that are written after vkCmdBindDescriptorSets was recorded, even after the command buffer was ended; of a binding
// with a variable count; some of which are never written.
TEST(IcdImageUse, UpdatesAfterBindingAndVariableCounts) {
  IndexingClient client;
  constexpr VkDescriptorBindingFlags kAfter =
      VK_DESCRIPTOR_BINDING_UPDATE_AFTER_BIND_BIT | VK_DESCRIPTOR_BINDING_PARTIALLY_BOUND_BIT;
  constexpr VkDescriptorType kCombined = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
  const VkDescriptorSetLayout set_layout =
      client.flagged_layout({{0, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr},
                             {1, kCombined, 1000, VK_SHADER_STAGE_COMPUTE_BIT, nullptr}},
                            {kAfter, kAfter | VK_DESCRIPTOR_BINDING_VARIABLE_DESCRIPTOR_COUNT_BIT});
  EXPECT_GE(client.most, 500000u);
  VkDescriptorSet set = VK_NULL_HANDLE;
  const std::vector<VkDescriptorPoolSize> sizes{{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1}, {kCombined, 5}};
  EXPECT_EQ(client.allocate(set_layout, sizes, 6, &set), VK_ERROR_OUT_OF_POOL_MEMORY);
  ASSERT_EQ(client.allocate(set_layout, sizes, 5, &set), VK_SUCCESS);
  const VkPipelineLayout layout = client.pipeline_layout(set_layout, 4);
  VkPipeline pipeline = VK_NULL_HANDLE;
  const std::string glsl = std::string(kHead) + R"(layout(std430, binding = 0) writeonly buffer O { float o[]; };
layout(binding = 1) uniform sampler2D t[];
void main() { uint i = gl_GlobalInvocationID.x, k = i % 5; if (k != 3) o[i] = textureLod(t[nonuniformEXT(k)], vec2(0.5), 0).x; })";
  ASSERT_EQ(client.compute_pipeline(layout, client.shader(VK_SHADER_STAGE_COMPUTE_BIT, glsl), nullptr, &pipeline), VK_SUCCESS);
  const auto out = client.buffer(kCount * 4);
  std::vector<Resource> textures;
  for (uint32_t i = 0; i < 10; ++i) {
    const VkImage image = client.make({.format = VK_FORMAT_R32_SFLOAT, .extent = {2, 2, 1}});
    client.run([&](VkCommandBuffer cb) {
      const VkClearColorValue value{{static_cast<float>(i)}};
      const VkImageSubresourceRange all = ImageClient::all();
      VK(client, CmdClearColorImage)(cb, image, VK_IMAGE_LAYOUT_GENERAL, &value, 1, &all);
    });
    textures.push_back(sampled_image(client.view(image, VK_FORMAT_R32_SFLOAT), client.nearest_sampler()));
  }
  const VkCommandBuffer cb = client.command_buffer();
  client.begin(cb);
  VK(client, CmdBindPipeline)(cb, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline);
  VK(client, CmdBindDescriptorSets)(cb, VK_PIPELINE_BIND_POINT_COMPUTE, layout, 0, 1, &set, 0, nullptr);
  client.write(set, 0, 0, storage_buffer(out));
  VK(client, CmdDispatch)(cb, 1, 1, 1);
  ASSERT_EQ(VK(client, EndCommandBuffer)(cb), VK_SUCCESS);
  for (uint32_t turn = 0; turn < 2; ++turn) {
    for (const uint32_t element : {0u, 1u, 2u, 4u}) client.write(set, 1, element, textures[5 * turn + element]);
    ASSERT_EQ(client.submit(cb), VK_SUCCESS);
    ASSERT_EQ(VK(client, QueueWaitIdle)(client.queue), VK_SUCCESS);
    for (uint32_t i = 0; i < kCount; ++i) {
      const float want = i % 5 == 3 ? 0 : static_cast<float>(5 * turn + i % 5);
      ASSERT_EQ(out.as<float>()[i], want) << "turn " << turn << " lane " << i;
    }
  }
}

// VK_EXT_4444_formats, which every ImageClient enables; what the formats do is in icd_format_*_test.cpp.
TEST(IcdImageUse, FourFourFourFour) {
  ImageClient client;
  constexpr VkFormatFeatureFlags kMandatory =
      VK_FORMAT_FEATURE_SAMPLED_IMAGE_BIT | VK_FORMAT_FEATURE_BLIT_SRC_BIT | VK_FORMAT_FEATURE_SAMPLED_IMAGE_FILTER_LINEAR_BIT;
  for (const VkFormat format : {VK_FORMAT_A4R4G4B4_UNORM_PACK16, VK_FORMAT_A4B4G4R4_UNORM_PACK16}) {
    EXPECT_EQ(client.format_properties(format).optimalTilingFeatures & kMandatory, kMandatory);
  }
}

}  // namespace
}  // namespace pineda::test
