// Workgroups of many waves: barriers in every place, shared memory, local sizes. Each shader runs in the evaluator and on every
// ISA and is compared with the answer worked out here.
#include <numeric>

#include "compiler/kernels/compute_rig.h"

namespace pineda::kernels::test {
namespace {

using Words = std::vector<uint32_t>;

std::string shader(const std::string& local_size, const std::string& globals, const std::string& body) {
  return "layout(" + local_size + ") in;\nlayout(std430, binding = 0) buffer Data { uint d[]; };\n" + globals +
         "\nvoid main() { uint i = gl_LocalInvocationIndex, g = gl_WorkGroupID.x, n = gl_WorkGroupSize.x * gl_WorkGroupSize.y * "
         "gl_WorkGroupSize.z;\n" +
         body + "\n}\n";
}

Words counted(size_t n) {
  Words out(n);
  for (size_t i = 0; i < n; ++i) out[i] = static_cast<uint32_t>(i * 2654435761u >> 7);
  return out;
}

// Reverses d within each workgroup.
void expect_reversal(const std::string& local_size, uint32_t invocations, bool optimize) {
  ComputeRig rig{.buffers = {counted(invocations * 2)}, .groups = {2, 1, 1}};
  rig.optimize = optimize;
  ASSERT_EQ(rig.run(shader(local_size, "shared uint s[" + std::to_string(invocations) + "];",
                           "s[i] = d[g * n + i]; barrier(); d[g * n + i] = s[n - 1u - i];")),
            "");
  const Words in = counted(invocations * 2);
  for (uint32_t g = 0; g < 2; ++g) {
    for (uint32_t i = 0; i < invocations; ++i) {
      ASSERT_EQ(rig.buffers[0][g * invocations + i], in[g * invocations + invocations - 1 - i]) << local_size << " " << i;
    }
  }
}

TEST(ComputeBarrier, WorkgroupsOfAllShapes) {
  for (const bool optimize : {false, true}) {
    expect_reversal("local_size_x = 1024", 1024, optimize);
    expect_reversal("local_size_x = 17", 17, optimize);
    expect_reversal("local_size_x = 8, local_size_y = 8, local_size_z = 16", 1024, optimize);
    expect_reversal("local_size_x = 3, local_size_y = 5, local_size_z = 7", 105, optimize);
  }
}

// gl_LocalInvocationID in all the forms that kernels/compute.cpp has, against its definition.
TEST(ComputeBarrier, LocalInvocationId) {
  constexpr std::array<uint32_t, 3> kSizes[] = {{16, 4, 2}, {32, 3, 1}, {48, 2, 2}, {8, 8, 1}, {4, 4, 4}, {2, 8, 3},
                                                {1, 16, 2}, {1, 1, 40}, {5, 3, 2},  {8, 3, 1}, {7, 1, 1}, {12, 4, 1}};
  for (const auto& [x, y, z] : kSizes) {
    ComputeRig rig{.buffers = {Words(x * y * z)}};
    const std::string size =
        "local_size_x = " + std::to_string(x) + ", local_size_y = " + std::to_string(y) + ", local_size_z = " + std::to_string(z);
    ASSERT_EQ(rig.run(shader(size, "", "uvec3 l = gl_LocalInvocationID; d[i] = l.x | l.y << 10 | l.z << 20;")), "");
    for (uint32_t i = 0; i < x * y * z; ++i) {
      ASSERT_EQ(rig.buffers[0][i], i % x | i / x % y << 10 | i / (x * y) << 20) << size << " " << i;
    }
  }
}

// A tree reduction: barriers in a loop whose count is the workgroup's, under a push constant.
TEST(ComputeBarrier, UniformLoop) {
  ComputeRig rig{.buffers = {counted(512)}, .groups = {2, 1, 1}, .push_constants = {128}};
  ASSERT_EQ(rig.run(shader("local_size_x = 256", "shared uint s[256]; layout(push_constant) uniform P { uint half_size; };",
                           R"(s[i] = d[g * n + i]; barrier();
    for (uint step = half_size; step > 0u; step >>= 1) { if (i < step) s[i] += s[i + step]; barrier(); }
    if (i == 0u) d[g * n] = s[0];)")),
            "");
  Words in = counted(512);
  for (uint32_t g = 0; g < 2; ++g) {
    EXPECT_EQ(rig.buffers[0][g * 256], std::accumulate(in.begin() + g * 256, in.begin() + g * 256 + 256, 0u));
  }
}

// Loop counters, conditions and carried values of every rate: a bound from memory (uniform, but only the invocations know), a
// barrier in a called function, in nested loops and Ifs, early exits with `break` and `continue`.
TEST(ComputeBarrier, NestedControlFlow) {
  Words data = counted(130);
  data[128] = 5;
  data[129] = 3;
  ComputeRig rig{.buffers = {data}};
  ASSERT_EQ(rig.run(shader("local_size_x = 128", R"(shared uint s[128]; shared uint rounds;
    uint rotate(uint i, uint by) { uint v = s[(i + by) % 128u]; barrier(); s[i] = v * 3u + by; memoryBarrierShared(); barrier(); return v; })",
                           R"(s[i] = d[i]; if (i == 7u) rounds = d[128]; barrier();
    uint sum = 0u; float f = float(i);
    for (uint k = 0u; k < rounds; ++k) {
      if (k == 3u) continue;
      if ((k & 1u) == 0u) { for (uint j = 0u; j < d[129]; ++j) { sum += rotate(i, k + j); if (j == k) break; f += 0.5; } }
      else { sum ^= rotate(i, 31u); }
    }
    d[i] = sum + uint(f);)")),
            "");
  Words s(data.begin(), data.begin() + 128), sum(128);
  std::vector<float> f(128);
  for (uint32_t i = 0; i < 128; ++i) f[i] = static_cast<float>(i);
  const auto rotate = [&](uint32_t by) {
    Words v(128);
    for (uint32_t i = 0; i < 128; ++i) v[i] = s[(i + by) % 128];
    for (uint32_t i = 0; i < 128; ++i) s[i] = v[i] * 3 + by;
    return v;
  };
  for (uint32_t k = 0; k < 5; ++k) {
    if (k == 3) continue;
    if ((k & 1) == 0) {
      for (uint32_t j = 0; j < 3; ++j) {
        const Words v = rotate(k + j);
        for (uint32_t i = 0; i < 128; ++i) sum[i] += v[i];
        if (j == k) break;
        for (float& x : f) x += 0.5f;
      }
    } else {
      const Words v = rotate(31);
      for (uint32_t i = 0; i < 128; ++i) sum[i] ^= v[i];
    }
  }
  for (uint32_t i = 0; i < 128; ++i) ASSERT_EQ(rig.buffers[0][i], sum[i] + static_cast<uint32_t>(f[i])) << i;
}

// Undefined by SPIR-V, defined by ir.h: ends, and the barrier still orders the waves.
TEST(ComputeBarrier, DivergentBarriersEnd) {
  ComputeRig rig{.buffers = {Words(100)}};
  ASSERT_EQ(rig.run(shader("local_size_x = 100", "shared uint s[100];", R"(if (i >= 90u) return;
    for (uint k = 0u; k < i % 7u; ++k) { s[i] = k + 1u; barrier(); if ((i & 1u) == 0u) { barrier(); s[i] += s[i] & 1u; } }
    d[i] = s[i];)")),
            "");
  for (uint32_t i = 0; i < 100; ++i) {
    const uint32_t turns = i % 7;
    EXPECT_EQ(rig.buffers[0][i], i >= 90 ? 0 : (i & 1) == 0 ? turns + (turns & 1) : turns) << i;
  }
}

// Values of every type live across a barrier, with arrays and structs in private and in shared memory.
TEST(ComputeBarrier, EverythingLivesOn) {
  ComputeRig rig{.buffers = {counted(64)}};
  const Words in = counted(64);
  ASSERT_EQ(rig.run(shader("local_size_x = 64", R"(struct A { vec3 p; uint k[2]; bool b; }; shared A s[64]; shared mat3 m;)",
                           R"(uint own[5]; for (uint k = 0u; k < 5u; ++k) own[k] = d[i] + k * i;
    bool odd = (d[i] & 1u) == 1u; float x = float(d[i] & 255u) * 0.25; A mine = A(vec3(x, -x, 2.0 * x), uint[2](i, d[i]), odd);
    s[63u - i] = mine; if (i < 3u) m[i] = vec3(i, i + 1u, i + 2u); barrier();
    A other = s[i]; uint r = own[d[i] % 5u] + other.k[1] + (odd ? 1u : 0u) + (other.b ? 2u : 0u);
    d[i] = r + uint(other.p.z) + uint(m[i % 3u].y);)")),
            "");
  for (uint32_t i = 0; i < 64; ++i) {
    const uint32_t other = in[63 - i];
    const uint32_t want = in[i] + in[i] % 5 * i + other + (in[i] & 1) + 2 * (other & 1) +
                          static_cast<uint32_t>(2.0f * (static_cast<float>(other & 255) * 0.25f)) + i % 3 + 1;
    ASSERT_EQ(rig.buffers[0][i], want) << i;
  }
}

TEST(ComputeBarrier, SharedMemoryIsSafe) {
  ComputeRig rig{.buffers = {Words(64, 1)}};
  ASSERT_EQ(
      rig.run(shader("local_size_x = 64", "shared uint s[16]; shared uint guard[4];", R"(if (i < 4u) guard[i] = 7u; barrier();
    uint far = 0xfffffff0u + i * 3u; s[far & 0x3fffffffu] = 9u; atomicAdd(s[far], 1u); barrier();
    d[i] = s[i + 4000u] + guard[i & 3u] * 10u + atomicOr(s[0x10000000u + i], 5u);)")),
      "");
  for (uint32_t v : rig.buffers[0]) EXPECT_EQ(v % 10, 0u);
}

// OpVariable ... Workgroup %null (VK_KHR_zero_initialize_workgroup_memory); all shared memory reads as zero at first.
TEST(ComputeBarrier, SharedMemoryStartsAtZero) {
  ComputeRig rig{.buffers = {Words(64, 1)}, .groups = {2, 1, 1}};
  ASSERT_EQ(rig.run("#extension GL_EXT_null_initializer : require\n" +
                    shader("local_size_x = 32", "struct A { uint x[3]; vec2 y; }; shared A a = {}; shared uint plain;",
                           "d[g * 32u + i] = a.x[i % 3u] + uint(a.y.x) + plain; barrier(); a.x[i % 3u] = 5u; plain = 3u;")),
            "");
  EXPECT_EQ(rig.buffers[0], Words(64, 0));
}

}  // namespace
}  // namespace pineda::kernels::test
