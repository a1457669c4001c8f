// synchronization.*: fences, semaphores, events, barriers between each pair of uses, command buffers used again.
#include <fmt/format.h>

#include <cstring>

#include "cts-subset/groups/groups.h"
#include "cts-subset/harness/case.h"
#include "cts-subset/harness/pipelines.h"

namespace pineda::cts {
namespace {

using Fence = Owned<VkFence, vkDestroyFence>;
using Semaphore = Owned<VkSemaphore, vkDestroySemaphore>;
using Event = Owned<VkEvent, vkDestroyEvent>;
using CommandPool = Owned<VkCommandPool, vkDestroyCommandPool>;

Fence create_fence(Device& device, bool signalled) {
  VkFenceCreateInfo info{VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
  info.flags = signalled ? VK_FENCE_CREATE_SIGNALED_BIT : 0;
  return make<VkFence, vkDestroyFence>(device, vkCreateFence, info, "vkCreateFence");
}
Event create_event(Device& device) {
  const VkEventCreateInfo info{VK_STRUCTURE_TYPE_EVENT_CREATE_INFO};
  return make<VkEvent, vkDestroyEvent>(device, vkCreateEvent, info, "vkCreateEvent");
}
Semaphore create_semaphore(Device& device) {
  const VkSemaphoreCreateInfo info{VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO};
  return make<VkSemaphore, vkDestroySemaphore>(device, vkCreateSemaphore, info, "vkCreateSemaphore");
}

// Command buffers that outlive one submission.
struct Commands {
  CommandPool pool;
  std::vector<VkCommandBuffer> buffers;
};
Commands create_commands(Device& device, uint32_t count, VkCommandBufferLevel level = VK_COMMAND_BUFFER_LEVEL_PRIMARY) {
  Commands c;
  VkCommandPoolCreateInfo info{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
  info.queueFamilyIndex = device.queue_family();
  info.flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT;
  c.pool = make<VkCommandPool, vkDestroyCommandPool>(device, vkCreateCommandPool, info, "vkCreateCommandPool");
  VkCommandBufferAllocateInfo allocate{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
  allocate.commandPool = c.pool;
  allocate.level = level;
  allocate.commandBufferCount = count;
  c.buffers.resize(count);
  check(vkAllocateCommandBuffers(device.handle(), &allocate, c.buffers.data()), "vkAllocateCommandBuffers");
  return c;
}
void record(VkCommandBuffer commands, VkCommandBufferUsageFlags flags, const std::function<void()>& body,
            const VkCommandBufferInheritanceInfo* inheritance = nullptr) {
  VkCommandBufferBeginInfo begin{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO, nullptr, flags, inheritance};
  check(vkBeginCommandBuffer(commands, &begin), "vkBeginCommandBuffer");
  body();
  check(vkEndCommandBuffer(commands), "vkEndCommandBuffer");
}
void submit(Device& device, const std::vector<VkCommandBuffer>& buffers, VkFence fence = VK_NULL_HANDLE,
            const std::vector<VkSemaphore>& waits = {}, const std::vector<VkSemaphore>& signals = {}) {
  const std::vector<VkPipelineStageFlags> stages(waits.size(), VK_PIPELINE_STAGE_ALL_COMMANDS_BIT);
  VkSubmitInfo info{VK_STRUCTURE_TYPE_SUBMIT_INFO};
  info.waitSemaphoreCount = static_cast<uint32_t>(waits.size());
  info.pWaitSemaphores = waits.data();
  info.pWaitDstStageMask = stages.data();
  info.commandBufferCount = static_cast<uint32_t>(buffers.size());
  info.pCommandBuffers = buffers.data();
  info.signalSemaphoreCount = static_cast<uint32_t>(signals.size());
  info.pSignalSemaphores = signals.data();
  check(vkQueueSubmit(device.queue(), 1, &info, fence), "vkQueueSubmit");
}

void run_fence_states(Device& device) {
  const Fence fence = create_fence(device, true);
  const VkFence handle = fence;
  expect(vkGetFenceStatus(device.handle(), fence) == VK_SUCCESS, "created signalled, but is not");
  check(vkResetFences(device.handle(), 1, &handle), "vkResetFences");
  expect(vkGetFenceStatus(device.handle(), fence) == VK_NOT_READY, "reset, but signalled");
  expect(vkWaitForFences(device.handle(), 1, &handle, VK_TRUE, 1000000) == VK_TIMEOUT, "a wait of 1 ms did not time out");
  submit(device, {}, fence);
  expect(vkWaitForFences(device.handle(), 1, &handle, VK_TRUE, 10'000'000'000) == VK_SUCCESS, "an empty submission's fence");
  expect(vkGetFenceStatus(device.handle(), fence) == VK_SUCCESS, "signalled, but not ready");
}

void run_fence_wait_any(Device& device, uint32_t count) {
  std::vector<Fence> fences;
  std::vector<VkFence> handles;
  for (uint32_t i = 0; i < count; ++i) fences.push_back(create_fence(device, false)), handles.push_back(fences.back());
  submit(device, {}, handles[count / 2]);
  expect(vkWaitForFences(device.handle(), count, handles.data(), VK_FALSE, 10'000'000'000) == VK_SUCCESS, "waiting for any");
  if (count > 1) expect(vkWaitForFences(device.handle(), count, handles.data(), VK_TRUE, 0) == VK_TIMEOUT, "waiting for all");
  for (uint32_t i = 0; i < count; ++i) {
    if (i != count / 2) submit(device, {}, handles[i]);
  }
  expect(vkWaitForFences(device.handle(), count, handles.data(), VK_TRUE, 10'000'000'000) == VK_SUCCESS,
         "waiting for all at the end");
}

// A chain of submissions, each adding to what the one before left, ordered by semaphores.
void run_semaphore_chain(Device& device, uint32_t length) {
  const Buffer a = create_buffer(device, 4096), b = create_buffer(device, 4096);
  const Commands commands = create_commands(device, length);
  std::vector<Semaphore> semaphores;
  for (uint32_t i = 0; i < length; ++i) {
    semaphores.push_back(create_semaphore(device));
    record(commands.buffers[i], 0, [&] {
      const VkBufferCopy shift{0, 4, 4092};
      const Buffer& from = i % 2 ? b : a;
      const Buffer& to = i % 2 ? a : b;
      vkCmdCopyBuffer(commands.buffers[i], from.handle, to.handle, 1, &shift);
      full_barrier(commands.buffers[i]);
      vkCmdFillBuffer(commands.buffers[i], to.handle, 0, 4, i + 1);
      full_barrier(commands.buffers[i]);
    });
  }
  const Fence fence = create_fence(device, false);
  for (uint32_t i = 0; i < length; ++i) {
    submit(device, {commands.buffers[i]}, i + 1 == length ? fence.get() : VK_NULL_HANDLE,
           i ? std::vector<VkSemaphore>{semaphores[i - 1]} : std::vector<VkSemaphore>{}, {semaphores[i]});
  }
  const VkFence handle = fence;
  check(vkWaitForFences(device.handle(), 1, &handle, VK_TRUE, ~0ull), "vkWaitForFences");
  submit(device, {}, VK_NULL_HANDLE, {semaphores[length - 1]});
  check(vkQueueWaitIdle(device.queue()), "vkQueueWaitIdle");
  const auto got = ((length - 1) % 2 ? a : b).as<uint32_t>();
  for (uint32_t i = 0; i < length; ++i) expect(got[i] == length - i, fmt::format("word {} is {}, not {}", i, got[i], length - i));
}

void run_event_host(Device& device) {
  const Event event = create_event(device);
  expect(vkGetEventStatus(device.handle(), event) == VK_EVENT_RESET, "a new event is set");
  check(vkSetEvent(device.handle(), event), "vkSetEvent");
  expect(vkGetEventStatus(device.handle(), event) == VK_EVENT_SET, "set, but is not");
  check(vkResetEvent(device.handle(), event), "vkResetEvent");
  expect(vkGetEventStatus(device.handle(), event) == VK_EVENT_RESET, "reset, but set");
  device.run([&](VkCommandBuffer commands) { vkCmdSetEvent(commands, event, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT); });
  expect(vkGetEventStatus(device.handle(), event) == VK_EVENT_SET, "the device did not set it");
  device.run([&](VkCommandBuffer commands) { vkCmdResetEvent(commands, event, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT); });
  expect(vkGetEventStatus(device.handle(), event) == VK_EVENT_RESET, "the device did not reset it");
}

// A submission waits for an event that the host sets later.
void run_event_wait(Device& device) {
  const Event event = create_event(device);
  const VkEvent handle = event;
  const Buffer buffer = create_buffer(device, 64);
  const Commands commands = create_commands(device, 1);
  record(commands.buffers[0], 0, [&] {
    vkCmdWaitEvents(commands.buffers[0], 1, &handle, VK_PIPELINE_STAGE_HOST_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT, 0, nullptr, 0,
                    nullptr, 0, nullptr);
    vkCmdFillBuffer(commands.buffers[0], buffer.handle, 0, VK_WHOLE_SIZE, 77);
    full_barrier(commands.buffers[0]);
  });
  const Fence fence = create_fence(device, false);
  const VkFence fence_handle = fence;
  submit(device, commands.buffers, fence);
  expect(vkWaitForFences(device.handle(), 1, &fence_handle, VK_TRUE, 20'000'000) == VK_TIMEOUT, "did not wait for the event");
  check(vkSetEvent(device.handle(), event), "vkSetEvent");
  expect(vkWaitForFences(device.handle(), 1, &fence_handle, VK_TRUE, 10'000'000'000) == VK_SUCCESS,
         "the event did not release it");
  expect(buffer.as<uint32_t>()[15] == 77, "the command behind the event did not run");
}

// What one use of a buffer writes, the next one reads.
enum class Use { kTransfer, kCompute, kFragment, kVertex, kHost };
constexpr std::pair<Use, const char*> kUses[] = {{Use::kTransfer, "transfer"},
                                                 {Use::kCompute, "compute"},
                                                 {Use::kFragment, "fragment"},
                                                 {Use::kVertex, "vertex"},
                                                 {Use::kHost, "host"}};

// Records a step that sets every word of `to` to that of `from` plus one.
class Steps {
 public:
  Steps(Device& device, uint32_t words) : device_(device), words_(words) {
    ImageDesc desc;
    desc.extent = {64, (words + 63) / 64, 1};
    desc.usage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT;
    colour_ = create_image(device, desc);
  }
  void run(Use use, const Buffer& from, const Buffer& to) {
    if (use == Use::kTransfer || use == Use::kHost) return run_copy(use, from, to);
    Resources resources;
    resources.descriptors = {storage_buffer(0, from), storage_buffer(1, to)};
    const std::string blocks =
        "layout(binding = 0, std430) readonly buffer A { uint a[]; }; layout(binding = 1, std430) buffer B { uint b[]; };\n";
    if (use == Use::kCompute) {
      dispatch(
          device_,
          compile_glsl(VK_SHADER_STAGE_COMPUTE_BIT, "layout(local_size_x = 64) in; " + blocks +
                                                        "void main() { uint i = gl_GlobalInvocationID.x; b[i] = a[i] + 1u; }"),
          resources, {words_ / 64, 1, 1});
      return;
    }
    DrawState state;
    state.resources = resources;
    state.fragment =
        compile_glsl(VK_SHADER_STAGE_FRAGMENT_BIT,
                     blocks +
                         "layout(location = 0) out vec4 c; void main() { c = vec4(1.0); uint i = uint(gl_FragCoord.y) * 64u + "
                         "uint(gl_FragCoord.x);" +
                         (use == Use::kFragment ? " b[i] = a[i] + 1u; }" : " }"));
    if (use == Use::kFragment) {
      state.vertex = fullscreen_vertex();
    } else {
      state.vertex = compile_glsl(VK_SHADER_STAGE_VERTEX_BIT, blocks +
                                                                  "void main() { uint i = uint(gl_VertexIndex); b[i] = a[i] + 1u;"
                                                                  " gl_Position = vec4(2.0); gl_PointSize = 1.0; }");
      state.topology = VK_PRIMITIVE_TOPOLOGY_POINT_LIST;
      state.vertices = words_;
    }
    Target target;
    target.colours.push_back({&colour_, VK_ATTACHMENT_LOAD_OP_CLEAR, {}});
    Pass pass(device_, target);
    pass.add(state);
    pass.run();
  }

 private:
  void run_copy(Use use, const Buffer& from, const Buffer& to) {
    if (use == Use::kTransfer) {
      device_.run([&](VkCommandBuffer commands) {
        const VkBufferCopy copy{0, 0, words_ * 4};
        vkCmdCopyBuffer(commands, from.handle, to.handle, 1, &copy);
        full_barrier(commands);
      });
    } else {
      std::memcpy(to.mapped, from.mapped, words_ * 4);
    }
    for (uint32_t& word : to.as<uint32_t>()) ++word;  // a coherent host write, the queue is idle
  }

  Device& device_;
  uint32_t words_;
  Image colour_;
};

void run_uses(Device& device, Use first, Use second) {
  const VkPhysicalDeviceFeatures& features = device.caps().features;
  const auto needs = [&](Use use) {
    if (use == Use::kFragment) require(features.fragmentStoresAndAtomics, "fragmentStoresAndAtomics");
    if (use == Use::kVertex) require(features.vertexPipelineStoresAndAtomics, "vertexPipelineStoresAndAtomics");
  };
  needs(first), needs(second);
  constexpr uint32_t kWords = 1024;
  std::vector<uint32_t> start(kWords);
  for (uint32_t i = 0; i < kWords; ++i) start[i] = i * 3;
  const Buffer a = create_buffer(device, start), b = create_buffer(device, kWords * 4), c = create_buffer(device, kWords * 4);
  Steps steps(device, kWords);
  steps.run(first, a, b);
  steps.run(second, b, c);
  steps.run(first, c, a);
  for (uint32_t i = 0; i < kWords; ++i) {
    expect(a.as<uint32_t>()[i] == i * 3 + 3, fmt::format("word {} is {}, not {}", i, a.as<uint32_t>()[i], i * 3 + 3));
  }
}

// In one command buffer: alternating fills and copies with precise barriers.
void run_barriers(Device& device, bool buffer_barrier, uint32_t rounds) {
  const Buffer a = create_buffer(device, 4096), b = create_buffer(device, 4096);
  device.run([&](VkCommandBuffer commands) {
    const auto barrier = [&](const Buffer& buffer, VkAccessFlags from, VkAccessFlags to) {
      VkBufferMemoryBarrier precise{VK_STRUCTURE_TYPE_BUFFER_MEMORY_BARRIER,
                                    nullptr,
                                    from,
                                    to,
                                    VK_QUEUE_FAMILY_IGNORED,
                                    VK_QUEUE_FAMILY_IGNORED,
                                    buffer.handle,
                                    0,
                                    VK_WHOLE_SIZE};
      VkMemoryBarrier global{VK_STRUCTURE_TYPE_MEMORY_BARRIER, nullptr, from, to};
      vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT, 0, buffer_barrier ? 0 : 1,
                           &global, buffer_barrier ? 1 : 0, &precise, 0, nullptr);
    };
    for (uint32_t i = 0; i < rounds; ++i) {
      vkCmdFillBuffer(commands, a.handle, 0, 4096, i + 1);
      barrier(a, VK_ACCESS_TRANSFER_WRITE_BIT, VK_ACCESS_TRANSFER_READ_BIT);
      const VkBufferCopy copy{0, i * 64, 64};
      vkCmdCopyBuffer(commands, a.handle, b.handle, 1, &copy);
      barrier(a, VK_ACCESS_TRANSFER_READ_BIT, VK_ACCESS_TRANSFER_WRITE_BIT);
    }
    full_barrier(commands);
  });
  for (uint32_t i = 0; i < rounds * 16; ++i) expect(b.as<uint32_t>()[i] == i / 16 + 1, fmt::format("word {}", i));
}

// Secondary command buffers, and the same primary submitted many times.
void run_reuse(Device& device, bool secondary, bool simultaneous, uint32_t times) {
  const Buffer counter = create_buffer(device, 64);
  Resources resources;
  resources.descriptors = {storage_buffer(0, counter)};
  const Bindings bindings(device, resources, VK_SHADER_STAGE_COMPUTE_BIT);
  const Pipeline pipeline =
      create_compute_pipeline(device,
                              compile_glsl(VK_SHADER_STAGE_COMPUTE_BIT,
                                           "layout(local_size_x = 8) in; layout(binding = 0, std430) buffer B { uint n; };\n"
                                           "void main() { atomicAdd(n, 1u); }"),
                              bindings.layout(), resources);
  const Commands primary = create_commands(device, 1), inner = create_commands(device, 1, VK_COMMAND_BUFFER_LEVEL_SECONDARY);
  const VkCommandBufferUsageFlags flags = simultaneous ? VK_COMMAND_BUFFER_USAGE_SIMULTANEOUS_USE_BIT : 0;
  const auto body = [&](VkCommandBuffer commands) {
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline);
    bindings.bind(commands, VK_PIPELINE_BIND_POINT_COMPUTE, resources);
    vkCmdDispatch(commands, 4, 1, 1);
    full_barrier(commands);
  };
  VkCommandBufferInheritanceInfo inheritance{VK_STRUCTURE_TYPE_COMMAND_BUFFER_INHERITANCE_INFO};
  if (secondary)
    record(
        inner.buffers[0], flags, [&] { body(inner.buffers[0]); }, &inheritance);
  record(primary.buffers[0], flags, [&] {
    if (secondary) {
      vkCmdExecuteCommands(primary.buffers[0], 1, inner.buffers.data());
      if (simultaneous) vkCmdExecuteCommands(primary.buffers[0], 1, inner.buffers.data());
    } else {
      body(primary.buffers[0]);
    }
  });
  for (uint32_t i = 0; i < times; ++i) {
    submit(device, primary.buffers);
    if (!simultaneous) check(vkQueueWaitIdle(device.queue()), "vkQueueWaitIdle");
  }
  check(vkQueueWaitIdle(device.queue()), "vkQueueWaitIdle");
  const uint32_t want = 32 * times * (secondary && simultaneous ? 2 : 1);
  expect(counter.as<uint32_t>()[0] == want, fmt::format("{} instead of {}", counter.as<uint32_t>()[0], want));
}

}  // namespace

void register_synchronization() {
  add_case("synchronization.fences", "states", "7.3 Fences", run_fence_states);
  for (const uint32_t count : {1u, 2u, 7u, 64u}) {
    add_case("synchronization.fences", fmt::format("wait_any_of_{}", count), "7.3 Fences",
             [count](Device& device) { run_fence_wait_any(device, count); });
  }
  for (const uint32_t length : {1u, 2u, 8u, 50u}) {
    add_case("synchronization.semaphores", fmt::format("chain_of_{}", length), "7.4 Semaphores",
             [length](Device& device) { run_semaphore_chain(device, length); });
  }
  add_case("synchronization.events", "states", "7.5 Events", run_event_host);
  add_case("synchronization.events", "device_waits_for_host", "7.5 Events", run_event_wait);
  for (const auto& [first, first_name] : kUses) {
    for (const auto& [second, second_name] : kUses) {
      add_case("synchronization.op", fmt::format("{}_then_{}", first_name, second_name), "7.1 Execution and Memory Dependencies",
               [first = first, second = second](Device& device) { run_uses(device, first, second); });
    }
  }
  for (const bool buffer : {false, true}) {
    for (const uint32_t rounds : {1u, 10u, 60u}) {
      add_case("synchronization.barriers", fmt::format("{}_{}_rounds", buffer ? "buffer" : "global", rounds),
               "7.6 Memory Barriers", [=](Device& device) { run_barriers(device, buffer, rounds); });
    }
  }
  for (const bool secondary : {false, true}) {
    for (const bool simultaneous : {false, true}) {
      for (const uint32_t times : {1u, 5u, 40u}) {
        add_case("synchronization.command_buffers",
                 fmt::format("{}{}_{}_times", secondary ? "secondary" : "primary", simultaneous ? "_simultaneous" : "", times),
                 "6.1 Command Buffer Lifecycle", [=](Device& device) { run_reuse(device, secondary, simultaneous, times); });
      }
    }
  }
}

}  // namespace pineda::cts
