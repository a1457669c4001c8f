// Vertex kernels: fetch of every vertex format against the specification's formulas, address rules, outputs.
#include <bit>
#include <cmath>

#include "compiler/kernels/test_rig.h"

namespace pineda::kernels::test {
namespace {

using ir::Builder;
using ir::Type;
using ir::Value;

// A shader that copies one vec4 input (location 3) to varying location 0, and 1..4 to the position.
struct VertexRig {
  compiler::PipelineLayout layout;
  compiler::GraphicsSource source{.layout = &layout, .name = "test"};
  Type type = Type::kF32;
  DrawContext draw{};
  VertexWave wave{.mask = 0xffff};
  std::vector<float> out = std::vector<float>(8 * kLanes, -1.0f);

  VertexRig(VkFormat format, uint32_t stride_bytes, VkVertexInputRate rate = VK_VERTEX_INPUT_RATE_VERTEX,
            uint32_t offset_bytes = 0) {
    source.vertex_input.attributes.push_back({.location = 3, .binding = 2, .format = format, .offset_bytes = offset_bytes});
    source.vertex_input.bindings.push_back({.binding = 2, .stride_bytes = stride_bytes, .rate = rate});
    type = find_format(format)->is_integer() ? Type::kI32 : Type::kF32;
    for (uint32_t l = 0; l < kLanes; ++l) wave.vertex_index[l] = l, wave.instance_index[l] = 100 + l;
  }

  void run(const void* buffer, uint32_t size_bytes) {
    Shader shader;
    shader.body = [this](Builder& b, spirv::StageInterface& stage) -> Result<spirv::Translation> {
      for (uint32_t c = 0; c < 4; ++c) {
        spirv::InterfaceScalar scalar{.location = 3, .component = c, .type = type};
        const Value value = stage.input(b, scalar);
        if (!value) return compile_error("no input");
        scalar.location = 0;
        stage.output(b, scalar, value);
        stage.output(b, {.built_in = spirv::BuiltIn::kPosition, .component = c}, b.f32(c + 1));
      }
      return spirv::Translation{};
    };
    const compiler::VaryingSlot varyings[] = {{0, 0}, {0, 1}, {0, 2}, {0, 3}};
    Result<ir::Kernel> kernel = build_vertex(source, shader, varyings);
    ASSERT_TRUE(kernel) << kernel.error().text;
    draw.vertex_buffers[2] = {.address = reinterpret_cast<uint64_t>(buffer), .size_bytes = size_bytes};
    wave.out = out.data();
    const PrimRecord record{nullptr, 0, 1};
    Runner(optimized(std::move(*kernel), eval::Mode::kF32), eval::Mode::kF32).run(&draw, nullptr, &record, 1, &wave);
  }

  float value(uint32_t lane, uint32_t component) const { return out[(4 + component) * kLanes + lane]; }
};

TEST(Vertex, FetchesEveryFormat) {
  std::mt19937 random(kSeed);
  for (const FormatInfo* format : all_formats()) {
    if (!(format->uses & kUseVertex)) continue;
    const uint32_t stride = format->texel_bytes + 3;
    std::vector<uint8_t> buffer(5 + stride * 16);
    for (uint8_t& byte : buffer) byte = static_cast<uint8_t>(random());
    VertexRig rig(format->format, stride, VK_VERTEX_INPUT_RATE_VERTEX, 5);
    rig.run(buffer.data(), static_cast<uint32_t>(buffer.size()));
    for (uint32_t lane = 0; lane < kLanes; ++lane) {
      for (uint32_t c = 0; c < 4; ++c) {
        const double want = decode_reference(*format, c, code_of(*format, c, &buffer[5 + lane * stride]));
        const uint32_t got = std::bit_cast<uint32_t>(rig.value(lane, c));
        if (format->is_integer()) {
          ASSERT_EQ(got, static_cast<uint32_t>(static_cast<int64_t>(want))) << format->name;
        } else if (!std::isnan(want)) {
          ASSERT_EQ(rig.value(lane, c), static_cast<float>(want)) << format->name;
        }
        ASSERT_EQ(rig.out[c * kLanes + lane], c + 1.0f);
      }
    }
  }
}

TEST(Vertex, ReadsPastTheEndGiveZero) {
  const float buffer[] = {1, 2, 3, 4, 5, 6};
  VertexRig rig(VK_FORMAT_R32G32_SFLOAT, 8);
  rig.run(buffer, sizeof buffer);
  for (uint32_t lane = 0; lane < kLanes; ++lane) {
    EXPECT_EQ(rig.value(lane, 0), lane < 3 ? buffer[2 * lane] : 0);
    EXPECT_EQ(rig.value(lane, 1), lane < 3 ? buffer[2 * lane + 1] : 0);
    EXPECT_EQ(rig.value(lane, 3), 1);
  }
}

TEST(Vertex, StrideZeroAndInstanceRate) {
  std::vector<float> buffer(200);
  for (size_t i = 0; i < buffer.size(); ++i) buffer[i] = static_cast<float>(i);
  VertexRig constant(VK_FORMAT_R32_SFLOAT, 0, VK_VERTEX_INPUT_RATE_VERTEX, 12);
  constant.run(buffer.data(), 800);
  VertexRig instanced(VK_FORMAT_R32_SFLOAT, 4, VK_VERTEX_INPUT_RATE_INSTANCE);
  instanced.run(buffer.data(), 800);
  for (uint32_t lane = 0; lane < kLanes; ++lane) {
    EXPECT_EQ(constant.value(lane, 0), 3);
    EXPECT_EQ(instanced.value(lane, 0), 100 + lane);
  }
}

TEST(Vertex, InactiveLanesStoreNothing) {
  const float buffer[16] = {};
  VertexRig rig(VK_FORMAT_R32_SFLOAT, 4);
  rig.wave.mask = 0x00ff;
  rig.run(buffer, sizeof buffer);
  for (uint32_t lane = 0; lane < kLanes; ++lane) EXPECT_EQ(rig.out[lane], lane < 8 ? 1 : -1);
}

TEST(Vertex, MissingAttributeIsAnError) {
  VertexRig rig(VK_FORMAT_R32_SFLOAT, 4);
  Shader shader;
  shader.body = [](Builder& b, spirv::StageInterface& stage) -> Result<spirv::Translation> {
    if (!stage.input(b, {.location = 9})) return compile_error("Input refused.");
    return spirv::Translation{};
  };
  const Result<ir::Kernel> kernel = build_vertex(rig.source, shader, {});
  ASSERT_FALSE(kernel);
  EXPECT_NE(kernel.error().text.find("location 9"), std::string::npos);
}

}  // namespace
}  // namespace pineda::kernels::test
