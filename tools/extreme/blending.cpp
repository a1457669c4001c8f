#include <algorithm>
#include <bit>
#include <cmath>
#include <random>

#include "tools/error.h"
#include "tools/extreme/rig.h"

namespace pineda::tools {
namespace {

enum class Kind { kUnorm, kSnorm, kFloat, kSrgb };

// The red component of a format: how its codes are read, and which numbers it can hold. A template's argument.
struct Component {
  VkFormat format;
  uint32_t bytes_per_pixel;
  uint32_t shift_bits;  // of the pixel as a little-endian number
  int bits;             // floats: of the mantissa, the hidden one included
  Kind kind;
  bool has_sign = true;  // floats

  double largest_code() const { return (1 << (kind == Kind::kSnorm ? bits - 1 : bits)) - 1; }
  double decode(const std::byte* pixel) const;
  double round_down(double value) const {
    return round(value, [](double x) { return std::floor(x); });
  }
  double round_up(double value) const {
    return round(value, [](double x) { return std::ceil(x); });
  }
  double nearest(double value) const {
    return round(value, [](double x) { return std::nearbyint(x); });
  }

  template <typename Whole>
  double round(double value, const Whole& whole) const {
    if (kind == Kind::kFloat) {
      int exponent = 0;
      std::frexp(value, &exponent);
      const int least = bits == 24 ? -149 : 1 - 14 - bits;  // binary16 and its unsigned relatives: 2^-14
      const double step = std::ldexp(1.0, std::max(exponent - bits, least)), rounded = whole(value / step) * step;
      return has_sign ? rounded : std::max(rounded, 0.0);
    }
    return std::clamp(whole(value * largest_code()), kind == Kind::kSnorm ? -largest_code() : 0.0, largest_code()) /
           largest_code();
  }
};

double small_float(uint32_t bits, int mantissa_bits) {  // no sign; mantissa_bits without the hidden one
  const int exponent = static_cast<int>(bits >> mantissa_bits);
  const double fraction = static_cast<double>(bits & ((1u << mantissa_bits) - 1)) / (1 << mantissa_bits);
  return exponent == 0 ? std::ldexp(fraction, -14) : std::ldexp(1 + fraction, exponent - 15);
}

double linear_of_srgb(double code) { return code <= 0.04045 ? code / 12.92 : std::pow((code + 0.055) / 1.055, 2.4); }

double Component::decode(const std::byte* pixel) const {
  uint32_t word = 0;
  std::memcpy(&word, pixel, std::min<size_t>(bytes_per_pixel, 4));
  word >>= shift_bits;
  if (kind == Kind::kFloat && bits == 24) return std::bit_cast<float>(word);
  if (kind == Kind::kFloat && has_sign) return (word & 0x8000 ? -1 : 1) * small_float(word & 0x7FFF, bits - 1);
  if (kind == Kind::kFloat) return small_float(word & ((32u << (bits - 1)) - 1), bits - 1);  // five bits of exponent
  const uint32_t code = word & ((1u << bits) - 1);
  if (kind == Kind::kSnorm) {
    return std::max((static_cast<int32_t>(code << (32 - bits)) >> (32 - bits)) / largest_code(), -1.0);
  }
  return kind == Kind::kSrgb ? linear_of_srgb(code / largest_code()) : code / largest_code();
}

constexpr Component kR8{VK_FORMAT_R8G8B8A8_UNORM, 4, 0, 8, Kind::kUnorm};
constexpr Component kF16{VK_FORMAT_R16G16B16A16_SFLOAT, 8, 0, 11, Kind::kFloat};
constexpr Component kF32{VK_FORMAT_R32G32B32A32_SFLOAT, 16, 0, 24, Kind::kFloat};

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

// In binary32 each operation rounds: the exact value is that of IEEE 754's operations in the order of the formula.
Outcome over_binary32(ExtremeRig& rig, const Component& component) {
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
  return judge(draw_chain(rig, component, layers, kOver, 0.25f), nearest, real - bound, real + bound, real);
}

// sRGB: blended in linear space, stored in codes.
Outcome over_srgb(ExtremeRig& rig, const Component& component) {
  const auto decode = [](double code) { return linear_of_srgb(code / 255); };
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
  const Chain chain = draw_chain(rig, component, layers, kOver, 0.25f);
  return judge(chain, decode(nearest), decode(low) - 1e-12, decode(high) + 1e-12, real);
}

template <Component kComponent>
Outcome over(ExtremeRig& rig) {
  if (!rig.has_format(kComponent.format, VK_FORMAT_FEATURE_COLOR_ATTACHMENT_BLEND_BIT)) return {};
  if (kComponent.kind == Kind::kSrgb) return over_srgb(rig, kComponent);
  return kComponent.kind == Kind::kFloat && kComponent.bits == 24 ? over_binary32(rig, kComponent) : over_chain(rig, kComponent);
}

// ---- accumulation ---------------------------------------------------------------------------------------------------------

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

// (start + 1.5) - start, where 1.5 on `start` became 2.
Outcome cancel(ExtremeRig& rig, const Component& component, float start) {
  if (!rig.has_format(component.format, VK_FORMAT_FEATURE_COLOR_ATTACHMENT_BLEND_BIT)) return {};
  const Layer layers[] = {{1.5f, 1}, {-start, 1}};
  return judge(draw_chain(rig, component, layers, kAdditive, start), 2, 0, 2, 1.5);
}
Outcome cancel_f16(ExtremeRig& rig) { return cancel(rig, kF16, 2048); }
Outcome cancel_f32(ExtremeRig& rig) { return cancel(rig, kF32, 0x1p24f); }

constexpr const char* kBlending =
    "Vulkan 1.3, Blending: as with the precision of the attachment's format or more, then converted";
constexpr const char* kIeee = "IEEE 754 addition; Vulkan 1.3, Blending";

#define PINEDA_LAYERS(format, ...)                                                                                              \
  {                                                                                                                             \
    "blending", "1,000 layers in " #format, "Translucent layers, source over destination, as red's codes hold them", kBlending, \
        over<Component{VK_FORMAT_##format, __VA_ARGS__}>                                                                        \
  }
constexpr ExtremeCase kCases[] = {
    PINEDA_LAYERS(R8_UNORM, 1, 0, 8, Kind::kUnorm),
    PINEDA_LAYERS(R8G8_UNORM, 2, 0, 8, Kind::kUnorm),
    PINEDA_LAYERS(R8G8B8A8_UNORM, 4, 0, 8, Kind::kUnorm),
    PINEDA_LAYERS(B8G8R8A8_UNORM, 4, 16, 8, Kind::kUnorm),
    PINEDA_LAYERS(A8B8G8R8_UNORM_PACK32, 4, 0, 8, Kind::kUnorm),
    PINEDA_LAYERS(R4G4B4A4_UNORM_PACK16, 2, 12, 4, Kind::kUnorm),
    PINEDA_LAYERS(B4G4R4A4_UNORM_PACK16, 2, 4, 4, Kind::kUnorm),
    PINEDA_LAYERS(R5G6B5_UNORM_PACK16, 2, 11, 5, Kind::kUnorm),
    PINEDA_LAYERS(B5G6R5_UNORM_PACK16, 2, 0, 5, Kind::kUnorm),
    PINEDA_LAYERS(R5G5B5A1_UNORM_PACK16, 2, 11, 5, Kind::kUnorm),
    PINEDA_LAYERS(B5G5R5A1_UNORM_PACK16, 2, 1, 5, Kind::kUnorm),
    PINEDA_LAYERS(A1R5G5B5_UNORM_PACK16, 2, 10, 5, Kind::kUnorm),
    PINEDA_LAYERS(A2R10G10B10_UNORM_PACK32, 4, 20, 10, Kind::kUnorm),
    PINEDA_LAYERS(A2B10G10R10_UNORM_PACK32, 4, 0, 10, Kind::kUnorm),
    PINEDA_LAYERS(R16_UNORM, 2, 0, 16, Kind::kUnorm),
    PINEDA_LAYERS(R16G16_UNORM, 4, 0, 16, Kind::kUnorm),
    PINEDA_LAYERS(R16G16B16A16_UNORM, 8, 0, 16, Kind::kUnorm),
    PINEDA_LAYERS(R8_SNORM, 1, 0, 8, Kind::kSnorm),
    PINEDA_LAYERS(R8G8_SNORM, 2, 0, 8, Kind::kSnorm),
    PINEDA_LAYERS(R8G8B8A8_SNORM, 4, 0, 8, Kind::kSnorm),
    PINEDA_LAYERS(A8B8G8R8_SNORM_PACK32, 4, 0, 8, Kind::kSnorm),
    PINEDA_LAYERS(R16_SNORM, 2, 0, 16, Kind::kSnorm),
    PINEDA_LAYERS(R16G16_SNORM, 4, 0, 16, Kind::kSnorm),
    PINEDA_LAYERS(R16G16B16A16_SNORM, 8, 0, 16, Kind::kSnorm),
    PINEDA_LAYERS(R8_SRGB, 1, 0, 8, Kind::kSrgb),
    PINEDA_LAYERS(R8G8_SRGB, 2, 0, 8, Kind::kSrgb),
    PINEDA_LAYERS(R8G8B8A8_SRGB, 4, 0, 8, Kind::kSrgb),
    PINEDA_LAYERS(B8G8R8A8_SRGB, 4, 16, 8, Kind::kSrgb),
    PINEDA_LAYERS(A8B8G8R8_SRGB_PACK32, 4, 0, 8, Kind::kSrgb),
    PINEDA_LAYERS(B10G11R11_UFLOAT_PACK32, 4, 0, 7, Kind::kFloat, false),
    PINEDA_LAYERS(R16_SFLOAT, 2, 0, 11, Kind::kFloat),
    PINEDA_LAYERS(R16G16_SFLOAT, 4, 0, 11, Kind::kFloat),
    PINEDA_LAYERS(R16G16B16A16_SFLOAT, 8, 0, 11, Kind::kFloat),
    PINEDA_LAYERS(R32_SFLOAT, 4, 0, 24, Kind::kFloat),
    PINEDA_LAYERS(R32G32_SFLOAT, 8, 0, 24, Kind::kFloat),
    PINEDA_LAYERS(R32G32B32A32_SFLOAT, 16, 0, 24, Kind::kFloat),
    {"blending", "3,000 ones in binary16", "The sum stays at 2,048, where 1 is half a unit in the last place", kIeee, ones_f16},
    {"blending", "1,000 tenths in binary16", "Each addition rounds to nearest", kIeee, tenths_f16},
    {"blending", "1,000 tenths in binary32", "The same in binary32", kIeee, tenths_f32},
    {"blending", "0.75 on 2^24, 1,000 times", "Each 0.75 rounds to 0 or 2", kIeee, small_on_large_f32},
    {"blending", "cancellation in binary16", "(2,048 + 1.5) - 2,048: 1.5 became 2", kIeee, cancel_f16},
    {"blending", "cancellation in binary32", "(2^24 + 1.5) - 2^24", kIeee, cancel_f32},
    {"blending", "saturation in UNORM", "1,000 times 0.3 end at 1", kBlending, saturate_r8},
};
#undef PINEDA_LAYERS

}  // namespace

std::span<const ExtremeCase> blending_cases() { return kCases; }

}  // namespace pineda::tools
