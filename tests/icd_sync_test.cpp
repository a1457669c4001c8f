// Fences, events, timestamps, submission order.
#include <chrono>
#include <thread>

#include "icd_client.h"

namespace pineda::test {
namespace {

using std::chrono::steady_clock;

VkFence make_fence(Client& client, VkFenceCreateFlags flags = 0) {
  const VkFenceCreateInfo info{VK_STRUCTURE_TYPE_FENCE_CREATE_INFO, nullptr, flags};
  VkFence fence = VK_NULL_HANDLE;
  EXPECT_EQ(VK(client, CreateFence)(client.device, &info, nullptr, &fence), VK_SUCCESS);
  client.defer([&client, fence] { VK(client, DestroyFence)(client.device, fence, nullptr); });
  return fence;
}

VkEvent make_event(Client& client) {
  const VkEventCreateInfo info{VK_STRUCTURE_TYPE_EVENT_CREATE_INFO};
  VkEvent event = VK_NULL_HANDLE;
  EXPECT_EQ(VK(client, CreateEvent)(client.device, &info, nullptr, &event), VK_SUCCESS);
  client.defer([&client, event] { VK(client, DestroyEvent)(client.device, event, nullptr); });
  return event;
}

TEST(IcdFence, StatesAndEmptySubmit) {
  Client client;
  const VkFence fence = make_fence(client), signaled = make_fence(client, VK_FENCE_CREATE_SIGNALED_BIT);
  EXPECT_EQ(VK(client, GetFenceStatus)(client.device, fence), VK_NOT_READY);
  EXPECT_EQ(VK(client, GetFenceStatus)(client.device, signaled), VK_SUCCESS);
  const VkFence both[] = {fence, signaled};
  EXPECT_EQ(VK(client, WaitForFences)(client.device, 2, both, VK_FALSE, 0), VK_SUCCESS);
  EXPECT_EQ(VK(client, WaitForFences)(client.device, 2, both, VK_TRUE, 0), VK_TIMEOUT);
  EXPECT_EQ(VK(client, QueueSubmit)(client.queue, 0, nullptr, fence), VK_SUCCESS);
  EXPECT_EQ(VK(client, WaitForFences)(client.device, 2, both, VK_TRUE, UINT64_MAX), VK_SUCCESS);
  EXPECT_EQ(VK(client, ResetFences)(client.device, 2, both), VK_SUCCESS);
  EXPECT_EQ(VK(client, GetFenceStatus)(client.device, signaled), VK_NOT_READY);
}

TEST(IcdFence, TimeoutIsKept) {
  Client client;
  const VkFence fence = make_fence(client);
  const auto start = steady_clock::now();
  EXPECT_EQ(VK(client, WaitForFences)(client.device, 1, &fence, VK_TRUE, 20'000'000), VK_TIMEOUT);
  EXPECT_GE(steady_clock::now() - start, std::chrono::milliseconds(20));
}

// A submission that waits for the host must not run inside vkQueueSubmit, and what is submitted behind it must keep its place.
TEST(IcdEvent, HostReleasesASubmission) {
  Client client;
  const VkEvent event = make_event(client);
  const VkFence first_done = make_fence(client), second_done = make_fence(client);
  const auto buffer = client.buffer(4);
  const VkCommandBuffer first = client.command_buffer(), second = client.command_buffer();
  client.begin(first);
  VK(client, CmdWaitEvents)
  (first, 1, &event, VK_PIPELINE_STAGE_HOST_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT, 0, nullptr, 0, nullptr, 0, nullptr);
  VK(client, CmdFillBuffer)(first, buffer.handle, 0, 4, 1);
  client.barrier(first);
  VK(client, CmdResetEvent)(first, event, VK_PIPELINE_STAGE_TRANSFER_BIT);
  EXPECT_EQ(VK(client, EndCommandBuffer)(first), VK_SUCCESS);
  client.begin(second);
  VK(client, CmdFillBuffer)(second, buffer.handle, 0, 4, 2);
  EXPECT_EQ(VK(client, EndCommandBuffer)(second), VK_SUCCESS);
  EXPECT_EQ(client.submit(first, first_done), VK_SUCCESS);
  EXPECT_EQ(client.submit(second, second_done), VK_SUCCESS);
  EXPECT_EQ(VK(client, WaitForFences)(client.device, 1, &second_done, VK_TRUE, 10'000'000), VK_TIMEOUT);
  EXPECT_EQ(buffer.as<uint32_t>()[0], 0u);
  EXPECT_EQ(VK(client, GetEventStatus)(client.device, event), VK_EVENT_RESET);
  EXPECT_EQ(VK(client, SetEvent)(client.device, event), VK_SUCCESS);
  EXPECT_EQ(VK(client, WaitForFences)(client.device, 1, &second_done, VK_TRUE, UINT64_MAX), VK_SUCCESS);
  EXPECT_EQ(VK(client, GetFenceStatus)(client.device, first_done), VK_SUCCESS);
  EXPECT_EQ(buffer.as<uint32_t>()[0], 2u);
  EXPECT_EQ(VK(client, GetEventStatus)(client.device, event), VK_EVENT_RESET);
}

// Large fills go to the worker or are taken by who waits; whoever it is, order holds.
TEST(IcdQueue, SubmissionsRunInOrder) {
  Client client;
  constexpr uint32_t kSubmissions = 40;
  const auto buffer = client.buffer(8u << 20);
  std::vector<VkCommandBuffer> command_buffers;
  for (uint32_t i = 0; i < kSubmissions; ++i) {
    command_buffers.push_back(client.command_buffer());
    client.begin(command_buffers.back());
    VK(client, CmdFillBuffer)(command_buffers.back(), buffer.handle, 0, i % 3 ? VkDeviceSize{64} : VK_WHOLE_SIZE, i);
    EXPECT_EQ(VK(client, EndCommandBuffer)(command_buffers.back()), VK_SUCCESS);
  }
  const VkFence fence = make_fence(client);
  for (uint32_t i = 0; i < kSubmissions; ++i) {
    EXPECT_EQ(client.submit(command_buffers[i], i + 1 == kSubmissions ? fence : VK_NULL_HANDLE), VK_SUCCESS);
  }
  EXPECT_EQ(VK(client, WaitForFences)(client.device, 1, &fence, VK_TRUE, 10'000'000'000), VK_SUCCESS);
  EXPECT_EQ(buffer.as<uint32_t>()[0], kSubmissions - 1);
  EXPECT_EQ(buffer.as<uint32_t>()[1 << 20], (kSubmissions - 1) / 3 * 3);
}

TEST(IcdQueue, SeveralThreadsWait) {
  Client client;
  const auto buffer = client.buffer(16u << 20);
  for (int round = 0; round < 10; ++round) {
    const VkFence fence = make_fence(client);
    const VkCommandBuffer cb = client.command_buffer();
    client.begin(cb);
    VK(client, CmdFillBuffer)(cb, buffer.handle, 0, VK_WHOLE_SIZE, 7);
    EXPECT_EQ(VK(client, EndCommandBuffer)(cb), VK_SUCCESS);
    EXPECT_EQ(client.submit(cb, fence), VK_SUCCESS);
    std::vector<std::thread> waiters;
    for (int i = 0; i < 3; ++i) {
      waiters.emplace_back(
          [&] { EXPECT_EQ(VK(client, WaitForFences)(client.device, 1, &fence, VK_TRUE, UINT64_MAX), VK_SUCCESS); });
    }
    for (std::thread& waiter : waiters) waiter.join();
  }
}

TEST(IcdCommandBuffer, SecondaryAndSimultaneousUse) {
  Client client;
  const auto buffer = client.buffer(16);
  const VkCommandBuffer secondary = client.command_buffer(VK_COMMAND_BUFFER_LEVEL_SECONDARY);
  const VkCommandBufferInheritanceInfo inheritance{VK_STRUCTURE_TYPE_COMMAND_BUFFER_INHERITANCE_INFO};
  const VkCommandBufferBeginInfo info{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO, nullptr,
                                      VK_COMMAND_BUFFER_USAGE_SIMULTANEOUS_USE_BIT, &inheritance};
  EXPECT_EQ(VK(client, BeginCommandBuffer)(secondary, &info), VK_SUCCESS);
  const VkBufferCopy shift{0, 4, 4};
  VK(client, CmdCopyBuffer)(secondary, buffer.handle, buffer.handle, 1, &shift);
  EXPECT_EQ(VK(client, EndCommandBuffer)(secondary), VK_SUCCESS);
  client.run([&](VkCommandBuffer cb) {
    VK(client, CmdFillBuffer)(cb, buffer.handle, 0, 4, 41);
    client.barrier(cb);
    VK(client, CmdExecuteCommands)(cb, 1, &secondary);
    client.barrier(cb);
    VK(client, CmdFillBuffer)(cb, buffer.handle, 0, 4, 42);
  });
  EXPECT_EQ(buffer.as<uint32_t>()[1], 41u);
  client.run([&](VkCommandBuffer cb) { VK(client, CmdExecuteCommands)(cb, 1, &secondary); });
  EXPECT_EQ(buffer.as<uint32_t>()[1], 42u);
}

TEST(IcdCommandBuffer, UnfinishedOneLosesTheDevice) {
  breaks_on_purpose({"UNASSIGNED-CoreValidation-DrawState-NoEndCommandBuffer"});
  loses_device();
  Client client;
  const VkCommandBuffer cb = client.command_buffer();
  client.begin(cb);
  EXPECT_EQ(client.submit(cb), VK_ERROR_DEVICE_LOST);
  EXPECT_EQ(VK(client, QueueSubmit)(client.queue, 0, nullptr, VK_NULL_HANDLE), VK_ERROR_DEVICE_LOST) << "loss is sticky";
}

TEST(IcdQuery, TimestampsGrow) {
  Client client;
  VkQueryPoolCreateInfo info{VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO};
  info.queryType = VK_QUERY_TYPE_TIMESTAMP;
  info.queryCount = 3;
  VkQueryPool pool;
  ASSERT_EQ(VK(client, CreateQueryPool)(client.device, &info, nullptr, &pool), VK_SUCCESS);
  client.defer([&client, pool] { VK(client, DestroyQueryPool)(client.device, pool, nullptr); });
  const auto buffer = client.buffer(64);
  client.run([&](VkCommandBuffer cb) {
    VK(client, CmdResetQueryPool)(cb, pool, 0, 3);
    VK(client, CmdWriteTimestamp)(cb, VK_PIPELINE_STAGE_TOP_OF_PIPE_BIT, pool, 0);
    VK(client, CmdWriteTimestamp)(cb, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, pool, 1);
    VK(client, CmdCopyQueryPoolResults)(cb, pool, 0, 2, buffer.handle, 0, 8, VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT);
  });
  uint64_t values[6] = {};
  constexpr VkQueryResultFlags kFlags = VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WITH_AVAILABILITY_BIT;
  EXPECT_EQ(VK(client, GetQueryPoolResults)(client.device, pool, 0, 3, sizeof(values), values, 16, kFlags), VK_NOT_READY);
  EXPECT_GE(values[2], values[0]);
  EXPECT_EQ(values[1], 1u);
  EXPECT_EQ(values[5], 0u) << "the third was never written";
  EXPECT_EQ(buffer.as<uint64_t>()[0], values[0]);
  EXPECT_EQ(buffer.as<uint64_t>()[1], values[2]);
  info.queryType = VK_QUERY_TYPE_TRANSFORM_FEEDBACK_STREAM_EXT;
  VkQueryPool refused;
  EXPECT_EQ(VK(client, CreateQueryPool)(client.device, &info, nullptr, &refused), VK_ERROR_FEATURE_NOT_PRESENT);
}

// VK_EXT_queue_family_foreign: memory that is handed to who is outside and taken back holds what it held.
TEST(IcdSync, ForeignQueuesKeepWhatIsThere) {
  Client client;
  const auto buffer = client.buffer(64);
  const auto hand = [&](VkCommandBuffer cb, VkAccessFlags from, VkAccessFlags to, uint32_t from_family, uint32_t to_family) {
    const VkBufferMemoryBarrier barrier{
        VK_STRUCTURE_TYPE_BUFFER_MEMORY_BARRIER, nullptr, from, to, from_family, to_family, buffer.handle, 0, VK_WHOLE_SIZE};
    VK(client, CmdPipelineBarrier)
    (cb, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT, 0, 0, nullptr, 1, &barrier, 0, nullptr);
  };
  client.run([&](VkCommandBuffer cb) {
    VK(client, CmdFillBuffer)(cb, buffer.handle, 0, 64, 0x12345678);
    hand(cb, VK_ACCESS_TRANSFER_WRITE_BIT, 0, 0, VK_QUEUE_FAMILY_FOREIGN_EXT);
  });
  client.run([&](VkCommandBuffer cb) {
    hand(cb, 0, VK_ACCESS_TRANSFER_WRITE_BIT, VK_QUEUE_FAMILY_FOREIGN_EXT, 0);
    VK(client, CmdFillBuffer)(cb, buffer.handle, 0, 32, 7);
  });
  EXPECT_EQ(buffer.as<uint32_t>()[7], 7u);
  EXPECT_EQ(buffer.as<uint32_t>()[8], 0x12345678u);
}

}  // namespace
}  // namespace pineda::test
