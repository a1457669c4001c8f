// Fragment kernels: interpolation against double precision, depth test, blending, coverage.
#include <bit>
#include <cmath>

#include "compiler/kernels/test_rig.h"

namespace pineda::kernels::test {
namespace {

using ir::Builder;
using ir::Type;
using ir::Value;
using spirv::BuiltIn;
using spirv::Interpolation;
using spirv::StageInterface;

// A triangle with corners at (x, y) px, values z and w; the prim's fields as raster's setup computes them, in double.
struct Corner {
  double x, y, z, w;
};
FragmentPrim triangle(const std::array<Corner, 3>& c) {
  FragmentPrim p{};
  const double ax = c[1].x - c[0].x, ay = c[1].y - c[0].y, bx = c[2].x - c[0].x, by = c[2].y - c[0].y;
  const double area = ax * by - ay * bx;
  p.x0_px = static_cast<float>(c[0].x);
  p.y0_px = static_cast<float>(c[0].y);
  p.l1_dx = static_cast<float>(by / area);
  p.l1_dy = static_cast<float>(-bx / area);
  p.l2_dx = static_cast<float>(-ay / area);
  p.l2_dy = static_cast<float>(ax / area);
  p.z0 = static_cast<float>(c[0].z);
  p.dz1 = static_cast<float>(c[1].z - c[0].z);
  p.dz2 = static_cast<float>(c[2].z - c[0].z);
  p.iw0 = static_cast<float>(1 / c[0].w);
  p.iw1 = static_cast<float>(1 / c[1].w);
  p.iw2 = static_cast<float>(1 / c[2].w);
  return p;
}

compiler::BlendState attachment(VkFormat format) { return {.format = format}; }

float float_at(const std::vector<uint8_t>& tile, uint32_t word, uint32_t lane) {
  float value;
  std::memcpy(&value, &tile[(word * kLanes + lane) * 4], 4);
  return value;
}

TEST(Fragment, InterpolatesAsTheFormulaSays) {
  std::mt19937 random(kSeed);
  const auto uniform = [&](double low, double high) { return low + (high - low) * (random() / 0x1p32); };
  FragmentRig rig = FragmentRig::with([](Builder& b, StageInterface& stage) {
    stage.output(b, color_output(0, 0), stage.input(b, {.location = 2, .component = 1}));
    stage.output(b, color_output(0, 1),
                 stage.input(b, {.location = 2, .component = 1, .interpolation = Interpolation::kNoPerspective}));
    stage.output(b, color_output(0, 2), stage.input(b, {.location = 0, .component = 3, .interpolation = Interpolation::kFlat}));
    stage.output(b, color_output(0, 3), stage.input(b, {.built_in = BuiltIn::kFragCoord, .component = 3}));
    for (uint32_t c = 0; c < 3; ++c) {
      stage.output(b, color_output(1, c), stage.input(b, {.built_in = BuiltIn::kFragCoord, .component = c}));
    }
    stage.output(b, color_output(1, 3),
                 b.convert(ir::Op::kUToF, Type::kF32, stage.input(b, {.built_in = BuiltIn::kPrimitiveId, .type = Type::kI32})));
  });
  rig.source.state.color = {attachment(VK_FORMAT_R32G32B32A32_SFLOAT), attachment(VK_FORMAT_R32G32B32A32_SFLOAT)};
  rig.source.state.color_count = 2;
  const auto varyings = rig.build(eval::Mode::kF32);
  ASSERT_EQ(varyings, (std::vector<compiler::VaryingSlot>{{0, 3}, {2, 1}}));
  for (int round = 0; round < 500; ++round) {
    std::array<Corner, 3> corner;
    do {
      for (Corner& c : corner) {
        c = {std::round(uniform(0, 2000) * 256) / 256, std::round(uniform(0, 2000) * 256) / 256, uniform(0, 1), uniform(0.1, 10)};
      }
    } while (std::fabs((corner[1].x - corner[0].x) * (corner[2].y - corner[0].y) -
                       (corner[1].y - corner[0].y) * (corner[2].x - corner[0].x)) < 1000);
    rig.prim = triangle(corner);
    rig.prim.primitive_id = 1234;
    double a[3], flat = uniform(-5, 5);
    for (uint32_t v = 0; v < 3; ++v) {
      a[v] = static_cast<float>(uniform(-100, 100));
      rig.vertices[v].assign(6 * kLanes, NAN);
      rig.vertices[v][5 * kLanes] = static_cast<float>(a[v]);
    }
    rig.vertices[0][4 * kLanes] = static_cast<float>(flat);
    // a block near the triangle's centre
    rig.wave.x_px = static_cast<uint16_t>((corner[0].x + corner[1].x + corner[2].x) / 3) & ~3;
    rig.wave.y_px = static_cast<uint16_t>((corner[0].y + corner[1].y + corner[2].y) / 3) & ~3;
    rig.run();
    const FragmentPrim& p = rig.prim;
    for (uint32_t lane = 0; lane < kLanes; ++lane) {
      const double x = rig.wave.x_px + lane_x(lane) + 0.5, y = rig.wave.y_px + lane_y(lane) + 0.5;
      const double l1 = p.l1_dx * (x - p.x0_px) + static_cast<double>(p.l1_dy) * (y - p.y0_px);
      const double l2 = p.l2_dx * (x - p.x0_px) + static_cast<double>(p.l2_dy) * (y - p.y0_px);
      const double iw = (1 - l1 - l2) * p.iw0 + l1 * p.iw1 + l2 * p.iw2;
      const double b1 = l1 * p.iw1 / iw, b2 = l2 * p.iw2 / iw;
      // Each barycentric is a sum of two products, each of which may be far larger than the sum: half an ulp of the largest for
      // each of three roundings; then the same again for the steps from barycentrics to values, which grow with the range of the
      // values.
      const double terms = 1 + std::fabs(p.l1_dx * (x - p.x0_px)) + std::fabs(p.l1_dy * (y - p.y0_px)) +
                           std::fabs(p.l2_dx * (x - p.x0_px)) + std::fabs(p.l2_dy * (y - p.y0_px));
      const double error = 6 * terms * 0x1p-25;
      const double tolerance = 200 * error;
      const double stretch = 1 + std::max({p.iw0, p.iw1, p.iw2}) / iw;  // what the division by 1/w makes of it
      EXPECT_NEAR(float_at(rig.color[0], 0, lane), a[0] + b1 * (a[1] - a[0]) + b2 * (a[2] - a[0]), tolerance * stretch * stretch);
      EXPECT_NEAR(float_at(rig.color[0], 1, lane), a[0] + l1 * (a[1] - a[0]) + l2 * (a[2] - a[0]), tolerance);
      EXPECT_EQ(float_at(rig.color[0], 2, lane), static_cast<float>(flat));
      EXPECT_NEAR(float_at(rig.color[0], 3, lane) / iw, 1, error * stretch);
      EXPECT_EQ(float_at(rig.color[1], 0, lane), x);
      EXPECT_EQ(float_at(rig.color[1], 1, lane), y);
      EXPECT_NEAR(float_at(rig.color[1], 2, lane), p.z0 + l1 * p.dz1 + l2 * p.dz2, error);
      EXPECT_EQ(float_at(rig.color[1], 3, lane), 1234);
    }
  }
}

TEST(Fragment, FlatInputsFollowTheProvokingVertex) {
  FragmentRig rig = FragmentRig::with([](Builder& b, StageInterface& stage) {
    stage.output(b, color_output(0, 0),
                 stage.input(b, {.location = 0, .type = Type::kI32, .interpolation = Interpolation::kFlat}));
  });
  rig.source.state.color[0] = attachment(VK_FORMAT_R32_UINT);
  rig.source.state.color_count = 1;
  rig.build(eval::Mode::kF32);
  for (auto& vertex : rig.vertices) vertex.assign(8 * kLanes, 0);
  rig.vertices[0][4 * kLanes + 7] = std::bit_cast<float>(42u);
  rig.prim.flat_offset_bytes = 28;
  rig.run();
  EXPECT_EQ(std::bit_cast<uint32_t>(float_at(rig.color[0], 0, 3)), 42u);
}

TEST(Fragment, OnlyCoveredLanesAreStored) {
  for (const VkFormat format : {VK_FORMAT_R8_UNORM, VK_FORMAT_R8G8_UNORM, VK_FORMAT_R8G8B8A8_UNORM, VK_FORMAT_R16G16B16A16_SFLOAT,
                                VK_FORMAT_R32G32B32A32_SFLOAT}) {
    FragmentRig rig = FragmentRig::with([](Builder& b, StageInterface& stage) {
      for (uint32_t c = 0; c < 4; ++c) stage.output(b, color_output(0, c), b.f32(1));
    });
    rig.source.state.color[0] = attachment(format);
    rig.source.state.color_count = 1;
    rig.build(eval::Mode::kF32);
    EXPECT_TRUE(rig.opaque);
    EXPECT_FALSE(rig.reads_color);
    rig.wave.coverage = 0x8421;
    rig.wave.block_index = 3;
    const uint32_t bytes = texel_bytes(format), element = std::min(bytes, 4u);
    rig.color[0].assign(4 * 16 * bytes, 0x11);
    rig.run();
    VkClearColorValue one{{1, 1, 1, 1}};
    uint8_t texel[16];
    pack_clear_color(*find_format(format), one, texel);
    for (uint32_t i = 0; i < rig.color[0].size(); ++i) {
      const uint32_t in_block = i % (16 * bytes), lane = in_block / element % 16, word = in_block / (16 * element);
      const bool covered = i >= 3 * 16 * bytes && (rig.wave.coverage >> lane & 1);
      ASSERT_EQ(rig.color[0][i], covered ? texel[word * 4 + in_block % element] : 0x11) << i;
    }
  }
}

bool passes_test(VkCompareOp op, double fresh, double old) {
  switch (op) {
    case VK_COMPARE_OP_NEVER:
      return false;
    case VK_COMPARE_OP_LESS:
      return fresh < old;
    case VK_COMPARE_OP_EQUAL:
      return fresh == old;
    case VK_COMPARE_OP_LESS_OR_EQUAL:
      return fresh <= old;
    case VK_COMPARE_OP_GREATER:
      return fresh > old;
    case VK_COMPARE_OP_NOT_EQUAL:
      return fresh != old;
    case VK_COMPARE_OP_GREATER_OR_EQUAL:
      return fresh >= old;
    default:
      return true;
  }
}

// Every operator and format; the shader is absent, plain, discards odd columns, or writes depth.
enum class DepthShader { kNone, kPlain, kDiscards, kWritesDepth, kForcedEarlyDiscards };

FragmentRig depth_rig(DepthShader kind, VkFormat format, VkCompareOp op) {
  FragmentRig rig;
  rig.shader.body = [kind](Builder& b, StageInterface& stage) -> Result<spirv::Translation> {
    stage.output(b, color_output(0, 0), b.i32(77));
    spirv::Translation done;
    if (kind == DepthShader::kDiscards || kind == DepthShader::kForcedEarlyDiscards) {
      done.discarded = b.ieq(b.and_(b.lane(), b.i32(1)), b.i32(1));
    }
    if (kind == DepthShader::kWritesDepth) {
      const Value z = stage.input(b, {.built_in = BuiltIn::kFragCoord, .component = 2});
      stage.output(b, {.built_in = BuiltIn::kFragDepth}, b.fsub(b.f32(1), z));
    }
    return done;
  };
  rig.shader.info.writes_depth = kind == DepthShader::kWritesDepth;
  rig.shader.info.early_fragment_tests = kind == DepthShader::kForcedEarlyDiscards;
  rig.source.state.color[0] = attachment(VK_FORMAT_R32_UINT);
  rig.source.state.color_count = kind == DepthShader::kNone ? 0 : 1;
  rig.source.state.depth = {.format = format, .test_enable = true, .write_enable = true, .compare = op};
  rig.build(eval::Mode::kF32, kind == DepthShader::kNone);
  EXPECT_EQ(rig.early_depth, kind != DepthShader::kWritesDepth);
  const bool keeps_lanes = kind == DepthShader::kPlain || kind == DepthShader::kWritesDepth;
  EXPECT_EQ(rig.opaque, keeps_lanes && op == VK_COMPARE_OP_ALWAYS);
  return rig;
}

void run_depth_case(FragmentRig& rig, DepthShader kind, const FormatInfo& info, VkCompareOp op, std::mt19937& random) {
  const double z0 = random() / 0x1p32 * 1.2 - 0.1;  // some of it outside [0, 1]
  const double step = op == VK_COMPARE_OP_EQUAL ? 0 : 0.02;
  rig.prim = {.l1_dx = 1, .z0 = static_cast<float>(z0), .dz1 = static_cast<float>(step)};
  rig.color[0].assign(64, 0);
  rig.depth.assign(16 * info.texel_bytes, 0);
  std::array<float, kLanes> old;
  for (uint32_t lane = 0; lane < kLanes; ++lane) {
    old[lane] = static_cast<float>(std::clamp(z0 + (static_cast<int>(random() % 5) - 1) * step, 0.0, 1.0));
    pack_depth(info, old[lane], &rig.depth[lane * info.texel_bytes]);
  }
  const std::vector<uint8_t> before = rig.depth;
  rig.wave.coverage = static_cast<uint32_t>(random()) & 0xffff;
  rig.run();
  for (uint32_t lane = 0; lane < kLanes; ++lane) {
    float z = std::fma(rig.prim.dz1, lane_x(lane) + 0.5f, rig.prim.z0);
    if (kind == DepthShader::kWritesDepth) z = 1 - z;
    uint8_t fresh[4] = {};
    pack_depth(info, std::clamp(z, 0.0f, 1.0f), fresh);
    const auto number = [&](const uint8_t* texel) { return decode_reference(info, 0, code_of(info, 0, texel)); };
    const bool covered = rig.wave.coverage >> lane & 1;
    const bool discards = kind == DepthShader::kDiscards || kind == DepthShader::kForcedEarlyDiscards;
    const bool passed = covered && passes_test(op, number(fresh), number(&before[lane * info.texel_bytes]));
    const bool shaded = passed && !(discards && (lane & 1));
    const bool stored = kind == DepthShader::kForcedEarlyDiscards ? passed : shaded;
    ASSERT_EQ(
        std::memcmp(&rig.depth[lane * info.texel_bytes], stored ? fresh : &before[lane * info.texel_bytes], info.texel_bytes), 0)
        << info.name << " op " << op << " shader " << static_cast<int>(kind) << " lane " << lane;
    if (kind != DepthShader::kNone) {
      ASSERT_EQ(std::bit_cast<uint32_t>(float_at(rig.color[0], 0, lane)), shaded ? 77u : 0u);
    }
  }
}

TEST(Fragment, DepthTestOfEveryFormatAndOperator) {
  std::mt19937 random(kSeed);
  for (const VkFormat format : {VK_FORMAT_D16_UNORM, VK_FORMAT_X8_D24_UNORM_PACK32, VK_FORMAT_D32_SFLOAT}) {
    for (int op = 0; op <= VK_COMPARE_OP_ALWAYS; ++op) {
      for (int kind = 0; kind <= static_cast<int>(DepthShader::kForcedEarlyDiscards); ++kind) {
        FragmentRig rig = depth_rig(static_cast<DepthShader>(kind), format, static_cast<VkCompareOp>(op));
        for (int round = 0; round < 20; ++round) {
          run_depth_case(rig, static_cast<DepthShader>(kind), *find_format(format), static_cast<VkCompareOp>(op), random);
          if (testing::Test::HasFatalFailure()) return;
        }
      }
    }
  }
}

TEST(Fragment, DepthClampUsesTheViewportsRange) {
  FragmentRig rig;
  rig.source.state.depth = {
      .format = VK_FORMAT_D32_SFLOAT, .test_enable = true, .write_enable = true, .compare = VK_COMPARE_OP_ALWAYS};
  rig.source.state.depth_clamp = true;
  rig.build(eval::Mode::kF32, true);
  rig.draw.depth_range[0][0] = 0.25f;
  rig.draw.depth_range[0][1] = 0.5f;
  for (const auto& [z, want] : {std::pair{0.1f, 0.25f}, {0.3f, 0.3f}, {2.0f, 0.5f}, {NAN, 0.25f}}) {
    rig.prim = {.z0 = z};
    rig.depth.clear();
    rig.run();
    EXPECT_EQ(float_at(rig.depth, 0, 5), want);
  }
}

// Only float formats; and no NaN is stored.
TEST(Fragment, UnrestrictedDepths) {
  for (const auto& [z, want] : {std::pair{-3.5f, -3.5f}, {0.5f, 0.5f}, {7e20f, 7e20f}, {NAN, 0.0f}}) {
    for (const VkFormat format : {VK_FORMAT_D32_SFLOAT, VK_FORMAT_D16_UNORM}) {
      FragmentRig rig;
      rig.source.state.depth = {
          .format = format, .test_enable = true, .write_enable = true, .compare = VK_COMPARE_OP_ALWAYS, .unrestricted = true};
      rig.build(eval::Mode::kF32, true);
      rig.prim = {.z0 = z};
      rig.run();
      if (format == VK_FORMAT_D32_SFLOAT) {
        EXPECT_EQ(float_at(rig.depth, 0, 5), want);
      } else {
        EXPECT_EQ(rig.depth[2 * 5] | rig.depth[2 * 5 + 1] << 8, z < 0 || std::isnan(z) ? 0 : z == 0.5f ? 32768 : 65535);
      }
    }
  }
}

TEST(Fragment, ShaderIsLeftOutWhenNoLanePasses) {
  FragmentRig rig = depth_rig(DepthShader::kPlain, VK_FORMAT_D32_SFLOAT, VK_COMPARE_OP_NEVER);
  rig.color[0].assign(64, 9);
  rig.run();
  for (const uint8_t byte : rig.color[0]) EXPECT_EQ(byte, 9);
}

}  // namespace
}  // namespace pineda::kernels::test
