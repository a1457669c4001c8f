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

// A vector access is taken when one comparison of its first index tells that all lanes are inside: every start around the one
// where that changes, behind headers of several sizes, and for buffers that end within an element.
TEST(ComputeBounds, EveryStartAroundTheLastWholeWave) {
  for (const uint32_t header : {0u, 1u, 3u}) {
    for (const uint32_t base : {0u, 13u, 14u, 15u, 16u, 17u, 18u, 19u, 20u, 0x3fffffefu, 0x3ffffff0u, 0x40000000u, 0xffffffedu}) {
      const Words memory = data(100);
      ComputeRig rig{.buffers = {memory, Words(1), Words(64)}, .push_constants = {base}};
      const std::string head = header == 0 ? "" : "uint head[" + std::to_string(header) + "];";
      ASSERT_EQ(
          rig.run(std::string(kHead) + "layout(binding = 0) buffer Data { " + head +
                  " uint d[]; }; void main() { uint i = gl_LocalInvocationID.x; r[i] = d[base + i + 16u]; d[base + i] = i; }"),
          "");
      Words after = memory;
      for (uint32_t i = 0; i < 64; ++i) {
        EXPECT_EQ(rig.buffers[2][i], read(memory, 4 * (header + uint64_t{base + i + 16}))) << header << ' ' << base << ' ' << i;
        const uint64_t word = header + uint64_t{base + i};
        if (word < after.size()) after[word] = i;
      }
      EXPECT_EQ(rig.buffers[0], after) << header << ' ' << base;
    }
  }
}

// Elements of other sizes than the word that offsets are counted in.
TEST(ComputeBounds, EveryStartOfDoubles) {
  for (const uint32_t base : {0u, 33u, 34u, 35u, 36u, 37u, 0x1fffffefu, 0x1ffffff0u, 0x20000000u, 0xfffffff8u}) {
    const Words memory = data(99);  // 49 doubles and a half
    ComputeRig rig{.buffers = {memory, Words(1), Words(32)}, .push_constants = {base}};
    ASSERT_EQ(rig.run(std::string(kHead) + "layout(binding = 0) buffer Data { double d[]; }; void main() { uint i = "
                                           "gl_LocalInvocationID.x; if (i < 16u) { uvec2 v = unpackDouble2x32(d[base + i]); "
                                           "r[2u * i] = v.x; r[2u * i + 1u] = v.y; } }"),
              "");
    for (uint32_t i = 0; i < 16; ++i) {
      const uint64_t offset = 8 * uint64_t{base + i};
      const bool inside = offset + 8 <= 4 * memory.size();
      EXPECT_EQ(rig.buffers[2][2 * i], inside ? memory[offset / 4] : 0) << base << ' ' << i;
      EXPECT_EQ(rig.buffers[2][2 * i + 1], inside ? memory[offset / 4 + 1] : 0) << base << ' ' << i;
    }
  }
}

// Rows that an index of the workgroup's chooses: the row's offset may wrap, and so may its sum with the column's.
TEST(ComputeBounds, RowsBeyondTheEnd) {
  for (const uint32_t base : {0u, 3u, 4u, 5u, 0x03333333u, 0x03333334u, 0x06666666u, 0x80000000u, 0xffffffffu}) {
    const Words memory = data(100);
    ComputeRig rig{.buffers = {memory, Words(1), Words(64)}, .push_constants = {base}};
    ASSERT_EQ(
        rig.run(std::string(kHead) + "layout(binding = 0) buffer Data { uint head[2]; uint m[][20]; }; void main() { uint i = "
                                     "gl_LocalInvocationID.x; r[i] = m[base][i]; if (i > 5u) m[base][i - 2u] = i; }"),
        "");
    Words after = memory;
    for (uint32_t i = 0; i < 64; ++i) {
      EXPECT_EQ(rig.buffers[2][i], read(memory, 8 + base * uint64_t{80} + 4 * i)) << base << ' ' << i;
      const uint64_t word = 2 + base * uint64_t{20} + i - 2;
      if (i > 5 && word < after.size()) after[word] = i;
    }
    EXPECT_EQ(rig.buffers[0], after) << base;
  }
}

// Workgroup memory, whose size is known: rows by an index of the workgroup's, and loops that stop at its end or behind it.
TEST(ComputeBounds, SharedRowsAndLoopsBeyondTheEnd) {
  for (const uint32_t base : {0u, 1u, 3u, 4u, 5u, 16u, 17u, 0x00ffffffu, 0x01000000u, 0x01000001u, 0xffffffffu}) {
    ComputeRig rig{.buffers = {Words(1), Words(1), Words(5 * 64)}, .push_constants = {base}};
    ASSERT_EQ(rig.run(std::string(kHead) + R"(shared uint s[4][64]; void main() { uint i = gl_LocalInvocationID.x;
      for (uint k = 0u; k < 4u; ++k) s[k][i] = k + 1u;
      barrier(); s[base][i] = 100u + i; barrier();
      for (uint k = 0u; k < 4u; ++k) r[k * 64u + i] = s[k][i];
      uint sum = 0u; for (uint k = 0u; k < min(base, 20u); ++k) sum += s[k][i] + s[k][k]; r[256u + i] = sum; })"),
              "");
    Words s(4 * 64);
    for (uint32_t w = 0; w < s.size(); ++w) s[w] = base == w / 64 ? 100 + w % 64 : w / 64 + 1;
    for (uint32_t i = 0; i < 64; ++i) {
      uint32_t sum = 0;
      for (uint32_t k = 0; k < std::min(base, 20u); ++k) sum += read(s, 4 * (64 * k + i)) + read(s, 4 * (64 * k + k));
      EXPECT_EQ(rig.buffers[2][256 + i], sum) << base << ' ' << i;
      for (uint32_t k = 0; k < 4; ++k) EXPECT_EQ(rig.buffers[2][k * 64 + i], s[k * 64 + i]) << base << ' ' << k << ' ' << i;
    }
  }
}

}  // namespace
}  // namespace pineda::kernels::test
