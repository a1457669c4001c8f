// SPIR-V to running kernels, through the public interface.
#include "compiler/compile.h"

#include <gtest/gtest.h>

#include <cstring>
#include <thread>

#include "base/config.h"
#include "base/srgb.h"
#include "compiler/spirv/test_shaders.h"

namespace pineda::compiler {
namespace {

spirv::ModulePtr parse(VkShaderStageFlagBits stage, const std::string& text) {
  const spirv::test::Words words = spirv::test::glsl(stage, text);
  Result<spirv::ModulePtr> module = spirv::parse({.words = words, .entry_point = "main", .stage = stage});
  EXPECT_TRUE(module) << (module ? "" : module.error().text);
  return module ? std::move(*module) : nullptr;
}

struct Graphics {
  spirv::ModulePtr vertex, fragment;
  PipelineLayout layout;
  GraphicsSource source;

  Graphics(const std::string& vertex_text, const std::string& fragment_text)
      : vertex(parse(VK_SHADER_STAGE_VERTEX_BIT, vertex_text)), fragment(parse(VK_SHADER_STAGE_FRAGMENT_BIT, fragment_text)) {
    source.vertex = vertex.get();
    source.fragment = fragment.get();
    source.layout = &layout;
    source.name = "test";
    source.state.color[0].format = VK_FORMAT_R8G8B8A8_UNORM;
    source.state.color_count = 1;
  }
};

constexpr const char* kVertex = R"(
  layout(location = 0) in vec3 position; layout(location = 1) in vec4 color;
  layout(location = 0) out vec4 unused; layout(location = 1) out vec4 passed;
  layout(push_constant) uniform Push { vec4 scale; };
  void main() { gl_Position = vec4(position * scale.xyz, 1); passed = color * 2.0; unused = vec4(sin(color.x)); })";
constexpr const char* kFragment = R"(
  layout(location = 0) in vec4 unused; layout(location = 1) in vec4 passed; layout(location = 0) out vec4 color;
  void main() { color = vec4(passed.x, passed.y * 0.0 + 0.25, passed.z, 1); })";

TEST(Compile, GraphicsRunsAndLeavesOutWhatNobodyReads) {
  Graphics g(kVertex, kFragment);
  g.layout.push_constant_bytes = 16;
  g.source.vertex_input = {.attributes = {{0, 0, VK_FORMAT_R32G32B32_SFLOAT, 0}, {1, 0, VK_FORMAT_R8G8B8A8_UNORM, 12}},
                           .bindings = {{0, 16, VK_VERTEX_INPUT_RATE_VERTEX}}};
  const Result<GraphicsKernels> kernels = compile_graphics(g.source);
  ASSERT_TRUE(kernels) << kernels.error().text;
  EXPECT_LE(kernels->vertex_slots, 4u + 3);  // x, z, and y unless 0 * y is known to vanish (it is not: y may be infinite)
  EXPECT_TRUE(kernels->opaque);
  EXPECT_FALSE(kernels->reads_color);
  // three vertices, then the block at (0, 0) under a triangle that covers it
  struct Vertex {
    float position[3];
    uint8_t color[4];
  } vertices[3] = {{{1, 2, 3}, {51, 0, 102, 0}}, {{4, 5, 6}, {51, 0, 102, 0}}, {{7, 8, 9}, {51, 0, 102, 0}}};
  DrawContext draw{};
  set_srgb_tables(draw);
  const float scale[4] = {2, 3, 4, 5};
  std::memcpy(draw.push_constants, scale, sizeof scale);
  draw.vertex_buffers[0] = {.address = reinterpret_cast<uint64_t>(vertices), .size_bytes = sizeof vertices};
  std::vector<float> out(kernels->vertex_slots * kLanes);
  VertexWave wave{.mask = 7, .out = out.data(), .vertex_index = {0, 1, 2}};
  const PrimRecord vertex_record{nullptr, 0, 1};
  kernels->vertex->handle(&draw, nullptr, &vertex_record, 1, &wave);
  EXPECT_EQ(out[0 * kLanes + 1], 8);
  EXPECT_EQ(out[1 * kLanes + 1], 15);
  EXPECT_EQ(out[2 * kLanes + 2], 36);
  EXPECT_EQ(out[3 * kLanes + 2], 1);
  const FragmentPrim prim{.l1_dx = 0.01f, .l2_dy = 0.01f, .iw0 = 1, .iw1 = 1, .iw2 = 1, .vertex = {&out[0], &out[1], &out[2]}};
  const FragmentWave fragment_wave{.exec_mask = 0xffff, .coverage = 0xff0f};
  const PrimRecord fragment_record{&prim, 0, 1};
  uint8_t tile[64] = {};
  ThreadContext thread{};
  thread.color[0] = tile;
  kernels->fragment->handle(&draw, &thread, &fragment_record, 1, &fragment_wave);
  const uint8_t want[4] = {102, 64, 204, 255}, untouched[4] = {};
  for (uint32_t lane = 0; lane < kLanes; ++lane) {
    EXPECT_EQ(std::memcmp(&tile[4 * lane], fragment_wave.coverage >> lane & 1 ? want : untouched, 4), 0) << lane;
  }
}

TEST(Compile, EqualKernelsAreCompiledOnce) {
  Graphics a("void main() { gl_Position = vec4(1); }", "layout(location = 0) out vec4 c; void main() { c = vec4(0.125); }");
  std::array<Result<GraphicsKernels>, 4> results{compile_error(""), compile_error(""), compile_error(""), compile_error("")};
  {
    std::vector<std::jthread> threads;
    for (auto& result : results) threads.emplace_back([&] { result = compile_graphics(a.source); });
  }
  for (const auto& result : results) {
    ASSERT_TRUE(result) << result.error().text;
    EXPECT_EQ(result->fragment, results[0]->fragment);
    EXPECT_EQ(result->vertex, results[0]->vertex);
  }
}

TEST(Compile, Compute) {
  const spirv::ModulePtr module = parse(VK_SHADER_STAGE_COMPUTE_BIT, R"(
    layout(local_size_x = 8, local_size_y = 4) in;
    layout(std430, set = 1, binding = 2) buffer Data { float data[]; };
    void main() {
      uint i = gl_GlobalInvocationID.y * 16 + gl_GlobalInvocationID.x;
      data[i] = data[i] * 2.0 + float(gl_LocalInvocationID.y);
    })");
  PipelineLayout layout;
  layout.bindings.push_back({.set = 1,
                             .binding = 2,
                             .type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER,
                             .count = 1,
                             .offset_bytes = 32,
                             .stride_bytes = sizeof(BufferDescriptor)});
  const Result<ComputeKernel> kernel = compile_compute({.module = module.get(), .layout = &layout, .name = "test"});
  ASSERT_TRUE(kernel) << kernel.error().text;
  EXPECT_EQ(kernel->local_size, (std::array<uint32_t, 3>{8, 4, 1}));
  std::vector<float> data(64);
  for (size_t i = 0; i < data.size(); ++i) data[i] = static_cast<float>(i);
  BufferDescriptor set[3] = {};
  set[2] = {.address = reinterpret_cast<uint64_t>(data.data()), .size_bytes = 256};
  DrawContext draw{};
  draw.sets[1] = set;
  // workgroup (1, 0): invocations x 8..15, y 0..3, two waves
  const WorkgroupRecord group{.id = {1, 0, 0}};
  const ComputeWave waves[2] = {{0xffff, 0}, {0xffff, 16}};
  const PrimRecord record{&group, 0, 2};
  kernel->kernel->handle(&draw, nullptr, &record, 1, waves);
  for (uint32_t i = 0; i < 64; ++i) {
    const uint32_t x = i % 16, y = i / 16;
    EXPECT_EQ(data[i], x >= 8 ? 2.0f * static_cast<float>(i) + static_cast<float>(y) : static_cast<float>(i));
  }
}

TEST(Compile, MissingDescriptorIsAnError) {
  Graphics g("void main() { gl_Position = vec4(1); }",
             "layout(set = 3, binding = 1) uniform U { vec4 u; }; layout(location = 0) out vec4 c; void main() { c = u; }");
  const Result<GraphicsKernels> kernels = compile_graphics(g.source);
  ASSERT_FALSE(kernels);
  EXPECT_NE(kernels.error().text.find("set 3, binding 1"), std::string::npos) << kernels.error().text;
}

}  // namespace
}  // namespace pineda::compiler
