// query_pool.*: occlusion queries count samples exactly, results are copied and reset as specified.
#include <fmt/format.h>

#include <cstring>

#include "cts-subset/groups/groups.h"
#include "cts-subset/harness/case.h"
#include "cts-subset/harness/pipelines.h"

namespace pineda::cts {
namespace {

constexpr uint32_t kSize = 32;

ImageDesc colour_desc() {
  ImageDesc desc;
  desc.extent = {kSize, kSize, 1};
  desc.usage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT;
  return desc;
}

// A rectangle of whole pixels, at depth z.
DrawState rectangle(uint32_t width, uint32_t height, float z) {
  DrawState state;
  state.vertex = compile_glsl(
      VK_SHADER_STAGE_VERTEX_BIT,
      fmt::format("void main() {{ vec2 p = vec2(gl_VertexIndex & 1, gl_VertexIndex >> 1) * vec2({}.0, {}.0) / {}.0 * 2.0 - 1.0;"
                  "gl_Position = vec4(p, {:.3f}, 1.0); }}",
                  width, height, kSize, z));
  state.fragment = compile_glsl(VK_SHADER_STAGE_FRAGMENT_BIT, "layout(location = 0) out vec4 c; void main() { c = vec4(1.0); }");
  state.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_STRIP;
  state.vertices = 4;
  return state;
}

struct OcclusionCase {
  uint32_t width, height;
  bool discards = false;  // every second column
  bool hidden = false;    // by the depth test
  bool precise = true;
  VkSampleCountFlagBits samples = VK_SAMPLE_COUNT_1_BIT;
  uint32_t draws = 1;
};

void run_occlusion(Device& device, const OcclusionCase& c) {
  require(!c.precise || device.caps().features.occlusionQueryPrecise, "occlusionQueryPrecise");
  require(device.limits().framebufferColorSampleCounts & c.samples, "sample count");
  ImageDesc desc = colour_desc();
  desc.samples = c.samples;
  const Image colour = create_image(device, desc);
  desc.format = VK_FORMAT_D16_UNORM;
  desc.usage = VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT;
  const Image depth = create_image(device, desc);
  Target target;
  target.colours.push_back({&colour, VK_ATTACHMENT_LOAD_OP_CLEAR, {}});
  target.depth_stencil = Attachment{&depth, VK_ATTACHMENT_LOAD_OP_CLEAR, {.depthStencil = {0.5f, 0}}};
  const QueryPool pool = create_query_pool(device, VK_QUERY_TYPE_OCCLUSION, 2);
  DrawState state = rectangle(c.width, c.height, c.hidden ? 0.75f : 0.25f);
  if (c.discards) {
    state.fragment = compile_glsl(
        VK_SHADER_STAGE_FRAGMENT_BIT,
        "layout(location = 0) out vec4 c; void main() { if ((uint(gl_FragCoord.x) & 1u) != 0u) discard; c = vec4(1.0); }");
  }
  state.depth_stencil.depthTestEnable = VK_TRUE;
  state.depth_stencil.depthCompareOp = VK_COMPARE_OP_LESS;
  state.multisample.rasterizationSamples = c.samples;
  Pass pass(device, target);
  for (uint32_t i = 0; i < c.draws; ++i) pass.add(state);
  pass.run([&](VkCommandBuffer commands, const std::function<void()>& record) {
    vkCmdResetQueryPool(commands, pool, 0, 2);
    vkCmdBeginQuery(commands, pool, 1, c.precise ? VK_QUERY_CONTROL_PRECISE_BIT : 0);
    record();
    vkCmdEndQuery(commands, pool, 1);
  });
  uint64_t result[2] = {};
  check(vkGetQueryPoolResults(device.handle(), pool, 1, 1, sizeof(result), result, sizeof(result),
                              VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT | VK_QUERY_RESULT_WITH_AVAILABILITY_BIT),
        "vkGetQueryPoolResults");
  const uint64_t pixels = uint64_t{c.discards ? c.width / 2 : c.width} * c.height;
  const uint64_t want = c.hidden ? 0 : pixels * c.samples * c.draws;
  expect(result[1] != 0, "the result is not available after the queue is idle");
  expect(c.precise ? result[0] == want : (result[0] != 0) == (want != 0),
         fmt::format("{} samples passed, not {}", result[0], want));
}

// The results of two queries, copied by the device with every combination of flags.
void run_copy(Device& device, VkQueryResultFlags flags, VkDeviceSize stride) {
  const QueryPool pool = create_query_pool(device, VK_QUERY_TYPE_OCCLUSION, 3);
  const Buffer out = create_buffer(device, 256, kAnyBuffer, 0xEE);
  const Image colour = create_image(device, colour_desc());
  Target target;
  target.colours.push_back({&colour, VK_ATTACHMENT_LOAD_OP_CLEAR, {}});
  Pass pass(device, target);
  pass.add(rectangle(kSize, kSize, 0.5f));
  pass.run([&](VkCommandBuffer commands, const std::function<void()>& record) {
    vkCmdResetQueryPool(commands, pool, 0, 3);
    vkCmdBeginQuery(commands, pool, 0, 0);
    record();
    vkCmdEndQuery(commands, pool, 0);
    full_barrier(commands);
    vkCmdCopyQueryPoolResults(commands, pool, 0, 2, out.handle, 16, stride, flags);  // query 1 is not available
  });
  const size_t width = flags & VK_QUERY_RESULT_64_BIT ? 8 : 4;
  const auto value_at = [&](size_t offset) {
    uint64_t value = 0;
    std::memcpy(&value, out.mapped + offset, width);
    return value;
  };
  const uint64_t untouched = width == 8 ? 0xEEEEEEEEEEEEEEEEu : 0xEEEEEEEEu;
  expect(value_at(16) != 0 && value_at(16) != untouched, "the first query's result was not copied");
  expect(value_at(0) == untouched, "something was written before the offset");
  if (!(flags & VK_QUERY_RESULT_PARTIAL_BIT)) expect(value_at(16 + stride) == untouched, "an unavailable result was written");
  if (flags & VK_QUERY_RESULT_WITH_AVAILABILITY_BIT) {
    expect(value_at(16 + width) != 0 && value_at(16 + width) != untouched, "the first query says that it is not available");
    expect(value_at(16 + stride + width) == 0, "the second query says that it is available");
  }
}

// A statistic of a known draw: 2 instances of a strip of 4 vertices that covers 16 x 16 pixels.
struct Statistic {
  VkQueryPipelineStatisticFlagBits bit;
  const char* name;
  uint64_t low, high;
};
constexpr Statistic kStatistics[] = {
    {VK_QUERY_PIPELINE_STATISTIC_INPUT_ASSEMBLY_VERTICES_BIT, "input_assembly_vertices", 8, 12},  // reuse may or may not count
    {VK_QUERY_PIPELINE_STATISTIC_INPUT_ASSEMBLY_PRIMITIVES_BIT, "input_assembly_primitives", 4, 4},
    {VK_QUERY_PIPELINE_STATISTIC_VERTEX_SHADER_INVOCATIONS_BIT, "vertex_shader_invocations", 1, 12},
    {VK_QUERY_PIPELINE_STATISTIC_CLIPPING_INVOCATIONS_BIT, "clipping_invocations", 1, 4},
    {VK_QUERY_PIPELINE_STATISTIC_CLIPPING_PRIMITIVES_BIT, "clipping_primitives", 1, 8},
    {VK_QUERY_PIPELINE_STATISTIC_FRAGMENT_SHADER_INVOCATIONS_BIT, "fragment_shader_invocations", 256, 1024},
};

void run_statistic(Device& device, const Statistic& statistic) {
  require(device.caps().features.pipelineStatisticsQuery, "pipelineStatisticsQuery");
  const QueryPool pool = create_query_pool(device, VK_QUERY_TYPE_PIPELINE_STATISTICS, 1, statistic.bit);
  const Image colour = create_image(device, colour_desc());
  Target target;
  target.colours.push_back({&colour, VK_ATTACHMENT_LOAD_OP_CLEAR, {}});
  Pass pass(device, target);
  DrawState state = rectangle(16, 16, 0.5f);
  state.instances = 2;
  pass.add(state);
  pass.run([&](VkCommandBuffer commands, const std::function<void()>& record) {
    vkCmdResetQueryPool(commands, pool, 0, 1);
    vkCmdBeginQuery(commands, pool, 0, 0);
    record();
    vkCmdEndQuery(commands, pool, 0);
  });
  uint64_t value = 0;
  check(vkGetQueryPoolResults(device.handle(), pool, 0, 1, 8, &value, 8, VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT),
        "vkGetQueryPoolResults");
  expect(value >= statistic.low && value <= statistic.high,
         fmt::format("{}, not in {} to {}", value, statistic.low, statistic.high));
}

}  // namespace

void register_queries() {
  constexpr const char* kOcclusion = "18.3 Occlusion Queries";
  for (const auto& [width, height] : {std::pair{1u, 1u}, {3u, 5u}, {16u, 16u}, {31u, 17u}, {32u, 32u}}) {
    for (const VkSampleCountFlagBits samples :
         {VK_SAMPLE_COUNT_1_BIT, VK_SAMPLE_COUNT_2_BIT, VK_SAMPLE_COUNT_4_BIT, VK_SAMPLE_COUNT_8_BIT}) {
      for (const bool precise : {false, true}) {
        const auto add = [&](const char* name, OcclusionCase c) {
          c.precise = precise, c.samples = samples;
          add_case("query_pool",
                   fmt::format("occlusion.{}x{}_{}_samples_{}_{}", width, height, static_cast<int>(samples), name,
                               precise ? "precise" : "boolean"),
                   kOcclusion, [c](Device& device) { run_occlusion(device, c); });
        };
        add("plain", {width, height});
        add("hidden", {width, height, false, true});
        add("two_draws", {width, height, false, false, true, VK_SAMPLE_COUNT_1_BIT, 2});
        if (width > 1) add("discards", {width - width % 2, height, true});
      }
    }
  }
  for (VkQueryResultFlags flags = 0; flags < 16; ++flags) {
    if (flags & VK_QUERY_RESULT_WAIT_BIT) continue;  // would wait for the query that never runs
    for (const VkDeviceSize stride : {16u, 32u}) {
      add_case("query_pool", fmt::format("copy.flags_{}_stride_{}", flags, stride), "18.2 vkCmdCopyQueryPoolResults",
               [flags, stride](Device& device) { run_copy(device, flags, stride); });
    }
  }
  for (const Statistic& statistic : kStatistics) {
    add_case("query_pool", fmt::format("statistics.{}", statistic.name), "18.4 Pipeline Statistics Queries",
             [&statistic](Device& device) { run_statistic(device, statistic); });
  }
}

}  // namespace pineda::cts
