// Blending: every factor pair and operation against the specification's equations in double precision.
#include <bit>
#include <cmath>

#include "compiler/kernels/test_rig.h"

namespace pineda::kernels::test {
namespace {

using compiler::BlendState;
using ir::Builder;
using ir::Type;
using ir::Value;
using spirv::Interpolation;
using spirv::StageInterface;

using Color = std::array<double, 4>;

Color clamped(const FormatInfo& format, Color c) {
  if (format.is_float()) return c;
  for (double& x : c) x = std::clamp(x, 0.0, 1.0);
  return c;
}

double factor(VkBlendFactor f, uint32_t c, const Color& s, const Color& d, const Color& k) {
  switch (f) {
    case VK_BLEND_FACTOR_ZERO:
      return 0;
    case VK_BLEND_FACTOR_ONE:
      return 1;
    case VK_BLEND_FACTOR_SRC_COLOR:
      return s[c];
    case VK_BLEND_FACTOR_ONE_MINUS_SRC_COLOR:
      return 1 - s[c];
    case VK_BLEND_FACTOR_DST_COLOR:
      return d[c];
    case VK_BLEND_FACTOR_ONE_MINUS_DST_COLOR:
      return 1 - d[c];
    case VK_BLEND_FACTOR_SRC_ALPHA:
      return s[3];
    case VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA:
      return 1 - s[3];
    case VK_BLEND_FACTOR_DST_ALPHA:
      return d[3];
    case VK_BLEND_FACTOR_ONE_MINUS_DST_ALPHA:
      return 1 - d[3];
    case VK_BLEND_FACTOR_CONSTANT_COLOR:
      return k[c];
    case VK_BLEND_FACTOR_ONE_MINUS_CONSTANT_COLOR:
      return 1 - k[c];
    case VK_BLEND_FACTOR_CONSTANT_ALPHA:
      return k[3];
    case VK_BLEND_FACTOR_ONE_MINUS_CONSTANT_ALPHA:
      return 1 - k[3];
    default:
      return c == 3 ? 1 : std::min(s[3], 1 - d[3]);
  }
}

double blend_reference(const BlendState& state, uint32_t c, const Color& s, const Color& d, const Color& k) {
  const VkBlendOp op = c == 3 ? state.alpha_op : state.color_op;
  const double sf = factor(c == 3 ? state.src_alpha : state.src_color, c, s, d, k);
  const double df = factor(c == 3 ? state.dst_alpha : state.dst_color, c, s, d, k);
  switch (op) {
    case VK_BLEND_OP_ADD:
      return s[c] * sf + d[c] * df;
    case VK_BLEND_OP_SUBTRACT:
      return s[c] * sf - d[c] * df;
    case VK_BLEND_OP_REVERSE_SUBTRACT:
      return d[c] * df - s[c] * sf;
    case VK_BLEND_OP_MIN:
      return std::min(s[c], d[c]);
    default:
      return std::max(s[c], d[c]);
  }
}

// A component's distance from its reference, in codes (fixed point) or relative to the terms' size (float formats).
double distance(const FormatInfo& format, uint32_t c, uint32_t code, double want) {
  if (format.is_float()) {
    const double got = decode_reference(format, c, code);
    return std::fabs(got - (format.numeric == Numeric::kUfloat ? std::max(want, 0.0) : want));
  }
  want = std::clamp(want, 0.0, 1.0);
  const bool encoded = format.numeric == Numeric::kSrgb && c < 3;
  const double scale = std::ldexp(1.0, format.component[c].bits) - 1;
  if (encoded) want = want <= 0.0031308 ? 12.92 * want : 1.055 * std::pow(want, 1 / 2.4) - 0.055;
  return std::fabs(code - want * scale);
}

// Half a code is rounding to the format; the rest is binary32 arithmetic: 2^-24 of 1 is 2^-14 codes of 10 bits, the sRGB curve is
// up to 12.92 steep.
double limit(const FormatInfo& format) {
  if (!format.is_float()) return 0.5 + (format.component[0].bits > 10 ? 0x1p-6 : 0x1p-12);
  if (format.numeric == Numeric::kUfloat) return 0x1p-4 + 0x1p-20;  // 5 mantissa bits: an ulp is 2^-3 below 8
  return format.component[0].bits == 16 ? 0x1p-8 : 0x1p-20;         // values of at most 8: an ulp of binary16 is 2^-8 there
}

class BlendRig {
 public:
  BlendRig(const FormatInfo& format, const BlendState& state)
      : format_(format), state_(state), rig_(FragmentRig::with([](Builder& b, StageInterface& stage) {
          for (uint32_t c = 0; c < 4; ++c) {  // a colour that differs from lane to lane: push constants [lane * 4 + c]
            const auto buffer = stage.buffer(b, StageInterface::kPushConstants, 0, {});
            const Value offset = b.iadd(b.shl(b.lane(), b.i32(4)), b.i32(4 * c));
            stage.output(b, color_output(0, c), b.load(Type::kF32, {.base = buffer->base, .offset = offset}));
          }
        })) {
    rig_.layout.push_constant_bytes = 256;
    rig_.source.state.color[0] = state;
    rig_.source.state.color_count = 1;
    rig_.build(eval::Mode::kF32);
  }

  void check(std::mt19937& random) {
    const bool floats = format_.is_float();
    const auto number = [&] { return static_cast<float>(random() / 0x1p32 * (floats ? 4 : 1.3) - (floats ? 2 : 0.15)); };
    Color constant;
    for (uint32_t c = 0; c < 4; ++c) constant[c] = rig_.draw.blend_constants[c] = number();
    constant = clamped(format_, constant);
    std::array<Color, kLanes> source, before;
    std::vector<uint8_t> texels(16 * format_.texel_bytes);
    for (uint32_t lane = 0; lane < kLanes; ++lane) {
      VkClearColorValue old;
      for (uint32_t c = 0; c < 4; ++c) {
        const float value = random() % 8 == 0 ? static_cast<float>(random() % 2) : number();
        source[lane][c] = value;
        std::memcpy(rig_.draw.push_constants + lane * 16 + c * 4, &value, 4);
        old.float32[c] = number();
      }
      source[lane] = clamped(format_, source[lane]);
      uint8_t* texel = &texels[lane * format_.texel_bytes];
      pack_clear_color(format_, old, texel);
      for (uint32_t c = 0; c < 4; ++c) before[lane][c] = decode_reference(format_, c, code_of(format_, c, texel));
    }
    rig_.color[0] = to_planes(texels);
    rig_.run();
    const std::vector<uint8_t> after = from_planes(rig_.color[0]);
    for (uint32_t lane = 0; lane < kLanes; ++lane) {
      const uint8_t* texel = &after[lane * format_.texel_bytes];
      for (uint32_t c = 0; c < 4; ++c) {
        if (format_.component[c].bits == 0) continue;
        const uint32_t code = code_of(format_, c, texel);
        if (!(state_.write_mask >> c & 1)) {
          ASSERT_EQ(code, code_of(format_, c, &texels[lane * format_.texel_bytes]));
          continue;
        }
        const double want =
            state_.blend_enable ? blend_reference(state_, c, source[lane], before[lane], constant) : source[lane][c];
        ASSERT_LE(distance(format_, c, code, want), limit(format_))
            << format_.name << " component " << c << " factors " << state_.src_color << " " << state_.dst_color << " op "
            << state_.color_op;
      }
    }
  }

 private:
  // 64- and 128-bit texels lie in planes of 32-bit words.
  std::vector<uint8_t> to_planes(const std::vector<uint8_t>& texels) const { return permuted(texels, true); }
  std::vector<uint8_t> from_planes(const std::vector<uint8_t>& tile) const { return permuted(tile, false); }
  std::vector<uint8_t> permuted(const std::vector<uint8_t>& in, bool to_tile) const {
    std::vector<uint8_t> out(in.size());
    const uint32_t element = std::min<uint32_t>(format_.texel_bytes, 4);
    for (uint32_t lane = 0; lane < kLanes; ++lane) {
      for (uint32_t i = 0; i < format_.texel_bytes; ++i) {
        const size_t texel_at = lane * format_.texel_bytes + i, tile_at = (i / element * kLanes + lane) * element + i % element;
        out[to_tile ? tile_at : texel_at] = in[to_tile ? texel_at : tile_at];
      }
    }
    return out;
  }

  const FormatInfo& format_;
  const BlendState state_;
  FragmentRig rig_;
};

constexpr int kFactors = VK_BLEND_FACTOR_SRC_ALPHA_SATURATE + 1;
constexpr int kOps = VK_BLEND_OP_MAX + 1;

BlendState blend(VkFormat format, int src, int dst, int op) {
  BlendState state{.format = format, .blend_enable = true};
  state.src_color = static_cast<VkBlendFactor>(src);
  state.dst_color = static_cast<VkBlendFactor>(dst);
  state.color_op = static_cast<VkBlendOp>(op);
  // Alpha takes another combination, so that all of them are seen there too.
  state.src_alpha = static_cast<VkBlendFactor>((dst + 4) % kFactors);
  state.dst_alpha = static_cast<VkBlendFactor>((src + 7) % kFactors);
  state.alpha_op = static_cast<VkBlendOp>((op + 2) % kOps);
  return state;
}

TEST(Blend, EveryFactorPairAndOperation) {
  std::mt19937 random(kSeed);
  for (int op = 0; op < kOps; ++op) {
    for (int src = 0; src < kFactors; ++src) {
      for (int dst = 0; dst < kFactors; ++dst) {
        if (op >= VK_BLEND_OP_MIN && src + dst > 0) continue;  // factors do not matter
        BlendRig rig(*find_format(VK_FORMAT_R8G8B8A8_UNORM), blend(VK_FORMAT_R8G8B8A8_UNORM, src, dst, op));
        for (int round = 0; round < 4; ++round) rig.check(random);
        if (HasFatalFailure()) return;
      }
    }
  }
}

TEST(Blend, EveryBlendableFormat) {
  std::mt19937 random(kSeed);
  for (const FormatInfo* format : all_formats()) {
    if (!(format->uses & kUseBlend)) continue;
    for (int i = 0; i < 12; ++i) {
      BlendState state = blend(format->format, random() % kFactors, random() % kFactors, random() % kOps);
      if (i == 0) state = blend(format->format, VK_BLEND_FACTOR_SRC_ALPHA, VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA, VK_BLEND_OP_ADD);
      if (i == 1) state.blend_enable = false;
      if (i % 3 == 2) state.write_mask = random() % 16;
      BlendRig rig(*format, state);
      for (int round = 0; round < 8; ++round) rig.check(random);
      if (HasFatalFailure()) return;
    }
  }
}

TEST(Blend, DualSourceIsAnError) {
  FragmentRig rig = FragmentRig::with([](Builder& b, StageInterface& stage) { stage.output(b, color_output(0, 0), b.f32(1)); });
  rig.source.state.color[0] = blend(VK_FORMAT_R8G8B8A8_UNORM, VK_BLEND_FACTOR_SRC1_COLOR, 0, 0);
  rig.source.state.color_count = 1;
  EXPECT_FALSE(build_fragment(rig.source, &rig.shader));
}

}  // namespace
}  // namespace pineda::kernels::test
