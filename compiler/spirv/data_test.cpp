// Composites, matrices, variables, buffer layouts, functions on vectors, specialization, atomics, shared memory.
#include <algorithm>
#include <cmath>
#include <random>

#include "compiler/spirv/test_shaders.h"

namespace pineda::spirv::test {
namespace {

using Vec = std::array<double, 4>;
using Mat = std::array<Vec, 4>;  // [column][row]

Words floats(std::initializer_list<float> values) {
  Words out;
  for (float v : values) out.push_back(word(v));
  return out;
}

void expect_near(const Words& out, size_t at, std::span<const double> want, double bound, const char* what) {
  for (size_t i = 0; i < want.size(); ++i) EXPECT_NEAR(real(out[at + i]), want[i], bound) << what << " component " << i;
}

TEST(SpirvData, MatrixAlgebra) {
  // Small integers: every product and sum is exact.
  const std::string body = R"(if (lane != 0u) return;
    mat4 a = mat4(d[0], d[1], d[2], d[3], 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 17); mat4 b = transpose(a) * 2.0; vec4 v = vec4(1, -2, 3, d[3]);
    vec4 r = a * v; for (int i = 0; i < 4; ++i) d[i] = r[i];
    r = v * a; for (int i = 0; i < 4; ++i) d[4 + i] = r[i];
    mat4 m = a * b; for (int i = 0; i < 16; ++i) d[8 + i] = m[i / 4][i % 4];
    mat3x2 o = outerProduct(v.xy, v.yzw); for (int i = 0; i < 6; ++i) d[24 + i] = o[i / 2][i % 2];
    d[30] = dot(v, v); d[31] = determinant(a); d[32] = determinant(mat2(a)); d[33] = determinant(mat3(a));)";
  Words data = floats({1, 2, 3, 4});
  data.resize(64);
  const Words out = compute(body, data, "float");
  Mat a{{{1, 2, 3, 4}, {5, 6, 7, 8}, {9, 10, 11, 12}, {13, 14, 15, 17}}};
  const Vec v{1, -2, 3, 4};
  Vec av{}, va{};
  for (int c = 0; c < 4; ++c) {
    for (int r = 0; r < 4; ++r) {
      av[r] += a[c][r] * v[c];
      va[c] += v[r] * a[c][r];
    }
  }
  expect_near(out, 0, av, 0, "M * v");
  expect_near(out, 4, va, 0, "v * M");
  std::array<double, 16> product{};
  for (int c = 0; c < 4; ++c) {
    for (int r = 0; r < 4; ++r) {
      for (int k = 0; k < 4; ++k) product[4 * c + r] += a[k][r] * 2 * a[k][c];
    }
  }
  expect_near(out, 8, product, 0, "M * 2 M^T");
  expect_near(out, 24, std::array<double, 6>{-2, 4, 3, -6, 4, -8}, 0, "outer product");
  expect_near(out, 30, std::array<double, 4>{30, 0, -4, 0}, 0, "dot, determinants");
}

TEST(SpirvData, InverseTimesMatrixIsOne) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> value(-1, 1);
  for (int n : {2, 3, 4}) {
    Words data(16);
    for (int i = 0; i < 16; ++i) data[i] = word(value(random) + (i % (n + 1) == 0 ? 3.0f : 0.0f));  // diagonally dominant
    const std::string type = "mat" + std::to_string(n), size = std::to_string(n);
    const Words out =
        compute("if (lane != 0u) return; " + type + " m; for (int i = 0; i < " + size + " * " + size + "; ++i) m[i / " + size +
                    "][i % " + size + "] = d[i]; m = inverse(m) * m; for (int i = 0; i < " + size + " * " + size +
                    "; ++i) d[i] = m[i / " + size + "][i % " + size + "];",
                data, "float");
    for (int i = 0; i < n * n; ++i) {  // some 30 roundings of numbers below 100 against a determinant above 10
      EXPECT_NEAR(real(out[i]), i % (n + 1) == 0 ? 1.0 : 0.0, 1e-5) << "mat" << n << " element " << i;
    }
  }
}

TEST(SpirvData, VectorGeometry) {
  const std::string body = R"(if (lane != 0u) return; vec3 a = vec3(d[0], d[1], d[2]), b = vec3(d[3], d[4], d[5]), r;
    d[6] = length(a); d[7] = distance(a, b); r = cross(a, b); d[8] = r.x; d[9] = r.y; d[10] = r.z;
    r = normalize(a); d[11] = r.x; d[12] = r.y; d[13] = r.z; r = reflect(a, r); d[14] = r.x; d[15] = r.y; d[16] = r.z;
    r = refract(normalize(a), normalize(b), 0.7); d[17] = r.x; d[18] = r.y; d[19] = r.z;
    r = faceforward(a, b, a); d[20] = r.x; d[21] = r.y; d[22] = r.z; r = refract(normalize(a), normalize(b), 3.0); d[23] = r.x;)";
  Words data = floats({1, 2, -2, 0.5f, -1, 4});
  data.resize(32);
  const Words out = compute(body, data, "float");
  const double a[3] = {1, 2, -2}, b[3] = {0.5, -1, 4};
  const double bl = std::sqrt(17.25), dot = -9.5;
  EXPECT_EQ(real(out[6]), 3.0f);
  expect_near(out, 7, std::array{std::sqrt(0.25 + 9 + 36)}, 1e-6, "distance");
  expect_near(out, 8, std::array<double, 3>{6, -5, -2}, 0, "cross");
  expect_near(out, 11, std::array<double, 3>{1. / 3, 2. / 3, -2. / 3}, 1e-7, "normalize");
  expect_near(out, 14, std::array<double, 3>{-1, -2, 2}, 2e-6, "reflect");
  const double d = dot / (3 * bl), k = 1 - 0.49 * (1 - d * d);
  std::array<double, 3> refracted;
  for (int i = 0; i < 3; ++i) refracted[i] = 0.7 * a[i] / 3 - (0.7 * d + std::sqrt(k)) * b[i] / bl;
  expect_near(out, 17, refracted, 1e-6, "refract");
  expect_near(out, 20, std::array<double, 3>{1, 2, -2}, 0, "faceforward");  // dot(a, b) < 0
  EXPECT_EQ(real(out[23]), 0.0f) << "total reflection";
}

TEST(SpirvData, Packing) {
  const std::string body = R"(if (lane != 0u) return; vec4 v = vec4(0.5, -0.25, 1.5, -2.0); vec2 h = vec2(1.5, -65504.0);
    d[0] = packUnorm4x8(v); d[1] = packSnorm4x8(v); d[2] = packUnorm2x16(v.xz); d[3] = packSnorm2x16(v.yw); d[4] = packHalf2x16(h);
    vec4 w = unpackUnorm4x8(0x804000ffu); d[5] = floatBitsToUint(w.x); d[6] = floatBitsToUint(w.w);
    w = unpackSnorm4x8(0x80ff7f01u); d[7] = floatBitsToUint(w.y); d[8] = floatBitsToUint(w.w); d[9] = floatBitsToUint(w.z);
    w.xy = unpackHalf2x16(0x03ffbc00u); d[10] = floatBitsToUint(w.x); d[11] = floatBitsToUint(w.y);
    w.xy = unpackSnorm2x16(0x80004000u); d[12] = floatBitsToUint(w.x); d[13] = floatBitsToUint(w.y);
    w.xy = unpackUnorm2x16(0xffff8000u); d[14] = floatBitsToUint(w.x); d[15] = floatBitsToUint(w.y);)";
  const Words out = compute(body, Words(16));
  EXPECT_EQ(out[0], 0x00ff0080u);  // 127.5 rounds to even: 128
  EXPECT_EQ(out[1], 0x817fe040u);  // 63.5 -> 64, -31.75 -> -32 = 0xe0, 127, -127
  EXPECT_EQ(out[2], 0xffff8000u);
  EXPECT_EQ(out[3], 0x8001e000u);  // -8191.75 -> -8192
  EXPECT_EQ(out[4], 0xfbff3e00u);
  EXPECT_EQ(real(out[5]), 1.0f);
  EXPECT_EQ(real(out[6]), 128.0f / 255);
  EXPECT_EQ(real(out[7]), 1.0f);
  EXPECT_EQ(real(out[8]), -1.0f) << "-128 clamps";
  EXPECT_EQ(real(out[9]), -1.0f / 127);
  EXPECT_EQ(real(out[10]), -1.0f);
  EXPECT_EQ(real(out[11]), 1023 * 0x1p-24f) << "denormal half";
  EXPECT_EQ(real(out[12]), 16384.0f / 32767);
  EXPECT_EQ(real(out[13]), -1.0f);
  EXPECT_EQ(real(out[14]), 32768.0f / 65535);
  EXPECT_EQ(real(out[15]), 1.0f);
}

TEST(SpirvData, CompositesAndDynamicIndices) {
  const std::string globals =
      R"(struct Inner { vec2 p; float q[3]; bool on; }; struct Outer { Inner inner[2]; mat2x3 m; int tail; };
    Outer make(float base) { Outer o; for (int i = 0; i < 2; ++i) { o.inner[i].p = vec2(base + float(i), 2.0); o.inner[i].on = i == 1;
      for (int j = 0; j < 3; ++j) o.inner[i].q[j] = base * 10.0 + float(3 * i + j); } o.m = mat2x3(1, 2, 3, 4, 5, 6); o.tail = 9; return o; })";
  const std::string body = R"(Outer o = make(float(lane)); Outer copy = o; uint k = lane % 3u;
    copy.inner[lane & 1u].q[k] += 0.5; Inner moved = copy.inner[1]; copy.inner[1] = copy.inner[0]; copy.inner[0] = moved;
    vec3 v = vec3(1, 2, 3); v[k] = 7.0; v.zx = v.xz; float from_constant = float[](5.0, 6.0, 8.0)[k];
    d[lane] = copy.inner[(lane >> 1u) & 1u].q[k] + (copy.inner[lane & 1u].on ? 1000.0 : 0.0) + copy.m[lane & 1u][k] * 0.125 +
      float(copy.tail) * 10000.0 + v[k] * 1e5 + from_constant * 1e6 + float(copy == o) * 1e7;)";
  const Words out = compute(body, Words(16), "float", globals);
  for (uint32_t lane = 0; lane < 16; ++lane) {
    const uint32_t k = lane % 3;
    double q[2][3];
    for (int i = 0; i < 2; ++i) {
      for (int j = 0; j < 3; ++j) q[i][j] = lane * 10.0 + 3 * i + j;
    }
    q[lane & 1][k] += 0.5;
    const int source = 1 - (lane >> 1 & 1);  // swapped
    double v[3] = {1, 2, 3};
    v[k] = 7;
    std::swap(v[0], v[2]);
    const double m[6] = {1, 2, 3, 4, 5, 6}, table[3] = {5, 6, 8};
    const double want =
        q[source][k] + ((lane & 1) == 0 ? 1000 : 0) + m[3 * (lane & 1) + k] * 0.125 + 90000 + v[k] * 1e5 + table[k] * 1e6;
    EXPECT_NEAR(real(out[lane]), want, want * 0x1p-22) << "lane " << lane;  // four roundings of the largest sum
  }
}

TEST(SpirvData, UniformLayouts) {
  const std::string text = R"(layout(local_size_x = 1) in;
    struct S { vec3 a; float b; mat3x2 m; };
    layout(std140, set = 0, binding = 1) uniform U { float f; vec3 v; S s[2]; layout(row_major) mat4x3 r; layout(row_major) mat2 rs[2]; float t[3]; } u;
    layout(std430, set = 0, binding = 0) buffer D { float d[]; };
    layout(push_constant) uniform P { layout(offset = 16) vec2 p; int i; };
    void main() { int k = i; d[0] = u.f; d[1] = u.v.y; d[2] = u.s[k].a.z; d[3] = u.s[1].b; d[4] = u.s[k].m[2].y; d[5] = u.s[0].m[1][k];
      d[6] = u.r[3].z; d[7] = u.r[k][2]; d[8] = u.rs[k][1].x; d[9] = u.t[k + 1]; d[10] = p.y; mat2 whole = u.rs[1]; d[11] = whole[0][1];
      S s = u.s[1]; d[12] = s.m[0].x; vec3 column = u.r[k]; d[13] = column.y; d[14] = float(d.length()); d[15] = d[100]; d[1000000000] = 1.0; })";
  FakeStage stage;
  stage.buffers[0].words.resize(16);
  Words& u = stage.buffers[10].words;
  for (uint32_t i = 0; i < 80; ++i) u.push_back(word(float(i)));  // word i holds i
  Words& push = stage.buffers[9999].words;
  push = floats({0, 0, 0, 0, 40, 41});
  push.push_back(1);
  ASSERT_EQ(run(stage, VK_SHADER_STAGE_COMPUTE_BIT, glsl(VK_SHADER_STAGE_COMPUTE_BIT, text)), "");
  // std140, in words: f 0; v 4..6; s at 8, 16 words each (a 0..2, b 3, columns of m at 4, 8, 12); r at 40 (3 rows of 4); rs at 52
  // (2 x 2 rows of 4); t at 68, stride 4.
  const float want[16] = {0,          5,      8 + 16 + 2, 8 + 16 + 3, 8 + 16 + 12 + 1, 8 + 8 + 1,  40 + 8 + 3, 40 + 8 + 1,
                          52 + 8 + 1, 68 + 8, 41,         52 + 8 + 4, 8 + 16 + 4,      40 + 4 + 1, 16,         0};
  for (int i = 0; i < 16; ++i) EXPECT_EQ(real(stage.buffers[0].words[i]), want[i]) << "d[" << i << "]";
}

TEST(SpirvData, AccessesBeyondTheBufferDoNothing) {
  FakeStage stage;
  stage.input_value = [](uint32_t lane, const InterfaceScalar&) { return lane; };
  stage.buffers[0].words = Words(16, 5);
  stage.buffers[0].size_bytes = 38;  // nine words and a half
  ASSERT_EQ(run(stage, VK_SHADER_STAGE_COMPUTE_BIT, compute_words("d[lane] = d[lane + 4u] + 1u;")), "");
  for (uint32_t i = 0; i < 16; ++i) EXPECT_EQ(stage.buffers[0].words[i], i < 5 ? 6u : i < 9 ? 1u : 5u) << i;
}

TEST(SpirvData, ArraysOfBuffers) {
  const std::string text = R"(layout(local_size_x = 16) in; layout(set = 0, binding = 1) uniform U { uint v; } u[3];
    layout(set = 0, binding = 0) buffer D { uint d[]; };
    void main() { uint i = gl_LocalInvocationIndex; d[i] = u[i].v + u[2].v * 100u; })";
  FakeStage stage;
  stage.input_value = [](uint32_t lane, const InterfaceScalar&) { return lane; };
  stage.buffers[0].words.resize(16);
  for (uint32_t i = 0; i < 3; ++i) stage.buffers[10 + i].words = {i + 1};
  ASSERT_EQ(run(stage, VK_SHADER_STAGE_COMPUTE_BIT, glsl(VK_SHADER_STAGE_COMPUTE_BIT, text)), "");
  for (uint32_t i = 0; i < 16; ++i) EXPECT_EQ(stage.buffers[0].words[i], 300 + std::min(i, 2u) + 1) << i;  // clamped to the array
}

TEST(SpirvData, AtomicsAndSharedMemory) {
  const std::string globals = "shared uint sum; shared uint slots[16]; shared bool flag;";
  const std::string body =
      R"(if (lane == 0u) { sum = 0u; flag = true; } barrier(); slots[15u - lane] = lane * lane; atomicAdd(sum, lane);
    memoryBarrierShared(); barrier(); uint old = atomicAdd(d[16], 2u); atomicMax(d[17], lane); atomicMin(d[18], lane + 3u); atomicOr(d[19], 1u << lane);
    atomicXor(d[20], lane); atomicAnd(d[21], ~(1u << lane)); if (lane == 5u) { d[24] = atomicExchange(d[22], 77u); d[25] = atomicCompSwap(d[23], 9u, 10u); }
    d[lane] = slots[lane] + sum * 1000u + (flag ? 1000000u : 0u); d[32u + lane] = old;)";
  Words data(48, 0);
  data[18] = 100, data[21] = ~0u, data[22] = 4, data[23] = 9;
  const Words out = compute(body, data, "uint", globals);
  std::vector<uint32_t> olds;
  for (uint32_t i = 0; i < 16; ++i) {
    EXPECT_EQ(out[i], (15 - i) * (15 - i) + 120 * 1000 + 1000000) << i;
    olds.push_back(out[32 + i]);
  }
  std::ranges::sort(olds);
  for (uint32_t i = 0; i < 16; ++i) EXPECT_EQ(olds[i], 2 * i) << "every invocation sees another old value";
  const uint32_t want[] = {32, 15, 3, 0xffff, 0, 0xffff0000, 77, 10, 4, 9};
  for (uint32_t i = 0; i < std::size(want); ++i) EXPECT_EQ(out[16 + i], want[i]) << "d[" << 16 + i << "]";
}

// ---- specialization ----

SpecializationConstant spec(uint32_t id, uint32_t value) {
  SpecializationConstant s{.id = id, .bytes = std::vector<uint8_t>(4)};
  std::memcpy(s.bytes.data(), &value, 4);
  return s;
}

TEST(SpirvData, Specialization) {
  const std::string text =
      R"(layout(local_size_x_id = 0, local_size_y = 2, local_size_z_id = 9) in; layout(constant_id = 1) const int n = 3;
    layout(constant_id = 2) const float f = 1.5; layout(constant_id = 3) const bool on = false; layout(constant_id = 4) const uint un = 5u;
    const int m = n * 2 - 7; const ivec2 pair = ivec2(n, m); const ivec2 swapped = pair.yx; const bool both = on && n > 2; const int chosen = both ? 10 : 20;
    const uint bits = (un << 3) ^ (un >> 1) | 1u; const int smod = -n % 4; const int neg = -n / 2;
    layout(set = 0, binding = 0) buffer D { float d[]; };
    void main() { float a[n + 1]; for (int i = 0; i <= n; ++i) a[i] = float(i * i); d[0] = a[n]; d[1] = float(m); d[2] = f; d[3] = float(swapped.x * 100 + swapped.y);
      d[4] = float(chosen); d[5] = float(bits); d[6] = float(gl_WorkGroupSize.x * 100u + gl_WorkGroupSize.y * 10u + gl_WorkGroupSize.z); d[7] = float(neg); })";
  const Words words = glsl(VK_SHADER_STAGE_COMPUTE_BIT, text);
  struct Case {
    int n;
    float f;
    bool on;
    uint32_t un, x;
  };
  for (const Case& c : {Case{3, 1.5f, false, 5, 1}, Case{8, -2.5f, true, 1000, 7}, Case{2, 0, true, 6, 4}}) {
    std::vector<SpecializationConstant> given;
    if (c.x != 1)
      given = {spec(0, c.x), spec(1, uint32_t(c.n)), spec(2, word(c.f)), spec(3, c.on ? 2 : 0), spec(4, c.un), spec(77, 1)};
    FakeStage stage;
    stage.buffers[0].words.resize(8);
    ModuleInfo found;
    ASSERT_EQ(run(stage, VK_SHADER_STAGE_COMPUTE_BIT, words, {.specialization = given}, &found), "");
    EXPECT_EQ(found.local_size, (std::array<uint32_t, 3>{c.x, 2, 1}));
    const int m = c.n * 2 - 7;
    const float want[] = {float(c.n * c.n),
                          float(m),
                          c.f,
                          float(m * 100 + c.n),
                          c.on && c.n > 2 ? 10.0f : 20.0f,
                          float((c.un << 3 ^ c.un >> 1) | 1),
                          float(c.x * 100 + 21),
                          float(-c.n / 2)};
    for (int i = 0; i < 8; ++i) EXPECT_EQ(real(stage.buffers[0].words[i]), want[i]) << "d[" << i << "] with n = " << c.n;
  }
}

TEST(SpirvData, SpecializationOfTheWrongSize) {
  const Words words =
      glsl(VK_SHADER_STAGE_COMPUTE_BIT,
           "layout(constant_id = 1) const int n = 3; layout(set = 0, binding = 0) buffer D { int d; }; void main() { d = n; }");
  const std::vector<SpecializationConstant> given{{.id = 1, .bytes = {1, 2}}};
  FakeStage stage;
  stage.buffers[0].words.resize(1);
  EXPECT_NE(run(stage, VK_SHADER_STAGE_COMPUTE_BIT, words, {.specialization = given}).find("SpecId 1"), std::string::npos);
}

TEST(SpirvData, SelectOfCompositesAndCopies) {  // SPIR-V 1.4: scalar condition on vectors, OpCopyLogical
  const Words words = glsl(VK_SHADER_STAGE_COMPUTE_BIT, R"(layout(local_size_x = 16) in; struct A { vec2 p; uint k; };
    layout(std140, set = 0, binding = 1) uniform U { A a; } u; layout(std430, set = 0, binding = 0) buffer D { A d[16]; };
    void main() { uint i = gl_LocalInvocationIndex; A local = u.a; vec2 q = i > 3u ? local.p : local.p.yx; d[i] = local; d[i].p = q; })",
                           "spirv1.4");
  FakeStage stage;
  stage.input_value = [](uint32_t lane, const InterfaceScalar&) { return lane; };
  stage.buffers[0].words.resize(64);
  stage.buffers[10].words = {1, 2, 3, 0};
  ASSERT_EQ(run(stage, VK_SHADER_STAGE_COMPUTE_BIT, words), "");
  for (uint32_t i = 0; i < 16; ++i) {
    EXPECT_EQ(stage.buffers[0].words[4 * i], i > 3 ? 1u : 2u);
    EXPECT_EQ(stage.buffers[0].words[4 * i + 2], 3u);
  }
}

}  // namespace
}  // namespace pineda::spirv::test
