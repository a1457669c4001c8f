// Blending: every factor pair and operation against the specification's equations in double precision.
#include "cts-subset/reference/blend.h"

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

double lowest(const FormatInfo& format) { return format.numeric == Numeric::kSnorm ? -1 : 0; }

Color clamped(const FormatInfo& format, Color c) {
  if (format.is_float()) return c;
  for (double& x : c) x = std::clamp(x, lowest(format), 1.0);
  return c;
}

// The second source of dual-source blending, from the first.
Color second_source(const Color& s) { return {s[1] * 0.5, s[2] * 0.5, s[3] * 0.5, s[0] * 0.5}; }

double blend_reference(const FormatInfo& format, const BlendState& state, uint32_t c, const Color& s, const Color& s1,
                       const Color& d, const Color& k) {
  const auto in_range = [&](double f) { return format.is_float() ? f : std::clamp(f, lowest(format), 1.0); };
  const VkBlendOp op = c == 3 ? state.alpha_op : state.color_op;
  const auto factor = [&](VkBlendFactor f) { return in_range(cts::blend_factor(f, c, s, s1, d, k)); };
  return cts::blended(op, s[c], factor(c == 3 ? state.src_alpha : state.src_color), d[c],
                      factor(c == 3 ? state.dst_alpha : state.dst_color));
}

// A component's distance from its reference, in codes (fixed point) or relative to the terms' size (float formats).
double distance(const FormatInfo& format, uint32_t c, uint32_t code, double want) {
  if (format.is_float()) {
    const double got = decode_reference(format, c, code);
    return std::fabs(got - (format.numeric == Numeric::kUfloat ? std::max(want, 0.0) : want));
  }
  want = std::clamp(want, lowest(format), 1.0);
  if (format.numeric == Numeric::kSnorm)
    return std::fabs(decode_reference(format, c, code) - want) * (std::ldexp(1.0, format.component[c].bits - 1) - 1);
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
  return format.component[0].bits == 16 ? 0x1p-8 : 0x1p-19;         // values of at most 16 in binary32, of 8 in binary16
}

class BlendRig {
 public:
  BlendRig(const FormatInfo& format, const BlendState& state)
      : format_(format), state_(state), rig_(FragmentRig::with([](Builder& b, StageInterface& stage) {
          for (uint32_t c = 0; c < 4; ++c) {  // a colour that differs from lane to lane: push constants [lane * 4 + c]
            const auto buffer = stage.buffer(b, StageInterface::kPushConstants, 0, {});
            const Value offset = b.iadd(b.shl(b.lane(), b.i32(4)), b.i32(4 * c));
            const Value value = b.load(Type::kF32, {.base = buffer->base, .offset = offset});
            stage.output(b, color_output(0, c), value);
            spirv::InterfaceScalar second = color_output(0, (c + 3) % 4);
            second.index = 1;
            stage.output(b, second, b.fmul(value, b.f32(0.5)));
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
    std::array<Color, kLanes> source, second, before;
    std::vector<uint8_t> texels(16 * format_.texel_bytes);
    for (uint32_t lane = 0; lane < kLanes; ++lane) {
      VkClearColorValue old;
      for (uint32_t c = 0; c < 4; ++c) {
        const float value = random() % 8 == 0 ? static_cast<float>(random() % 2) : number();
        source[lane][c] = value;
        std::memcpy(rig_.draw.push_constants + lane * 16 + c * 4, &value, 4);
        old.float32[c] = number();
      }
      second[lane] = clamped(format_, second_source(source[lane]));
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
        const double want = state_.blend_enable
                                ? blend_reference(format_, state_, c, source[lane], second[lane], before[lane], constant)
                                : source[lane][c];
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

constexpr int kFactors = VK_BLEND_FACTOR_ONE_MINUS_SRC1_ALPHA + 1;
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
    for (int i = 0; i < 2 * kFactors; ++i) {  // every factor on either side
      const int other = static_cast<int>(random() % kFactors);
      BlendState state = blend(format->format, i < kFactors ? i : other, i < kFactors ? other : i - kFactors, i % kOps);
      if (i == 0) state = blend(format->format, VK_BLEND_FACTOR_SRC_ALPHA, VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA, VK_BLEND_OP_ADD);
      if (i == 1) state.blend_enable = false;
      if (i % 3 == 2) state.write_mask = random() % 16;
      BlendRig rig(*format, state);
      for (int round = 0; round < 3; ++round) rig.check(random);
      if (HasFatalFailure()) return;
    }
  }
}

uint32_t logic_reference(VkLogicOp op, uint32_t s, uint32_t d) {
  // A logical operation is its truth table: bit 2 * s + d of these numbers (the specification's table, row by row).
  constexpr uint32_t kTables[] = {0b0000, 0b1000, 0b0100, 0b1100, 0b0010, 0b1010, 0b0110, 0b1110,
                                  0b0001, 0b1001, 0b0101, 0b1101, 0b0011, 0b1011, 0b0111, 0b1111};
  uint32_t result = 0;
  for (uint32_t bit = 0; bit < 32; ++bit) {
    const uint32_t index = (s >> bit & 1) * 2 + (d >> bit & 1);
    result |= (kTables[op] >> index & 1) << bit;
  }
  return result;
}

TEST(Blend, LogicOperationsOnCodes) {
  std::mt19937 random(kSeed);
  for (const VkFormat format_name :
       {VK_FORMAT_R8G8B8A8_UNORM, VK_FORMAT_R8G8_SNORM, VK_FORMAT_R16_UINT, VK_FORMAT_R32_SINT, VK_FORMAT_A2B10G10R10_UINT_PACK32,
        VK_FORMAT_R5G6B5_UNORM_PACK16, VK_FORMAT_R8G8B8A8_SRGB, VK_FORMAT_R32_SFLOAT}) {
    const FormatInfo& format = *find_format(format_name);
    for (int op = 0; op <= VK_LOGIC_OP_SET; ++op) {
      FragmentRig rig = FragmentRig::with([&](Builder& b, StageInterface& stage) {
        for (uint32_t c = 0; c < 4; ++c)
          stage.output(b, color_output(0, c), format.is_integer() ? b.i32(0x1b5u * (c + 3)) : b.f32(0.25 * c + 0.1));
      });
      rig.source.state.color[0] = {.format = format_name, .blend_enable = true};  // "blending is disabled"
      rig.source.state.color_count = 1;
      rig.source.state.logic_op = static_cast<VkLogicOp>(op);
      rig.build(eval::Mode::kF32);
      std::vector<uint8_t> before(16 * format.texel_bytes);
      for (uint8_t& byte : before) byte = static_cast<uint8_t>(random());
      rig.color[0] = before;
      rig.run();
      VkClearColorValue color;
      for (uint32_t c = 0; c < 4; ++c) {
        if (format.is_integer())
          color.uint32[c] = 0x1b5u * (c + 3);
        else
          color.float32[c] = static_cast<float>(0.25 * c + 0.1);
      }
      uint8_t source[16] = {};
      pack_clear_color(format, color, source);
      const bool passes = format.numeric == Numeric::kSrgb || format.is_float();
      for (uint32_t lane = 0; lane < kLanes; ++lane) {
        for (uint32_t c = 0; c < 4; ++c) {
          const uint32_t bits = format.component[c].bits;
          if (bits == 0) continue;
          const uint32_t s = code_of(format, c, source), d = code_of(format, c, &before[lane * format.texel_bytes]);
          const uint32_t all = bits == 32 ? ~0u : (1u << bits) - 1;
          const uint32_t want = passes ? s : logic_reference(static_cast<VkLogicOp>(op), s, d) & all;
          ASSERT_EQ(code_of(format, c, &rig.color[0][lane * format.texel_bytes]), want) << format.name << " operation " << op;
        }
      }
    }
  }
}

}  // namespace
}  // namespace pineda::kernels::test
