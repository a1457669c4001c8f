// subgroups.*: each operation, with all and with some invocations active, against the definition applied lane by lane.
#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <deque>
#include <functional>
#include <memory>

#include "cts-subset/groups/groups.h"
#include "cts-subset/harness/case.h"
#include "cts-subset/harness/pipelines.h"
#include "cts-subset/reference/random.h"

namespace pineda::cts {
namespace {

constexpr uint32_t kInvocations = 128;

// What a lane sees: its value, and the active lanes of its subgroup.
struct Lane {
  uint32_t index, size;
  const uint32_t* values;  // of the subgroup
  const bool* active;
};

struct Operation {
  const char* name;
  const char* expression;  // of uint v and lane indices; gives a uint
  const char* extension;
  VkSubgroupFeatureFlagBits feature;
  std::function<uint32_t(const Lane&)> want;
  bool defined_everywhere = true;  // false: lanes whose source is inactive are skipped by the function, returning kAnything
};

constexpr uint32_t kAnything = 0xDEADBEEF;

uint32_t reduce(const Lane& lane, uint32_t first, uint32_t last, uint32_t start, uint32_t (*op)(uint32_t, uint32_t)) {
  uint32_t total = start;
  for (uint32_t i = first; i < last; ++i) {
    if (lane.active[i]) total = op(total, lane.values[i]);
  }
  return total;
}
uint32_t add(uint32_t a, uint32_t b) { return a + b; }
uint32_t mul(uint32_t a, uint32_t b) { return a * b; }
uint32_t min_of(uint32_t a, uint32_t b) { return std::min(a, b); }
uint32_t max_of(uint32_t a, uint32_t b) { return std::max(a, b); }
uint32_t and_of(uint32_t a, uint32_t b) { return a & b; }
uint32_t or_of(uint32_t a, uint32_t b) { return a | b; }
uint32_t xor_of(uint32_t a, uint32_t b) { return a ^ b; }

uint32_t first_active(const Lane& lane) {
  uint32_t i = 0;
  while (!lane.active[i]) ++i;
  return i;
}

uint32_t value_at(const Lane& lane, uint32_t at) { return at < lane.size && lane.active[at] ? lane.values[at] : kAnything; }

uint32_t ballot(const Lane& lane, uint32_t first, uint32_t last) {  // of odd values, lanes first .. last - 1
  uint32_t count = 0;
  for (uint32_t i = first; i < last; ++i) count += lane.active[i] && (lane.values[i] & 1);
  return count;
}

std::vector<Operation> operations() {
  constexpr const char* kBasic = "GL_KHR_shader_subgroup_basic";
  constexpr const char* kVote = "GL_KHR_shader_subgroup_vote";
  constexpr const char* kBallot = "GL_KHR_shader_subgroup_ballot";
  constexpr const char* kShuffle = "GL_KHR_shader_subgroup_shuffle";
  constexpr const char* kRelative = "GL_KHR_shader_subgroup_shuffle_relative";
  constexpr const char* kQuad = "GL_KHR_shader_subgroup_quad";
  using F = VkSubgroupFeatureFlagBits;
  constexpr F basic = VK_SUBGROUP_FEATURE_BASIC_BIT, vote = VK_SUBGROUP_FEATURE_VOTE_BIT,
              ballots = VK_SUBGROUP_FEATURE_BALLOT_BIT;
  constexpr F shuffle = VK_SUBGROUP_FEATURE_SHUFFLE_BIT, relative = VK_SUBGROUP_FEATURE_SHUFFLE_RELATIVE_BIT,
              quad = VK_SUBGROUP_FEATURE_QUAD_BIT;
  std::vector<Operation> table = {
      {"elect", "subgroupElect() ? 1u : 0u", kBasic, basic, [](const Lane& l) { return l.index == first_active(l) ? 1u : 0u; }},
      {"invocation_id", "gl_SubgroupInvocationID", kBasic, basic, [](const Lane& l) { return l.index; }},
      {"all", "subgroupAll(v > 10u) ? 1u : 0u", kVote, vote,
       [](const Lane& l) { return reduce(l, 0, l.size, ~0u, min_of) > 10 ? 1u : 0u; }},
      {"any", "subgroupAny(v < 5u) ? 1u : 0u", kVote, vote,
       [](const Lane& l) { return reduce(l, 0, l.size, ~0u, min_of) < 5 ? 1u : 0u; }},
      {"all_equal", "subgroupAllEqual(v >> 6u) ? 1u : 0u", kVote, vote,
       [](const Lane& l) {
         for (uint32_t i = 0; i < l.size; ++i) {
           if (l.active[i] && l.values[i] >> 6 != l.values[l.index] >> 6) return 0u;
         }
         return 1u;
       }},
      {"broadcast_first", "subgroupBroadcastFirst(v)", kBallot, ballots, [](const Lane& l) { return l.values[first_active(l)]; }},
      {"broadcast", "subgroupBroadcast(v, 2u)", kBallot, ballots, [](const Lane& l) { return value_at(l, 2); }},
      {"ballot_bit_count", "subgroupBallotBitCount(subgroupBallot((v & 1u) != 0u))", kBallot, ballots,
       [](const Lane& l) { return ballot(l, 0, l.size); }},
      {"ballot_inclusive", "subgroupBallotInclusiveBitCount(subgroupBallot((v & 1u) != 0u))", kBallot, ballots,
       [](const Lane& l) { return ballot(l, 0, l.index + 1); }},
      {"ballot_exclusive", "subgroupBallotExclusiveBitCount(subgroupBallot((v & 1u) != 0u))", kBallot, ballots,
       [](const Lane& l) { return ballot(l, 0, l.index); }},
      {"inverse_ballot", "subgroupInverseBallot(subgroupBallot((v & 1u) != 0u)) ? 1u : 0u", kBallot, ballots,
       [](const Lane& l) { return l.values[l.index] & 1; }},
      {"ballot_bit_extract", "subgroupBallotBitExtract(subgroupBallot((v & 1u) != 0u), 1u) ? 1u : 0u", kBallot, ballots,
       [](const Lane& l) { return l.active[1] ? l.values[1] & 1 : 0u; }},
      {"eq_mask", "subgroupBallotBitCount(gl_SubgroupEqMask)", kBallot, ballots, [](const Lane&) { return 1u; }},
      {"lt_mask", "subgroupBallotBitCount(gl_SubgroupLtMask)", kBallot, ballots, [](const Lane& l) { return l.index; }},
      {"ge_mask", "subgroupBallotBitCount(gl_SubgroupGeMask)", kBallot, ballots, [](const Lane& l) { return l.size - l.index; }},
      {"shuffle", "subgroupShuffle(v, (gl_SubgroupInvocationID * 3u + 1u) % gl_SubgroupSize)", kShuffle, shuffle,
       [](const Lane& l) { return value_at(l, (l.index * 3 + 1) % l.size); }},
      {"shuffle_xor", "subgroupShuffleXor(v, 3u)", kShuffle, shuffle, [](const Lane& l) { return value_at(l, l.index ^ 3); }},
      {"shuffle_up", "subgroupShuffleUp(v, 2u)", kRelative, relative,
       [](const Lane& l) { return l.index < 2 ? kAnything : value_at(l, l.index - 2); }},
      {"shuffle_down", "subgroupShuffleDown(v, 1u)", kRelative, relative, [](const Lane& l) { return value_at(l, l.index + 1); }},
      {"quad_broadcast", "subgroupQuadBroadcast(v, 1u)", kQuad, quad,
       [](const Lane& l) { return value_at(l, (l.index & ~3u) + 1); }},
      {"quad_swap_horizontal", "subgroupQuadSwapHorizontal(v)", kQuad, quad,
       [](const Lane& l) { return value_at(l, l.index ^ 1); }},
      {"quad_swap_vertical", "subgroupQuadSwapVertical(v)", kQuad, quad, [](const Lane& l) { return value_at(l, l.index ^ 2); }},
      {"quad_swap_diagonal", "subgroupQuadSwapDiagonal(v)", kQuad, quad, [](const Lane& l) { return value_at(l, l.index ^ 3); }},
  };
  struct Reduction {
    const char* name;
    const char* glsl;
    uint32_t start;
    uint32_t (*op)(uint32_t, uint32_t);
  };
  static constexpr Reduction kReductions[] = {{"add", "Add", 0, add},    {"mul", "Mul", 1, mul},      {"min", "Min", ~0u, min_of},
                                              {"max", "Max", 0, max_of}, {"and", "And", ~0u, and_of}, {"or", "Or", 0, or_of},
                                              {"xor", "Xor", 0, xor_of}};
  static std::deque<std::string> kept;  // the table holds pointers
  const auto keep = [&](std::string text) { return kept.emplace_back(std::move(text)).c_str(); };
  for (const Reduction& r : kReductions) {
    constexpr const char* kArithmetic = "GL_KHR_shader_subgroup_arithmetic";
    constexpr F arithmetic = VK_SUBGROUP_FEATURE_ARITHMETIC_BIT;
    table.push_back({keep(fmt::format("reduce_{}", r.name)), keep(fmt::format("subgroup{}(v)", r.glsl)), kArithmetic, arithmetic,
                     [&r](const Lane& l) { return reduce(l, 0, l.size, r.start, r.op); }});
    table.push_back({keep(fmt::format("inclusive_{}", r.name)), keep(fmt::format("subgroupInclusive{}(v)", r.glsl)), kArithmetic,
                     arithmetic, [&r](const Lane& l) { return reduce(l, 0, l.index + 1, r.start, r.op); }});
    table.push_back({keep(fmt::format("exclusive_{}", r.name)), keep(fmt::format("subgroupExclusive{}(v)", r.glsl)), kArithmetic,
                     arithmetic, [&r](const Lane& l) { return reduce(l, 0, l.index, r.start, r.op); }});
    for (const uint32_t cluster : {1u, 2u, 4u}) {
      table.push_back({keep(fmt::format("clustered_{}_{}", cluster, r.name)),
                       keep(fmt::format("subgroupClustered{}(v, {}u)", r.glsl, cluster)), "GL_KHR_shader_subgroup_clustered",
                       VK_SUBGROUP_FEATURE_CLUSTERED_BIT, [&r, cluster](const Lane& l) {
                         const uint32_t first = l.index / cluster * cluster;
                         return reduce(l, first, first + cluster, r.start, r.op);
                       }});
    }
  }
  return table;
}

enum class Active { kAll, kSome };

// Subgroup ids are asked from the device, so that no mapping of invocations to subgroups is assumed.
void run(Device& device, const Operation& op, Active activity) {
  const VkPhysicalDeviceSubgroupProperties& properties = device.caps().subgroup;
  require(device.caps().api_version >= VK_API_VERSION_1_1, "Vulkan 1.1");
  require(properties.supportedOperations & op.feature, "this class of subgroup operations");
  require(properties.supportedStages & VK_SHADER_STAGE_COMPUTE_BIT, "subgroup operations in compute");
  std::vector<uint32_t> input(kInvocations);
  Random random(op.name);
  for (uint32_t& v : input) v = random.below(200);
  const Buffer in = create_buffer(device, input), out = create_buffer(device, kInvocations * 16);
  const char* condition = activity == Active::kAll ? "true" : "v % 3u != 0u";
  const std::string text = fmt::format(
      "#extension GL_KHR_shader_subgroup_basic : require\n#extension {} : require\nlayout(local_size_x = {}) in;\n"
      "layout(binding = 0, std430) readonly buffer In {{ uint inputs[]; }};\nlayout(binding = 1, std430) buffer Out {{ uvec4 "
      "outputs[]; }};\n"
      "void main() {{\n  uint at = gl_LocalInvocationIndex, v = inputs[at], r = 0u, ran = 0u;\n"
      "  if ({}) {{ r = {}; ran = 1u; }}\n  outputs[at] = uvec4(r, ran, gl_SubgroupID, gl_SubgroupInvocationID);\n}}\n",
      op.extension, kInvocations, condition, op.expression);
  Resources resources;
  resources.descriptors = {storage_buffer(0, in), storage_buffer(1, out)};
  dispatch(device, compile_glsl(VK_SHADER_STAGE_COMPUTE_BIT, text, 3), resources);
  const auto results = out.as<std::array<uint32_t, 4>>();
  const uint32_t size = properties.subgroupSize;
  std::vector<uint32_t> values(size);
  for (uint32_t group = 0; group * size < kInvocations; ++group) {
    const std::unique_ptr<bool[]> active(new bool[size + 1]{});
    for (uint32_t i = 0; i < kInvocations; ++i) {
      if (results[i][2] != group) continue;
      values[results[i][3]] = input[i];
      active[results[i][3]] = results[i][1] != 0;
    }
    for (uint32_t i = 0; i < kInvocations; ++i) {
      if (results[i][2] != group || !results[i][1]) continue;
      const uint32_t want = op.want({results[i][3], size, values.data(), active.get()});
      expect(want == kAnything || results[i][0] == want,
             fmt::format("invocation {} (lane {} of subgroup {}): {}, not {}", i, results[i][3], group, results[i][0], want));
    }
  }
}

}  // namespace

void register_subgroups() {
  static const std::vector<Operation> table = operations();
  for (const Operation& op : table) {
    for (const Active activity : {Active::kAll, Active::kSome}) {
      add_case("subgroups", fmt::format("{}.{}", op.name, activity == Active::kAll ? "all_active" : "some_active"),
               "9.27 Group Operations; SPIR-V 3.49.21 Non-Uniform Instructions",
               [&op, activity](Device& device) { run(device, op, activity); });
    }
  }
}

}  // namespace pineda::cts
