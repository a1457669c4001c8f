// Descriptor pools: what was promised can be allocated, and no more.
#include "icd_client.h"

namespace pineda::test {
namespace {

struct DescriptorFixture {
  Client client;

  VkDescriptorSetLayout layout(std::initializer_list<VkDescriptorSetLayoutBinding> bindings) {
    const VkDescriptorSetLayoutCreateInfo info{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO, nullptr, 0,
                                               static_cast<uint32_t>(bindings.size()), bindings.begin()};
    VkDescriptorSetLayout out = VK_NULL_HANDLE;
    EXPECT_EQ(VK(client, CreateDescriptorSetLayout)(client.device, &info, nullptr, &out), VK_SUCCESS);
    client.defer([this, out] { VK(client, DestroyDescriptorSetLayout)(client.device, out, nullptr); });
    return out;
  }
  VkDescriptorPool pool(uint32_t sets, std::initializer_list<VkDescriptorPoolSize> sizes) {
    const VkDescriptorPoolCreateInfo info{
        VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO, nullptr,      VK_DESCRIPTOR_POOL_CREATE_FREE_DESCRIPTOR_SET_BIT, sets,
        static_cast<uint32_t>(sizes.size()),           sizes.begin()};
    VkDescriptorPool out = VK_NULL_HANDLE;
    EXPECT_EQ(VK(client, CreateDescriptorPool)(client.device, &info, nullptr, &out), VK_SUCCESS);
    client.defer([this, out] { VK(client, DestroyDescriptorPool)(client.device, out, nullptr); });
    return out;
  }
  VkResult allocate(VkDescriptorPool from, std::vector<VkDescriptorSetLayout> layouts, VkDescriptorSet* out) {
    const VkDescriptorSetAllocateInfo info{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO, nullptr, from,
                                           static_cast<uint32_t>(layouts.size()), layouts.data()};
    return VK(client, AllocateDescriptorSets)(client.device, &info, out);
  }
};

constexpr VkDescriptorType kUniform = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
constexpr VkDescriptorType kCombined = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;

TEST(IcdDescriptor, PoolCountsDescriptorsAndSets) {
  DescriptorFixture f;
  const auto two = f.layout({{0, kUniform, 2, VK_SHADER_STAGE_ALL, nullptr}});
  const auto image = f.layout({{3, kCombined, 1, VK_SHADER_STAGE_ALL, nullptr}});
  const auto pool = f.pool(3, {{kUniform, 3}, {kUniform, 1}, {kCombined, 1}});
  VkDescriptorSet sets[4];
  EXPECT_EQ(f.allocate(pool, {two, two}, sets), VK_SUCCESS);
  EXPECT_EQ(f.allocate(pool, {two}, sets + 2), VK_ERROR_OUT_OF_POOL_MEMORY);
  EXPECT_EQ(sets[2], VkDescriptorSet(VK_NULL_HANDLE));
  EXPECT_EQ(VK(f.client, FreeDescriptorSets)(f.client.device, pool, 1, sets), VK_SUCCESS);
  EXPECT_EQ(f.allocate(pool, {image, image}, sets + 2), VK_ERROR_OUT_OF_POOL_MEMORY) << "all or nothing";
  EXPECT_EQ(f.allocate(pool, {image, two}, sets + 2), VK_SUCCESS);
  EXPECT_EQ(f.allocate(pool, {f.layout({})}, sets), VK_ERROR_OUT_OF_POOL_MEMORY) << "maxSets";
  EXPECT_EQ(VK(f.client, ResetDescriptorPool)(f.client.device, pool, 0), VK_SUCCESS);
  EXPECT_EQ(f.allocate(pool, {two, two, image}, sets), VK_SUCCESS);
}

TEST(IcdDescriptor, UnsupportedTypesAreRefused) {
  breaks_on_purpose({"VUID-VkDescriptorSetLayoutCreateInfo-mutableDescriptorType-04595",
                     "VUID-VkDescriptorSetLayoutCreateInfo-pBindings-07303"});
  DescriptorFixture f;
  for (const VkDescriptorType type : {VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR, VK_DESCRIPTOR_TYPE_MUTABLE_EXT}) {
    const VkDescriptorSetLayoutBinding binding{0, type, 1, VK_SHADER_STAGE_ALL, nullptr};
    const VkDescriptorSetLayoutCreateInfo info{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO, nullptr, 0, 1, &binding};
    VkDescriptorSetLayout out;
    EXPECT_EQ(VK(f.client, CreateDescriptorSetLayout)(f.client.device, &info, nullptr, &out), VK_ERROR_FEATURE_NOT_PRESENT);
  }
}

// Updates that run past a binding go on in the next one, and copies follow the same rule; nothing outside the set may be written.
TEST(IcdDescriptor, UpdatesCrossBindings) {
  DescriptorFixture f;
  const auto layout = f.layout({{0, kUniform, 2, VK_SHADER_STAGE_ALL, nullptr},
                                {1, kUniform, 0, VK_SHADER_STAGE_ALL, nullptr},
                                {5, kUniform, 3, VK_SHADER_STAGE_ALL, nullptr}});
  const auto pool = f.pool(2, {{kUniform, 10}});
  VkDescriptorSet sets[2];
  ASSERT_EQ(f.allocate(pool, {layout, layout}, sets), VK_SUCCESS);
  const auto buffer = f.client.buffer(1024);
  std::vector<VkDescriptorBufferInfo> infos(8, {buffer.handle, 0, VK_WHOLE_SIZE});
  VkWriteDescriptorSet write{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
  write.dstSet = sets[0];
  write.dstArrayElement = 1;
  write.descriptorCount = 8;  // four more than there are: the rest is dropped
  write.descriptorType = kUniform;
  write.pBufferInfo = infos.data();
  const VkCopyDescriptorSet copy{VK_STRUCTURE_TYPE_COPY_DESCRIPTOR_SET, nullptr, sets[0], 0, 1, sets[1], 0, 0, 9};
  VK(f.client, UpdateDescriptorSets)(f.client.device, 1, &write, 1, &copy);
}

}  // namespace
}  // namespace pineda::test
