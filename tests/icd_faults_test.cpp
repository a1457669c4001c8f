// What goes wrong around a driver: shaders without end, forks, exits without a word, loading and unloading, many threads, and
// destruction in every order that is legal.
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <mutex>
#include <random>
#include <string>
#include <thread>

#include "icd_pipeline_client.h"
#include "icd_shaders.h"
#include "icd_shaders_driver.h"
#include "tests/process.h"

namespace pineda::test {
namespace {

using std::chrono::steady_clock;

// Runs the body in a child process; its exit status, or 128 + the signal that ended it (SIGKILL after ten seconds).
template <typename Body>
int in_child(Body&& body) {
  fflush(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    alarm(10);
    signal(SIGALRM, SIG_DFL);
    body();
    _exit(99);  // the body leaves by itself
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

size_t resident_bytes() {
  std::ifstream statm("/proc/self/statm");
  size_t total = 0, resident = 0;
  statm >> total >> resident;
  return resident * size_t(sysconf(_SC_PAGESIZE));
}

size_t mapping_count() {
  std::ifstream maps("/proc/self/maps");
  return size_t(std::count(std::istreambuf_iterator<char>(maps), {}, '\n'));
}

// What a messenger was told.
struct Messages {
  std::string text, objects, command_labels, queue_labels;
};

VkBool32 keep_message(VkDebugUtilsMessageSeverityFlagBitsEXT, VkDebugUtilsMessageTypeFlagsEXT,
                      const VkDebugUtilsMessengerCallbackDataEXT* data, void* to) {
  auto& messages = *static_cast<Messages*>(to);
  messages.text += data->pMessage;
  for (uint32_t i = 0; i < data->objectCount; ++i) {
    messages.objects += std::to_string(data->pObjects[i].objectType) + ":";
    messages.objects += data->pObjects[i].pObjectName ? data->pObjects[i].pObjectName : "?";
  }
  for (uint32_t i = 0; i < data->cmdBufLabelCount; ++i)
    messages.command_labels += data->pCmdBufLabels[i].pLabelName + std::string(";");
  for (uint32_t i = 0; i < data->queueLabelCount; ++i)
    messages.queue_labels += data->pQueueLabels[i].pLabelName + std::string(";");
  return VK_FALSE;
}

// Dispatches a shader that never ends; 0 when the device is lost in time and the message says why.
int dispatch_endless(std::span<const uint32_t> shader) {
  loses_device();
  Client::Buffer buffer;
  Messages messages;
  PipelineClient client(nullptr, {VK_EXT_DEBUG_UTILS_EXTENSION_NAME}, {VK_EXT_DEVICE_FAULT_EXTENSION_NAME});
  VkDebugUtilsMessengerCreateInfoEXT messenger_info{VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT};
  messenger_info.messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
  messenger_info.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_GENERAL_BIT_EXT;
  messenger_info.pUserData = &messages;
  messenger_info.pfnUserCallback = keep_message;
  VkDebugUtilsMessengerEXT messenger = VK_NULL_HANDLE;
  VK(client, CreateDebugUtilsMessengerEXT)(client.instance, &messenger_info, nullptr, &messenger);
  const VkDescriptorSetLayout set_layout =
      client.set_layout({{0, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr}});
  const VkPipelineLayout layout = client.pipeline_layout(set_layout, 0);
  const VkDescriptorSet set = client.descriptor_set(set_layout);
  buffer = client.buffer(64);
  client.write_buffer(set, 0, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, {buffer.handle, 0, VK_WHOLE_SIZE});
  VkPipeline pipeline = VK_NULL_HANDLE;
  if (client.compute_pipeline(layout, client.module(shader), nullptr, &pipeline) != VK_SUCCESS) return 1;
  const VkCommandBuffer cb = client.command_buffer();
  const VkDebugUtilsObjectNameInfoEXT name{VK_STRUCTURE_TYPE_DEBUG_UTILS_OBJECT_NAME_INFO_EXT, nullptr,
                                           VK_OBJECT_TYPE_COMMAND_BUFFER, reinterpret_cast<uint64_t>(cb), "the endless one"};
  VK(client, SetDebugUtilsObjectNameEXT)(client.device, &name);
  client.begin(cb);
  const auto label = [](const char* text) {
    return VkDebugUtilsLabelEXT{VK_STRUCTURE_TYPE_DEBUG_UTILS_LABEL_EXT, nullptr, text, {}};
  };
  const auto over = label("over"), frame = label("frame"), physics = label("physics"), queue_label = label("loading");
  VK(client, CmdBeginDebugUtilsLabelEXT)(cb, &over);
  VK(client, CmdEndDebugUtilsLabelEXT)(cb);
  VK(client, CmdBeginDebugUtilsLabelEXT)(cb, &frame);
  VK(client, CmdInsertDebugUtilsLabelEXT)(cb, &over);
  VK(client, CmdBeginDebugUtilsLabelEXT)(cb, &physics);
  VK(client, CmdBindPipeline)(cb, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline);
  VK(client, CmdBindDescriptorSets)(cb, VK_PIPELINE_BIND_POINT_COMPUTE, layout, 0, 1, &set, 0, nullptr);
  VK(client, CmdDispatch)(cb, 2, 1, 1);
  VK(client, CmdEndDebugUtilsLabelEXT)(cb);
  VK(client, CmdEndDebugUtilsLabelEXT)(cb);
  VK(client, EndCommandBuffer)(cb);
  VkDeviceFaultCountsEXT counts{VK_STRUCTURE_TYPE_DEVICE_FAULT_COUNTS_EXT};
  VkDeviceFaultInfoEXT info{VK_STRUCTURE_TYPE_DEVICE_FAULT_INFO_EXT};
  VK(client, QueueBeginDebugUtilsLabelEXT)(client.queue, &queue_label);
  const auto start = steady_clock::now();
  (void)client.submit(cb);  // may execute it, and then says so itself
  if (VK(client, QueueWaitIdle)(client.queue) != VK_ERROR_DEVICE_LOST) return 2;
  if (steady_clock::now() - start > std::chrono::seconds(5)) return 3;
  VK(client, QueueEndDebugUtilsLabelEXT)(client.queue);
  if (messages.text.find("PINEDA_TIMEOUT") == std::string::npos) return 4;
  if (messages.text.find("command buffer 'the endless one', label 'frame > physics', queue label 'loading'") ==
      std::string::npos) {
    printf("%s\n", messages.text.c_str());
    return 5;
  }
  if (messages.objects != std::to_string(VK_OBJECT_TYPE_COMMAND_BUFFER) + ":the endless one") return 6;
  if (messages.command_labels != "physics;frame;" || messages.queue_labels != "loading;") return 7;  // innermost first
  if (VK(client, GetDeviceFaultInfoEXT)(client.device, &counts, nullptr) != VK_SUCCESS || counts.addressInfoCount != 0) return 8;
  if (VK(client, GetDeviceFaultInfoEXT)(client.device, &counts, &info) != VK_SUCCESS) return 9;
  if (std::string(info.description).find("PINEDA_TIMEOUT") == std::string::npos) return 10;
  VK(client, DestroyDebugUtilsMessengerEXT)(client.instance, messenger, nullptr);
  return 0;
}

// Run by the test below in processes of their own, because the environment is read once per process.
TEST(IcdFaultsChild, DISABLED_EndlessStores) { EXPECT_EQ(dispatch_endless(kEndlessStores), 0); }
TEST(IcdFaultsChild, DISABLED_EndlessArithmetic) { EXPECT_EQ(dispatch_endless(kEndlessArithmetic), 0); }

TEST(IcdFaults, ShadersThatNeverEndLoseTheDevice) {
  char self[4096] = {};
  ASSERT_GT(readlink("/proc/self/exe", self, sizeof(self) - 1), 0);
  for (const char* environment : {"PINEDA_MODE=jit", "PINEDA_MODE=jit PINEDA_ISA=sse42", "PINEDA_MODE=f32"}) {
    const tests::ProcessResult result =
        tests::run_process(std::string("PINEDA_TIMEOUT=1 ") + environment + " timeout 20 " + self +
                           " --gtest_also_run_disabled_tests --gtest_filter=IcdFaultsChild.*");
    EXPECT_EQ(result.exit_status, 0) << environment << "\n" << result.output;
    EXPECT_NE(result.output.find("2 tests from 1 test suite ran"), std::string::npos) << result.output;
  }
}

TEST(IcdFaults, AThousandDevicesLeaveNothing) {
  const auto cycle = [] {
    Client client;
    ASSERT_EQ(client.result, VK_SUCCESS);
    const auto buffer = client.buffer(64);
    client.run([&](VkCommandBuffer cb) { VK(client, CmdFillBuffer)(cb, buffer.handle, 0, 64, 1); });
  };
  for (int i = 0; i < 100; ++i) cycle();
  const size_t resident = resident_bytes(), mappings = mapping_count();
  for (int i = 0; i < 1000; ++i) cycle();
  EXPECT_LT(resident_bytes(), resident + (1u << 20));
  EXPECT_LE(mapping_count(), mappings + 4) << "the allocator may map a heap of its own";
}

// The child has the parent's memory but none of its threads: a new device works there, and the parent's is not disturbed.
TEST(IcdFaults, AForkedProcessUsesADeviceOfItsOwn) {
  Client parent;
  const auto buffer = parent.buffer(32u << 20);
  const auto fill = [](Client& client, const Client::Buffer& to, uint32_t value) {
    client.run([&](VkCommandBuffer cb) { VK(client, CmdFillBuffer)(cb, to.handle, 0, VK_WHOLE_SIZE, value); });
    return to.as<uint32_t>()[1 << 20] == value;
  };
  ASSERT_TRUE(fill(parent, buffer, 1));
  EXPECT_EQ(in_child([&] {
              Client child;
              const auto own = child.buffer(32u << 20);
              _exit(child.result == VK_SUCCESS && fill(child, own, 7) ? 0 : 1);
            }),
            0);
  EXPECT_TRUE(fill(parent, buffer, 2));
}

TEST(IcdFaults, ExitWithoutDestroying) {
  EXPECT_EQ(in_child([] {
              auto* client = new Client;  // never destroyed
              const auto buffer = client->buffer(64u << 20);
              const VkCommandBuffer cb = client->command_buffer();
              client->begin(cb);
              for (int i = 0; i < 4; ++i) VK(*client, CmdFillBuffer)(cb, buffer.handle, 0, VK_WHOLE_SIZE, uint32_t(i));
              VK(*client, EndCommandBuffer)(cb);
              (void)client->submit(cb);
              std::exit(0);  // while it executes
            }),
            0);
}

// A copy of the library, so that the one of the other tests does not keep it loaded.
TEST(IcdFaults, LoadedAndUnloadedAHundredTimes) {
  char folder[] = "/tmp/pineda-unload-XXXXXX";
  ASSERT_NE(mkdtemp(folder), nullptr);
  const std::string copy = std::string(folder) + "/libvk_pineda.so";
  ASSERT_EQ(symlink((tests::build_dir() + "/libpineda_jit.so").c_str(), (std::string(folder) + "/libpineda_jit.so").c_str()), 0);
  {
    std::ifstream from(tests::build_dir() + "/libvk_pineda.so", std::ios::binary);
    std::ofstream(copy, std::ios::binary) << from.rdbuf();
  }
  size_t mappings = 0;
  for (int i = 0; i < 100; ++i) {
    void* library = dlopen(copy.c_str(), RTLD_NOW | RTLD_LOCAL);
    ASSERT_NE(library, nullptr) << dlerror();
    const auto get = reinterpret_cast<GetProcFn>(dlsym(library, "vk_icdGetInstanceProcAddr"));
    const auto create = reinterpret_cast<PFN_vkCreateInstance>(get(nullptr, "vkCreateInstance"));
    const VkInstanceCreateInfo info{VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO};
    VkInstance instance = VK_NULL_HANDLE;
    ASSERT_EQ(create(&info, nullptr, &instance), VK_SUCCESS);
    uint32_t count = 1;
    VkPhysicalDevice physical;
    reinterpret_cast<PFN_vkEnumeratePhysicalDevices>(get(instance, "vkEnumeratePhysicalDevices"))(instance, &count, &physical);
    const float priority = 1;
    const VkDeviceQueueCreateInfo queue_info{VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO, nullptr, 0, 0, 1, &priority};
    VkDeviceCreateInfo device_info{VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO};
    device_info.queueCreateInfoCount = 1;
    device_info.pQueueCreateInfos = &queue_info;
    VkDevice device = VK_NULL_HANDLE;
    ASSERT_EQ(reinterpret_cast<PFN_vkCreateDevice>(get(instance, "vkCreateDevice"))(physical, &device_info, nullptr, &device),
              VK_SUCCESS);
    reinterpret_cast<PFN_vkDestroyDevice>(get(instance, "vkDestroyDevice"))(device, nullptr);
    reinterpret_cast<PFN_vkDestroyInstance>(get(instance, "vkDestroyInstance"))(instance, nullptr);
    ASSERT_EQ(dlclose(library), 0);
    if (i == 10) mappings = mapping_count();
  }
  EXPECT_LE(mapping_count(), mappings + 4);
  for (const char* name : {"/libvk_pineda.so", "/libpineda_jit.so"}) unlink((std::string(folder) + name).c_str());
  rmdir(folder);
}

// 16 threads, each with its own pool, record and submit to three queues' worth of work under one lock for the queue, as the
// specification asks of applications. Meant for the `tsan` preset too.
TEST(IcdFaults, SixteenThreadsRecordAndSubmit) {
  PipelineClient client;
  constexpr uint32_t kThreads = 16, kRounds = 20, kWords = 64;
  const auto buffer = client.buffer(kThreads * kWords * 4);
  std::mutex queue_mutex;
  const auto work = [&](uint32_t thread) {
    VkCommandPool pool = VK_NULL_HANDLE;
    const VkCommandPoolCreateInfo pool_info{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
    EXPECT_EQ(VK(client, CreateCommandPool)(client.device, &pool_info, nullptr, &pool), VK_SUCCESS);
    const VkFenceCreateInfo fence_info{VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
    VkFence fence = VK_NULL_HANDLE;
    EXPECT_EQ(VK(client, CreateFence)(client.device, &fence_info, nullptr, &fence), VK_SUCCESS);
    for (uint32_t round = 0; round < kRounds; ++round) {
      const VkCommandBufferAllocateInfo info{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO, nullptr, pool,
                                             VK_COMMAND_BUFFER_LEVEL_PRIMARY, 1};
      VkCommandBuffer cb = VK_NULL_HANDLE;
      EXPECT_EQ(VK(client, AllocateCommandBuffers)(client.device, &info, &cb), VK_SUCCESS);
      client.begin(cb);
      for (uint32_t i = 0; i < kWords; ++i) {
        VK(client, CmdFillBuffer)(cb, buffer.handle, (thread * kWords + i) * 4, 4, thread * 1000 + round);
      }
      EXPECT_EQ(VK(client, EndCommandBuffer)(cb), VK_SUCCESS);
      {
        const std::scoped_lock lock(queue_mutex);
        EXPECT_EQ(client.submit(cb, fence), VK_SUCCESS);
      }
      EXPECT_EQ(VK(client, WaitForFences)(client.device, 1, &fence, VK_TRUE, UINT64_MAX), VK_SUCCESS);
      EXPECT_EQ(VK(client, ResetFences)(client.device, 1, &fence), VK_SUCCESS);
      for (uint32_t i = 0; i < kWords; ++i) EXPECT_EQ(buffer.as<uint32_t>()[thread * kWords + i], thread * 1000 + round);
      EXPECT_EQ(VK(client, ResetCommandPool)(client.device, pool, 0), VK_SUCCESS);
    }
    VK(client, DestroyFence)(client.device, fence, nullptr);
    VK(client, DestroyCommandPool)(client.device, pool, nullptr);
  };
  std::vector<std::thread> threads;
  for (uint32_t i = 0; i < kThreads; ++i) threads.emplace_back(work, i);
  for (std::thread& thread : threads) thread.join();
}

// One of everything, drawn with; then destroyed in a random order. Nothing is in use, so every order is legal.
TEST(IcdFaults, DestructionInAnyOrder) {
  constexpr VkFormat kFormat = VK_FORMAT_R8G8B8A8_UNORM;
  for (uint32_t seed = 0; seed < 30; ++seed) {
    PipelineClient client;
    std::vector<std::function<void()>> destroy;
#define DESTROY_LATER(name, handle) \
  destroy.push_back([&client, h = handle] { VK(client, Destroy##name)(client.device, h, nullptr); })
#define CREATE(name, info, handle)                                                         \
  ASSERT_EQ(VK(client, Create##name)(client.device, &info, nullptr, &handle), VK_SUCCESS); \
  DESTROY_LATER(name, handle)
    VkBufferCreateInfo buffer_info{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
    buffer_info.size = 256;
    buffer_info.usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
    VkBuffer buffer;
    CREATE(Buffer, buffer_info, buffer);
    VkImageCreateInfo image_info{VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO};
    image_info.imageType = VK_IMAGE_TYPE_2D;
    image_info.format = kFormat;
    image_info.extent = {16, 16, 1};
    image_info.mipLevels = image_info.arrayLayers = 1;
    image_info.samples = VK_SAMPLE_COUNT_1_BIT;
    image_info.usage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT;
    VkImage image;
    CREATE(Image, image_info, image);
    const VkMemoryAllocateInfo memory_info{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, nullptr, 65536, 0};
    VkDeviceMemory memory;
    ASSERT_EQ(VK(client, AllocateMemory)(client.device, &memory_info, nullptr, &memory), VK_SUCCESS);
    destroy.push_back([&client, memory] { VK(client, FreeMemory)(client.device, memory, nullptr); });
    ASSERT_EQ(VK(client, BindBufferMemory)(client.device, buffer, memory, 0), VK_SUCCESS);
    ASSERT_EQ(VK(client, BindImageMemory)(client.device, image, memory, 4096), VK_SUCCESS);
    VkImageViewCreateInfo view_info{VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO};
    view_info.image = image;
    view_info.viewType = VK_IMAGE_VIEW_TYPE_2D;
    view_info.format = kFormat;
    view_info.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
    VkImageView view;
    CREATE(ImageView, view_info, view);
    const VkSamplerCreateInfo sampler_info{VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO};
    VkSampler sampler;
    CREATE(Sampler, sampler_info, sampler);
    const VkDescriptorSetLayoutBinding bindings[] = {
        {0, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, VK_SHADER_STAGE_ALL, nullptr},
        {1, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 1, VK_SHADER_STAGE_ALL, &sampler}};
    VkDescriptorSetLayoutCreateInfo set_info{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO};
    set_info.bindingCount = 2;
    set_info.pBindings = bindings;
    VkDescriptorSetLayout set_layout;
    CREATE(DescriptorSetLayout, set_info, set_layout);
    VkPipelineLayoutCreateInfo layout_info{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
    layout_info.setLayoutCount = 1;
    layout_info.pSetLayouts = &set_layout;
    VkPipelineLayout layout;
    CREATE(PipelineLayout, layout_info, layout);
    const VkDescriptorPoolSize sizes[] = {{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 2}, {VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 2}};
    const VkDescriptorPoolCreateInfo pool_info{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO, nullptr, 0, 2, 2, sizes};
    VkDescriptorPool pool;
    CREATE(DescriptorPool, pool_info, pool);
    const VkDescriptorSetAllocateInfo allocate{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO, nullptr, pool, 1, &set_layout};
    VkDescriptorSet set;
    ASSERT_EQ(VK(client, AllocateDescriptorSets)(client.device, &allocate, &set), VK_SUCCESS);
    client.write_buffer(set, 0, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, {buffer, 0, VK_WHOLE_SIZE});
    client.write_image(set, 1, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, view, sampler);
    VkShaderModuleCreateInfo module_info{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
    module_info.codeSize = sizeof(kEndlessStores);
    module_info.pCode = kEndlessStores;
    VkShaderModule module;
    CREATE(ShaderModule, module_info, module);
    VkComputePipelineCreateInfo pipeline_info{VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO};
    pipeline_info.stage = {
        VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO, nullptr, 0, VK_SHADER_STAGE_COMPUTE_BIT, module, "main", nullptr};
    pipeline_info.layout = layout;
    VkPipeline pipeline;
    ASSERT_EQ(VK(client, CreateComputePipelines)(client.device, VK_NULL_HANDLE, 1, &pipeline_info, nullptr, &pipeline),
              VK_SUCCESS);
    DESTROY_LATER(Pipeline, pipeline);
    const VkFenceCreateInfo fence_info{VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
    VkFence fence;
    CREATE(Fence, fence_info, fence);
    const VkEventCreateInfo event_info{VK_STRUCTURE_TYPE_EVENT_CREATE_INFO};
    VkEvent event;
    CREATE(Event, event_info, event);
    const VkSemaphoreCreateInfo semaphore_info{VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO};
    VkSemaphore semaphore;
    CREATE(Semaphore, semaphore_info, semaphore);
#undef CREATE
#undef DESTROY_LATER
    const VkCommandBuffer cb = client.command_buffer();
    client.begin(cb);
    VK(client, CmdBindPipeline)(cb, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline);
    VK(client, CmdBindDescriptorSets)(cb, VK_PIPELINE_BIND_POINT_COMPUTE, layout, 0, 1, &set, 0, nullptr);
    VK(client, CmdFillBuffer)(cb, buffer, 0, 4, 1);  // the shader's loop ends at once
    client.barrier(cb);
    VK(client, CmdDispatch)(cb, 1, 1, 1);
    EXPECT_EQ(VK(client, EndCommandBuffer)(cb), VK_SUCCESS);
    EXPECT_EQ(client.submit(cb, fence), VK_SUCCESS);
    EXPECT_EQ(VK(client, WaitForFences)(client.device, 1, &fence, VK_TRUE, UINT64_MAX), VK_SUCCESS);
    std::ranges::shuffle(destroy, std::mt19937(seed));
    for (const auto& release : destroy) release();
  }
}

}  // namespace
}  // namespace pineda::test
