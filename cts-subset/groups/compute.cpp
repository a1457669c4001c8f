// compute.*: built-in variables for every shape of workgroup, shared memory between barriers, atomics, indirect dispatches.
#include <fmt/format.h>

#include <array>
#include <cstring>
#include <set>

#include "cts-subset/groups/groups.h"
#include "cts-subset/harness/case.h"
#include "cts-subset/harness/pipelines.h"
#include "cts-subset/reference/random.h"

namespace pineda::cts {
namespace {

using Size3 = std::array<uint32_t, 3>;
uint32_t product(const Size3& s) { return s[0] * s[1] * s[2]; }

void require_size(const Device& device, const Size3& local) {
  const VkPhysicalDeviceLimits& limits = device.limits();
  for (size_t i = 0; i < 3; ++i) require(local[i] <= limits.maxComputeWorkGroupSize[i], "this size of workgroup");
  require(product(local) <= limits.maxComputeWorkGroupInvocations, "as many invocations");
}

// Each invocation writes its own slot, by its identifiers; the formula of each built-in from the others is checked here.
void run_builtins(Device& device, const Size3& local, const Size3& groups, bool specialised) {
  require_size(device, local);
  const uint32_t count = product(local) * product(groups);
  const Buffer out = create_buffer(device, VkDeviceSize{count} * 48, kAnyBuffer, 0xFF);
  Resources resources;
  resources.descriptors = {storage_buffer(0, out)};
  std::string layout;
  for (uint32_t i = 0; i < 3; ++i) {
    layout +=
        fmt::format("{}local_size_{}{} = {}", i ? ", " : "", "xyz"[i], specialised ? "_id" : "", specialised ? i : local[i]);
    if (specialised) add_specialization(resources, i, local[i]);
  }
  const Spirv shader = compile_glsl(
      VK_SHADER_STAGE_COMPUTE_BIT,
      fmt::format("layout({}) in;\nlayout(binding = 0, std430) buffer B {{ uvec4 values[]; }};\n"
                  "void main() {{ uvec3 all = gl_NumWorkGroups * gl_WorkGroupSize; uvec3 g = gl_GlobalInvocationID;\n"
                  "  uint at = (g.z * all.y + g.y) * all.x + g.x;\n"
                  "  values[at * 3u] = uvec4(gl_LocalInvocationID, gl_LocalInvocationIndex);\n"
                  "  values[at * 3u + 1u] = uvec4(gl_WorkGroupID, 7u); values[at * 3u + 2u] = uvec4(gl_NumWorkGroups, 9u); }}",
                  layout));
  dispatch(device, shader, resources, groups);
  const auto got = out.as<std::array<uint32_t, 12>>();
  for (uint32_t at = 0; at < count; ++at) {
    const Size3 all = {local[0] * groups[0], local[1] * groups[1], local[2] * groups[2]};
    const Size3 global = {at % all[0], at / all[0] % all[1], at / all[0] / all[1]};
    Size3 in{}, group{};
    for (size_t i = 0; i < 3; ++i) in[i] = global[i] % local[i], group[i] = global[i] / local[i];
    const std::array<uint32_t, 12> want = {in[0],     in[1],     in[2],     (in[2] * local[1] + in[1]) * local[0] + in[0],
                                           group[0],  group[1],  group[2],  7,
                                           groups[0], groups[1], groups[2], 9};
    expect(got[at] == want, fmt::format("invocation ({}, {}, {}) reports other identifiers", global[0], global[1], global[2]));
  }
}

// A permutation through shared memory, `rounds` times; wrong or missing barriers break it.
void run_shared(Device& device, uint32_t invocations, uint32_t rounds, bool in_loop) {
  require_size(device, {invocations, 1, 1});
  constexpr uint32_t kGroups = 5;
  Random random("shared");
  std::vector<uint32_t> values(invocations * kGroups);
  for (uint32_t& v : values) v = random.bits();
  const Buffer data = create_buffer(device, values);
  Resources resources;
  resources.descriptors = {storage_buffer(0, data)};
  const std::string step = fmt::format(
      "  shared_values[i] = v; barrier(); v = shared_values[(i * 7u + 3u) % {0}u] ^ shared_values[{0}u - 1u - i]; barrier();\n",
      invocations);
  std::string body;
  if (in_loop) {
    body = fmt::format("  for (int r = 0; r < {}; ++r) {{\n{}  }}\n", rounds, step);
  } else {
    for (uint32_t r = 0; r < rounds; ++r) body += step;
  }
  dispatch(device,
           compile_glsl(VK_SHADER_STAGE_COMPUTE_BIT,
                        fmt::format("layout(local_size_x = {0}) in; layout(binding = 0, std430) buffer B {{ uint values[]; }};\n"
                                    "shared uint shared_values[{0}];\n"
                                    "void main() {{ uint i = gl_LocalInvocationID.x; uint v = values[gl_GlobalInvocationID.x];\n"
                                    "{1}  values[gl_GlobalInvocationID.x] = v; }}",
                                    invocations, body)),
           resources, {kGroups, 1, 1});
  for (uint32_t group = 0; group < kGroups; ++group) {
    std::vector<uint32_t> now(values.begin() + group * invocations, values.begin() + (group + 1) * invocations),
        next(invocations);
    for (uint32_t r = 0; r < rounds; ++r) {
      for (uint32_t i = 0; i < invocations; ++i) next[i] = now[(i * 7 + 3) % invocations] ^ now[invocations - 1 - i];
      now.swap(next);
    }
    for (uint32_t i = 0; i < invocations; ++i) {
      const uint32_t got = data.as<uint32_t>()[group * invocations + i];
      expect(got == now[i], fmt::format("invocation {} of group {} has {:#x}, not {:#x}", i, group, got, now[i]));
    }
  }
}

// One memory word that all invocations change: the final value does not depend on the order for these operations.
struct AtomicOp {
  const char* name;
  uint32_t (*apply)(uint32_t, uint32_t);
  bool exchanges = false;  // any of the operands may be what stays
};
constexpr AtomicOp kAtomics[] = {
    {"Add", [](uint32_t a, uint32_t b) { return a + b; }},
    {"Min", [](uint32_t a, uint32_t b) { return std::min(a, b); }},
    {"Max", [](uint32_t a, uint32_t b) { return std::max(a, b); }},
    {"And", [](uint32_t a, uint32_t b) { return a & b; }},
    {"Or", [](uint32_t a, uint32_t b) { return a | b; }},
    {"Xor", [](uint32_t a, uint32_t b) { return a ^ b; }},
    {"Exchange", [](uint32_t, uint32_t b) { return b; }, true},
};
enum class Where { kBuffer, kShared };

uint32_t hash(uint32_t i) { return (i * 2654435761u) ^ (i << 7); }

void run_atomic(Device& device, const AtomicOp& op, Where where, bool is_signed) {
  constexpr uint32_t kInvocations = 64, kGroups = 8;
  const uint32_t start = 0x0F0F5A5A;
  const Buffer out = create_buffer(device, std::vector<uint32_t>(kGroups, start));
  Resources resources;
  resources.descriptors = {storage_buffer(0, out)};
  const char* type = is_signed ? "int" : "uint";
  const bool shared = where == Where::kShared;
  const std::string target = shared ? "cell" : "values[gl_WorkGroupID.x]";
  const std::string text = fmt::format(
      "layout(local_size_x = {}) in; layout(binding = 0, std430) buffer B {{ {} values[]; }}; shared {} cell;\n"
      "void main() {{ uint i = gl_GlobalInvocationID.x; if (gl_LocalInvocationIndex == 0u) cell = {}({}u); barrier();\n"
      "  atomic{}({}, {}((i * 2654435761u) ^ (i << 7))); barrier();\n"
      "  {} }}",
      kInvocations, type, type, type, start, op.name, target, type,
      shared ? "if (gl_LocalInvocationIndex == 0u) values[gl_WorkGroupID.x] = cell;" : "");
  dispatch(device, compile_glsl(VK_SHADER_STAGE_COMPUTE_BIT, text), resources, {kGroups, 1, 1});
  for (uint32_t group = 0; group < kGroups; ++group) {
    const uint32_t got = out.as<uint32_t>()[group];
    uint32_t want = start;
    bool found = false;
    const bool ordered = is_signed && (op.name[0] == 'M');
    for (uint32_t i = group * kInvocations; i < (group + 1) * kInvocations; ++i) {
      if (ordered) {
        const int32_t a = static_cast<int32_t>(want), b = static_cast<int32_t>(hash(i));
        want = static_cast<uint32_t>(op.name[1] == 'i' ? std::min(a, b) : std::max(a, b));
      } else {
        want = op.apply(want, hash(i));
      }
      found |= got == hash(i);
    }
    expect(op.exchanges ? found : got == want, fmt::format("group {} left {:#x}, not {:#x}", group, got, want));
  }
}

// Tickets: atomicAdd returns each number once; a compare-and-swap loop counts exactly.
void run_tickets(Device& device, bool compare_and_swap) {
  constexpr uint32_t kInvocations = 64, kGroups = 16, kAll = kInvocations * kGroups;
  const Buffer out = create_buffer(device, (kAll + 1) * 4);
  Resources resources;
  resources.descriptors = {storage_buffer(0, out)};
  const char* take = compare_and_swap
                         ? "uint old; do { old = counter; } while (atomicCompSwap(counter, old, old + 1u) != old); uint t = old;"
                         : "uint t = atomicAdd(counter, 1u);";
  dispatch(device,
           compile_glsl(VK_SHADER_STAGE_COMPUTE_BIT,
                        fmt::format("layout(local_size_x = {}) in;\n"
                                    "layout(binding = 0, std430) coherent volatile buffer B {{ uint counter; uint seen[]; }};\n"
                                    "void main() {{ {} atomicAdd(seen[t], 1u); }}",
                                    kInvocations, take)),
           resources, {kGroups, 1, 1});
  const auto got = out.as<uint32_t>();
  expect(got[0] == kAll, fmt::format("the counter is {}, not {}", got[0], kAll));
  for (uint32_t t = 0; t < kAll; ++t) expect(got[t + 1] == 1, fmt::format("ticket {} was given {} times", t, got[t + 1]));
}

// vkCmdDispatchIndirect and vkCmdDispatchBase count the same groups.
void run_indirect(Device& device, const Size3& groups, VkDeviceSize offset) {
  const Buffer out = create_buffer(device, 4);
  std::vector<uint32_t> parameters(offset / 4);
  parameters.insert(parameters.end(), groups.begin(), groups.end());
  const Buffer indirect = create_buffer(device, parameters);
  Resources resources;
  resources.descriptors = {storage_buffer(0, out)};
  const Bindings bindings(device, resources, VK_SHADER_STAGE_COMPUTE_BIT);
  const Spirv code = compile_glsl(VK_SHADER_STAGE_COMPUTE_BIT,
                                  "layout(local_size_x = 4) in; layout(binding = 0, std430) buffer B { uint n; };\n"
                                  "void main() { atomicAdd(n, 1u + gl_NumWorkGroups.x * 256u); }");
  const Pipeline pipeline = create_compute_pipeline(device, code, bindings.layout(), resources);
  device.run([&](VkCommandBuffer commands) {
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline);
    bindings.bind(commands, VK_PIPELINE_BIND_POINT_COMPUTE, resources);
    vkCmdDispatchIndirect(commands, indirect.handle, offset);
    full_barrier(commands);
  });
  const uint32_t want = product(groups) * 4 * (1 + groups[0] * 256);
  expect(out.as<uint32_t>()[0] == want, fmt::format("{} instead of {}", out.as<uint32_t>()[0], want));
}

// A dispatch sees what the one before wrote, through a barrier; 2^k sums by pairwise passes.
void run_chain(Device& device, uint32_t passes) {
  const uint32_t count = 64u << passes;
  std::vector<uint32_t> values(count);
  Random random("chain");
  uint32_t want = 0;
  for (uint32_t& v : values) want += v = random.bits();
  const Buffer data = create_buffer(device, values);
  Resources resources;
  resources.descriptors = {storage_buffer(0, data)};
  resources.push_constants = to_bytes(uint32_t{0});
  const Bindings bindings(device, resources, VK_SHADER_STAGE_COMPUTE_BIT);
  const Spirv code =
      compile_glsl(VK_SHADER_STAGE_COMPUTE_BIT,
                   "layout(local_size_x = 32) in; layout(binding = 0, std430) buffer B { uint v[]; };\n"
                   "layout(push_constant) uniform P { uint half_count; };\n"
                   "void main() { uint i = gl_GlobalInvocationID.x; if (i < half_count) v[i] += v[i + half_count]; }");
  const Pipeline pipeline = create_compute_pipeline(device, code, bindings.layout(), resources);
  device.run([&](VkCommandBuffer commands) {
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline);
    bindings.bind(commands, VK_PIPELINE_BIND_POINT_COMPUTE, resources);
    for (uint32_t half = count / 2; half; half /= 2) {
      vkCmdPushConstants(commands, bindings.layout(), VK_SHADER_STAGE_COMPUTE_BIT, 0, 4, &half);
      vkCmdDispatch(commands, (half + 31) / 32, 1, 1);
      full_barrier(commands);
    }
  });
  expect(data.as<uint32_t>()[0] == want, "the sum is wrong");
}

}  // namespace

void register_compute() {
  static constexpr Size3 kLocals[] = {{1, 1, 1},   {2, 1, 1},   {7, 1, 1},   {16, 1, 1},  {17, 1, 1}, {64, 1, 1},
                                      {1, 16, 1},  {1, 1, 16},  {3, 5, 7},   {8, 8, 1},   {4, 4, 4},  {5, 3, 2},
                                      {128, 1, 1}, {16, 16, 1}, {32, 32, 1}, {1, 128, 1}, {2, 3, 64}};
  static constexpr Size3 kGroups[] = {{1, 1, 1}, {3, 1, 1}, {1, 3, 2}, {5, 2, 3}};
  for (const Size3& local : kLocals) {
    for (const Size3& groups : kGroups) {
      for (const bool specialised : {false, true}) {
        add_case("compute.builtins",
                 fmt::format("local_{}x{}x{}_groups_{}x{}x{}{}", local[0], local[1], local[2], groups[0], groups[1], groups[2],
                             specialised ? "_specialised" : ""),
                 "15.8 Built-In Variables: compute", [=](Device& device) { run_builtins(device, local, groups, specialised); });
      }
    }
  }
  for (const uint32_t invocations : {16u, 33u, 64u, 100u, 128u, 256u, 1024u}) {
    for (const uint32_t rounds : {1u, 4u}) {
      for (const bool in_loop : {false, true}) {
        add_case("compute.shared", fmt::format("{}_invocations_{}_rounds{}", invocations, rounds, in_loop ? "_in_loop" : ""),
                 "SPIR-V 3.42.20 OpControlBarrier", [=](Device& device) { run_shared(device, invocations, rounds, in_loop); });
      }
    }
  }
  for (const AtomicOp& op : kAtomics) {
    for (const bool is_signed : {false, true}) {
      for (const Where where : {Where::kBuffer, Where::kShared}) {
        add_case("compute.atomics",
                 fmt::format("{}_{}_{}", op.name, is_signed ? "int" : "uint", where == Where::kShared ? "shared" : "buffer"),
                 "SPIR-V 3.42.18 Atomic Instructions",
                 [&op, where, is_signed](Device& device) { run_atomic(device, op, where, is_signed); });
      }
    }
  }
  add_case("compute.atomics", "tickets_by_add", "SPIR-V 3.42.18 Atomic Instructions",
           [](Device& device) { run_tickets(device, false); });
  add_case("compute.atomics", "tickets_by_compare_and_swap", "SPIR-V 3.42.18 Atomic Instructions",
           [](Device& device) { run_tickets(device, true); });
  for (const Size3& groups : {Size3{1, 1, 1}, Size3{0, 1, 1}, Size3{4, 0, 2}, Size3{3, 4, 5}, Size3{100, 1, 1}}) {
    for (const VkDeviceSize offset : {0u, 4u, 64u}) {
      add_case("compute.indirect", fmt::format("groups_{}x{}x{}_offset_{}", groups[0], groups[1], groups[2], offset),
               "29 Dispatching Commands", [=](Device& device) { run_indirect(device, groups, offset); });
    }
  }
  for (const uint32_t passes : {0u, 3u, 8u}) {
    add_case("compute.dependencies", fmt::format("sum_in_{}_passes", passes + 6), "7.6 Memory Barriers",
             [=](Device& device) { run_chain(device, passes); });
  }
}

}  // namespace pineda::cts
