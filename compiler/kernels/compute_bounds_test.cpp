// Indices of every size against buffers: whatever an index is, the access goes where the exact product tells, or nowhere. In 32
// bits an index beyond 2^30 would come back into an array of words.
#include <random>

#include "compiler/kernels/compute_rig.h"

namespace pineda::kernels::test {
namespace {

using Words = std::vector<uint32_t>;

constexpr uint32_t kCount = 256;  // invocations
constexpr uint32_t kSeed = 91;

// Indices near everything that could wrap.
Words indices(uint32_t elements) {
  std::mt19937 random(kSeed);
  const uint32_t places[] = {0,          elements,   0x10000000, 0x15555555, 0x20000000, 0x3fffffff,
                             0x40000000, 0x7fffffff, 0x80000000, 0xc0000000, 0xfffffff0, 0xffffffff};
  Words out(kCount);
  for (uint32_t& index : out) {
    index = random() % 2 ? random() % (elements + 2) : places[random() % std::size(places)] + random() % 17 - 8;
  }
  return out;
}

Words data(uint32_t words) {
  Words out(words);
  for (uint32_t i = 0; i < words; ++i) out[i] = i * 2654435761u | 1;
  return out;
}

uint32_t read(const Words& memory, uint64_t offset_bytes) {
  return offset_bytes + 4 <= memory.size() * 4 ? memory[offset_bytes / 4] : 0;
}

constexpr const char* kHead =
    "layout(local_size_x = 64) in; layout(binding = 1) buffer Index { uint at[]; }; layout(binding = 2) "
    "buffer Out { uint r[]; }; layout(push_constant) uniform P { uint base; };\n";

// One array behind a header, by indices from memory.
TEST(ComputeBounds, GatheredIndicesDoNotComeBack) {
  const Words memory = data(40), at = indices(38);
  ComputeRig rig{.buffers = {memory, at, Words(kCount)}, .groups = {4, 1, 1}};
  ASSERT_EQ(rig.run(std::string(kHead) + "layout(binding = 0) buffer Data { uint head[2]; uint d[]; }; void main() { uint i = "
                                         "gl_GlobalInvocationID.x; r[i] = d[at[i]]; }"),
            "");
  for (uint32_t i = 0; i < kCount; ++i) EXPECT_EQ(rig.buffers[2][i], read(memory, 8 + uint64_t{at[i]} * 4)) << at[i];
}

// Consecutive indices, whose accesses become vectors: the start is anywhere, so waves straddle every border.
TEST(ComputeBounds, ConsecutiveIndicesDoNotComeBack) {
  for (const uint32_t base :
       {0u, 30u, 0x3ffffff8u, 0x40000000u, 0x7ffffff9u, 0xc0000003u, 0xfffffff8u, 0xffffffc0u, 0x3fffffd0u}) {
    const Words memory = data(80);
    ComputeRig rig{.buffers = {memory, Words(1), Words(kCount)}, .groups = {4, 1, 1}, .push_constants = {base}};
    ASSERT_EQ(rig.run(std::string(kHead) + "layout(binding = 0) buffer Data { uint head[2]; uint d[]; }; void main() { uint i = "
                                           "gl_GlobalInvocationID.x; r[i] = d[base + i]; if (i % 3u != 0u) d[base + i] = i; }"),
              "");
    Words after = memory;
    for (uint32_t i = 0; i < kCount; ++i) {
      const uint64_t offset = 8 + uint64_t{base + i} * 4;
      EXPECT_EQ(rig.buffers[2][i], read(memory, offset)) << base << ' ' << i;
      if (i % 3 != 0 && offset + 4 <= after.size() * 4) after[offset / 4] = i;
    }
    EXPECT_EQ(rig.buffers[0], after) << base;
  }
}

// Structures, vectors and nested arrays: several strides, whose sum may wrap too.
TEST(ComputeBounds, NestedArraysDoNotComeBack) {
  const Words memory = data(300), at = indices(19);
  ComputeRig rig{.buffers = {memory, at, Words(4 * kCount)}, .groups = {4, 1, 1}};
  ASSERT_EQ(rig.run(std::string(kHead) + R"(struct S { uint m[3][5]; }; layout(binding = 0) buffer Data { uint head[2]; S s[]; };
    void main() { uint i = gl_GlobalInvocationID.x, a = at[i], b = at[(i + 7u) % 256u], c = at[(i + 31u) % 256u];
      r[4u * i] = s[a].m[1][2]; r[4u * i + 1u] = s[a % 5u].m[b][c]; r[4u * i + 2u] = s[a].m[b % 3u][c]; r[4u * i + 3u] = s[a].m[b][c]; })"),
            "");
  for (uint32_t i = 0; i < kCount; ++i) {
    const uint64_t a = at[i], b = at[(i + 7) % kCount], c = at[(i + 31) % kCount];
    const uint64_t offsets[] = {8 + a * 60 + 28, 8 + a % 5 * 60 + b * 20 + c * 4, 8 + a * 60 + b % 3 * 20 + c * 4,
                                8 + a * 60 + b * 20 + c * 4};
    for (uint32_t k = 0; k < 4; ++k) EXPECT_EQ(rig.buffers[2][4 * i + k], read(memory, offsets[k])) << a << ' ' << b << ' ' << c;
  }
}

// Workgroup memory, and atomics on buffers.
TEST(ComputeBounds, SharedMemoryAndAtomicsDoNotComeBack) {
  const Words at = indices(64);
  ComputeRig rig{.buffers = {Words(64), at, Words(kCount)}, .groups = {4, 1, 1}};
  ASSERT_EQ(rig.run(std::string(kHead) + R"(layout(binding = 0) buffer Data { uint d[]; }; shared uint s[64];
    void main() { uint i = gl_GlobalInvocationID.x; s[gl_LocalInvocationIndex] = i + 1u; barrier(); r[i] = s[at[i]]; atomicAdd(d[at[i]], 1u); })"),
            "");
  Words count(64);
  for (uint32_t i = 0; i < kCount; ++i) {
    EXPECT_EQ(rig.buffers[2][i], at[i] < 64 ? i / 64 * 64 + at[i] + 1 : 0);
    if (at[i] < 64) ++count[at[i]];
  }
  EXPECT_EQ(rig.buffers[0], count);
}

}  // namespace
}  // namespace pineda::kernels::test
