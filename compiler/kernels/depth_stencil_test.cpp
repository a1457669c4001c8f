// Stencil, depth bounds and depth test of one sample and of many, and what becomes of colours: against a scalar model of the
// specification's pipeline, for every sample count.
#include <bit>

#include "base/sample_locations.h"
#include "compiler/kernels/test_rig.h"

namespace pineda::kernels::test {
namespace {

using ir::Builder;
using ir::Type;
using ir::Value;
using spirv::BuiltIn;
using spirv::StageInterface;

bool passes(VkCompareOp op, double a, double b) {
  switch (op) {
    case VK_COMPARE_OP_NEVER:
      return false;
    case VK_COMPARE_OP_LESS:
      return a < b;
    case VK_COMPARE_OP_EQUAL:
      return a == b;
    case VK_COMPARE_OP_LESS_OR_EQUAL:
      return a <= b;
    case VK_COMPARE_OP_GREATER:
      return a > b;
    case VK_COMPARE_OP_NOT_EQUAL:
      return a != b;
    case VK_COMPARE_OP_GREATER_OR_EQUAL:
      return a >= b;
    default:
      return true;
  }
}

uint32_t stencil_result(VkStencilOp op, uint32_t s, uint32_t reference) {
  switch (op) {
    case VK_STENCIL_OP_ZERO:
      return 0;
    case VK_STENCIL_OP_REPLACE:
      return reference;
    case VK_STENCIL_OP_INCREMENT_AND_CLAMP:
      return s == 255 ? 255 : s + 1;
    case VK_STENCIL_OP_DECREMENT_AND_CLAMP:
      return s == 0 ? 0 : s - 1;
    case VK_STENCIL_OP_INVERT:
      return ~s & 255;
    case VK_STENCIL_OP_INCREMENT_AND_WRAP:
      return (s + 1) & 255;
    case VK_STENCIL_OP_DECREMENT_AND_WRAP:
      return (s - 1) & 255;
    default:
      return s;
  }
}

// One pixel's sample, before and after.
struct Sample {
  uint32_t color;
  float depth;
  uint32_t stencil;
  bool operator==(const Sample&) const = default;
};

// What the shader of a case does, decided for each lane by bits of its number.
struct ShaderKind {
  bool writes_depth, discards, writes_mask, forced_early, exports_stencil;
};
constexpr uint32_t kDiscardBits = 0b0010'0100'1000'0001, kMaskPattern = 0x9E37;
constexpr float kShaderDepth = 0.3125f;

FragmentRig make_rig(const ShaderKind& kind) {
  FragmentRig rig;
  if (kind.writes_depth) {
    rig.shader.info.writes_depth = true;
    rig.shader.info.outputs.push_back({.built_in = BuiltIn::kFragDepth});
  }
  if (kind.exports_stencil) rig.shader.info.outputs.push_back({.built_in = BuiltIn::kFragStencilRef, .type = Type::kI32});
  if (kind.writes_mask) rig.shader.info.outputs.push_back({.built_in = BuiltIn::kSampleMask, .type = Type::kI32});
  rig.shader.info.uses_discard = kind.discards;
  rig.shader.info.early_fragment_tests = kind.forced_early;
  rig.shader.body = [kind](Builder& b, StageInterface& stage) -> Result<spirv::Translation> {
    const Value lane = b.lane();
    stage.output(b, {.location = 0, .type = Type::kI32}, b.iadd(lane, b.i32(1000)));
    if (kind.writes_depth) stage.output(b, {.built_in = BuiltIn::kFragDepth}, b.f32(kShaderDepth));
    if (kind.exports_stencil)
      stage.output(b, {.built_in = BuiltIn::kFragStencilRef, .type = Type::kI32}, b.iadd(lane, b.i32(0x120)));
    if (kind.writes_mask)
      stage.output(b, {.built_in = BuiltIn::kSampleMask, .type = Type::kI32},
                   b.lshr(b.i32(kMaskPattern), b.and_(lane, b.i32(7))));
    spirv::Translation done;
    if (kind.discards) done.discarded = b.ine(b.and_(b.lshr(b.i32(kDiscardBits), lane), b.i32(1)), b.i32(0));
    return done;
  };
  return rig;
}

class Case {
 public:
  Case(std::mt19937& random, uint32_t samples, const ShaderKind& kind)
      : random_(random), n_(samples), kind_(kind), rig_(make_rig(kind)) {
    compiler::FragmentState& state = rig_.source.state;
    state.samples = samples;
    state.sample_mask = random() % 3 == 0 ? random() & 0xFFFF : 0xFFFF;
    state.equal_samples = random() % 4 != 0;
    state.color[0] = {.format = VK_FORMAT_R32_UINT, .write_mask = 0xf};
    state.color_count = 1;
    state.depth.format = VK_FORMAT_D32_SFLOAT;
    state.depth.test_enable = random() % 4 != 0;
    state.depth.write_enable = random() % 2;
    state.depth.compare = static_cast<VkCompareOp>(random() % 8);
    state.depth.bounds_test = random() % 3 == 0;
    state.stencil.test_enable = random() % 4 != 0;
    state.stencil.front = face();
    state.stencil.back = random() % 2 ? face() : state.stencil.front;
    rig_.build(eval::Mode::kF32);
    // z = 1/2 + x / 64 + y / 128 at absolute positions: exact in binary32, at samples too.
    rig_.prim.l1_dx = rig_.prim.l2_dy = 1;
    rig_.prim.z0 = 0.5f;
    rig_.prim.dz1 = 1.0f / 64;
    rig_.prim.dz2 = 1.0f / 128;
    rig_.prim.iw0 = rig_.prim.iw1 = rig_.prim.iw2 = 1;
  }

  void check() {
    prepare();
    std::vector<std::array<Sample, kMaxSamples>> want = before_;
    uint64_t passed = 0;
    for (uint32_t lane = 0; lane < kLanes; ++lane) {
      for (uint32_t s = 0; s < n_; ++s) passed += model(lane, s, want[lane][s]);
    }
    rig_.run();
    for (uint32_t lane = 0; lane < kLanes; ++lane) {
      for (uint32_t s = 0; s < n_; ++s) {
        const Sample got = read(lane, s);
        ASSERT_EQ(got.color, want[lane][s].color) << "lane " << lane << " sample " << s << " of " << n_ << describe();
        ASSERT_EQ(got.depth, want[lane][s].depth) << "lane " << lane << " sample " << s << " of " << n_;
        ASSERT_EQ(got.stencil, want[lane][s].stencil) << "lane " << lane << " sample " << s << " of " << n_;
      }
    }
    ASSERT_EQ(rig_.samples_passed, passed);
  }

 private:
  compiler::StencilFace face() {
    const auto op = [&] { return static_cast<VkStencilOp>(random_() % 8); };
    if (random_() % 4 == 0) return {.compare = static_cast<VkCompareOp>(random_() % 8)};  // no writes
    return {.fail = op(), .pass = op(), .depth_fail = op(), .compare = static_cast<VkCompareOp>(random_() % 8)};
  }

  std::string describe() const {
    const compiler::FragmentState& state = rig_.source.state;
    return " depth test " + std::to_string(state.depth.test_enable) + " write " + std::to_string(state.depth.write_enable) +
           " compare " + std::to_string(state.depth.compare) + " bounds " + std::to_string(state.depth.bounds_test) +
           " stencil test " + std::to_string(state.stencil.test_enable) + " front compare " +
           std::to_string(state.stencil.front.compare) + " writes " + std::to_string(state.stencil.writes()) + " mask " +
           std::to_string(state.sample_mask) + " equal samples " + std::to_string(state.equal_samples);
  }

  size_t index(uint32_t lane, uint32_t s) const { return s * kLanes + lane; }

  Sample read(uint32_t lane, uint32_t s) const {
    Sample out;
    const bool shared = n_ > 1 && rig_.source.state.equal_samples && rig_.equal[0];
    std::memcpy(&out.color, &rig_.color[0][index(lane, shared ? 0 : s) * 4], 4);
    std::memcpy(&out.depth, &rig_.depth[index(lane, s) * 4], 4);
    out.stencil = rig_.stencil[index(lane, s)];
    return out;
  }

  void prepare() {
    rig_.color[0].resize(n_ * 64);
    rig_.depth.resize(n_ * 64);
    rig_.stencil.resize(n_ * 16);
    rig_.equal[0] = rig_.source.state.equal_samples && random_() % 2;
    for (uint32_t i = 0; i < n_ * kLanes; ++i) {
      const uint32_t color = random_() % 100;
      const float depth = 0.5f + static_cast<float>(random_() % 8) / 64;
      std::memcpy(&rig_.color[0][i * 4], &color, 4);
      std::memcpy(&rig_.depth[i * 4], &depth, 4);
      rig_.stencil[i] = static_cast<uint8_t>(random_() % 3 == 0 ? random_() % 2 * 255 : random_());
    }
    const uint32_t full = (1u << n_) - 1, mode = random_() % 4;
    uint32_t any = 0;
    for (uint32_t lane = 0; lane < kLanes; ++lane) {
      const uint32_t mask = mode == 0 ? full : mode == 1 ? (random_() % 2 ? full : 0) : random_() & full;
      rig_.samples[lane] = static_cast<uint16_t>(mask);
      any |= (mask != 0) << lane;
    }
    rig_.wave.coverage = any;
    rig_.prim.front_facing = random_() % 2;
    DrawContext& draw = rig_.draw;
    draw.count_samples = 1;
    for (uint32_t f = 0; f < 2; ++f) {
      draw.stencil_reference[f] = random_() & 0xFF;
      draw.stencil_compare_mask[f] = random_() % 2 ? 0xFF : random_();
      draw.stencil_write_mask[f] = random_() % 2 ? 0xFF : random_();
      draw.depth_bounds[f] = 0.5f + (f ? 1 : 0) * 0.0625f + static_cast<float>(random_() % 3) / 64;
    }
    before_.resize(kLanes);
    for (uint32_t lane = 0; lane < kLanes; ++lane)
      for (uint32_t s = 0; s < n_; ++s) before_[lane][s] = read(lane, s);
  }

  // Sections 29 and 30 of the specification for one sample; whether it passed everything.
  bool model(uint32_t lane, uint32_t s, Sample& sample) const {
    const compiler::FragmentState& state = rig_.source.state;
    const bool covered = n_ == 1 ? rig_.wave.coverage >> lane & 1 : rig_.samples[lane] >> s & 1;
    if (!covered || !(state.sample_mask >> s & 1)) return false;
    bool lives = true;
    if (kind_.discards && (kDiscardBits >> lane & 1)) lives = false;
    if (kind_.writes_mask && !(kMaskPattern >> (lane & 7) >> s & 1)) lives = false;
    if (!lives && !kind_.forced_early) return false;
    const uint32_t face = rig_.prim.front_facing ? 0 : 1;
    if (state.depth.bounds_test && !(rig_.draw.depth_bounds[0] <= sample.depth && sample.depth <= rig_.draw.depth_bounds[1]))
      return false;
    const SampleLocation at = sample_locations(n_)[s];
    const float x = static_cast<float>(lane_x(lane)) + at.x / 16.0f, y = static_cast<float>(lane_y(lane)) + at.y / 16.0f;
    const bool late = !kind_.forced_early;
    const float z = kind_.writes_depth && late ? kShaderDepth : 0.5f + x / 64 + y / 128;
    const bool depth_ok = !state.depth.test_enable || passes(state.depth.compare, z, sample.depth);
    if (state.stencil.test_enable) {
      const compiler::StencilFace& ops = face ? state.stencil.back : state.stencil.front;
      const uint32_t exported = (lane + 0x120) & 0xFF;
      const uint32_t reference = kind_.exports_stencil && late ? exported : rig_.draw.stencil_reference[face] & 0xFF;
      const uint32_t mask = rig_.draw.stencil_compare_mask[face], write_mask = rig_.draw.stencil_write_mask[face];
      const bool stencil_ok = passes(ops.compare, reference & mask, sample.stencil & mask);
      const VkStencilOp op = !stencil_ok ? ops.fail : !depth_ok ? ops.depth_fail : ops.pass;
      const uint32_t fresh = stencil_result(op, sample.stencil, reference);
      sample.stencil = ((sample.stencil & ~write_mask) | (fresh & write_mask)) & 0xFF;
      if (!stencil_ok) return false;
    }
    if (!depth_ok) return false;
    if (state.depth.test_enable && state.depth.write_enable) sample.depth = z;
    if (!lives) return false;
    sample.color = 1000 + lane;
    return true;
  }

  std::mt19937& random_;
  const uint32_t n_;
  const ShaderKind kind_;
  FragmentRig rig_;
  std::vector<std::array<Sample, kMaxSamples>> before_;
};

TEST(DepthStencil, AsTheScalarModelForEverySampleCountAndShader) {
  std::mt19937 random(kSeed);
  for (const uint32_t samples : {1u, 2u, 4u, 8u, 16u}) {
    for (int i = 0; i < (samples <= 4 ? 120 : 40); ++i) {
      // Forced early tests and a depth that the shader writes exclude each other in valid programs.
      ShaderKind kind{};
      kind.forced_early = random() % 4 == 0;
      kind.writes_depth = !kind.forced_early && random() % 4 == 0;
      kind.exports_stencil = !kind.forced_early && random() % 5 == 0;
      kind.discards = random() % 3 == 0;
      kind.writes_mask = random() % 3 == 0;
      Case one(random, samples, kind);
      for (int round = 0; round < 6; ++round) one.check();
      if (HasFatalFailure()) {
        ADD_FAILURE() << "case " << i << ": early " << kind.forced_early << " depth " << kind.writes_depth << " stencil "
                      << kind.exports_stencil << " discards " << kind.discards << " mask " << kind.writes_mask;
        return;
      }
    }
  }
}

// ---- where the shader runs --------------------------------------------------------------------------------------------------

float texel_f32(const std::vector<uint8_t>& tile, size_t plane, uint32_t word, uint32_t lane) {
  float value;
  std::memcpy(&value, &tile[((plane * 4 + word) * kLanes + lane) * 4], 4);
  return value;
}

FragmentRig place_rig(uint32_t samples, spirv::InterpolationAt at, bool reads_id) {
  FragmentRig rig;
  spirv::InterfaceScalar input{.location = 0, .component = 0, .at = at};
  rig.shader.info.inputs.push_back(input);
  if (reads_id) rig.shader.info.inputs.push_back({.built_in = BuiltIn::kSampleId, .type = Type::kI32});
  rig.shader.body = [input](Builder& b, StageInterface& stage) -> Result<spirv::Translation> {
    stage.output(b, color_output(0, 0), stage.input(b, input));
    stage.output(b, color_output(0, 1), stage.input(b, {.built_in = BuiltIn::kFragCoord, .component = 0}));
    stage.output(b, color_output(0, 2), stage.input(b, {.built_in = BuiltIn::kSamplePosition, .component = 1}));
    stage.output(b, color_output(0, 3),
                 b.convert(ir::Op::kUToF, Type::kF32, stage.input(b, {.built_in = BuiltIn::kSampleMask, .type = Type::kI32})));
    return spirv::Translation{};
  };
  rig.source.state.samples = samples;
  rig.source.state.equal_samples = false;
  rig.source.state.color[0] = {.format = VK_FORMAT_R32G32B32A32_SFLOAT};
  rig.source.state.color_count = 1;
  rig.build(eval::Mode::kF32);
  // The attribute is x + 16 y.
  rig.prim.l1_dx = rig.prim.l2_dy = 1;
  rig.prim.iw0 = rig.prim.iw1 = rig.prim.iw2 = 1;
  for (uint32_t v = 0; v < 3; ++v) rig.vertices[v].assign(5 * kLanes, v == 0 ? 0.0f : v == 1 ? 1.0f : 16.0f);
  return rig;
}

TEST(SampleShading, RunsAtEachSample) {
  for (const uint32_t samples : {2u, 4u, 8u, 16u}) {
    FragmentRig rig = place_rig(samples, spirv::InterpolationAt::kCenter, true);
    ASSERT_TRUE(rig.per_sample);
    for (uint32_t s = 0; s < samples; ++s) {
      rig.wave.block_index = s;
      rig.run();
      for (uint32_t lane = 0; lane < kLanes; ++lane) {
        const double x = lane_x(lane) + sample_locations(samples)[s].x / 16.0,
                     y = lane_y(lane) + sample_locations(samples)[s].y / 16.0;
        ASSERT_EQ(texel_f32(rig.color[0], s, 0, lane), x + 16 * y);
        ASSERT_EQ(texel_f32(rig.color[0], s, 1, lane), x);
        ASSERT_EQ(texel_f32(rig.color[0], s, 2, lane), sample_locations(samples)[s].y / 16.0);
        ASSERT_EQ(texel_f32(rig.color[0], s, 3, lane), 1u << s);
      }
    }
  }
}

TEST(SampleShading, CentroidIsInsideThePrimitive) {
  std::mt19937 random(kSeed);
  for (const uint32_t samples : {2u, 4u, 8u, 16u}) {
    FragmentRig rig = place_rig(samples, spirv::InterpolationAt::kCentroid, false);
    ASSERT_FALSE(rig.per_sample);
    for (uint32_t lane = 0; lane < kLanes; ++lane) rig.samples[lane] = static_cast<uint16_t>(random() & ((1u << samples) - 1));
    rig.samples[3] = static_cast<uint16_t>((1u << samples) - 1);
    rig.run();
    for (uint32_t lane = 0; lane < kLanes; ++lane) {
      const uint32_t mask = rig.samples[lane];
      const bool centre = mask == (1u << samples) - 1;
      for (uint32_t s = 0; s < samples; ++s) {
        if (!(mask >> s & 1)) continue;
        const SampleLocation at = centre ? SampleLocation{8, 8} : sample_locations(samples)[__builtin_ctz(mask)];
        ASSERT_EQ(texel_f32(rig.color[0], s, 0, lane), lane_x(lane) + at.x / 16.0 + 16 * (lane_y(lane) + at.y / 16.0));
        ASSERT_EQ(texel_f32(rig.color[0], s, 1, lane), lane_x(lane) + 0.5);
        ASSERT_EQ(texel_f32(rig.color[0], s, 3, lane), mask);
      }
    }
  }
}

TEST(AlphaToCoverage, RoundsToTheNearestNumberOfSamples) {
  for (const uint32_t samples : {1u, 2u, 4u, 8u, 16u}) {
    FragmentRig rig = FragmentRig::with([](Builder& b, StageInterface& stage) {
      const Value alpha = b.fmul(b.convert(ir::Op::kSToF, Type::kF32, b.isub(b.lane(), b.i32(1))), b.f32(1.0 / 13));
      stage.output(b, color_output(0, 0), b.f32(1));
      stage.output(b, color_output(0, 3), alpha);
    });
    rig.source.state.samples = samples;
    rig.source.state.alpha_to_coverage = rig.source.state.alpha_to_one = true;
    rig.source.state.color[0] = {.format = VK_FORMAT_R8G8B8A8_UNORM};
    rig.source.state.color_count = 1;
    rig.build(eval::Mode::kF32);
    rig.color[0].assign(samples * 64, 0);
    rig.samples.fill(static_cast<uint16_t>((1u << samples) - 1));
    rig.run();
    for (uint32_t lane = 0; lane < kLanes; ++lane) {
      const double alpha = std::clamp((static_cast<int>(lane) - 1) / 13.0, 0.0, 1.0);
      const auto count = static_cast<uint32_t>(std::floor(alpha * samples + 0.5));
      for (uint32_t s = 0; s < samples; ++s) {
        uint32_t texel;
        std::memcpy(&texel, &rig.color[0][(s * kLanes + lane) * 4], 4);
        ASSERT_EQ(texel, s < count ? 0xFF0000FFu : 0u) << "lane " << lane << " sample " << s << " of " << samples;
      }
    }
  }
}

// ---- resolve ----------------------------------------------------------------------------------------------------------------

TEST(Resolve, AveragesEveryColourFormat) {
  std::mt19937 random(kSeed);
  for (const FormatInfo* format : all_formats()) {
    if (!(format->uses & kUseColor)) continue;
    for (const uint32_t samples : {2u, 4u, 8u, 16u}) {
      if (samples > 4 && random() % 8 != 0) continue;
      Result<ir::Kernel> built = build_resolve(format->format, samples, VK_RESOLVE_MODE_AVERAGE_BIT);
      ASSERT_TRUE(built);
      const ir::Kernel kernel = optimized(std::move(*built), eval::Mode::kF32);
      const Runner runner(kernel, eval::Mode::kF32);
      // Texels of one, two or four words: planes of 16.
      const uint32_t bytes = format->texel_bytes, element = std::min(bytes, 4u);
      std::vector<uint8_t> from(samples * kLanes * bytes), to(kLanes * bytes);
      std::vector<std::array<uint8_t, 16>> texels(samples * kLanes);
      for (uint32_t s = 0; s < samples; ++s) {
        for (uint32_t lane = 0; lane < kLanes; ++lane) {
          auto& texel = texels[s * kLanes + lane];
          VkClearColorValue color;
          for (uint32_t c = 0; c < 4; ++c) {
            if (format->is_integer())
              color.uint32[c] = random();
            else
              color.float32[c] = static_cast<float>(random() / 0x1p31 - (format->numeric == Numeric::kSnorm ? 1 : 0.5));
          }
          if (lane == 0 && s > 0) {
            texel = texels[0];  // equal samples
          } else {
            pack_clear_color(*format, color, texel.data());
          }
          for (uint32_t i = 0; i < bytes; ++i)
            from[(s * (bytes / element) + i / element) * kLanes * element + lane * element + i % element] = texel[i];
        }
      }
      ThreadContext thread{};
      thread.color[0] = from.data();
      thread.color[1] = to.data();
      DrawContext draw{};
      set_srgb_tables(draw);
      const FragmentWave wave{.exec_mask = 0xFFFF, .coverage = 0xFFFF};
      const PrimRecord record{nullptr, 0, 1};
      runner.run(&draw, &thread, &record, 1, &wave);
      for (uint32_t lane = 0; lane < kLanes; ++lane) {
        uint8_t got[16] = {};
        for (uint32_t i = 0; i < bytes; ++i) got[i] = to[i / element * kLanes * element + lane * element + i % element];
        if (lane == 0 || format->is_integer()) {
          ASSERT_EQ(std::memcmp(got, texels[lane].data(), bytes), 0) << format->name << " lane " << lane;
          continue;
        }
        for (uint32_t c = 0; c < 4; ++c) {
          if (format->component[c].bits == 0) continue;
          double sum = 0;
          for (uint32_t s = 0; s < samples; ++s)
            sum += decode_reference(*format, c, code_of(*format, c, texels[s * kLanes + lane].data()));
          const double mean = sum / samples, value = decode_reference(*format, c, code_of(*format, c, got));
          // Half a step of the format: a code, or half an ulp of values below 2.
          const uint32_t bits = format->component[c].bits;
          const bool encoded = format->numeric == Numeric::kSrgb && c < 3;
          const double step = encoded                               ? 0.0091  // the steepest step of the curve's inverse
                              : format->numeric == Numeric::kUfloat ? (bits == 11 ? 0x1p-6 : 0x1p-5)
                              : format->is_float()                  ? (bits == 16 ? 0x1p-10 : 0x1p-23)
                              : format->numeric == Numeric::kSnorm  ? 1 / (std::ldexp(1.0, bits - 1) - 1)
                                                                    : 1 / (std::ldexp(1.0, bits) - 1);
          ASSERT_LE(std::fabs(value - mean), step * 0.5 * (1 + 1e-6)) << format->name << " component " << c << " of " << samples;
        }
      }
    }
  }
}

}  // namespace
}  // namespace pineda::kernels::test
