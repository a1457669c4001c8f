// VkPipelineCache: its data, what becomes of damaged data, and pipelines that come from it. Pipelines created together.
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>
#include <thread>

#include "icd_pipeline_client.h"
#include "icd_shaders.h"
#include "tests/paths.h"
#include "tests/process.h"

namespace pineda::test {
namespace {

namespace fs = std::filesystem;

constexpr uint32_t kSeed = 3;
constexpr VkDescriptorType kStorage = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
constexpr VkSpecializationMapEntry kBiasEntry{7, 0, 4};

// Before the driver reads the environment: what these tests see comes from their pipeline caches alone.
[[maybe_unused]] const int kNoDiskCache = setenv("PINEDA_CACHE", "off", 0);

// b[i] = a[i] * scale + i + bias, one pipeline for each bias.
struct Fixture {
  PipelineClient client;
  VkDescriptorSetLayout set_layout = client.set_layout(
      {{0, kStorage, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr}, {1, kStorage, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr}});
  VkPipelineLayout layout = client.pipeline_layout(set_layout, 4);
  VkDescriptorSet set = client.descriptor_set(set_layout);
  VkShaderModule shader = client.module(kScaleCompute);
  Client::Buffer in = client.buffer(128), out = client.buffer(128);

  Fixture() {
    for (uint32_t i = 0; i < 32; ++i) in.as<uint32_t>()[i] = i * 77;
    client.write_buffer(set, 0, kStorage, {in.handle, 0, VK_WHOLE_SIZE});
    client.write_buffer(set, 1, kStorage, {out.handle, 0, VK_WHOLE_SIZE});
  }

  VkPipelineCache cache(std::span<const uint8_t> data = {}) {
    VkPipelineCacheCreateInfo info{VK_STRUCTURE_TYPE_PIPELINE_CACHE_CREATE_INFO};
    info.initialDataSize = data.size();
    info.pInitialData = data.data();
    VkPipelineCache made = VK_NULL_HANDLE;
    EXPECT_EQ(VK(client, CreatePipelineCache)(client.device, &info, nullptr, &made), VK_SUCCESS);
    client.defer([this, made] { VK(client, DestroyPipelineCache)(client.device, made, nullptr); });
    return made;
  }
  std::vector<uint8_t> data(VkPipelineCache from) {
    size_t size_bytes = 0;
    EXPECT_EQ(VK(client, GetPipelineCacheData)(client.device, from, &size_bytes, nullptr), VK_SUCCESS);
    std::vector<uint8_t> bytes(size_bytes);
    EXPECT_EQ(VK(client, GetPipelineCacheData)(client.device, from, &size_bytes, bytes.data()), VK_SUCCESS);
    EXPECT_EQ(size_bytes, bytes.size());
    return bytes;
  }

  std::vector<VkPipeline> pipelines(VkPipelineCache with, uint32_t first_bias, uint32_t count) {
    std::vector<uint32_t> biases(count);
    std::vector<VkSpecializationInfo> specializations(count);
    std::vector<VkComputePipelineCreateInfo> infos(count);
    for (uint32_t i = 0; i < count; ++i) {
      biases[i] = first_bias + i;
      specializations[i] = {1, &kBiasEntry, 4, &biases[i]};
      infos[i] = {VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO};
      infos[i].stage = {VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                        nullptr,
                        0,
                        VK_SHADER_STAGE_COMPUTE_BIT,
                        shader,
                        "main",
                        &specializations[i]};
      infos[i].layout = layout;
    }
    std::vector<VkPipeline> made(count);
    EXPECT_EQ(VK(client, CreateComputePipelines)(client.device, with, count, infos.data(), nullptr, made.data()), VK_SUCCESS);
    return made;
  }
  void destroy(const std::vector<VkPipeline>& all) {
    for (const VkPipeline pipeline : all) VK(client, DestroyPipeline)(client.device, pipeline, nullptr);
  }
  void expect_computes(VkPipeline pipeline, uint32_t bias) {
    const uint32_t scale = 3;
    client.run([&](VkCommandBuffer cb) {
      VK(client, CmdBindPipeline)(cb, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline);
      VK(client, CmdBindDescriptorSets)(cb, VK_PIPELINE_BIND_POINT_COMPUTE, layout, 0, 1, &set, 0, nullptr);
      VK(client, CmdPushConstants)(cb, layout, VK_SHADER_STAGE_ALL, 0, 4, &scale);
      VK(client, CmdDispatch)(cb, 1, 1, 1);
    });
    for (uint32_t i = 0; i < 32; ++i) ASSERT_EQ(out.as<uint32_t>()[i], in.as<uint32_t>()[i] * scale + i + bias) << i;
  }
  // Code of `count` pipelines.
  std::vector<uint8_t> filled(uint32_t first_bias, uint32_t count) {
    const VkPipelineCache made = cache();
    destroy(pipelines(made, first_bias, count));
    return data(made);
  }
};

constexpr size_t kHeaderBytes = sizeof(VkPipelineCacheHeaderVersionOne);

TEST(IcdPipelineCache, HeaderIsThatOfTheDevice) {
  Fixture f;
  const std::vector<uint8_t> bytes = f.data(f.cache());
  ASSERT_EQ(bytes.size(), kHeaderBytes);
  VkPipelineCacheHeaderVersionOne header;
  std::memcpy(&header, bytes.data(), sizeof header);
  VkPhysicalDeviceProperties properties;
  VK(f.client, GetPhysicalDeviceProperties)(f.client.physical, &properties);
  EXPECT_EQ(header.headerSize, 32u);
  EXPECT_EQ(header.headerVersion, VK_PIPELINE_CACHE_HEADER_VERSION_ONE);
  EXPECT_EQ(header.vendorID, properties.vendorID);
  EXPECT_EQ(header.deviceID, properties.deviceID);
  EXPECT_EQ(std::memcmp(header.pipelineCacheUUID, properties.pipelineCacheUUID, VK_UUID_SIZE), 0);
}

// Machine code may be generated after vkCreate*Pipelines has returned: whoever needs it waits for it, whoever does not may go.
TEST(IcdPipelineCache, PipelinesThatAreNotFinished) {
  std::vector<uint8_t> bytes;
  {
    Fixture f;
    const VkPipelineCache cache = f.cache();
    for (uint32_t i = 0; i < 8; ++i) f.destroy(f.pipelines(cache, 900 + i, 1));
    bytes = f.data(cache);
    const std::vector<VkPipeline> unused = f.pipelines(f.cache(), 920, 6);
    f.destroy(f.pipelines({}, 930, 6));
    for (uint32_t i = 0; i < 4; ++i) {
      const std::vector<VkPipeline> used = f.pipelines({}, 940 + i, 2);
      f.expect_computes(used[1], 941 + i);
      f.destroy(used);
    }
    f.destroy(unused);
  }  // the device goes while kernels of 920 and 930 may be under way
  Fixture f;
  const VkPipelineCache again = f.cache(bytes);
  f.destroy(f.pipelines(again, 900, 8));
  EXPECT_EQ(f.data(again), bytes) << "all eight were there";
}

TEST(IcdPipelineCache, PipelinesGoInAndComeBack) {
  Fixture f;
  const std::vector<uint8_t> bytes = f.filled(100, 3);
  EXPECT_GT(bytes.size(), kHeaderBytes);
  const VkPipelineCache second = f.cache(bytes);
  EXPECT_EQ(f.data(second), bytes);
  const std::vector<VkPipeline> made = f.pipelines(second, 100, 3);
  for (uint32_t i = 0; i < 3; ++i) f.expect_computes(made[i], 100 + i);
  EXPECT_EQ(f.data(second), bytes) << "nothing was added";
  f.destroy(made);
}

// "If pData is not NULL ... and dataSize is less than the maximum size that can be retrieved, at most pDataSize bytes will be
// written, and VK_INCOMPLETE will be returned"; what was written is a valid cache.
TEST(IcdPipelineCache, IncompleteDataIsValid) {
  Fixture f;
  const VkPipelineCache full = f.cache(f.filled(200, 4));
  const std::vector<uint8_t> whole = f.data(full);
  for (size_t room = 0; room < whole.size(); room += 97) {
    std::vector<uint8_t> part(whole.size(), 0xAB);
    size_t size_bytes = room;
    ASSERT_EQ(VK(f.client, GetPipelineCacheData)(f.client.device, full, &size_bytes, part.data()), VK_INCOMPLETE);
    ASSERT_LE(size_bytes, room);
    ASSERT_TRUE(size_bytes == 0 || size_bytes >= kHeaderBytes);
    for (size_t i = size_bytes; i < part.size(); ++i) ASSERT_EQ(part[i], 0xAB);
    part.resize(size_bytes);
    if (size_bytes == 0) continue;
    ASSERT_EQ(f.data(f.cache(part)), part);
  }
}

TEST(IcdPipelineCache, Merge) {
  Fixture f;
  const VkPipelineCache all = f.cache(f.filled(300, 4));
  const VkPipelineCache parts[2] = {f.cache(f.filled(300, 2)), f.cache(f.filled(302, 2))}, merged = f.cache();
  EXPECT_EQ(VK(f.client, MergePipelineCaches)(f.client.device, merged, 2, parts), VK_SUCCESS);
  EXPECT_EQ(f.data(merged), f.data(all));
}

// Foreign headers, every prefix, random damage: the cache is smaller, pipelines are right.
TEST(IcdPipelineCache, DamagedDataIsLeftOut) {
  Fixture f;
  const std::vector<uint8_t> good = f.filled(400, 2);
  for (size_t at = 0; at < kHeaderBytes; ++at) {
    std::vector<uint8_t> foreign = good;
    foreign[at] ^= 1;
    ASSERT_EQ(f.data(f.cache(foreign)).size(), kHeaderBytes) << at;
  }
  std::mt19937 random(kSeed);
  for (int i = 0; i < 300; ++i) {
    std::vector<uint8_t> bad = good;
    if (i % 3 == 0) bad.resize(random() % bad.size());
    const size_t flips = 1 + random() % 3;
    for (size_t k = 0; k < flips && !bad.empty(); ++k) bad[random() % bad.size()] ^= static_cast<uint8_t>(1 + random() % 255);
    const VkPipelineCache cache = f.cache(bad);
    ASSERT_LE(f.data(cache).size(), good.size());
    if (i % 30 != 0) continue;
    const std::vector<VkPipeline> made = f.pipelines(cache, 400, 2);
    f.expect_computes(made[1], 401);
    f.destroy(made);
  }
}

TEST(IcdPipelines, ManyInOneCallAndFromManyThreads) {
  Fixture f;
  const VkPipelineCache cache = f.cache();
  std::vector<VkPipeline> made[4];
  std::vector<std::thread> threads;
  for (uint32_t t = 0; t < 4; ++t)
    threads.emplace_back([&, t] { made[t] = f.pipelines(cache, 500 + t / 2, 16); });  // pairs share
  for (std::thread& thread : threads) thread.join();
  for (uint32_t t = 0; t < 4; ++t) {
    for (const uint32_t i : {0u, 7u, 15u}) f.expect_computes(made[t][i], 500 + t / 2 + i);
    f.destroy(made[t]);
  }
}

// The first failure is the result; the others are made.
TEST(IcdPipelines, AFailedOneLeavesTheOthers) {
  Fixture f;
  VkComputePipelineCreateInfo infos[3];
  for (auto& info : infos) {
    info = {VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO};
    info.stage = {
        VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO, nullptr, 0, VK_SHADER_STAGE_COMPUTE_BIT, f.shader, "main", nullptr};
    info.layout = f.layout;
  }
  infos[1].stage.pName = "no such entry point";
  VkPipeline made[3];
  EXPECT_NE(VK(f.client, CreateComputePipelines)(f.client.device, VK_NULL_HANDLE, 3, infos, nullptr, made), VK_SUCCESS);
  EXPECT_NE(made[0], VK_NULL_HANDLE);
  EXPECT_EQ(made[1], VK_NULL_HANDLE);
  EXPECT_NE(made[2], VK_NULL_HANDLE);
  f.expect_computes(made[2], 5);
  f.destroy({made[0], made[2]});
}

// The cache on disk: pictures are the same with an empty one, a full one and a damaged one.
TEST(IcdDiskCache, KeepsTheBits) {
  const fs::path directory = fs::temp_directory_path() / ("pineda-api-cache-" + std::to_string(getpid()));
  fs::remove_all(directory);
  const std::string command = "PINEDA_CACHE=" + directory.string() + " " + tests::build_dir() + "/pineda golden " +
                              tests::source_dir() + "/tests/golden/scenes.txt";
  const auto draw = [&] {
    const tests::ProcessResult result = tests::run_process(command);
    EXPECT_EQ(result.exit_status, 0) << result.output;
    return static_cast<size_t>(std::distance(fs::directory_iterator(directory), fs::directory_iterator()));
  };
  const size_t files = draw();
  EXPECT_GT(files, 4u);
  EXPECT_GE(draw(), files);  // more when background compiles came to their end this time
  std::mt19937 random(kSeed);
  for (const auto& entry : fs::directory_iterator(directory)) {
    if (random() % 2) {
      fs::resize_file(entry.path(), fs::file_size(entry.path()) / 2);
    } else {
      std::fstream(entry.path(), std::ios::in | std::ios::out | std::ios::binary).seekp(60) << "damage";
    }
  }
  EXPECT_GE(draw(), files);
  fs::remove_all(directory);
}

// Two processes that fill one empty directory at the same time, while a third one damages what it finds there.
TEST(IcdDiskCache, ProcessesRace) {
  const fs::path directory = fs::temp_directory_path() / ("pineda-api-race-" + std::to_string(getpid()));
  fs::remove_all(directory);
  const std::string command = "PINEDA_CACHE=" + directory.string() + " " + tests::build_dir() + "/pineda golden " +
                              tests::source_dir() + "/tests/golden/scenes.txt";
  std::atomic<int> running{2};
  std::thread processes[2];
  for (std::thread& process : processes) {
    process = std::thread([&] {
      const tests::ProcessResult result = tests::run_process(command);
      EXPECT_EQ(result.exit_status, 0) << result.output;
      --running;
    });
  }
  std::mt19937 random(kSeed);
  while (running > 0) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    std::error_code gone;
    for (fs::directory_iterator at(directory, gone), end; !gone && at != end; at.increment(gone)) {
      std::error_code ignored;
      if (random() % 16 == 0) fs::resize_file(at->path(), random() % 4096, ignored);
    }
  }
  for (std::thread& process : processes) process.join();
  const tests::ProcessResult after = tests::run_process(command);
  EXPECT_EQ(after.exit_status, 0) << after.output;
  for (const auto& entry : fs::directory_iterator(directory)) {
    EXPECT_EQ(entry.path().extension(), ".kernel") << "what was being written is gone or whole: " << entry.path();
  }
  fs::remove_all(directory);
}

}  // namespace
}  // namespace pineda::test
