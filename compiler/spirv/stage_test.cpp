// Vertex and fragment stages: interfaces, built-ins, discard, derivatives, guarded writes; what ModuleInfo says; what is refused.
#include <algorithm>
#include <cmath>

#include "compiler/spirv/test_shaders.h"

namespace pineda::spirv::test {
namespace {

constexpr auto kVertex = VK_SHADER_STAGE_VERTEX_BIT;
constexpr auto kFragment = VK_SHADER_STAGE_FRAGMENT_BIT;
constexpr auto kCompute = VK_SHADER_STAGE_COMPUTE_BIT;

std::string name(const InterfaceScalar& s) {
  std::string out = s.built_in ? "b" + std::to_string(static_cast<int>(*s.built_in)) : std::to_string(s.location);
  out += "." + std::to_string(s.component) + ir::type_name(s.type);
  if (s.index) out += "i";
  if (s.interpolation != Interpolation::kPerspective) out += s.interpolation == Interpolation::kFlat ? "F" : "N";
  if (s.at != InterpolationAt::kCenter) out += s.at == InterpolationAt::kCentroid ? "C" : "S";
  return out;
}
std::string names(const std::vector<InterfaceScalar>& list) {
  std::string out;
  for (const InterfaceScalar& s : list) out += (out.empty() ? "" : " ") + name(s);
  return out;
}

ModuleInfo info_of(VkShaderStageFlagBits stage, const std::string& text) {
  const Words words = glsl(stage, text);
  const auto module = parse({.words = words, .entry_point = "main", .stage = stage});
  if (!module) {
    ADD_FAILURE() << module.error().text;
    return {};
  }
  return info(**module);
}

std::string error_of(VkShaderStageFlagBits stage, const Words& words, const std::string& entry = "main") {
  const auto module = parse({.words = words, .entry_point = entry, .stage = stage});
  return module ? "" : module.error().text;
}

TEST(SpirvStage, VertexInterface) {
  const ModuleInfo i = info_of(
      kVertex,
      R"(layout(location = 2) in mat2x3 m; layout(location = 0, component = 1) in vec2 uv; layout(location = 5) in uint unused;
    layout(location = 6) in ivec2 k; layout(location = 1) out Block { vec2 a; float b[2]; } block; layout(location = 5) flat out uint id; layout(location = 7) out float never;
    void main() { gl_Position = vec4(m[1], uv.x + float(k.y)); block.a = uv; id = gl_VertexIndex; })");
  EXPECT_EQ(names(i.inputs), "b2.0i32 0.1f32 0.2f32 2.0f32 2.1f32 2.2f32 3.0f32 3.1f32 3.2f32 6.0i32F 6.1i32F");
  EXPECT_EQ(names(i.outputs), "b0.0f32 b0.1f32 b0.2f32 b0.3f32 1.0f32 1.1f32 2.0f32 3.0f32 5.0i32F 7.0f32");
  EXPECT_FALSE(i.uses_discard || i.writes_memory || i.uses_derivatives || i.uses_barriers);
}

TEST(SpirvStage, FragmentInterface) {
  const ModuleInfo i = info_of(
      kFragment,
      R"(layout(location = 0) in vec2 a; layout(location = 1) flat in int b; layout(location = 2) noperspective in float c;
    layout(location = 3) centroid in float d; layout(location = 4) sample in float e; layout(early_fragment_tests) in;
    layout(location = 0, index = 0) out vec4 color; layout(location = 0, index = 1) out vec4 second;
    void main() { color = vec4(a, b, c); second = vec4(d + e + gl_FragCoord.x); gl_FragDepth = 0.5; if (!gl_FrontFacing) discard; })");
  EXPECT_EQ(names(i.inputs), "b7.0f32 b7.1f32 b7.2f32 b7.3f32 b8.0b1 0.0f32 0.1f32 1.0i32F 2.0f32N 3.0f32C 4.0f32S");
  EXPECT_EQ(names(i.outputs), "b16.0f32 0.0f32 0.1f32 0.2f32 0.3f32 0.0f32i 0.1f32i 0.2f32i 0.3f32i");
  EXPECT_TRUE(i.uses_discard && i.early_fragment_tests && i.writes_depth);
}

TEST(SpirvStage, ComputeInfo) {
  const ModuleInfo i = info_of(
      kCompute,
      R"(layout(local_size_x = 4, local_size_y = 3, local_size_z = 1) in; shared vec3 a[5]; shared bool unused; shared int b;
    layout(set = 0, binding = 0) buffer D { uint d; }; layout(r32ui, set = 2, binding = 3) uniform uimage2D image[4];
    void f(int k) { barrier(); imageStore(image[2], ivec2(k), uvec4(1)); } void main() { a[gl_LocalInvocationID.x] = vec3(gl_WorkGroupID); b = int(d); f(b); })");
  EXPECT_EQ(i.local_size, (std::array<uint32_t, 3>{4, 3, 1}));
  EXPECT_EQ(i.shared_memory_bytes, 64u);
  EXPECT_TRUE(i.writes_memory && i.uses_barriers);
  ASSERT_EQ(i.images.size(), 1u);
  EXPECT_EQ(i.images[0].image, (ImageRef{2, 3, 2}));
  EXPECT_FALSE(i.images[0].sampled);
}

TEST(SpirvStage, VertexShaderComputesItsOutputs) {
  const Words words = glsl(
      kVertex,
      R"(layout(location = 0) in vec3 p; layout(location = 1) in uvec2 k; layout(location = 0) out vec4 c[2]; layout(location = 2) flat out ivec2 n;
    layout(location = 3) out float never; void set(out vec4 v, float x) { v = vec4(x, 1, 2, 3); }
    void main() { gl_Position = vec4(p * 2.0, 1); set(c[1], p.y); c[0].y = float(k.x); n = ivec2(gl_InstanceIndex, int(k.y) - 5); })");
  FakeStage stage;
  stage.input_value = [](uint32_t lane, const InterfaceScalar& s) {
    if (s.built_in) return 100 + lane;
    return s.location == 0 ? word(float(lane) + 0.25f * s.component) : 2 * lane + s.component;
  };
  ASSERT_EQ(run(stage, kVertex, words), "");
  ASSERT_EQ(stage.outputs.size(), 4 + 8 + 2 + 1u);
  for (uint32_t lane = 0; lane < 16; ++lane) {
    EXPECT_EQ(real(stage.at(1, 0)[lane]), lane + 0.25f);
    EXPECT_EQ(real(stage.at(1, 3)[lane]), 3.0f);
    EXPECT_EQ(real(stage.at(0, 1)[lane]), 2.0f * lane);
    EXPECT_EQ(stage.at(0, 0)[lane], 0u) << "never written";
    EXPECT_EQ(stage.at(2, 0)[lane], 100 + lane);
    EXPECT_EQ(stage.at(2, 1)[lane], 2 * lane + 1 - 5);
    EXPECT_EQ(stage.at(3)[lane], 0u);
    for (const FakeStage::Output& o : stage.outputs) {
      if (o.scalar.built_in == BuiltIn::kPosition) {
        EXPECT_EQ(real(o.value[lane]), o.scalar.component == 3 ? 1.0f : 2 * (lane + 0.25f * o.scalar.component));
      }
    }
  }
}

// ---- discard ----

FakeStage run_fragment(const std::string& text, uint32_t coverage = 0xffff, const std::string& extensions = "") {
  FakeStage stage;
  stage.coverage = coverage;
  stage.input_value = [](uint32_t lane, const InterfaceScalar& s) {
    if (s.built_in == BuiltIn::kHelperInvocation) return 0u;
    return s.type == ir::Type::kF32 ? word(float(lane)) : lane;
  };
  stage.buffers[0].words.resize(32);
  EXPECT_EQ(
      run(stage, kFragment,
          glsl(kFragment,
               extensions +
                   "layout(location = 0) in float f; layout(location = 1) flat in uint lane; layout(location = 0) out float r;\n"
                   "layout(set = 0, binding = 0) buffer D { uint d[]; };\n" +
                   text)),
      "");
  return stage;
}

TEST(SpirvStage, DiscardInBranches) {
  const FakeStage s =
      run_fragment("void main() { r = f; if (lane > 3u) { if (lane < 6u) discard; r += 100.0; } d[lane] = 1u; r += 0.5; }");
  EXPECT_EQ(s.discarded, 0x0030u);
  for (uint32_t lane = 0; lane < 16; ++lane) {
    if (lane == 4 || lane == 5) continue;
    EXPECT_EQ(real(s.at(0)[lane]), lane + 0.5f + (lane > 3 ? 100 : 0)) << lane;
  }
  for (uint32_t lane = 0; lane < 16; ++lane) {
    EXPECT_EQ(s.buffers.at(0).words[lane], lane == 4 || lane == 5 ? 0u : 1u) << lane;
  }
}

TEST(SpirvStage, DiscardInLoopsAndFunctions) {
  const FakeStage s = run_fragment(
      R"(uint f2(uint x) { for (uint i = 0u; i < 100u; ++i) { if (i == x) discard; if (i * i > 30u) return i; } return 7u; }
    void main() { uint v = lane < 4u ? f2(lane * 3u) : f2(50u + lane); d[lane] = v; r = float(v); })");
  EXPECT_EQ(s.discarded, 0x0007u);  // x = 0, 3 and 6; x = 9 returns first
  for (uint32_t lane = 0; lane < 16; ++lane) EXPECT_EQ(s.buffers.at(0).words[lane], lane < 3 ? 0u : 6u) << lane;
}

TEST(SpirvStage, DiscardedLanesLeaveEveryLoop) {  // the loop ends only for lanes that were not discarded
  const FakeStage s =
      run_fragment("void main() { if (lane == 2u) discard; float t = 0.0; while (t < 8.0) t += lane == 2u ? 0.0 : 1.0; r = t; }");
  EXPECT_EQ(s.discarded, 0x0004u);
  EXPECT_EQ(real(s.at(0)[3]), 8.0f);
}

TEST(SpirvStage, DiscardedLanesStayWithTheirQuadInLoops) {
  const FakeStage s =
      run_fragment(R"(layout(location = 2) in float g; void main() { if ((lane & 3u) == 3u) discard; float sum = 0.0;
    for (uint i = 0u; i < 3u + (lane >> 2u); ++i) sum += dFdxFine(g * float(i)) + 100.0 * dFdyFine(g * float(i)); r = sum; })");
  EXPECT_EQ(s.discarded, 0x8888u);
  for (uint32_t lane = 0; lane < 16; ++lane) {
    if ((lane & 3) == 3) continue;
    const uint32_t n = 3 + (lane >> 2);
    EXPECT_EQ(real(s.at(0)[lane]), 201.0f * n * (n - 1) / 2) << "lane " << lane;  // lane 1 and 2 read lane 3
  }
}

TEST(SpirvStage, HelpersWriteNothingButFeedDerivatives) {
  const FakeStage s = run_fragment(
      "void main() { uint old = atomicAdd(d[16], 1u); d[lane] = 5u; r = dFdx(f) + 100.0 * dFdy(f) + float(old) * 0.0; }", 0x00f1);
  for (uint32_t lane = 0; lane < 16; ++lane) {
    EXPECT_EQ(s.buffers.at(0).words[lane], 0x00f1u >> lane & 1 ? 5u : 0u) << lane;
    EXPECT_EQ(real(s.at(0)[lane]), 201.0f) << "lanes of a quad are 0 1 / 2 3";
  }
  EXPECT_EQ(s.buffers.at(0).words[16], 5u) << "five covered lanes";
}

TEST(SpirvStage, Derivatives) {
  const FakeStage s = run_fragment(R"(void main() { float q = f * f; vec2 v = vec2(q, -q);
    r = dFdxFine(q) + dFdxCoarse(q) * 1000.0 + dFdyFine(v).y * 1e-3 + fwidthCoarse(q) * 1e6; })");
  for (uint32_t lane = 0; lane < 16; ++lane) {
    const uint32_t q = lane & ~3u;
    const auto sq = [](uint32_t i) { return double(i) * i; };
    const double fine_x = sq((lane | 1)) - sq(lane & ~1u), coarse_x = sq(q + 1) - sq(q), fine_y = sq(lane | 2) - sq(lane & ~2u);
    const double want = fine_x + coarse_x * 1000 - fine_y * 1e-3 + (coarse_x + sq(q + 2) - sq(q)) * 1e6;
    EXPECT_NEAR(real(s.at(0)[lane]), want, want * 0x1p-22) << lane;
  }
}

TEST(SpirvStage, DemoteGoesOnAsHelper) {
  const FakeStage s = run_fragment(
      "void main() { if (lane == 3u) demote; r = helperInvocationEXT() ? 200.0 : 300.0; r += dFdx(f); d[lane] = 1u; }", 0xff0f,
      "#extension GL_EXT_demote_to_helper_invocation : require\n");
  EXPECT_EQ(s.discarded, 0x0008u);
  for (uint32_t lane = 0; lane < 16; ++lane) {
    const bool helper = lane == 3 || (lane >= 4 && lane < 8);
    EXPECT_EQ(real(s.at(0)[lane]), helper ? 201.0f : 301.0f) << lane;
    EXPECT_EQ(s.buffers.at(0).words[lane], helper ? 0u : 1u) << lane;
  }
}

// ---- refusals name what they refuse ----

TEST(SpirvStage, Refusals) {
  const Words good = glsl(kVertex, "void main() { gl_Position = vec4(0); }");
  EXPECT_EQ(error_of(kVertex, good), "");
  EXPECT_NE(error_of(kFragment, good).find("entry point"), std::string::npos);
  EXPECT_NE(error_of(kVertex, good, "other").find("\"other\""), std::string::npos);
  const std::string sparse =
      "#extension GL_ARB_sparse_texture2 : require\nlayout(set = 0, binding = 0) uniform sampler2D s;"
      "void main() { vec4 c; sparseTextureARB(s, vec2(0.5), c); gl_Position = c; }";
  EXPECT_NE(error_of(kVertex, glsl(kVertex, sparse)).find("SparseResidency"), std::string::npos);
  Words version = good;
  version[1] = 0x00020000;
  EXPECT_NE(error_of(kVertex, version).find("version"), std::string::npos);
  EXPECT_NE(error_of(kVertex, {}).find("header"), std::string::npos);
}

TEST(SpirvStage, ErrorsNameInstructionAndWord) {
  const Words words = assembly(R"(
OpCapability Shader
OpMemoryModel Logical GLSL450
OpEntryPoint Vertex %main "main"
%void = OpTypeVoid
%fn = OpTypeFunction %void
%float = OpTypeFloat 32
%int = OpTypeInt 32 1
%i = OpConstant %int 1
%f = OpConstant %float 1
%main = OpFunction %void None %fn
%a = OpLabel
%r = OpFAdd %float %f %i
OpReturn
OpFunctionEnd
)");
  const std::string error = error_of(kVertex, words);
  EXPECT_EQ(error.substr(0, 13), "OpFAdd (word ");
  EXPECT_NE(error.find("is not a float"), std::string::npos);
}

TEST(SpirvStage, FunctionInliningIsBounded) {  // 2^30 calls
  std::string text;
  for (int i = 30; i-- > 0;)
    text = "void f" + std::to_string(i) + "() { f" + std::to_string(i + 1) + "(); f" + std::to_string(i + 1) + "(); }\n" + text;
  std::string forward;
  for (int i = 0; i <= 30; ++i) forward += "void f" + std::to_string(i) + "();\n";
  const Words words = glsl(kCompute, "layout(set = 0, binding = 0) buffer D { uint d; };\n" + forward + text +
                                         "void f30() { d += 1u; }\nvoid main() { f0(); }");
  EXPECT_NE(error_of(kCompute, words).find("too large"), std::string::npos);
}

// An input that nothing else reads.
TEST(SpirvStage, InputsThatAreOnlyInterpolatedElsewhere) {
  for (const std::string call : {"interpolateAtOffset(v, vec2(0.25))", "interpolateAtCentroid(v)", "interpolateAtSample(v, 1)"}) {
    const Words words =
        glsl(VK_SHADER_STAGE_FRAGMENT_BIT,
             "layout(location = 3) in vec2 v; layout(location = 0) out vec4 r; void main() { r = " + call + ".xyxy; }");
    const auto module = parse({.words = words, .entry_point = "main", .stage = VK_SHADER_STAGE_FRAGMENT_BIT});
    ASSERT_TRUE(module) << call << ": " << module.error().text;
    ASSERT_EQ(info(**module).inputs.size(), 2u) << call;
    EXPECT_EQ(info(**module).inputs[0].location, 3u);
  }
}

}  // namespace
}  // namespace pineda::spirv::test
