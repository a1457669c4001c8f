// Dispatches, and shaders that must be refused.
#include <random>
#include <string>

#include "icd_pipeline_client.h"
#include "icd_shaders.h"

namespace pineda::test {
namespace {

constexpr VkDescriptorType kStorage = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
constexpr VkDescriptorType kDynamic = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER_DYNAMIC;

// b[i] = a[i] * scale + i + bias over kScaleCompute.
struct ComputeFixture {
  PipelineClient client;
  VkDescriptorSetLayout set_layout;
  VkPipelineLayout layout;
  VkDescriptorSet set;
  Client::Buffer in = client.buffer(1024), out = client.buffer(1024);

  explicit ComputeFixture(VkDescriptorType out_type = kStorage)
      : set_layout(client.set_layout(
            {{0, kStorage, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr}, {1, out_type, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr}})),
        layout(client.pipeline_layout(set_layout, 4)),
        set(client.descriptor_set(set_layout)) {
    for (uint32_t i = 0; i < 256; ++i) in.as<uint32_t>()[i] = i * 2654435761u;
    client.write_buffer(set, 0, kStorage, {in.handle, 0, VK_WHOLE_SIZE});
    client.write_buffer(set, 1, out_type, {out.handle, 0, 512});
  }

  VkPipeline pipeline(uint32_t bias) {
    static constexpr VkSpecializationMapEntry kEntry{7, 0, 4};
    const VkSpecializationInfo specialization{1, &kEntry, 4, &bias};
    VkPipeline out_pipeline = VK_NULL_HANDLE;
    EXPECT_EQ(client.compute_pipeline(layout, client.module(kScaleCompute), &specialization, &out_pipeline), VK_SUCCESS);
    return out_pipeline;
  }
  void bind(VkCommandBuffer cb, VkPipeline pipeline, uint32_t scale, std::vector<uint32_t> offsets = {}) {
    VK(client, CmdBindPipeline)(cb, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline);
    VK(client, CmdBindDescriptorSets)
    (cb, VK_PIPELINE_BIND_POINT_COMPUTE, layout, 0, 1, &set, static_cast<uint32_t>(offsets.size()), offsets.data());
    VK(client, CmdPushConstants)(cb, layout, VK_SHADER_STAGE_ALL, 0, 4, &scale);
  }
  void expect(uint32_t first, uint32_t count, uint32_t scale, uint32_t bias, uint32_t out_offset = 0) {
    for (uint32_t i = first; i < first + count; ++i) {
      ASSERT_EQ(out.as<uint32_t>()[i + out_offset], in.as<uint32_t>()[i] * scale + i + bias) << i;
    }
  }
};

TEST(IcdCompute, DispatchAndSpecialization) {
  ComputeFixture f;
  const VkPipeline nine = f.pipeline(9), one = f.pipeline(1);
  f.client.run([&](VkCommandBuffer cb) {
    f.bind(cb, nine, 3);
    VK(f.client, CmdDispatch)(cb, 4, 1, 1);
  });
  f.expect(0, 128, 3, 9);
  EXPECT_EQ(f.out.as<uint32_t>()[128], 0u);
  f.client.run([&](VkCommandBuffer cb) {
    f.bind(cb, one, 5);
    VK(f.client, CmdDispatch)(cb, 2, 1, 1);
    VK(f.client, CmdDispatch)(cb, 0, 1, 1);
  });
  f.expect(0, 64, 5, 1);
  f.expect(64, 64, 3, 9);
}

// The range of the descriptor is 512 bytes: what lies behind it stays, although the buffer goes on.
TEST(IcdCompute, StoresOutsideTheRangeAreDropped) {
  ComputeFixture f;
  const VkPipeline pipeline = f.pipeline(0);
  f.client.run([&](VkCommandBuffer cb) {
    f.bind(cb, pipeline, 1);
    VK(f.client, CmdDispatch)(cb, 8, 1, 1);
  });
  f.expect(0, 128, 1, 0);
  for (int i = 128; i < 256; ++i) EXPECT_EQ(f.out.as<uint32_t>()[i], 0u);
}

TEST(IcdCompute, DynamicOffsetAndIndirect) {
  breaks_on_purpose({"VUID-vkCmdDispatchIndirect-offset-00407"});
  ComputeFixture f(kDynamic);
  const VkPipeline pipeline = f.pipeline(2);
  const auto indirect = f.client.buffer(32);
  const uint32_t counts[3] = {1, 1, 1};
  std::memcpy(indirect.data + 16, counts, sizeof(counts));
  f.client.run([&](VkCommandBuffer cb) {
    f.bind(cb, pipeline, 7, {256});
    VK(f.client, CmdDispatchIndirect)(cb, indirect.handle, 16);
    VK(f.client, CmdDispatchIndirect)(cb, indirect.handle, 28);  // not inside the buffer: dropped
  });
  f.expect(0, 32, 7, 2, 64);
  EXPECT_EQ(f.out.as<uint32_t>()[0], 0u);
  EXPECT_EQ(f.out.as<uint32_t>()[96], 0u);
}

// Workgroups as large as the limits say: 1024 invocations (from a specialisation constant) and 64 KiB of shared memory, barriers
// in loops. Sums of k * 7 + g over the 16384 words.
TEST(IcdCompute, LargestWorkgroups) {
  PipelineClient client;
  VkPhysicalDeviceProperties properties;
  VK(client, GetPhysicalDeviceProperties)(client.physical, &properties);
  EXPECT_GE(properties.limits.maxComputeSharedMemorySize, 65536u);
  EXPECT_GE(properties.limits.maxComputeWorkGroupInvocations, 1024u);
  const auto set_layout = client.set_layout({{0, kStorage, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr}});
  const VkPipelineLayout layout = client.pipeline_layout(set_layout, 0);
  const VkDescriptorSet set = client.descriptor_set(set_layout);
  for (const uint32_t size : {1024u, 64u, 16u}) {
    const auto out = client.buffer(5 * 4);
    client.write_buffer(set, 0, kStorage, {out.handle, 0, VK_WHOLE_SIZE});
    static constexpr VkSpecializationMapEntry kEntry{0, 0, 4};
    const VkSpecializationInfo specialization{1, &kEntry, 4, &size};
    VkPipeline pipeline = VK_NULL_HANDLE;
    ASSERT_EQ(client.compute_pipeline(layout, client.module(kSharedReduceCompute), &specialization, &pipeline), VK_SUCCESS);
    client.run([&](VkCommandBuffer cb) {
      VK(client, CmdBindPipeline)(cb, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline);
      VK(client, CmdBindDescriptorSets)(cb, VK_PIPELINE_BIND_POINT_COMPUTE, layout, 0, 1, &set, 0, nullptr);
      VK(client, CmdDispatch)(cb, 5, 1, 1);
    });
    for (uint32_t g = 0; g < 5; ++g) {
      EXPECT_EQ(out.as<uint32_t>()[g], 7u * (16384u * 16383u / 2) + 16384u * g) << size << " " << g;
    }
  }
}

// "Dynamically uniform" indices of arrays of uniform and storage buffers.
TEST(IcdCompute, BufferArraysAreIndexedDynamically) {
  constexpr VkDescriptorType kUniform = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
  PipelineClient client;
  const auto set_layout = client.set_layout(
      {{0, kUniform, 4, VK_SHADER_STAGE_COMPUTE_BIT, nullptr}, {1, kStorage, 2, VK_SHADER_STAGE_COMPUTE_BIT, nullptr}});
  const VkPipelineLayout layout = client.pipeline_layout(set_layout, 4);
  const VkDescriptorSet set = client.descriptor_set(set_layout);
  const auto in = client.buffer(64), out = client.buffer(128);
  for (uint32_t i = 0; i < 4; ++i) {
    in.as<uint32_t>()[i * 4] = 1000 * i + 7;
    client.write_buffer(set, 0, kUniform, {in.handle, i * 16, 16}, i);
  }
  for (uint32_t i = 0; i < 2; ++i) client.write_buffer(set, 1, kStorage, {out.handle, i * 64, 64}, i);
  VkPipeline pipeline = VK_NULL_HANDLE;
  ASSERT_EQ(client.compute_pipeline(layout, client.module(kArraysCompute), nullptr, &pipeline), VK_SUCCESS);
  for (uint32_t first = 0; first < 4; ++first) {
    client.run([&](VkCommandBuffer cb) {
      VK(client, CmdBindPipeline)(cb, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline);
      VK(client, CmdBindDescriptorSets)(cb, VK_PIPELINE_BIND_POINT_COMPUTE, layout, 0, 1, &set, 0, nullptr);
      VK(client, CmdPushConstants)(cb, layout, VK_SHADER_STAGE_ALL, 0, 4, &first);
      VK(client, CmdDispatch)(cb, 1, 1, 1);
    });
    for (uint32_t i = 0; i < 16; ++i) EXPECT_EQ(out.as<uint32_t>()[(first & 1) * 16 + i], 1000 * first + 7 + i);
  }
}

// destination(y, x) = source(x, y).bgra, with a size that fills no workgroup: what lies outside is neither read nor written.
TEST(IcdCompute, StorageImages) {
  constexpr VkDescriptorType kImage = VK_DESCRIPTOR_TYPE_STORAGE_IMAGE;
  constexpr VkFormat kFormat = VK_FORMAT_R8G8B8A8_UNORM;
  constexpr uint32_t kWidth = 13, kHeight = 21;
  PipelineClient client;
  VkFormatProperties properties;
  VK(client, GetPhysicalDeviceFormatProperties)(client.physical, kFormat, &properties);
  ASSERT_TRUE(properties.optimalTilingFeatures & VK_FORMAT_FEATURE_STORAGE_IMAGE_BIT);
  const auto set_layout = client.set_layout(
      {{0, kImage, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr}, {1, kImage, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr}});
  const VkPipelineLayout layout = client.pipeline_layout(set_layout, 0);
  const VkDescriptorSet set = client.descriptor_set(set_layout);
  const VkImage source = client.image(kFormat, {kWidth, kHeight, 1}, 1, 1, VK_IMAGE_USAGE_STORAGE_BIT);
  const VkImage destination = client.image(kFormat, {kHeight, kWidth, 1}, 1, 1, VK_IMAGE_USAGE_STORAGE_BIT);
  client.write_image(set, 0, kImage, client.view(source, kFormat));
  client.write_image(set, 1, kImage, client.view(destination, kFormat));
  VkPipeline pipeline = VK_NULL_HANDLE;
  ASSERT_EQ(client.compute_pipeline(layout, client.module(kStorageImageCompute), nullptr, &pipeline), VK_SUCCESS);
  const auto in = client.buffer(kWidth * kHeight * 4), out = client.buffer(kWidth * kHeight * 4);
  for (uint32_t i = 0; i < kWidth * kHeight; ++i) in.as<uint32_t>()[i] = i * 2654435761u;
  client.run([&](VkCommandBuffer cb) {
    const VkBufferImageCopy upload{0, 0, 0, color_layers(), {}, {kWidth, kHeight, 1}};
    const VkBufferImageCopy download{0, 0, 0, color_layers(), {}, {kHeight, kWidth, 1}};
    VK(client, CmdCopyBufferToImage)(cb, in.handle, source, VK_IMAGE_LAYOUT_GENERAL, 1, &upload);
    client.barrier(cb);
    VK(client, CmdBindPipeline)(cb, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline);
    VK(client, CmdBindDescriptorSets)(cb, VK_PIPELINE_BIND_POINT_COMPUTE, layout, 0, 1, &set, 0, nullptr);
    VK(client, CmdDispatch)(cb, 2, 3, 1);
    client.barrier(cb);
    VK(client, CmdCopyImageToBuffer)(cb, destination, VK_IMAGE_LAYOUT_GENERAL, out.handle, 1, &download);
  });
  for (uint32_t y = 0; y < kHeight; ++y) {
    for (uint32_t x = 0; x < kWidth; ++x) {
      const uint32_t t = in.as<uint32_t>()[y * kWidth + x];
      ASSERT_EQ(out.as<uint32_t>()[x * kHeight + y], (t & 0xFF00FF00u) | (t & 0xFFu) << 16 | (t >> 16 & 0xFFu)) << x << ' ' << y;
    }
  }
}

// Invalid, but not a crash: without sets reads give zero and stores do nothing.
TEST(IcdCompute, UnboundSetsAreHarmless) {
  breaks_on_purpose({"VUID-vkCmdDispatch-None-02697", "VUID-vkCmdDispatch-maintenance4-06425"});
  ComputeFixture f;
  const VkPipeline pipeline = f.pipeline(1);
  f.client.run([&](VkCommandBuffer cb) {
    VK(f.client, CmdBindPipeline)(cb, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline);
    VK(f.client, CmdDispatch)(cb, 4, 1, 1);
  });
  for (int i = 0; i < 256; ++i) EXPECT_EQ(f.out.as<uint32_t>()[i], 0u);
}

struct Messages {
  std::vector<std::string> texts;
  static VkBool32 receive(VkDebugUtilsMessageSeverityFlagBitsEXT, VkDebugUtilsMessageTypeFlagsEXT,
                          const VkDebugUtilsMessengerCallbackDataEXT* data, void* self) {
    static_cast<Messages*>(self)->texts.push_back(data->pMessage);
    return VK_FALSE;
  }
};

TEST(IcdCompute, InvalidShadersAreErrorsWithWords) {
  Messages messages;
  PipelineClient client(nullptr, {VK_EXT_DEBUG_UTILS_EXTENSION_NAME});
  VkDebugUtilsMessengerCreateInfoEXT info{VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT};
  info.messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
  info.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_GENERAL_BIT_EXT;
  info.pfnUserCallback = Messages::receive;
  info.pUserData = &messages;
  VkDebugUtilsMessengerEXT messenger;
  ASSERT_EQ(VK(client, CreateDebugUtilsMessengerEXT)(client.instance, &info, nullptr, &messenger), VK_SUCCESS);
  const VkPipelineLayout layout = client.pipeline_layout(std::nullopt, 4);
  const std::span whole(kScaleCompute);
  std::vector<uint32_t> no_magic(whole.begin(), whole.end()), wrong_stage(std::begin(kColorVertex), std::end(kColorVertex));
  no_magic[0] = 0;
  for (const std::span<const uint32_t> words : {std::span<const uint32_t>(no_magic), std::span<const uint32_t>(wrong_stage),
                                                whole.first(5), whole.first(whole.size() / 2), whole.first(whole.size() - 3)}) {
    messages.texts.clear();
    const VkShaderModule module = client.module(words);
    const VkDebugUtilsObjectNameInfoEXT name{VK_STRUCTURE_TYPE_DEBUG_UTILS_OBJECT_NAME_INFO_EXT, nullptr,
                                             VK_OBJECT_TYPE_SHADER_MODULE, reinterpret_cast<uint64_t>(module), "broken"};
    VK(client, SetDebugUtilsObjectNameEXT)(client.device, &name);
    VkPipeline pipeline;
    EXPECT_EQ(client.compute_pipeline(layout, module, nullptr, &pipeline), VK_ERROR_UNKNOWN);
    EXPECT_EQ(pipeline, VkPipeline(VK_NULL_HANDLE));
    ASSERT_EQ(messages.texts.size(), 1u);
    EXPECT_NE(messages.texts[0].find("'broken'"), std::string::npos) << messages.texts[0];
  }
  VK(client, DestroyDebugUtilsMessengerEXT)(client.instance, messenger, nullptr);
  messages.texts.clear();
  VkPipeline pipeline;
  EXPECT_EQ(client.compute_pipeline(layout, client.module(no_magic), nullptr, &pipeline), VK_ERROR_UNKNOWN);
  EXPECT_TRUE(messages.texts.empty()) << "the messenger is gone";
}

// Words of a valid module with one replaced: any result is fine, a crash is not.
TEST(IcdCompute, DamagedModulesNeverCrash) {
  constexpr uint32_t kSeed = 7;
  PipelineClient client;
  const auto set_layout =
      client.set_layout({{0, kStorage, 1, VK_SHADER_STAGE_ALL, nullptr}, {1, kStorage, 1, VK_SHADER_STAGE_ALL, nullptr}});
  const VkPipelineLayout layout = client.pipeline_layout(set_layout, 4);
  std::mt19937 random(kSeed);
  for (int i = 0; i < 300; ++i) {
    std::vector<uint32_t> words(std::begin(kScaleCompute), std::end(kScaleCompute));
    words[5 + random() % (words.size() - 5)] = random() % 2 ? random() : random() % 64;
    VkPipeline pipeline;
    client.compute_pipeline(layout, client.module(words), nullptr, &pipeline);
  }
}

}  // namespace
}  // namespace pineda::test
