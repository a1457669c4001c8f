#include "cts-subset/reference/formats.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <stdexcept>
#include <string>

namespace pineda::cts {
namespace {

// Bits of the texel as one number; texels have at most 16 bytes and channels at most 32 bits.
uint32_t read_bits(const std::byte* texel, uint32_t shift, uint32_t bits) {
  uint64_t value = 0;
  const uint32_t first = shift / 8, last = (shift + bits - 1) / 8;
  for (uint32_t i = last + 1; i-- > first;) value = value << 8 | std::to_integer<uint64_t>(texel[i]);
  return static_cast<uint32_t>(value >> (shift % 8) & ((uint64_t{1} << bits) - 1));
}

void write_bits(std::byte* texel, uint32_t shift, uint32_t bits, uint32_t value) {
  for (uint32_t i = 0; i < bits; ++i) {
    const uint32_t at = shift + i;
    const std::byte mask = std::byte{1} << (at % 8);
    texel[at / 8] = value >> i & 1 ? texel[at / 8] | mask : texel[at / 8] & ~mask;
  }
}

struct FloatLayout {
  int exponent_bits, mantissa_bits;
  bool sign;
};

FloatLayout layout_of(const Channel& channel) {
  if (channel.bits == 32) return {8, 23, true};
  if (channel.bits == 16) return {5, 10, true};
  return {5, static_cast<int>(channel.bits) - 5, false};  // the 10- and 11-bit unsigned floats
}

double decode_float(const FloatLayout& layout, uint32_t bits) {
  const int bias = (1 << (layout.exponent_bits - 1)) - 1;
  const uint32_t mantissa = bits & ((1u << layout.mantissa_bits) - 1);
  const int exponent = static_cast<int>(bits >> layout.mantissa_bits & ((1u << layout.exponent_bits) - 1));
  const bool negative = layout.sign && (bits >> (layout.mantissa_bits + layout.exponent_bits) & 1);
  double value;
  if (exponent == (1 << layout.exponent_bits) - 1) {
    value = mantissa ? std::nan("") : INFINITY;
  } else if (exponent == 0) {
    value = std::ldexp(mantissa, 1 - bias - layout.mantissa_bits);
  } else {
    value = std::ldexp(1.0 + std::ldexp(mantissa, -layout.mantissa_bits), exponent - bias);
  }
  return negative ? -value : value;
}

double decode_channel(const Channel& channel, uint32_t bits) {
  const double max_unsigned = std::exp2(channel.bits) - 1, max_signed = std::exp2(channel.bits - 1) - 1;
  const int32_t as_signed = static_cast<int32_t>(bits << (32 - channel.bits)) >> (32 - channel.bits);
  switch (channel.numeric) {
    case Numeric::kUnorm:
      return bits / max_unsigned;
    case Numeric::kSnorm:
      return std::max(as_signed / max_signed, -1.0);
    case Numeric::kUscaled:
    case Numeric::kUint:
      return bits;
    case Numeric::kSscaled:
    case Numeric::kSint:
      return as_signed;
    case Numeric::kSrgb:
      return srgb_to_linear(bits / max_unsigned);
    default:
      return decode_float(layout_of(channel), bits);
  }
}

// Encodings are ordered like their values within one sign, so a search finds the neighbours of a value.
struct Codes {
  uint32_t below, above;
};

Codes neighbours(const Channel& channel, double value, uint32_t first, uint32_t last) {  // decode(first) <= ... <= decode(last)
  if (value <= decode_channel(channel, first)) return {first, first};
  if (value >= decode_channel(channel, last)) return {last, last};
  uint32_t low = first, high = last;
  while (high - low > 1) {
    const uint32_t middle = low + (high - low) / 2;
    (decode_channel(channel, middle) <= value ? low : high) = middle;
  }
  return {low, decode_channel(channel, low) == value ? low : high};
}

Codes codes_of(const Channel& channel, double value) {
  const uint32_t top = 1u << (channel.bits - 1), all = channel.bits == 32 ? ~0u : (1u << channel.bits) - 1;
  switch (channel.numeric) {
    case Numeric::kUnorm:
    case Numeric::kSrgb:
    case Numeric::kUscaled:
    case Numeric::kUint:
      return neighbours(channel, value, 0, all);
    case Numeric::kSnorm:
    case Numeric::kSscaled:
    case Numeric::kSint: {
      if (value >= 0) return neighbours(channel, value, 0, top - 1);
      const uint32_t lowest = channel.numeric == Numeric::kSnorm ? top + 1 : top;
      return value > decode_channel(channel, all) ? Codes{all, 0} : neighbours(channel, value, lowest, all);
    }
    default: {
      const FloatLayout layout = layout_of(channel);
      const uint32_t infinity = ((1u << layout.exponent_bits) - 1) << layout.mantissa_bits;
      if (value < 0 && !layout.sign) return {0, 0};
      const Codes magnitude = neighbours(channel, std::abs(value), 0, infinity);
      if (value >= 0) return magnitude;
      return {magnitude.above | top, magnitude.below | top};
    }
  }
}

FormatInfo array_format(VkFormat format, const char* name, std::string_view order, uint32_t bits, Numeric numeric) {
  FormatInfo info{format, name, static_cast<uint32_t>(order.size()) * bits / 8, {}};
  for (uint32_t i = 0; i < order.size(); ++i) {
    const bool linear_alpha = numeric == Numeric::kSrgb && order[i] == 'a';
    info.channels.push_back({order[i], i * bits, bits, linear_alpha ? Numeric::kUnorm : numeric});
  }
  return info;
}

// `order` names the channels from the most significant bit on, as the format's name does.
FormatInfo packed_format(VkFormat format, const char* name, std::string_view order, std::initializer_list<uint32_t> widths,
                         Numeric numeric) {
  uint32_t total = 0;
  for (const uint32_t width : widths) total += width;
  FormatInfo info{format, name, total / 8, {}};
  uint32_t shift = total;
  size_t i = 0;
  for (const uint32_t width : widths) {
    shift -= width;
    const bool linear_alpha = numeric == Numeric::kSrgb && order[i] == 'a';
    info.channels.push_back({order[i++], shift, width, linear_alpha ? Numeric::kUnorm : numeric});
  }
  return info;
}

std::vector<FormatInfo> make_table() {
  using N = Numeric;
  std::vector<FormatInfo> table;
#define ARRAY(F, SUFFIX, order, bits, numeric) \
  table.push_back(array_format(VK_FORMAT_##F##_##SUFFIX, #F "_" #SUFFIX, order, bits, numeric))
#define INTEGERS(F, order, bits)         \
  ARRAY(F, UINT, order, bits, N::kUint); \
  ARRAY(F, SINT, order, bits, N::kSint)
#define FIXED_POINT(F, order, bits)            \
  ARRAY(F, UNORM, order, bits, N::kUnorm);     \
  ARRAY(F, SNORM, order, bits, N::kSnorm);     \
  ARRAY(F, USCALED, order, bits, N::kUscaled); \
  ARRAY(F, SSCALED, order, bits, N::kSscaled); \
  INTEGERS(F, order, bits)
#define ARRAY8(F, order)    \
  FIXED_POINT(F, order, 8); \
  ARRAY(F, SRGB, order, 8, N::kSrgb)
#define ARRAY16(F, order)    \
  FIXED_POINT(F, order, 16); \
  ARRAY(F, SFLOAT, order, 16, N::kSfloat)
#define ARRAY32(F, order) \
  INTEGERS(F, order, 32); \
  ARRAY(F, SFLOAT, order, 32, N::kSfloat)
#define PACKED(F, order, numeric, ...) table.push_back(packed_format(VK_FORMAT_##F, #F, order, {__VA_ARGS__}, numeric))
#define PACKED32(F, order, ...)                                \
  PACKED(F##_UNORM_PACK32, order, N::kUnorm, __VA_ARGS__);     \
  PACKED(F##_SNORM_PACK32, order, N::kSnorm, __VA_ARGS__);     \
  PACKED(F##_USCALED_PACK32, order, N::kUscaled, __VA_ARGS__); \
  PACKED(F##_SSCALED_PACK32, order, N::kSscaled, __VA_ARGS__); \
  PACKED(F##_UINT_PACK32, order, N::kUint, __VA_ARGS__);       \
  PACKED(F##_SINT_PACK32, order, N::kSint, __VA_ARGS__)
  ARRAY8(R8, "r");
  ARRAY8(R8G8, "rg");
  ARRAY8(R8G8B8, "rgb");
  ARRAY8(B8G8R8, "bgr");
  ARRAY8(R8G8B8A8, "rgba");
  ARRAY8(B8G8R8A8, "bgra");
  ARRAY16(R16, "r");
  ARRAY16(R16G16, "rg");
  ARRAY16(R16G16B16, "rgb");
  ARRAY16(R16G16B16A16, "rgba");
  ARRAY32(R32, "r");
  ARRAY32(R32G32, "rg");
  ARRAY32(R32G32B32, "rgb");
  ARRAY32(R32G32B32A32, "rgba");
  PACKED(R4G4_UNORM_PACK8, "rg", N::kUnorm, 4, 4);
  PACKED(R4G4B4A4_UNORM_PACK16, "rgba", N::kUnorm, 4, 4, 4, 4);
  PACKED(B4G4R4A4_UNORM_PACK16, "bgra", N::kUnorm, 4, 4, 4, 4);
  PACKED(A4R4G4B4_UNORM_PACK16, "argb", N::kUnorm, 4, 4, 4, 4);
  PACKED(A4B4G4R4_UNORM_PACK16, "abgr", N::kUnorm, 4, 4, 4, 4);
  PACKED(R5G6B5_UNORM_PACK16, "rgb", N::kUnorm, 5, 6, 5);
  PACKED(B5G6R5_UNORM_PACK16, "bgr", N::kUnorm, 5, 6, 5);
  PACKED(R5G5B5A1_UNORM_PACK16, "rgba", N::kUnorm, 5, 5, 5, 1);
  PACKED(B5G5R5A1_UNORM_PACK16, "bgra", N::kUnorm, 5, 5, 5, 1);
  PACKED(A1R5G5B5_UNORM_PACK16, "argb", N::kUnorm, 1, 5, 5, 5);
  PACKED32(A8B8G8R8, "abgr", 8, 8, 8, 8);
  PACKED(A8B8G8R8_SRGB_PACK32, "abgr", N::kSrgb, 8, 8, 8, 8);
  PACKED32(A2R10G10B10, "argb", 2, 10, 10, 10);
  PACKED32(A2B10G10R10, "abgr", 2, 10, 10, 10);
  PACKED(B10G11R11_UFLOAT_PACK32, "bgr", N::kUfloat, 10, 11, 11);
  PACKED(E5B9G9R9_UFLOAT_PACK32, "ebgr", N::kUfloat, 5, 9, 9, 9);
#undef ARRAY
#undef INTEGERS
#undef FIXED_POINT
#undef ARRAY8
#undef ARRAY16
#undef ARRAY32
#undef PACKED
#undef PACKED32
  return table;
}

constexpr std::string_view kColourNames = "rgba";

}  // namespace

bool FormatInfo::is_signed() const {
  const Numeric n = channels[0].numeric;
  return n == Numeric::kSnorm || n == Numeric::kSscaled || n == Numeric::kSint || n == Numeric::kSfloat;
}

const Channel* FormatInfo::channel(char wanted) const {
  const auto found = std::ranges::find(channels, wanted, &Channel::name);
  return found == channels.end() ? nullptr : &*found;
}

std::span<const FormatInfo> colour_formats() {
  static const std::vector<FormatInfo> table = make_table();
  return table;
}

const FormatInfo& info_of(VkFormat format) {
  for (const FormatInfo& info : colour_formats()) {
    if (info.format == format) return info;
  }
  throw std::logic_error("no reference for this format");
}

std::span<const StorageFormat> storage_formats() {
  static constexpr StorageFormat kTable[] = {
      {VK_FORMAT_R32G32B32A32_SFLOAT, "rgba32f"},
      {VK_FORMAT_R16G16B16A16_SFLOAT, "rgba16f"},
      {VK_FORMAT_R32G32_SFLOAT, "rg32f"},
      {VK_FORMAT_R16G16_SFLOAT, "rg16f"},
      {VK_FORMAT_B10G11R11_UFLOAT_PACK32, "r11f_g11f_b10f"},
      {VK_FORMAT_R32_SFLOAT, "r32f"},
      {VK_FORMAT_R16_SFLOAT, "r16f"},
      {VK_FORMAT_R16G16B16A16_UNORM, "rgba16"},
      {VK_FORMAT_A2B10G10R10_UNORM_PACK32, "rgb10_a2"},
      {VK_FORMAT_R8G8B8A8_UNORM, "rgba8"},
      {VK_FORMAT_R16G16_UNORM, "rg16"},
      {VK_FORMAT_R8G8_UNORM, "rg8"},
      {VK_FORMAT_R16_UNORM, "r16"},
      {VK_FORMAT_R8_UNORM, "r8"},
      {VK_FORMAT_R16G16B16A16_SNORM, "rgba16_snorm"},
      {VK_FORMAT_R8G8B8A8_SNORM, "rgba8_snorm"},
      {VK_FORMAT_R16G16_SNORM, "rg16_snorm"},
      {VK_FORMAT_R8G8_SNORM, "rg8_snorm"},
      {VK_FORMAT_R16_SNORM, "r16_snorm"},
      {VK_FORMAT_R8_SNORM, "r8_snorm"},
      {VK_FORMAT_R32G32B32A32_SINT, "rgba32i"},
      {VK_FORMAT_R16G16B16A16_SINT, "rgba16i"},
      {VK_FORMAT_R8G8B8A8_SINT, "rgba8i"},
      {VK_FORMAT_R32G32_SINT, "rg32i"},
      {VK_FORMAT_R16G16_SINT, "rg16i"},
      {VK_FORMAT_R8G8_SINT, "rg8i"},
      {VK_FORMAT_R32_SINT, "r32i"},
      {VK_FORMAT_R16_SINT, "r16i"},
      {VK_FORMAT_R8_SINT, "r8i"},
      {VK_FORMAT_R32G32B32A32_UINT, "rgba32ui"},
      {VK_FORMAT_R16G16B16A16_UINT, "rgba16ui"},
      {VK_FORMAT_R8G8B8A8_UINT, "rgba8ui"},
      {VK_FORMAT_R32G32_UINT, "rg32ui"},
      {VK_FORMAT_R16G16_UINT, "rg16ui"},
      {VK_FORMAT_R8G8_UINT, "rg8ui"},
      {VK_FORMAT_R32_UINT, "r32ui"},
      {VK_FORMAT_R16_UINT, "r16ui"},
      {VK_FORMAT_R8_UINT, "r8ui"},
      {VK_FORMAT_A2B10G10R10_UINT_PACK32, "rgb10_a2ui"},
  };
  return kTable;
}

Colour decode(const FormatInfo& info, const std::byte* texel) {
  Colour colour{0, 0, 0, 1};
  if (info.format ==
      VK_FORMAT_E5B9G9R9_UFLOAT_PACK32) {  // "Conversion from RGB to Shared Exponent" read backwards: N = 9, B = 15
    const double scale = std::exp2(static_cast<int>(read_bits(texel, 27, 5)) - 15 - 9);
    for (uint32_t i = 0; i < 3; ++i) colour[i] = read_bits(texel, i * 9, 9) * scale;
    return colour;
  }
  for (const Channel& channel : info.channels) {
    const size_t at = kColourNames.find(channel.name);
    if (at != std::string_view::npos) colour[at] = decode_channel(channel, read_bits(texel, channel.shift_bits, channel.bits));
  }
  return colour;
}

Bracket representable(const Channel& channel, double value) {
  const Codes codes = codes_of(channel, value);
  const double low = decode_channel(channel, codes.below), high = decode_channel(channel, codes.above);
  return {low, high, std::abs(value - low) <= std::abs(high - value) ? low : high};
}

void encode(const FormatInfo& info, const Colour& colour, std::byte* texel) {
  std::memset(texel, 0, info.bytes);
  if (info.format == VK_FORMAT_E5B9G9R9_UFLOAT_PACK32) throw std::logic_error("E5B9G9R9 is only decoded here");
  for (const Channel& channel : info.channels) {
    const size_t at = kColourNames.find(channel.name);
    if (at == std::string_view::npos) continue;
    const Codes codes = codes_of(channel, colour[at]);
    const double low = decode_channel(channel, codes.below), high = decode_channel(channel, codes.above);
    const bool take_low = std::abs(colour[at] - low) <= std::abs(high - colour[at]);
    write_bits(texel, channel.shift_bits, channel.bits, take_low ? codes.below : codes.above);
  }
}

double srgb_to_linear(double encoded) { return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4); }

double linear_to_srgb(double linear) {
  if (!(linear > 0)) return 0;
  if (linear >= 1) return 1;
  return linear < 0.0031308 ? linear * 12.92 : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

}  // namespace pineda::cts
