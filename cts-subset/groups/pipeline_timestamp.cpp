// pipeline.timestamp.*: timestamps of every stage around every kind of work, in order, and no further apart than the host saw
// pass.
#include <fmt/format.h>

#include <chrono>

#include "cts-subset/groups/groups.h"
#include "cts-subset/harness/case.h"
#include "cts-subset/harness/pipelines.h"

namespace pineda::cts {
namespace {

constexpr uint32_t kSize = 16;

uint32_t valid_bits(Device& device) {
  const uint32_t bits = device.caps().queue_families[device.queue_family()].timestampValidBits;
  require(bits != 0, "timestamps");
  return bits;
}

std::vector<uint64_t> results_of(Device& device, VkQueryPool pool, uint32_t count) {
  std::vector<uint64_t> times(count);
  check(vkGetQueryPoolResults(device.handle(), pool, 0, count, count * 8, times.data(), 8,
                              VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT),
        "vkGetQueryPoolResults");
  return times;
}

using Record = std::function<void(VkCommandBuffer)>;
enum class Work { kNothing, kDraw, kDispatch, kFill };

// Submits the work with what `before` and `after` record around it.
void run_between(Device& device, Work work, const Record& before, const Record& after) {
  if (work == Work::kDraw) {
    ImageDesc desc;
    desc.extent = {kSize, kSize, 1};
    desc.usage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT;
    const Image colour = create_image(device, desc);
    Target target;
    target.colours.push_back({&colour, VK_ATTACHMENT_LOAD_OP_CLEAR, {}});
    DrawState state;
    state.vertex = fullscreen_vertex();
    state.fragment =
        compile_glsl(VK_SHADER_STAGE_FRAGMENT_BIT, "layout(location = 0) out vec4 c; void main() { c = vec4(1.0); }");
    Pass pass(device, target);
    pass.add(state);
    pass.run([&](VkCommandBuffer commands, const std::function<void()>& record) {
      before(commands);
      record();
      after(commands);
    });
    return;
  }
  const Buffer buffer = create_buffer(device, 4096);
  Resources resources;
  resources.descriptors = {storage_buffer(0, buffer)};
  const Bindings bindings(device, resources, VK_SHADER_STAGE_COMPUTE_BIT);
  const Pipeline pipeline =
      create_compute_pipeline(device,
                              compile_glsl(VK_SHADER_STAGE_COMPUTE_BIT,
                                           "layout(local_size_x = 64) in; layout(binding = 0, std430) buffer B { uint b[]; };\n"
                                           "void main() { b[gl_GlobalInvocationID.x] = gl_GlobalInvocationID.x; }"),
                              bindings.layout(), resources);
  device.run([&](VkCommandBuffer commands) {
    before(commands);
    if (work == Work::kDispatch) {
      vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline);
      bindings.bind(commands, VK_PIPELINE_BIND_POINT_COMPUTE, resources);
      vkCmdDispatch(commands, 16, 1, 1);
    } else if (work == Work::kFill) {
      vkCmdFillBuffer(commands, buffer.handle, 0, VK_WHOLE_SIZE, 7);
    }
    after(commands);
  });
}

// One timestamp of the stage before the work, one of it and one of all stages behind it.
void run_stage(Device& device, VkPipelineStageFlagBits stage, Work work) {
  const uint32_t bits = valid_bits(device);
  const QueryPool pool = create_query_pool(device, VK_QUERY_TYPE_TIMESTAMP, 3);
  const auto begin = std::chrono::steady_clock::now();
  run_between(
      device, work,
      [&](VkCommandBuffer commands) {
        vkCmdResetQueryPool(commands, pool, 0, 3);
        vkCmdWriteTimestamp(commands, stage, pool, 0);
      },
      [&](VkCommandBuffer commands) {
        vkCmdWriteTimestamp(commands, stage, pool, 1);
        vkCmdWriteTimestamp(commands, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, pool, 2);
      });
  const std::vector<uint64_t> times = results_of(device, pool, 3);
  const double host_ns = std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - begin).count();
  const uint64_t mask = bits == 64 ? ~uint64_t{0} : (uint64_t{1} << bits) - 1;
  for (const uint64_t time : times) expect((time & ~mask) == 0, "bits beyond timestampValidBits");
  // Modulo 2^bits; what went back would come out close to 2^bits.
  const auto elapsed_ns = [&](size_t i) {
    return static_cast<double>((times[i] - times[0]) & mask) * double{device.limits().timestampPeriod};
  };
  constexpr double kClockSlack = 1.01, kClockGrain_ns = 1e6;  // the two clocks may run differently
  for (const size_t i : {1, 2}) {
    expect(elapsed_ns(i) <= host_ns * kClockSlack + kClockGrain_ns,
           fmt::format("timestamp {} lies {} ns behind the first, of {} ns that went by", i, elapsed_ns(i), host_ns));
  }
}

void run_order_over_submissions(Device& device) {
  const uint32_t bits = valid_bits(device);
  constexpr uint32_t kSubmissions = 8;
  const QueryPool pool = create_query_pool(device, VK_QUERY_TYPE_TIMESTAMP, kSubmissions);
  for (uint32_t i = 0; i < kSubmissions; ++i) {
    device.run([&](VkCommandBuffer commands) {
      vkCmdResetQueryPool(commands, pool, i, 1);
      vkCmdWriteTimestamp(commands, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, pool, i);
    });
  }
  const std::vector<uint64_t> times = results_of(device, pool, kSubmissions);
  for (uint32_t i = 1; i < kSubmissions; ++i) {
    const uint64_t forward = (times[i] - times[i - 1]) << (64 - bits);
    expect(forward >> 63 == 0, fmt::format("submission {}: {} after {}", i, times[i], times[i - 1]));
  }
}

// With 32 bits a result that does not fit may wrap or saturate.
void run_narrow(Device& device) {
  valid_bits(device);
  const QueryPool pool = create_query_pool(device, VK_QUERY_TYPE_TIMESTAMP, 1);
  device.run([&](VkCommandBuffer commands) {
    vkCmdResetQueryPool(commands, pool, 0, 1);
    vkCmdWriteTimestamp(commands, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, pool, 0);
  });
  uint32_t narrow = 0;
  check(vkGetQueryPoolResults(device.handle(), pool, 0, 1, 4, &narrow, 4, VK_QUERY_RESULT_WAIT_BIT), "vkGetQueryPoolResults");
  const uint64_t wide = results_of(device, pool, 1)[0];
  expect(narrow == static_cast<uint32_t>(wide) || (wide > ~0u && narrow == ~0u), fmt::format("{:#x} of {:#x}", narrow, wide));
}

// What the device copies is what the host gets, and a query that was only reset is not available.
void run_copy_and_availability(Device& device) {
  valid_bits(device);
  const QueryPool pool = create_query_pool(device, VK_QUERY_TYPE_TIMESTAMP, 3);
  const Buffer out = create_buffer(device, 64);
  device.run([&](VkCommandBuffer commands) {
    vkCmdResetQueryPool(commands, pool, 0, 3);
    for (uint32_t i = 0; i < 2; ++i) vkCmdWriteTimestamp(commands, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, pool, i);
    vkCmdCopyQueryPoolResults(commands, pool, 0, 2, out.handle, 0, 16,
                              VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WITH_AVAILABILITY_BIT | VK_QUERY_RESULT_WAIT_BIT);
    full_barrier(commands);
  });
  const std::vector<uint64_t> times = results_of(device, pool, 2);
  for (uint32_t i = 0; i < 2; ++i) {
    expect(out.as<uint64_t>()[2 * i] == times[i], fmt::format("timestamp {} was copied as another number", i));
    expect(out.as<uint64_t>()[2 * i + 1] != 0, fmt::format("timestamp {} was copied as not available", i));
  }
  uint64_t late[2] = {1, 1};
  const VkResult result = vkGetQueryPoolResults(device.handle(), pool, 2, 1, sizeof(late), late, sizeof(late),
                                                VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WITH_AVAILABILITY_BIT);
  expect(result == VK_NOT_READY && late[1] == 0, "a timestamp that was only reset is available");
}

}  // namespace

void register_pipeline_timestamp() {
  constexpr const char* kGroup = "pipeline.timestamp";
  constexpr const char* kSection = "18.5 Timestamp Queries";
  static constexpr std::pair<VkPipelineStageFlagBits, const char*> kStages[] = {
      {VK_PIPELINE_STAGE_TOP_OF_PIPE_BIT, "top_of_pipe"},
      {VK_PIPELINE_STAGE_DRAW_INDIRECT_BIT, "draw_indirect"},
      {VK_PIPELINE_STAGE_VERTEX_INPUT_BIT, "vertex_input"},
      {VK_PIPELINE_STAGE_VERTEX_SHADER_BIT, "vertex_shader"},
      {VK_PIPELINE_STAGE_EARLY_FRAGMENT_TESTS_BIT, "early_fragment_tests"},
      {VK_PIPELINE_STAGE_FRAGMENT_SHADER_BIT, "fragment_shader"},
      {VK_PIPELINE_STAGE_LATE_FRAGMENT_TESTS_BIT, "late_fragment_tests"},
      {VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT, "color_attachment_output"},
      {VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, "compute_shader"},
      {VK_PIPELINE_STAGE_TRANSFER_BIT, "transfer"},
      {VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, "bottom_of_pipe"},
      {VK_PIPELINE_STAGE_ALL_GRAPHICS_BIT, "all_graphics"},
      {VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, "all_commands"}};
  static constexpr std::pair<Work, const char*> kWorks[] = {
      {Work::kNothing, "nothing"}, {Work::kDraw, "draw"}, {Work::kDispatch, "dispatch"}, {Work::kFill, "fill"}};
  for (const auto& [stage, stage_name] : kStages) {
    for (const auto& [work, work_name] : kWorks) {
      add_case(kGroup, fmt::format("{}.around_{}", stage_name, work_name), kSection,
               [stage = stage, work = work](Device& device) { run_stage(device, stage, work); });
    }
  }
  add_case(kGroup, "order_over_submissions", kSection, run_order_over_submissions);
  add_case(kGroup, "32_bits", "18.2 Query Operation", run_narrow);
  add_case(kGroup, "copy_and_availability", "18.2 Query Operation", run_copy_and_availability);
}

}  // namespace pineda::cts
