// GLSL's KHR_shader_subgroup_* functions against their definitions, with all lanes active, with some (divergent control flow),
// and in a wave that is not full; each also by the JIT on every ISA against the evaluator.
#include <bit>
#include <cmath>
#include <cstdint>
#include <functional>
#include <optional>

#include "compiler/kernels/compute_rig.h"

namespace pineda::kernels::test {
namespace {

using Words = std::vector<uint32_t>;
constexpr uint32_t kInvocations = 40;  // two full waves and a half
constexpr uint32_t kUnused = 0xdeadbeef;

struct Wave {
  std::array<uint32_t, kLanes> in{};  // value of each lane
  uint32_t active = 0;
  bool is_active(uint32_t l) const { return (active >> l & 1) != 0; }
  uint32_t first() const { return static_cast<uint32_t>(std::countr_zero(active)); }
};

// What a lane's result must be; none: undefined there.
using Expected = std::function<std::optional<uint32_t>(const Wave&, uint32_t lane)>;

struct Case {
  const char* expression;  // of `v`, an uint, and `f`, its float(v & 1023) / 8
  Expected expected;
};

void check(const std::vector<Case>& cases) {
  Words in(kInvocations);
  for (uint32_t i = 0; i < kInvocations; ++i) in[i] = i * 2654435761u >> 3;
  for (const char* condition : {"true", "(i * 7u) % 5u != 1u", "i == 21u || i == 5u || i == 38u"}) {
    ComputeRig rig{.buffers = {in, Words(kInvocations * cases.size(), kUnused)}, .target = "vulkan1.1"};
    std::string text = "#extension GL_KHR_shader_subgroup_basic : require\n";
    for (const char* part : {"vote", "ballot", "shuffle", "shuffle_relative", "arithmetic", "clustered", "quad"}) {
      text += std::string("#extension GL_KHR_shader_subgroup_") + part + " : require\n";
    }
    text += "layout(local_size_x = " + std::to_string(kInvocations) +
            ") in; layout(std430, binding = 0) buffer In { uint d[]; }; layout(std430, binding = 1) buffer Out { uint o[]; };\n"
            "void main() { uint i = gl_LocalInvocationIndex, l = gl_SubgroupInvocationID; uint v = d[i]; float f = float(v & "
            "1023u) / "
            "8.0; if (" +
            std::string(condition) + ") {\n";
    for (size_t c = 0; c < cases.size(); ++c) {
      text += "o[" + std::to_string(c * kInvocations) + "u + i] = " + cases[c].expression + ";\n";
    }
    ASSERT_EQ(rig.run(text + "} }"), "") << text;
    const auto is_on = [&](uint32_t i) {
      return condition[0] == 't' || (condition[0] == '(' ? i * 7 % 5 != 1 : i == 21 || i == 5 || i == 38);
    };
    for (uint32_t w = 0; w < kInvocations; w += kLanes) {
      Wave wave;
      for (uint32_t l = 0; l < kLanes && w + l < kInvocations; ++l) {
        wave.in[l] = in[w + l];
        wave.active |= static_cast<uint32_t>(is_on(w + l)) << l;
      }
      for (uint32_t l = 0; l < kLanes && w + l < kInvocations; ++l) {
        for (size_t c = 0; c < cases.size(); ++c) {
          const uint32_t got = rig.buffers[1][c * kInvocations + w + l];
          const auto want = wave.is_active(l) ? cases[c].expected(wave, l) : std::optional(kUnused);
          if (!want) continue;
          EXPECT_EQ(got, *want) << cases[c].expression << " if " << condition << ", invocation " << w + l;
        }
      }
    }
  }
}

uint32_t word_of(float f) { return std::bit_cast<uint32_t>(f); }
float float_of(uint32_t v) { return static_cast<float>(v & 1023) / 8; }

TEST(ComputeSubgroup, BasicAndVote) {
  check({
      {"gl_SubgroupSize", [](const Wave&, uint32_t) { return 16; }},
      {"gl_NumSubgroups * 100u + gl_SubgroupID - i / 16u", [](const Wave&, uint32_t) { return 300; }},
      {"gl_SubgroupInvocationID", [](const Wave&, uint32_t l) { return l; }},
      {"subgroupElect() ? 1u : 0u", [](const Wave& w, uint32_t l) { return l == w.first(); }},
      {"subgroupAll(i != 0u) ? 1u : 0u", [](const Wave& w, uint32_t) { return !(w.in[0] == 0 && w.is_active(0)); }},
      {"subgroupAny(l == 5u) ? 1u : 0u", [](const Wave& w, uint32_t) { return w.is_active(5); }},
      {"subgroupAllEqual(i / 16u) ? 1u : 0u", [](const Wave&, uint32_t) { return 1; }},
      {"subgroupAllEqual(vec2(f, 1.0)) ? 1u : 0u", [](const Wave& w, uint32_t) { return std::popcount(w.active) == 1; }},
  });
}

TEST(ComputeSubgroup, Ballot) {
  const auto odd = [](const Wave& w) {
    uint32_t out = 0;
    for (uint32_t l = 0; l < kLanes; ++l) out |= (w.is_active(l) ? w.in[l] & 1 : 0) << l;
    return out;
  };
  check({
      {"subgroupBallot((v & 1u) == 1u).x", [=](const Wave& w, uint32_t) { return odd(w); }},
      {"subgroupBallot(true).y", [](const Wave&, uint32_t) { return 0; }},
      {"subgroupInverseBallot(uvec4(0x5a3cu, 0, 0, 0)) ? 1u : 0u", [](const Wave&, uint32_t l) { return 0x5a3cu >> l & 1; }},
      {"subgroupBallotBitExtract(uvec4(0x5a3cu, 0, 0, 0), 15u - l) ? 1u : 0u",
       [](const Wave&, uint32_t l) { return 0x5a3cu >> (15 - l) & 1; }},
      {"subgroupBallotBitCount(uvec4(0xfff15a3cu, 7u, 7u, 7u))", [](const Wave&, uint32_t) { return 8; }},
      {"subgroupBallotInclusiveBitCount(uvec4(0x5a3cu, 0, 0, 0))",
       [](const Wave&, uint32_t l) { return std::popcount(0x5a3cu & ((2u << l) - 1)); }},
      {"subgroupBallotExclusiveBitCount(uvec4(0x5a3cu, 0, 0, 0))",
       [](const Wave&, uint32_t l) { return std::popcount(0x5a3cu & ((1u << l) - 1)); }},
      {"subgroupBallotFindLSB(uvec4(0xfff05a30u, 1, 1, 1))", [](const Wave&, uint32_t) { return 4; }},
      {"subgroupBallotFindMSB(uvec4(0xfff05a30u, 1, 1, 1))", [](const Wave&, uint32_t) { return 14; }},
      {"subgroupBroadcastFirst(v)", [](const Wave& w, uint32_t) { return w.in[w.first()]; }},
      {"subgroupBroadcast(v, 5u)",
       [](const Wave& w, uint32_t) { return w.is_active(5) ? std::optional(w.in[5]) : std::nullopt; }},
      {"gl_SubgroupEqMask.x", [](const Wave&, uint32_t l) { return 1u << l; }},
      {"gl_SubgroupGeMask.x | gl_SubgroupGeMask.y", [](const Wave&, uint32_t l) { return 0xffffu & (0xffffu << l); }},
      {"gl_SubgroupGtMask.x", [](const Wave&, uint32_t l) { return 0xffffu & (0xfffeu << l); }},
      {"gl_SubgroupLeMask.x", [](const Wave&, uint32_t l) { return (2u << l) - 1; }},
      {"gl_SubgroupLtMask.x", [](const Wave&, uint32_t l) { return (1u << l) - 1; }},
  });
}

TEST(ComputeSubgroup, ShuffleAndQuad) {
  const auto from = [](auto source) {
    return [source](const Wave& w, uint32_t l) -> std::optional<uint32_t> {
      const uint32_t s = source(w, l);
      if (s >= kLanes || !w.is_active(s)) return std::nullopt;
      return w.in[s];
    };
  };
  check({
      {"subgroupShuffle(v, (v >> 5) & 15u)", from([](const Wave& w, uint32_t l) { return w.in[l] >> 5 & 15; })},
      {"floatBitsToUint(subgroupShuffle(uintBitsToFloat(v), 15u - l))", from([](const Wave&, uint32_t l) { return 15 - l; })},
      {"subgroupShuffleXor(v, 6u)", from([](const Wave&, uint32_t l) { return l ^ 6; })},
      {"subgroupShuffleUp(v, 3u)", from([](const Wave&, uint32_t l) { return l - 3; })},
      {"subgroupShuffleDown(v, v & 3u)", from([](const Wave& w, uint32_t l) { return l + (w.in[l] & 3); })},
      {"subgroupShuffle(v > 5u, l) ? v : 0u", from([](const Wave&, uint32_t l) { return l; })},
      {"subgroupQuadBroadcast(v, 2u)", from([](const Wave&, uint32_t l) { return (l & ~3u) | 2; })},
      {"subgroupQuadSwapHorizontal(v)", from([](const Wave&, uint32_t l) { return l ^ 1; })},
      {"subgroupQuadSwapVertical(v)", from([](const Wave&, uint32_t l) { return l ^ 2; })},
      {"subgroupQuadSwapDiagonal(v)", from([](const Wave&, uint32_t l) { return l ^ 3; })},
      {"subgroupShuffle(uvec3(1u, v, 3u), l ^ 9u).y", from([](const Wave&, uint32_t l) { return l ^ 9; })},
  });
}

// Folds the active lanes of [begin, end) in any order: for operations that are associative.
template <class T, class Op>
T fold(const Wave& w, uint32_t begin, uint32_t end, T identity, Op op) {
  for (uint32_t l = begin; l < end; ++l) identity = w.is_active(l) ? op(identity, w.in[l]) : identity;
  return identity;
}

TEST(ComputeSubgroup, Arithmetic) {
  const auto add = [](uint32_t a, uint32_t b) { return a + b; };
  const auto minimum = [](uint32_t a, uint32_t b) { return std::min(a, b); };
  const auto smax = [](int32_t a, uint32_t b) { return std::max(a, static_cast<int32_t>(b * 77777)); };
  const auto bits = [](auto op) { return [op](uint32_t a, uint32_t b) { return static_cast<uint32_t>(op(a, b)); }; };
  const auto cluster = [](uint32_t l, uint32_t size) { return l & ~(size - 1); };
  check({
      {"subgroupAdd(v)", [=](const Wave& w, uint32_t) { return fold(w, 0, 16, 0u, add); }},
      {"subgroupInclusiveAdd(v)", [=](const Wave& w, uint32_t l) { return fold(w, 0, l + 1, 0u, add); }},
      {"subgroupExclusiveAdd(v)", [=](const Wave& w, uint32_t l) { return fold(w, 0, l, 0u, add); }},
      {"subgroupMul(v | 1u)",
       [=](const Wave& w, uint32_t) { return fold(w, 0, 16, 1u, [](uint32_t a, uint32_t b) { return a * (b | 1); }); }},
      {"subgroupMin(v)", [=](const Wave& w, uint32_t) { return fold(w, 0, 16, ~0u, minimum); }},
      {"subgroupExclusiveMin(v)", [=](const Wave& w, uint32_t l) { return fold(w, 0, l, ~0u, minimum); }},
      {"uint(subgroupMax(int(v * 77777u)))",
       [=](const Wave& w, uint32_t) { return static_cast<uint32_t>(fold(w, 0, 16, INT32_MIN, smax)); }},
      {"subgroupAnd(v)", [=](const Wave& w, uint32_t) { return fold(w, 0, 16, ~0u, bits(std::bit_and<>())); }},
      {"subgroupInclusiveOr(v)", [=](const Wave& w, uint32_t l) { return fold(w, 0, l + 1, 0u, bits(std::bit_or<>())); }},
      {"subgroupXor(v)", [=](const Wave& w, uint32_t) { return fold(w, 0, 16, 0u, bits(std::bit_xor<>())); }},
      {"subgroupXor((v & 4u) != 0u) ? 4u : 0u",
       [=](const Wave& w, uint32_t) { return fold(w, 0, 16, 0u, bits(std::bit_xor<>())) & 4; }},
      {"subgroupExclusiveAnd((v & 4u) != 0u) ? 4u : 0u",
       [=](const Wave& w, uint32_t l) { return fold(w, 0, l, ~0u, bits(std::bit_and<>())) & 4; }},
      {"subgroupClusteredAdd(v, 4u)",
       [=](const Wave& w, uint32_t l) { return fold(w, cluster(l, 4), cluster(l, 4) + 4, 0u, add); }},
      {"subgroupClusteredMin(v, 8u)",
       [=](const Wave& w, uint32_t l) { return fold(w, cluster(l, 8), cluster(l, 8) + 8, ~0u, minimum); }},
      {"subgroupClusteredXor(v, 1u)", [=](const Wave& w, uint32_t l) { return w.in[l]; }},
  });
}

// Multiples of 1/8 below 128: sums are exact in every order. What the order is: Eval.FloatReductionsHaveOneOrder.
TEST(ComputeSubgroup, FloatArithmetic) {
  const auto add = [](float a, uint32_t b) { return a + float_of(b); };
  const auto minimum = [](float a, uint32_t b) { return std::min(a, float_of(b)); };
  const auto maximum = [](float a, uint32_t b) { return std::max(a, float_of(b)); };
  check({
      {"floatBitsToUint(subgroupAdd(f))", [=](const Wave& w, uint32_t) { return word_of(fold(w, 0, 16, 0.0f, add)); }},
      {"floatBitsToUint(subgroupInclusiveAdd(f))",
       [=](const Wave& w, uint32_t l) { return word_of(fold(w, 0, l + 1, 0.0f, add)); }},
      {"floatBitsToUint(subgroupExclusiveAdd(f))", [=](const Wave& w, uint32_t l) { return word_of(fold(w, 0, l, 0.0f, add)); }},
      {"floatBitsToUint(subgroupMin(vec2(f, -f)).x)",
       [=](const Wave& w, uint32_t) { return word_of(fold(w, 0, 16, INFINITY, minimum)); }},
      {"floatBitsToUint(subgroupExclusiveMax(f))",
       [=](const Wave& w, uint32_t l) { return word_of(fold(w, 0, l, -INFINITY, maximum)); }},
      {"floatBitsToUint(subgroupMul((l & 1u) == 1u ? 2.0 : 1.0))",
       [=](const Wave& w, uint32_t) { return word_of(static_cast<float>(1 << std::popcount(w.active & 0xaaaa))); }},
      {"floatBitsToUint(subgroupClusteredMax(f, 2u))",
       [=](const Wave& w, uint32_t l) { return word_of(fold(w, l & ~1u, (l & ~1u) + 2, -INFINITY, maximum)); }},
  });
}

// A loop that lanes leave at different times: each turn sees those that are left.
TEST(ComputeSubgroup, DivergentLoop) {
  ComputeRig rig{.buffers = {Words(16)}, .target = "vulkan1.1"};
  ASSERT_EQ(rig.run(R"(#extension GL_KHR_shader_subgroup_arithmetic : require
    layout(local_size_x = 16) in; layout(std430, binding = 0) buffer Out { uint o[]; };
    void main() { uint l = gl_LocalInvocationIndex, sum = 0u; for (uint k = 0u; k <= l; ++k) sum += subgroupAdd(1u); o[l] = sum; })"),
            "");
  uint32_t sum = 0;
  for (uint32_t l = 0; l < 16; ++l) EXPECT_EQ(rig.buffers[0][l], sum += 16 - l);
}

}  // namespace
}  // namespace pineda::kernels::test
