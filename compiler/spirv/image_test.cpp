// Image instructions: what the translator asks of the stage, and what it does with the answer.
#include <cmath>

#include "compiler/spirv/test_shaders.h"

namespace pineda::spirv::test {
namespace {

constexpr auto kFragment = VK_SHADER_STAGE_FRAGMENT_BIT;

struct Sampled {
  FakeStage stage;
  ModuleInfo info;
  std::string error;
};

// Runs a fragment shader whose inputs are v = (lane, 2, 0.5, 4) and writes `r`.
Sampled sample(const std::string& declarations, const std::string& body) {
  Sampled s;
  s.stage.input_value = [](uint32_t lane, const InterfaceScalar& in) {
    return word(in.component == 0 ? float(lane) : in.component == 1 ? 2.0f : in.component == 2 ? 0.5f : 4.0f);
  };
  s.stage.buffers[90].words.resize(16);  // what FakeStage::image_store writes
  s.error = run(s.stage, kFragment,
                glsl(kFragment, "layout(location = 0) in vec4 v; layout(location = 0) out vec4 r;\n" + declarations +
                                    "\nvoid main() {\n" + body + "\n}"),
                {}, &s.info);
  return s;
}

std::array<float, 4> result(const Sampled& s, uint32_t lane) {
  return {real(s.stage.at(0, 0)[lane]), real(s.stage.at(0, 1)[lane]), real(s.stage.at(0, 2)[lane]), real(s.stage.at(0, 3)[lane])};
}
using Four = std::array<float, 4>;

TEST(SpirvImage, ImplicitBiasExplicitGradient) {
  const std::string texture = "layout(set = 1, binding = 2) uniform sampler2D t;";
  Sampled s = sample(texture, "r = texture(t, v.xy);");
  ASSERT_EQ(s.error, "");
  EXPECT_EQ(s.stage.samples[0].lod_mode, LodMode::kImplicit);
  EXPECT_EQ(s.stage.samples[0].image, (ImageRef{1, 2, 0}));
  EXPECT_EQ(s.stage.samples[0].sampler, (ImageRef{1, 2, 0}));
  EXPECT_EQ(s.stage.samples[0].view_type, VK_IMAGE_VIEW_TYPE_2D);
  EXPECT_TRUE(s.info.uses_derivatives);
  EXPECT_EQ(result(s, 5), (Four{5, 2, 0, 0}));
  s = sample(texture, "r = texture(t, v.xy, 1.25);");
  EXPECT_EQ(s.stage.samples[0].lod_mode, LodMode::kImplicit);
  EXPECT_TRUE(s.stage.samples[0].bias);
  EXPECT_EQ(result(s, 5), (Four{5, 2, 1.25f, 0}));
  s = sample(texture, "r = textureLodOffset(t, v.yx, v.w, ivec2(-3, 4));");
  EXPECT_EQ(s.stage.samples[0].lod_mode, LodMode::kExplicit);
  EXPECT_EQ(s.stage.samples[0].offset, (std::array<int32_t, 3>{-3, 4, 0}));
  EXPECT_FALSE(s.info.uses_derivatives);
  EXPECT_EQ(result(s, 5), (Four{2, 5, 4, 0}));
  s = sample(texture, "r = textureGrad(t, v.xy, vec2(1, 2), v.zw);");
  EXPECT_EQ(s.stage.samples[0].lod_mode, LodMode::kGradient);
  EXPECT_TRUE(s.stage.samples[0].ddx[1] && s.stage.samples[0].ddy[1] && !s.stage.samples[0].ddx[2]);
}

TEST(SpirvImage, ProjectionDividesEverything) {
  const Sampled s =
      sample("layout(set = 0, binding = 0) uniform sampler2DShadow t; layout(set = 0, binding = 1) uniform sampler2D u;",
             "r = textureProj(u, vec3(v.x, v.y, v.w)); r.w = textureProj(t, vec4(v.x, v.y, 3.0, v.w));");
  ASSERT_EQ(s.error, "");
  EXPECT_EQ(result(s, 6), (Four{1.5f, 0.5f, 0, 1.5f}));  // the shadow lookup's first component is u / q
  EXPECT_TRUE(s.stage.samples[1].depth_reference);
  EXPECT_FALSE(s.stage.samples[0].depth_reference);
}

TEST(SpirvImage, ViewTypesAndLayers) {
  const Sampled s = sample(
      R"(layout(set = 0, binding = 0) uniform sampler1D a; layout(set = 0, binding = 1) uniform sampler1DArray b; layout(set = 0, binding = 2) uniform sampler2DArray c;
    layout(set = 0, binding = 3) uniform sampler3D d; layout(set = 0, binding = 4) uniform samplerCube e; layout(set = 0, binding = 5) uniform samplerCubeArray f;
    layout(set = 0, binding = 6) uniform isampler2D g; layout(set = 0, binding = 7) uniform samplerCubeArrayShadow h;)",
      "r = texture(a, v.x) + texture(b, v.xy) + texture(c, v.xyz) + texture(d, v.xyz) + texture(e, v.xyz) + texture(f, v) + "
      "vec4(texture(g, v.xy)) + texture(h, v, 0.5);");
  ASSERT_EQ(s.error, "");
  const VkImageViewType types[] = {VK_IMAGE_VIEW_TYPE_1D, VK_IMAGE_VIEW_TYPE_1D_ARRAY,  VK_IMAGE_VIEW_TYPE_2D_ARRAY,
                                   VK_IMAGE_VIEW_TYPE_3D, VK_IMAGE_VIEW_TYPE_CUBE,      VK_IMAGE_VIEW_TYPE_CUBE_ARRAY,
                                   VK_IMAGE_VIEW_TYPE_2D, VK_IMAGE_VIEW_TYPE_CUBE_ARRAY};
  const int coords[] = {1, 2, 3, 3, 3, 4, 2, 4};
  ASSERT_EQ(s.stage.samples.size(), 8u);
  for (int i = 0; i < 8; ++i) {
    const SampleRequest& r = s.stage.samples[i];
    EXPECT_EQ(r.view_type, types[i]) << i;
    int count = 0;
    for (ir::Value v : r.coord) count += static_cast<bool>(v);
    EXPECT_EQ(count, coords[i]) << i;
    EXPECT_EQ(r.result, i == 6 ? ir::Type::kI32 : ir::Type::kF32);
  }
}

TEST(SpirvImage, SeparateSamplersThroughFunctionsAndArrays) {
  const Sampled s = sample(
      R"(layout(set = 0, binding = 0) uniform texture2D t[3]; layout(set = 0, binding = 1) uniform sampler s; layout(set = 0, binding = 4) uniform sampler q;
    vec4 get(texture2D x, sampler y) { return texture(sampler2D(x, y), v.xy); })",
      "r = get(t[2], s) + get(t[0], q) + get(t[2], s);");
  ASSERT_EQ(s.error, "");
  ASSERT_EQ(s.info.images.size(), 2u);
  EXPECT_EQ(s.info.images[0].image, (ImageRef{0, 0, 2}));
  EXPECT_EQ(s.info.images[0].sampler, (ImageRef{0, 1, 0}));
  EXPECT_EQ(s.info.images[1].image, (ImageRef{0, 0, 0}));
  EXPECT_EQ(s.info.images[1].sampler, (ImageRef{0, 4, 0}));
  EXPECT_TRUE(s.info.images[0].sampled);
}

TEST(SpirvImage, FetchGatherQuery) {
  const Sampled s = sample(
      R"(layout(set = 0, binding = 0) uniform sampler2DArray t; layout(set = 0, binding = 1) uniform samplerCubeArray c; layout(set = 0, binding = 2) uniform sampler2D u;)",
      R"(r = texelFetch(t, ivec3(v.xyw), 3); r += textureGather(t, v.xyz, 2) * 10.0; ivec3 size = textureSize(t, 1); r.x += float(size.x * 10000 + size.z * 1000);
                              r.y += float(textureSize(c, 0).z); r.z += float(textureQueryLevels(u)); r.w += textureQueryLod(u, v.xy).y;)");
  ASSERT_EQ(s.error, "");
  EXPECT_EQ(s.stage.samples[0].lod_mode, LodMode::kFetch);
  EXPECT_EQ(s.stage.samples[1].gather_component, 2);
  // fetch (5, 2, 4, 3); gather (5, 2 + 10 * 0.5, 0, 0); size 64 x 32, 12 layers = 2 cubes, levels 64
  EXPECT_EQ(result(s, 5), (Four{5 + 50 + 640000 + 12000, 2 + 70 + 2, 4 + 64, 3 + 2}));
}

TEST(SpirvImage, GatherWithFourOffsets) {
  const Sampled s = sample(
      "layout(set = 0, binding = 0) uniform sampler2D t; const ivec2 o[4] = ivec2[](ivec2(-1, 0), ivec2(1, 2), ivec2(3, 4), "
      "ivec2(5, -6));",
      "r = textureGatherOffsets(t, v.xy, o, 1);");
  ASSERT_EQ(s.error, "");
  ASSERT_EQ(s.stage.samples.size(), 4u);
  EXPECT_EQ(s.stage.samples[3].offset, (std::array<int32_t, 3>{5, -6, 0}));
}

TEST(SpirvImage, StorageImages) {
  const Sampled s = sample(
      "layout(set = 0, binding = 0, rgba8) uniform image2D a; layout(set = 0, binding = 1, r32i) uniform iimage3D b; layout(set "
      "= 0, binding = 2) writeonly uniform image2DArray c;",
      "ivec3 p = ivec3(v.xyw); r = imageLoad(a, p.xy) + vec4(imageLoad(b, p)); imageStore(c, p, r); if (p.x == 3) discard; "
      "imageStore(a, p.xy, vec4(7));");
  ASSERT_EQ(s.error, "");
  EXPECT_EQ(s.stage.loads[0].format, VK_FORMAT_R8G8B8A8_UNORM);
  EXPECT_EQ(s.stage.loads[1].format, VK_FORMAT_R32_SINT);
  EXPECT_EQ(s.stage.loads[1].component, ir::Type::kI32);
  EXPECT_EQ(s.stage.stores[0].format, VK_FORMAT_UNDEFINED);
  EXPECT_EQ(s.stage.stores[0].view_type, VK_IMAGE_VIEW_TYPE_2D_ARRAY);
  EXPECT_TRUE(s.info.writes_memory);
  EXPECT_EQ(s.info.images.size(), 3u);
  for (uint32_t lane = 0; lane < 16; ++lane) {
    EXPECT_EQ(real(s.stage.buffers.at(90).words[lane]), lane == 3 ? 6.0f : 7.0f) << "discarded lanes keep the first store";
  }
}

TEST(SpirvImage, OutsideFragmentShadersTheBaseLevelIsSampled) {
  FakeStage stage;
  stage.buffers[0].words.resize(16);
  const std::string error =
      run(stage, VK_SHADER_STAGE_COMPUTE_BIT,
          compute_words("d[lane] = texture(t, vec2(lane)).z;", "float", "layout(set = 0, binding = 1) uniform sampler2D t;"));
  ASSERT_EQ(error, "");
  EXPECT_EQ(stage.samples[0].lod_mode, LodMode::kExplicit);
}

TEST(SpirvImage, DynamicIndicesReachTheStage) {
  const Words words = glsl(kFragment,
                           "layout(location = 0) flat in int i; layout(location = 0) out vec4 r; layout(set = 0, binding = 0) "
                           "uniform sampler2D t[3]; void main() { r = texture(t[i], vec2(0)); }");
  FakeStage stage;
  ASSERT_EQ(run(stage, kFragment, words), "");
  ASSERT_EQ(stage.samples.size(), 1u);
  EXPECT_TRUE(stage.samples[0].image.index);
  EXPECT_EQ(stage.samples[0].image, stage.samples[0].sampler);
}

}  // namespace
}  // namespace pineda::spirv::test
