// Host side of texel packing: the same rounding as compiler/kernels/texel.cpp, which its test holds against this file.
#include <algorithm>
#include <bit>
#include <cstring>

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
    default:
      return 0;
  }
}

}  // namespace

void pack_clear_color(const FormatInfo& format, const VkClearColorValue& color, uint8_t* out) {
  uint64_t words[2] = {0, 0};
  for (uint32_t c = 0; c < 4; ++c) {
    const ComponentBits where = format.component[c];
    if (where.bits == 0) continue;
    const uint64_t value = format.is_integer() ? color.uint32[c] & low_bits(where.bits) : pack_float(format, c, color.float32[c]);
    words[where.first_bit / 64] |= value << where.first_bit % 64;
  }
  std::memcpy(out, words, format.texel_bytes);
}

void pack_depth(const FormatInfo& format, float depth, uint8_t* out) {
  float z = 0.0f < depth ? depth : 0.0f;
  z = 1.0f < z ? 1.0f : z;
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
