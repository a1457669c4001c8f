// Untrusted input: truncated and mutated modules must give an error or IR that verify() accepts.
#include <random>

#include "compiler/spirv/test_shaders.h"

namespace pineda::spirv::test {
namespace {

constexpr uint32_t kSeed = 77;

struct Shader {
  VkShaderStageFlagBits stage;
  const char* text;
};

const Shader kShaders[] = {
    {VK_SHADER_STAGE_VERTEX_BIT, R"(
layout(location = 0) in vec3 position; layout(location = 1) in vec2 uv; layout(location = 2) in uvec4 bones;
layout(std140, set = 0, binding = 0) uniform Camera { mat4 view; mat4 projection[2]; layout(row_major) mat3x4 normal; } camera;
layout(std430, set = 1, binding = 1) readonly buffer Bones { mat4 bone[]; };
layout(push_constant) uniform Push { vec4 tint; int which; } push;
layout(location = 0) out vec2 out_uv; layout(location = 1) out Block { vec4 tint; float fade[3]; } block;
void main() { mat4 skin = bone[bones.x] * 0.5 + bone[bones.y] * 0.5;
  gl_Position = camera.projection[push.which] * camera.view * skin * vec4(position, 1.0);
  out_uv = uv * mat2(1, 2, 3, 4); block.tint = push.tint; for (int i = 0; i < 3; ++i) block.fade[i] = float(i) * position.x; })"},
    {VK_SHADER_STAGE_FRAGMENT_BIT, R"(
layout(location = 0) in vec2 uv; layout(location = 1) flat in int kind; layout(location = 0) out vec4 color;
layout(set = 0, binding = 0) uniform sampler2D albedo; layout(set = 0, binding = 1) uniform texture2DArray layers;
layout(set = 0, binding = 2) uniform sampler smooth_; layout(set = 0, binding = 3) uniform samplerCubeShadow shadow;
vec4 pick(texture2DArray t, sampler s, vec3 at) { return texture(sampler2DArray(t, s), at); }
void main() { vec4 c = texture(albedo, uv); if (c.a < 0.5) discard;
  switch (kind) { case 0: c *= 2.0; break; case 1: c += pick(layers, smooth_, vec3(uv, 1)); default: c.x = dFdx(uv.x); }
  c.y += texture(shadow, vec4(uv, 1, 0.5)); c.z += float(textureSize(albedo, 0).x) + texelFetch(albedo, ivec2(1, 2), 0).x;
  color = c * gl_FragCoord; })"},
    {VK_SHADER_STAGE_COMPUTE_BIT, R"(
layout(local_size_x_id = 1, local_size_y = 2) in; layout(constant_id = 3) const int N = 4; const int M = N * 2 + 1;
layout(std430, set = 0, binding = 0) buffer Data { uint count; float values[]; } data; shared float tile[16];
void main() { uint i = gl_LocalInvocationIndex; float local[M]; for (int k = 0; k < M; ++k) local[k] = data.values[k] * float(N);
  tile[i & 15u] = local[i % uint(M)]; barrier(); atomicAdd(data.count, 1u); float sum = 0.0;
  for (uint k = 0u; k < 16u; ++k) { if (tile[k] < 0.0) continue; sum += tile[k]; if (sum > 100.0) break; }
  data.values[i] = sum + float(data.values.length()); })"},
    {VK_SHADER_STAGE_COMPUTE_BIT, R"(
layout(local_size_x = 8) in; layout(rgba8, set = 0, binding = 1) uniform image2D target;
layout(std430, set = 0, binding = 0) buffer Data { int values[]; };
int f(int n, inout int steps) { while (n != 1) { n = (n & 1) == 0 ? n >> 1 : 3 * n + 1; if (++steps > 99) return -1; } return steps; }
void main() { int steps = 0; int r = f(values[gl_GlobalInvocationID.x], steps); ivec2 at = ivec2(gl_GlobalInvocationID.xy);
  imageStore(target, at, imageLoad(target, at) + vec4(r)); values[gl_GlobalInvocationID.x] = steps; })"},
    {VK_SHADER_STAGE_FRAGMENT_BIT, R"(
layout(location = 0) in vec3 normal; layout(location = 3) centroid in mat3 basis; layout(location = 0) out vec4 color[2];
struct Light { vec3 direction; float power; }; layout(set = 0, binding = 0) uniform Lights { Light light[4]; int count; };
void main() { vec3 n = normalize(basis * normal); vec3 sum = vec3(0); int e; float m = frexp(n.x, e);
  for (int i = 0; i < count; ++i) { Light l = light[i]; sum += max(dot(n, l.direction), 0.0) * l.power * reflect(n, l.direction); }
  color[0] = vec4(sum, m); color[1] = inverse(mat4(basis)) * vec4(pow(n, vec3(2.2)), float(e)) + unpackUnorm4x8(packSnorm4x8(vec4(n, 1)));
  gl_FragDepth = smoothstep(0.0, 1.0, n.z); })"},
    {VK_SHADER_STAGE_VERTEX_BIT, R"(
layout(location = 0) out vec4 color; const vec2 kCorners[3] = vec2[](vec2(-1, -1), vec2(3, -1), vec2(-1, 3));
void main() { vec2 p = kCorners[gl_VertexIndex % 3]; bvec2 b = greaterThan(p, vec2(0)); uint u = floatBitsToUint(p.x);
  uint c; uint s = uaddCarry(u, 5u, c); gl_Position = vec4(mix(p, -p, b), bitfieldExtract(s, 3, 5), any(b) ? c : findMSB(u));
  color = vec4(isnan(p.x) ? 1.0 : fract(p.y)); })"},
};

// Whether the module was refused. What is accepted must translate into IR that verifies.
bool refused(const Words& words, VkShaderStageFlagBits stage) {
  const auto module = parse({.words = words, .entry_point = "main", .stage = stage});
  if (!module) {
    EXPECT_FALSE(module.error().text.empty());
    return true;
  }
  FakeStage fake;
  for (uint32_t key : {0u, 10u, 20u, 30u, 100u, 110u, 9000u, 90u, 9999u}) fake.buffers[key] = {};
  ir::Kernel kernel;
  kernel.kind = kind_of(stage);
  ir::Builder b(kernel);
  if (!translate(**module, b, fake)) return true;
  EXPECT_EQ(ir::verify(kernel), "");
  passes::optimize(kernel, passes::Form::kMachine);
  EXPECT_EQ(ir::verify(kernel), "");
  return false;
}

TEST(SpirvRobust, AcceptsTheShadersThemselves) {
  for (const Shader& s : kShaders) {
    const Words words = glsl(s.stage, s.text);
    const auto module = parse({.words = words, .entry_point = "main", .stage = s.stage});
    ASSERT_TRUE(module) << module.error().text << s.text;
    EXPECT_FALSE(refused(words, s.stage)) << s.text;
  }
}

TEST(SpirvRobust, EveryPrefix) {
  for (const Shader& s : kShaders) {
    const Words words = glsl(s.stage, s.text);
    for (size_t n = 0; n < words.size(); ++n) {
      EXPECT_TRUE(refused(Words(words.begin(), words.begin() + n), s.stage)) << "prefix of " << n << " words";
    }
  }
}

TEST(SpirvRobust, RandomMutations) {
  const char* rounds = getenv("PINEDA_FUZZ_ROUNDS");
  const uint32_t count = rounds ? static_cast<uint32_t>(atoi(rounds)) : 1000;
  std::mt19937 random(kSeed);
  uint32_t accepted = 0, total = 0;
  for (const Shader& s : kShaders) {
    const Words words = glsl(s.stage, s.text);
    for (uint32_t round = 0; round < count; ++round) {
      Words mutant = words;
      for (uint32_t edits = 1 + random() % 3; edits > 0; --edits) {
        uint32_t& word = mutant[random() % mutant.size()];
        switch (random() % 5) {
          case 0:
            word = random();
            break;
          case 1:
            word ^= 1u << random() % 32;
            break;
          case 2:
            word = random() % words[3];
            break;  // another id
          case 3:
            word = mutant[random() % mutant.size()];
            break;  // another word
          default:
            word += random() % 5 - 2;
            break;
        }
      }
      ++total;
      accepted += !refused(mutant, s.stage);
    }
  }
  EXPECT_GT(accepted, total / 50) << "seed " << kSeed << ": mutations that are always refused test nothing";
  EXPECT_LT(accepted, total);
}

}  // namespace
}  // namespace pineda::spirv::test
