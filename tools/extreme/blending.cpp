#include <algorithm>
#include <cmath>
#include <random>

#include "tools/error.h"
#include "tools/extreme/rig.h"

namespace pineda::tools {
namespace {

// One component of a format: how its codes are read, and which numbers it can hold.
struct Component {
  VkFormat format;
  uint32_t bytes_per_pixel;
  int fixed_bits = 0;     // UNORM; else
  int mantissa_bits = 0;  // of a float, the hidden one included
  bool has_sign = true;
  bool srgb = false;

  double decode(const std::byte* pixel) const;
  double round_down(double value) const;
  double round_up(double value) const;
  double nearest(double value) const;

 private:
  double spacing(double value) const {
    if (fixed_bits) return 1.0 / ((1 << fixed_bits) - 1);
    int exponent = 0;
    std::frexp(value, &exponent);
    const int least = mantissa_bits == 24 ? -149 : 1 - 14 - mantissa_bits;  // binary16 and its unsigned relatives: 2^-14
    return std::ldexp(1.0, std::max(exponent - mantissa_bits, least));
  }
  double limit(double value) const { return fixed_bits ? std::clamp(value, 0.0, 1.0) : has_sign ? value : std::max(value, 0.0); }
};

double half(uint32_t bits, int mantissa_bits) {  // no sign; mantissa_bits without the hidden one
  const int exponent = static_cast<int>(bits >> mantissa_bits);
  const double fraction = static_cast<double>(bits & ((1u << mantissa_bits) - 1)) / (1 << mantissa_bits);
  return exponent == 0 ? std::ldexp(fraction, -14) : std::ldexp(1 + fraction, exponent - 15);
}

// The first component (red) of a pixel.
double Component::decode(const std::byte* pixel) const {
  uint32_t word = 0;
  std::memcpy(&word, pixel, std::min<size_t>(bytes_per_pixel, 4));
  switch (format) {
    case VK_FORMAT_R5G6B5_UNORM_PACK16:
      return (word >> 11 & 31) / 31.0;
    case VK_FORMAT_A2B10G10R10_UNORM_PACK32:
      return (word & 1023) / 1023.0;
    case VK_FORMAT_R16G16B16A16_UNORM:
      return (word & 65535) / 65535.0;
    case VK_FORMAT_R16G16B16A16_SFLOAT:
      return (word & 0x8000 ? -1 : 1) * half(word & 0x7FFF, 10);
    case VK_FORMAT_B10G11R11_UFLOAT_PACK32:
      return half(word & 2047, 6);
    case VK_FORMAT_R32G32B32A32_SFLOAT: {
      float value;
      std::memcpy(&value, pixel, sizeof value);
      return value;
    }
    default: {
      const double code = (word & 255) / 255.0;
      if (!srgb) return code;
      return code <= 0.04045 ? code / 12.92 : std::pow((code + 0.055) / 1.055, 2.4);
    }
  }
}

double Component::round_down(double value) const {
  if (srgb) return value;  // not used
  const double step = spacing(value);
  return limit(std::floor(value / step) * step);
}
double Component::round_up(double value) const {
  const double step = spacing(value);
  return limit(std::ceil(value / step) * step);
}
double Component::nearest(double value) const {
  const double step = spacing(value);
  return limit(std::nearbyint(value / step) * step);
}

constexpr Component kR8{VK_FORMAT_R8G8B8A8_UNORM, 4, 8};
constexpr Component k565{VK_FORMAT_R5G6B5_UNORM_PACK16, 2, 5};
constexpr Component k1010102{VK_FORMAT_A2B10G10R10_UNORM_PACK32, 4, 10};
constexpr Component kR16{VK_FORMAT_R16G16B16A16_UNORM, 8, 16};
constexpr Component kF16{VK_FORMAT_R16G16B16A16_SFLOAT, 8, 0, 11};
constexpr Component kF11{VK_FORMAT_B10G11R11_UFLOAT_PACK32, 4, 0, 7, false};
constexpr Component kF32{VK_FORMAT_R32G32B32A32_SFLOAT, 16, 0, 24};

struct Layer {
  float colour, alpha;
};

// Every layer over the whole picture, in one draw; the picture's pixels agree or the case is wrong.
struct Chain {
  double result = 0;
  bool uniform = true;
  std::string bytes;
};

Chain draw_chain(ExtremeRig& rig, const Component& component, std::span<const Layer> layers, RigBlend blend, float clear) {
  RigDraw draw{.blend = blend};
  for (const Layer& layer : layers) {
    const std::vector<RigVertex> quad = rectangle(-1, -1, 1, 1, 0, {layer.colour, layer.colour, layer.colour, layer.alpha});
    draw.vertices.insert(draw.vertices.end(), quad.begin(), quad.end());
  }
  const RigTarget target{.extent = {8, 8},
                         .colour = component.format,
                         .bytes_per_pixel = component.bytes_per_pixel,
                         .clear_colour = {clear, clear, clear, clear}};
  const std::vector<std::byte> bytes = rig.draw(target, std::span(&draw, 1));
  Chain chain{component.decode(bytes.data()), true, bytes_of(bytes)};
  for (size_t at = component.bytes_per_pixel; at < bytes.size(); at += component.bytes_per_pixel) {
    chain.uniform &= std::memcmp(bytes.data(), bytes.data() + at, component.bytes_per_pixel) == 0;
  }
  return chain;
}

Outcome judge(const Chain& chain, double nearest, double low, double high, double real) {
  const bool within = chain.uniform && chain.result >= low && chain.result <= high;
  return {.verdict = chain.uniform && chain.result == nearest ? Verdict::kExact
                     : within                                 ? Verdict::kWithin
                                                              : Verdict::kWrong,
          .measured = fmt::format("{:.9g}{}", chain.result, chain.uniform ? "" : ", and other pixels differ"),
          .truth = fmt::format("{:.9g} when each layer is rounded to nearest; {:.9g} in real numbers", nearest, real),
          .bound = fmt::format("{:.9g} to {:.9g}: each layer rounded down, or up", low, high),
          .bytes = chain.bytes};
}

// 1,000 translucent layers.
Outcome over_chain(ExtremeRig& rig, const Component& component) {
  if (!rig.has_format(component.format, VK_FORMAT_FEATURE_COLOR_ATTACHMENT_BLEND_BIT)) return {};
  std::mt19937 random(4711);
  std::vector<Layer> layers;
  for (int i = 0; i < 1000; ++i) {
    // Alphas of 1/64 to 1/2 in 1/1024: binary32 holds them and 1 - alpha exactly.
    const float alpha = static_cast<float>(16 + random() % 497) / 1024, colour = static_cast<float>(random() % 1025) / 1024;
    layers.push_back({colour, alpha});
  }
  // Beside the format's rounding there is that of the arithmetic: at least the format's precision (Blending); binary32 here.
  constexpr double kArithmetic = 4 * 0x1p-24;
  double nearest = component.nearest(0.25), low = nearest, high = nearest, real = 0.25;
  for (const Layer& layer : layers) {
    const auto step = [&](double value) { return double{layer.colour} * layer.alpha + value * (1 - double{layer.alpha}); };
    nearest = component.nearest(step(nearest));
    low = component.round_down(step(low) - kArithmetic);
    high = component.round_up(step(high) + kArithmetic);
    real = step(real);
  }
  return judge(draw_chain(rig, component, layers, kOver, 0.25f), nearest, low, high, real);
}

Outcome over_r8(ExtremeRig& rig) { return over_chain(rig, kR8); }
Outcome over_565(ExtremeRig& rig) { return over_chain(rig, k565); }
Outcome over_1010102(ExtremeRig& rig) { return over_chain(rig, k1010102); }
Outcome over_r16(ExtremeRig& rig) { return over_chain(rig, kR16); }
Outcome over_f16(ExtremeRig& rig) { return over_chain(rig, kF16); }
Outcome over_f11(ExtremeRig& rig) { return over_chain(rig, kF11); }

// In binary32 each operation rounds: the exact value is that of IEEE 754's operations in the order of the formula.
Outcome over_f32(ExtremeRig& rig) {
  if (!rig.has_format(kF32.format, VK_FORMAT_FEATURE_COLOR_ATTACHMENT_BLEND_BIT)) return {};
  std::mt19937 random(4711);
  std::vector<Layer> layers;
  for (int i = 0; i < 1000; ++i) {
    const float alpha = static_cast<float>(random() >> 8) / 0x1p25f, colour = static_cast<float>(random() >> 8) / 0x1p24f;
    layers.push_back({colour, alpha});
  }
  float nearest = 0.25f;
  double real = 0.25, bound = 0;
  for (const Layer& layer : layers) {
    const float source = layer.colour * layer.alpha, rest = 1 - layer.alpha, destination = nearest * rest;
    nearest = source + destination;
    real = double{layer.colour} * layer.alpha + real * (1 - double{layer.alpha});
    bound = bound * (1 - double{layer.alpha}) + 4 * 0x1p-24;
  }
  return judge(draw_chain(rig, kF32, layers, kOver, 0.25f), nearest, real - bound, real + bound, real);
}

// sRGB: blended in linear space, stored in codes.
Outcome over_srgb(ExtremeRig& rig) {
  constexpr Component kSrgb{VK_FORMAT_R8G8B8A8_SRGB, 4, 8, 0, true, true};
  if (!rig.has_format(kSrgb.format, VK_FORMAT_FEATURE_COLOR_ATTACHMENT_BLEND_BIT)) return {};
  const auto decode = [](double code) {
    const double c = code / 255;
    return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
  };
  const auto encode = [](double linear) {
    const double c = std::clamp(linear, 0.0, 1.0);
    return 255 * (c <= 0.0031308 ? 12.92 * c : 1.055 * std::pow(c, 1 / 2.4) - 0.055);
  };
  std::mt19937 random(99);
  std::vector<Layer> layers;
  for (int i = 0; i < 1000; ++i)
    layers.push_back({static_cast<float>(random() % 1025) / 1024, static_cast<float>(16 + random() % 497) / 1024});
  // The transfer function's own error: half a code and a little ("sRGB EOTF", Khronos Data Format).
  constexpr double kTransfer = 0.1;
  double nearest = std::nearbyint(encode(0.25)), low = nearest, high = nearest, real = 0.25;
  for (const Layer& layer : layers) {
    const auto step = [&](double linear) { return double{layer.colour} * layer.alpha + linear * (1 - double{layer.alpha}); };
    nearest = std::nearbyint(encode(step(decode(nearest))));
    low = std::max(0.0, std::floor(encode(step(decode(low))) - kTransfer));
    high = std::min(255.0, std::ceil(encode(step(decode(high))) + kTransfer));
    real = step(real);
  }
  const Chain chain = draw_chain(rig, kSrgb, layers, kOver, 0.25f);
  return judge(chain, decode(nearest), decode(low) - 1e-12, decode(high) + 1e-12, real);
}

// ---- accumulation
// ------------------------------------------------------------------------------------------------------------------

Outcome accumulate(ExtremeRig& rig, const Component& component, float term, int count, float start) {
  if (!rig.has_format(component.format, VK_FORMAT_FEATURE_COLOR_ATTACHMENT_BLEND_BIT)) return {};
  const std::vector<Layer> layers(static_cast<size_t>(count), Layer{term, 1});
  double nearest = start, low = start, high = start;
  for (int i = 0; i < count; ++i) {
    nearest = component.nearest(nearest + term);
    low = component.round_down(low + term);
    high = component.round_up(high + term);
  }
  return judge(draw_chain(rig, component, layers, kAdditive, start), nearest, low, high, start + double{term} * count);
}

Outcome ones_f16(ExtremeRig& rig) { return accumulate(rig, kF16, 1, 3000, 0); }
Outcome tenths_f16(ExtremeRig& rig) { return accumulate(rig, kF16, 0.1f, 1000, 0); }
Outcome tenths_f32(ExtremeRig& rig) { return accumulate(rig, kF32, 0.1f, 1000, 0); }
Outcome small_on_large_f32(ExtremeRig& rig) { return accumulate(rig, kF32, 0.75f, 1000, 0x1p24f); }
Outcome saturate_r8(ExtremeRig& rig) { return accumulate(rig, kR8, 0.3f, 1000, 0); }

Outcome cancel_f32(ExtremeRig& rig) {  // (2^24 + 1.5) - 2^24: the 1.5 became 2
  if (!rig.has_format(kF32.format, VK_FORMAT_FEATURE_COLOR_ATTACHMENT_BLEND_BIT)) return {};
  const Layer layers[] = {{1.5f, 1}, {-0x1p24f, 1}};
  return judge(draw_chain(rig, kF32, layers, kAdditive, 0x1p24f), 2, 0, 2, 1.5);
}

constexpr const char* kBlending =
    "Vulkan 1.3, Blending: as with the precision of the attachment's format or more, then converted";
constexpr const char* kIeee = "IEEE 754 addition; Vulkan 1.3, Blending";

constexpr ExtremeCase kCases[] = {
    {"blending", "1,000 layers in R8G8B8A8_UNORM", "Translucent layers, source over destination", kBlending, over_r8},
    {"blending", "1,000 layers in R5G6B5_UNORM", "The same in 5 bits", kBlending, over_565},
    {"blending", "1,000 layers in A2B10G10R10_UNORM", "The same in 10 bits", kBlending, over_1010102},
    {"blending", "1,000 layers in R16G16B16A16_UNORM", "The same in 16 bits", kBlending, over_r16},
    {"blending", "1,000 layers in R8G8B8A8_SRGB", "Blended in linear space, stored in sRGB codes", kBlending, over_srgb},
    {"blending", "1,000 layers in B10G11R11_UFLOAT", "Floats of 7 bits", kBlending, over_f11},
    {"blending", "1,000 layers in R16G16B16A16_SFLOAT", "Floats of 11 bits", kBlending, over_f16},
    {"blending", "1,000 layers in R32G32B32A32_SFLOAT", "Four operations in binary32 for each layer", kBlending, over_f32},
    {"blending", "3,000 ones in binary16", "The sum stays at 2,048, where 1 is half a unit in the last place", kIeee, ones_f16},
    {"blending", "1,000 tenths in binary16", "Each addition rounds to nearest", kIeee, tenths_f16},
    {"blending", "1,000 tenths in binary32", "The same in binary32", kIeee, tenths_f32},
    {"blending", "0.75 on 2^24, 1,000 times", "Each 0.75 rounds to 0 or 2", kIeee, small_on_large_f32},
    {"blending", "cancellation", "(2^24 + 1.5) - 2^24 in binary32", kIeee, cancel_f32},
    {"blending", "saturation in UNORM", "1,000 times 0.3 end at 1", kBlending, saturate_r8},
};

}  // namespace

std::span<const ExtremeCase> blending_cases() { return kCases; }

}  // namespace pineda::tools
