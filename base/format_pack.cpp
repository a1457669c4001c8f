// Host side of texel packing: the same rounding as compiler/kernels/texel.cpp, which its test holds against this file.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "base/format.h"
#include "base/half.h"
#include "base/srgb.h"

namespace pineda {
namespace {

// The product is exact in double (24 + 24 bits); adding 2^52 rounds it to the nearest even integer. 0 <= x * scale < 2^51.
uint64_t round_product(double x, double scale) {
  const double shifted = x * scale + 0x1p52;
  return std::bit_cast<uint64_t>(shifted) & 0xfffffffffffffull;
}

uint64_t low_bits(uint32_t bits) { return (uint64_t{1} << bits) - 1; }

uint64_t unorm(float x, uint32_t bits) {
  x = 0.0f < x ? x : 0.0f;  // NaN gives 0
  x = 1.0f < x ? 1.0f : x;
  return round_product(x, static_cast<double>(low_bits(bits)));
}

uint64_t snorm(float x, uint32_t bits) {
  x = -1.0f < x ? x : -1.0f;
  x = 1.0f < x ? 1.0f : x;
  const double scale = static_cast<double>(low_bits(bits - 1));
  return x < 0 ? (0 - round_product(-x, scale)) & low_bits(bits) : round_product(x, scale);
}

// 5 exponent bits, no sign ("Unsigned 11-Bit Floating-Point Numbers"): to nearest even; below zero gives 0, finite values beyond
// the largest finite one give that.
uint64_t ufloat(float x, uint32_t bits) {
  const uint32_t mantissa_bits = bits - 5;
  if (x != x) return (31u << mantissa_bits) | 1u << (mantissa_bits - 1);
  if (!(x > 0.0f)) return 0;
  if (x > std::numeric_limits<float>::max()) return 31u << mantissa_bits;
  if (x < 0x1p-14f) return round_product(x, std::ldexp(1.0, 14 + static_cast<int>(mantissa_bits)));
  const uint32_t shift = 23 - mantissa_bits, largest = (31u << mantissa_bits) - 1;
  const uint32_t word = std::bit_cast<uint32_t>(x);
  const uint32_t rounded = (word + (1u << (shift - 1)) - 1 + (word >> shift & 1)) >> shift;
  return std::min(rounded - (112u << mantissa_bits), largest);
}

// "RGB to Shared Exponent Conversion": 9 mantissa bits, bias 15. The products are exact in double.
uint32_t shared_exponent(const float (&color)[4]) {
  double c[3], largest = 0;
  for (int i = 0; i < 3; ++i) {
    const float x = 0.0f < color[i] ? color[i] : 0.0f;  // NaN gives 0
    c[i] = x < 65408.0f ? x : 65408.0f;
    largest = std::max(largest, c[i]);
  }
  uint32_t exponent = 0;
  while (exponent < 31 && largest >= std::ldexp(1.0, static_cast<int>(exponent) - 15)) ++exponent;
  if (std::floor(std::ldexp(largest, 24 - static_cast<int>(exponent)) + 0.5) == 512) ++exponent;
  uint32_t word = exponent << 27;
  for (int i = 0; i < 3; ++i) {
    word |= static_cast<uint32_t>(std::floor(std::ldexp(c[i], 24 - static_cast<int>(exponent)) + 0.5)) << 9 * i;
  }
  return word;
}

uint64_t pack_float(const FormatInfo& format, uint32_t component, float x) {
  const uint32_t bits = format.component[component].bits;
  switch (format.numeric) {
    case Numeric::kUnorm:
      return unorm(x, bits);
    case Numeric::kSnorm:
      return snorm(x, bits);
    case Numeric::kSrgb:
      return component == 3 ? unorm(x, bits) : srgb_encode(x);
    case Numeric::kSfloat:
      if (bits == 16) return float_to_half(x);
      return std::bit_cast<uint32_t>(x);
    case Numeric::kUfloat:
      return ufloat(x, bits);
    default:
      return 0;
  }
}

}  // namespace

void pack_clear_color(const FormatInfo& format, const VkClearColorValue& color, uint8_t* out) {
  uint64_t words[2] = {0, 0};
  if (format.numeric == Numeric::kSharedExp) {
    const uint32_t word = shared_exponent(color.float32);
    std::memcpy(out, &word, sizeof(word));
    return;
  }
  for (uint32_t c = 0; c < 4; ++c) {
    const ComponentBits where = format.component[c];
    if (where.bits == 0) continue;
    const uint64_t value = format.is_integer() ? color.uint32[c] & low_bits(where.bits) : pack_float(format, c, color.float32[c]);
    words[where.first_bit / 64] |= value << where.first_bit % 64;
  }
  std::memcpy(out, words, format.texel_bytes);
}

void pack_depth(const FormatInfo& format, float depth, uint8_t* out) {
  const bool is_float = format.numeric == Numeric::kSfloat;  // whose depths may be unrestricted
  const float z = is_float ? (std::isnan(depth) ? 0.0f : depth) : std::clamp(0.0f < depth ? depth : 0.0f, 0.0f, 1.0f);
  uint32_t word = 0;
  switch (format.component[0].bits) {
    case 16:
      word = static_cast<uint32_t>(round_product(z, 0xffff));
      break;
    // The kernel's product is rounded to binary32 first, because the integer does not fit beside a rounding constant.
    case 24:
      word = static_cast<uint32_t>(round_product(z * 16777215.0f, 1.0));
      break;
    default:
      word = std::bit_cast<uint32_t>(z);
      break;
  }
  std::memcpy(out, &word, format.texel_bytes);
}

}  // namespace pineda
