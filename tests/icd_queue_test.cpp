// Several queues, semaphores between them, timelines, and that waiting burns no core.
#include <time.h>

#include <chrono>
#include <thread>

#include "icd_client.h"

namespace pineda::test {
namespace {

// The queue of each family and a command pool for each.
class QueueClient : public Client {
 public:
  QueueClient() {
    pools[0] = pool;
    for (uint32_t i = 0; i < kQueueFamilies; ++i) {
      VK(*this, GetDeviceQueue)(device, i, 0, &queues[i]);
      const VkCommandPoolCreateInfo pool_info{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO, nullptr,
                                              VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT, i};
      if (i == 0) continue;
      EXPECT_EQ(VK(*this, CreateCommandPool)(device, &pool_info, nullptr, &pools[i]), VK_SUCCESS);
      defer([this, i] { VK(*this, DestroyCommandPool)(device, pools[i], nullptr); });
    }
  }

  VkSemaphore semaphore(bool timeline, uint64_t value = 0) {
    const VkSemaphoreTypeCreateInfo type{VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO, nullptr, VK_SEMAPHORE_TYPE_TIMELINE,
                                         value};
    const VkSemaphoreCreateInfo info{VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO, timeline ? &type : nullptr};
    VkSemaphore out = VK_NULL_HANDLE;
    EXPECT_EQ(VK(*this, CreateSemaphore)(device, &info, nullptr, &out), VK_SUCCESS);
    defer([this, out] { VK(*this, DestroySemaphore)(device, out, nullptr); });
    return out;
  }

  // A command buffer of the family that fills `words` words of the buffer.
  VkCommandBuffer fill(uint32_t family, VkBuffer buffer, uint32_t first_word, uint32_t words, uint32_t value) {
    const VkCommandBufferAllocateInfo info{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO, nullptr, pools[family],
                                           VK_COMMAND_BUFFER_LEVEL_PRIMARY, 1};
    VkCommandBuffer cb = VK_NULL_HANDLE;
    EXPECT_EQ(VK(*this, AllocateCommandBuffers)(device, &info, &cb), VK_SUCCESS);
    begin(cb);
    VK(*this, CmdFillBuffer)(cb, buffer, first_word * 4ull, words * 4ull, value);
    EXPECT_EQ(VK(*this, EndCommandBuffer)(cb), VK_SUCCESS);
    return cb;
  }

  struct Operation {
    VkSemaphore semaphore = VK_NULL_HANDLE;
    uint64_t value = 0;
  };
  VkResult submit_to(uint32_t family, VkCommandBuffer cb, Operation wait, Operation signal, VkFence fence = VK_NULL_HANDLE) {
    const VkPipelineStageFlags stage = VK_PIPELINE_STAGE_ALL_COMMANDS_BIT;
    const VkTimelineSemaphoreSubmitInfo values{
        VK_STRUCTURE_TYPE_TIMELINE_SEMAPHORE_SUBMIT_INFO, nullptr, 1, &wait.value, 1, &signal.value};
    VkSubmitInfo info{VK_STRUCTURE_TYPE_SUBMIT_INFO, &values};
    info.waitSemaphoreCount = wait.semaphore ? 1 : 0;
    info.pWaitSemaphores = &wait.semaphore;
    info.pWaitDstStageMask = &stage;
    info.commandBufferCount = cb ? 1 : 0;
    info.pCommandBuffers = &cb;
    info.signalSemaphoreCount = signal.semaphore ? 1 : 0;
    info.pSignalSemaphores = &signal.semaphore;
    return VK(*this, QueueSubmit)(queues[family], 1, &info, fence);
  }
  VkResult wait_for(VkSemaphore semaphore, uint64_t value, uint64_t timeout_ns) {
    const VkSemaphoreWaitInfo info{VK_STRUCTURE_TYPE_SEMAPHORE_WAIT_INFO, nullptr, 0, 1, &semaphore, &value};
    return VK(*this, WaitSemaphoresKHR)(device, &info, timeout_ns);
  }
  void signal(VkSemaphore semaphore, uint64_t value) {
    const VkSemaphoreSignalInfo info{VK_STRUCTURE_TYPE_SEMAPHORE_SIGNAL_INFO, nullptr, semaphore, value};
    EXPECT_EQ(VK(*this, SignalSemaphoreKHR)(device, &info), VK_SUCCESS);
  }
  uint64_t value_of(VkSemaphore semaphore) {
    uint64_t value = ~0ull;
    EXPECT_EQ(VK(*this, GetSemaphoreCounterValueKHR)(device, semaphore, &value), VK_SUCCESS);
    return value;
  }

  VkQueue queues[kQueueFamilies] = {};
  VkCommandPool pools[kQueueFamilies] = {};
};

TEST(IcdQueues, FamiliesAreWhatTheySay) {
  QueueClient client;
  uint32_t count = 8;
  VkQueueFamilyProperties families[8];
  VK(client, GetPhysicalDeviceQueueFamilyProperties)(client.physical, &count, families);
  ASSERT_EQ(count, kQueueFamilies);
  EXPECT_EQ(families[0].queueFlags, VkQueueFlags(VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT | VK_QUEUE_TRANSFER_BIT));
  EXPECT_EQ(families[1].queueFlags, VkQueueFlags(VK_QUEUE_COMPUTE_BIT | VK_QUEUE_TRANSFER_BIT));
  EXPECT_EQ(families[2].queueFlags, VkQueueFlags(VK_QUEUE_TRANSFER_BIT));
  EXPECT_NE(client.queues[0], client.queues[1]);
  EXPECT_NE(client.queues[1], client.queues[2]);
}

// A binary semaphore carries work from queue to queue; large fills go to the worker, small ones would run inside vkQueueSubmit if
// the semaphore did not hold them back.
TEST(IcdQueues, BinarySemaphoresOrderQueues) {
  QueueClient client;
  constexpr uint32_t kWords = 4u << 20;
  const auto buffer = client.buffer(kWords * 4ull);
  const VkSemaphore first = client.semaphore(false), second = client.semaphore(false);
  for (uint32_t round = 1; round <= 20; ++round) {
    EXPECT_EQ(client.submit_to(0, client.fill(0, buffer.handle, 0, kWords, round), {}, {first}), VK_SUCCESS);
    EXPECT_EQ(client.submit_to(1, client.fill(1, buffer.handle, kWords - 2, 2, round + 100), {first}, {second}), VK_SUCCESS);
    EXPECT_EQ(client.submit_to(2, client.fill(2, buffer.handle, kWords - 1, 1, round + 200), {second}, {}), VK_SUCCESS);
    EXPECT_EQ(VK(client, QueueWaitIdle)(client.queues[2]), VK_SUCCESS);
    ASSERT_EQ(buffer.as<uint32_t>()[0], round);
    ASSERT_EQ(buffer.as<uint32_t>()[kWords - 2], round + 100);
    ASSERT_EQ(buffer.as<uint32_t>()[kWords - 1], round + 200);
  }
}

TEST(IcdQueues, TimelinesMayBeWaitedForBeforeTheyAreSignalled) {
  QueueClient client;
  const auto buffer = client.buffer(16);
  const VkSemaphore timeline = client.semaphore(true, 5);
  EXPECT_EQ(client.value_of(timeline), 5u);
  EXPECT_EQ(client.wait_for(timeline, 5, 0), VK_SUCCESS);
  EXPECT_EQ(client.wait_for(timeline, 6, 0), VK_TIMEOUT);
  // Queue 0 waits for 7, which queue 1 signals once it has seen 6 from the host.
  EXPECT_EQ(client.submit_to(0, client.fill(0, buffer.handle, 0, 1, 70), {timeline, 7}, {timeline, 8}), VK_SUCCESS);
  EXPECT_EQ(client.submit_to(1, client.fill(1, buffer.handle, 1, 1, 60), {timeline, 6}, {timeline, 7}), VK_SUCCESS);
  EXPECT_EQ(client.submit_to(2, client.fill(2, buffer.handle, 2, 1, 50), {timeline, 5}, {}), VK_SUCCESS);
  EXPECT_EQ(VK(client, QueueWaitIdle)(client.queues[2]), VK_SUCCESS) << "a queue that waits for nothing goes on";
  EXPECT_EQ(buffer.as<uint32_t>()[2], 50u);
  EXPECT_EQ(client.wait_for(timeline, 8, 5'000'000), VK_TIMEOUT);
  EXPECT_EQ(buffer.as<uint32_t>()[0] | buffer.as<uint32_t>()[1], 0u);
  client.signal(timeline, 6);
  EXPECT_EQ(client.wait_for(timeline, 8, UINT64_MAX), VK_SUCCESS);
  EXPECT_EQ(buffer.as<uint32_t>()[0], 70u);
  EXPECT_EQ(buffer.as<uint32_t>()[1], 60u);
  EXPECT_EQ(client.value_of(timeline), 8u);
}

// While one queue waits for an event of the host, another works.
TEST(IcdQueues, AQueueThatWaitsForTheHostBlocksNoOther) {
  QueueClient client;
  const auto buffer = client.buffer(16);
  const VkEventCreateInfo event_info{VK_STRUCTURE_TYPE_EVENT_CREATE_INFO};
  VkEvent event = VK_NULL_HANDLE;
  ASSERT_EQ(VK(client, CreateEvent)(client.device, &event_info, nullptr, &event), VK_SUCCESS);
  client.defer([&] { VK(client, DestroyEvent)(client.device, event, nullptr); });
  const VkCommandBuffer waiting = client.command_buffer();
  client.begin(waiting);
  VK(client, CmdWaitEvents)
  (waiting, 1, &event, VK_PIPELINE_STAGE_HOST_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT, 0, nullptr, 0, nullptr, 0, nullptr);
  VK(client, CmdFillBuffer)(waiting, buffer.handle, 0, 4, 1);
  EXPECT_EQ(VK(client, EndCommandBuffer)(waiting), VK_SUCCESS);
  EXPECT_EQ(client.submit_to(0, waiting, {}, {}), VK_SUCCESS);
  for (uint32_t i = 1; i <= 10; ++i) {
    EXPECT_EQ(client.submit_to(1, client.fill(1, buffer.handle, 1, 1, i), {}, {}), VK_SUCCESS);
    EXPECT_EQ(VK(client, QueueWaitIdle)(client.queues[1]), VK_SUCCESS);
    EXPECT_EQ(buffer.as<uint32_t>()[1], i);
  }
  EXPECT_EQ(buffer.as<uint32_t>()[0], 0u);
  EXPECT_EQ(VK(client, SetEvent)(client.device, event), VK_SUCCESS);
  EXPECT_EQ(VK(client, DeviceWaitIdle)(client.device), VK_SUCCESS);
  EXPECT_EQ(buffer.as<uint32_t>()[0], 1u);
}

TEST(IcdQueues, HostResetMakesQueriesUnavailable) {
  Client client(nullptr, {}, {VK_EXT_HOST_QUERY_RESET_EXTENSION_NAME});
  ASSERT_EQ(client.result, VK_SUCCESS);
  const VkQueryPoolCreateInfo info{VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO, nullptr, 0, VK_QUERY_TYPE_TIMESTAMP, 2, 0};
  VkQueryPool pool = VK_NULL_HANDLE;
  ASSERT_EQ(VK(client, CreateQueryPool)(client.device, &info, nullptr, &pool), VK_SUCCESS);
  client.defer([&] { VK(client, DestroyQueryPool)(client.device, pool, nullptr); });
  VK(client, ResetQueryPoolEXT)(client.device, pool, 0, 2);
  client.run([&](VkCommandBuffer cb) {
    VK(client, CmdWriteTimestamp)(cb, VK_PIPELINE_STAGE_TOP_OF_PIPE_BIT, pool, 0);
    VK(client, CmdWriteTimestamp)(cb, VK_PIPELINE_STAGE_TOP_OF_PIPE_BIT, pool, 1);
  });
  uint64_t value = 0;
  const auto query = [&](uint32_t i) {
    return VK(client, GetQueryPoolResults)(client.device, pool, i, 1, 8, &value, 8, VK_QUERY_RESULT_64_BIT);
  };
  EXPECT_EQ(query(1), VK_SUCCESS);
  VK(client, ResetQueryPoolEXT)(client.device, pool, 1, 1);
  EXPECT_EQ(query(0), VK_SUCCESS);
  EXPECT_EQ(query(1), VK_NOT_READY);
}

// CPU time of the process while a thread waits 100 ms in each of the ways: far less than a core.
TEST(IcdQueues, WaitingBurnsNoCore) {
  QueueClient client;
  const auto buffer = client.buffer(16);
  const VkSemaphore timeline = client.semaphore(true);
  const VkFenceCreateInfo fence_info{VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
  VkFence fence = VK_NULL_HANDLE;
  ASSERT_EQ(VK(client, CreateFence)(client.device, &fence_info, nullptr, &fence), VK_SUCCESS);
  client.defer([&] { VK(client, DestroyFence)(client.device, fence, nullptr); });
  const auto cpu_ms = [] {
    timespec time;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return double(time.tv_sec) * 1e3 + double(time.tv_nsec) * 1e-6;
  };
  EXPECT_EQ(client.submit_to(0, client.fill(0, buffer.handle, 0, 1, 1), {timeline, 1}, {}, fence), VK_SUCCESS);
  const double before = cpu_ms();
  EXPECT_EQ(VK(client, WaitForFences)(client.device, 1, &fence, VK_TRUE, 100'000'000), VK_TIMEOUT);
  EXPECT_EQ(client.wait_for(timeline, 1, 100'000'000), VK_TIMEOUT);
  std::thread idle([&] { EXPECT_EQ(VK(client, QueueWaitIdle)(client.queues[0]), VK_SUCCESS); });
  std::thread forever([&] { EXPECT_EQ(client.wait_for(timeline, 1, UINT64_MAX), VK_SUCCESS); });
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  // vkCmdWaitEvents, with a queue and a thread that wait for it.
  const VkEventCreateInfo event_info{VK_STRUCTURE_TYPE_EVENT_CREATE_INFO};
  VkEvent event = VK_NULL_HANDLE;
  ASSERT_EQ(VK(client, CreateEvent)(client.device, &event_info, nullptr, &event), VK_SUCCESS);
  client.defer([&] { VK(client, DestroyEvent)(client.device, event, nullptr); });
  const VkCommandBuffer waiting = client.fill(1, buffer.handle, 1, 1, 1);
  client.begin(waiting);
  VK(client, CmdWaitEvents)
  (waiting, 1, &event, VK_PIPELINE_STAGE_HOST_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT, 0, nullptr, 0, nullptr, 0, nullptr);
  EXPECT_EQ(VK(client, EndCommandBuffer)(waiting), VK_SUCCESS);
  EXPECT_EQ(client.submit_to(1, waiting, {}, {}), VK_SUCCESS);
  std::thread event_idle([&] { EXPECT_EQ(VK(client, QueueWaitIdle)(client.queues[1]), VK_SUCCESS); });
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  const double spent = cpu_ms() - before;
  printf("%.2f ms of CPU time in 400 ms that up to five threads have waited\n", spent);
  EXPECT_LT(spent, 30);
  EXPECT_EQ(VK(client, SetEvent)(client.device, event), VK_SUCCESS);
  event_idle.join();
  client.signal(timeline, 1);
  idle.join();
  forever.join();
  EXPECT_EQ(VK(client, GetFenceStatus)(client.device, fence), VK_SUCCESS);
}

}  // namespace
}  // namespace pineda::test
