// BC1 to BC5: Khronos Data Format Specification, chapters "S3TC" and "RGTC". The specification interpolates real numbers; here
// each texel is the nearest code to the exact quotient, so a decoded texel is off by at most half a code of its format.
#include <array>

#include "base/block_decoders.h"

namespace pineda {
namespace {

// numerator / denominator to the nearest integer, halves to even; both positive.
uint32_t divide_to_nearest(uint32_t numerator, uint32_t denominator) {
  const uint32_t quotient = numerator / denominator, twice_rest = 2 * (numerator % denominator);
  return quotient + (twice_rest > denominator || (twice_rest == denominator && (quotient & 1)));
}

using Color = std::array<uint8_t, 4>;

// (weight0 * c0 + weight1 * c1) / (weight0 + weight1) of two RGB565 colours, as 8-bit codes.
Color mix_565(uint32_t c0, uint32_t weight0, uint32_t c1, uint32_t weight1) {
  const auto channel = [&](uint32_t shift, uint32_t largest) {
    const uint32_t sum = weight0 * (c0 >> shift & largest) + weight1 * (c1 >> shift & largest);
    return static_cast<uint8_t>(divide_to_nearest(sum * 255, largest * (weight0 + weight1)));
  };
  return {channel(11, 31), channel(5, 63), channel(0, 31), 255};
}

// The colour half of BC1 to BC3. `three_colors`: an order of the endpoints that selects the mode with black has that meaning.
void decode_color(const uint8_t* block, bool three_colors, uint8_t black_alpha, uint8_t* texels) {
  const uint32_t c0 = block[0] | block[1] << 8, c1 = block[2] | block[3] << 8;
  std::array<Color, 4> palette = {mix_565(c0, 1, c1, 0), mix_565(c0, 0, c1, 1)};
  if (three_colors && c0 <= c1) {
    palette[2] = mix_565(c0, 1, c1, 1);
    palette[3] = {0, 0, 0, black_alpha};
  } else {
    palette[2] = mix_565(c0, 2, c1, 1);
    palette[3] = mix_565(c0, 1, c1, 2);
  }
  for (uint32_t i = 0; i < 16; ++i) std::memcpy(texels + 4 * i, palette[block[4 + i / 4] >> 2 * (i % 4) & 3].data(), 4);
}

// Weights of the endpoints in the eight values of an RGTC block, in sevenths or fifths.
struct Weights {
  uint32_t first, second;
};
Weights rgtc_weights(bool eight_values, uint32_t code) {
  const uint32_t steps = eight_values ? 7 : 5;
  if (code < 2) return {code == 0 ? steps : 0, code == 0 ? 0 : steps};
  return {steps + 1 - code, code - 1};
}

uint64_t rgtc_codes(const uint8_t* block) {
  uint64_t codes = 0;
  for (uint32_t i = 0; i < 6; ++i) codes |= uint64_t{block[2 + i]} << 8 * i;
  return codes;
}

// Palette of an unsigned block, 1.0 being `one`.
std::array<uint32_t, 8> unsigned_palette(const uint8_t* block, uint32_t one) {
  const bool eight_values = block[0] > block[1];
  const uint32_t steps = eight_values ? 7 : 5;
  std::array<uint32_t, 8> palette{};
  for (uint32_t code = 0; code <= steps; ++code) {
    const Weights w = rgtc_weights(eight_values, code);
    palette[code] = divide_to_nearest((w.first * block[0] + w.second * block[1]) * (one / 255), steps);
  }
  if (!eight_values) palette[6] = 0, palette[7] = one;
  return palette;
}

// Of a signed block, as 16-bit SNORM codes. Which of -127 and -128 is larger is undefined; here it is the number as stored.
std::array<uint32_t, 8> signed_palette(const uint8_t* block) {
  constexpr int32_t kOne = 32767;
  const auto red0 = static_cast<int8_t>(block[0]), red1 = static_cast<int8_t>(block[1]);
  const bool eight_values = red0 > red1;
  const int32_t steps = eight_values ? 7 : 5, value0 = red0 < -127 ? -127 : red0, value1 = red1 < -127 ? -127 : red1;
  std::array<uint32_t, 8> palette{};
  for (uint32_t code = 0; code <= static_cast<uint32_t>(steps); ++code) {
    const Weights w = rgtc_weights(eight_values, code);
    const int32_t sum = (static_cast<int32_t>(w.first) * value0 + static_cast<int32_t>(w.second) * value1) * kOne;
    const uint32_t magnitude = divide_to_nearest(static_cast<uint32_t>(sum < 0 ? -sum : sum), static_cast<uint32_t>(127 * steps));
    palette[code] = sum < 0 ? 0 - magnitude : magnitude;
  }
  if (!eight_values) palette[6] = static_cast<uint32_t>(-kOne), palette[7] = kOne;
  return palette;
}

// 16-bit codes of one channel into texels of `stride_bytes`.
void decode_channel(const FormatInfo& format, const uint8_t* block, uint32_t stride_bytes, uint8_t* texels) {
  const bool is_signed = format.decoded == VK_FORMAT_R16_SNORM || format.decoded == VK_FORMAT_R16G16_SNORM;
  const std::array<uint32_t, 8> palette = is_signed ? signed_palette(block) : unsigned_palette(block, 65535);
  const uint64_t codes = rgtc_codes(block);
  for (uint32_t i = 0; i < 16; ++i) {
    const auto value = static_cast<uint16_t>(palette[codes >> 3 * i & 7]);
    std::memcpy(texels + i * stride_bytes, &value, sizeof(value));
  }
}

}  // namespace

void decode_bc1(const FormatInfo& format, const uint8_t* block, uint8_t* texels) {
  const bool opaque = format.format == VK_FORMAT_BC1_RGB_UNORM_BLOCK || format.format == VK_FORMAT_BC1_RGB_SRGB_BLOCK;
  decode_color(block, true, opaque ? 255 : 0, texels);
}

void decode_bc2(const FormatInfo&, const uint8_t* block, uint8_t* texels) {
  decode_color(block + 8, false, 255, texels);
  for (uint32_t i = 0; i < 16; ++i) texels[4 * i + 3] = static_cast<uint8_t>((block[i / 2] >> 4 * (i % 2) & 15) * 17);
}

void decode_bc3(const FormatInfo&, const uint8_t* block, uint8_t* texels) {
  decode_color(block + 8, false, 255, texels);
  const std::array<uint32_t, 8> palette = unsigned_palette(block, 255);
  const uint64_t codes = rgtc_codes(block);
  for (uint32_t i = 0; i < 16; ++i) texels[4 * i + 3] = static_cast<uint8_t>(palette[codes >> 3 * i & 7]);
}

void decode_bc4(const FormatInfo& format, const uint8_t* block, uint8_t* texels) { decode_channel(format, block, 2, texels); }

void decode_bc5(const FormatInfo& format, const uint8_t* block, uint8_t* texels) {
  decode_channel(format, block, 4, texels);
  decode_channel(format, block + 8, 4, texels + 2);
}

}  // namespace pineda
