// ETC2 and EAC: Khronos Data Format Specification, chapter "ETC2". Blocks are big-endian 64-bit numbers, texels count down the
// columns. Bit-exact; 11-bit values are widened to 16 bits by replication, as the specification tells.
#include <algorithm>
#include <array>

#include "base/block_decoders.h"

namespace pineda {
namespace {

uint64_t read_big_endian(const uint8_t* bytes) {
  uint64_t value = 0;
  for (int i = 0; i < 8; ++i) value = value << 8 | bytes[i];
  return value;
}

uint32_t field(uint64_t block, uint32_t high, uint32_t low) {
  return static_cast<uint32_t>(block >> low & ((uint64_t{1} << (high - low + 1)) - 1));
}

uint8_t clamp255(int32_t value) { return static_cast<uint8_t>(std::clamp(value, 0, 255)); }

using Rgb = std::array<int32_t, 3>;

int32_t extend(uint32_t value, uint32_t bits) {  // by replication, to 8 bits
  const uint32_t high = value << (8 - bits);
  return static_cast<int32_t>(high | high >> bits);
}
Rgb extend(uint32_t r, uint32_t g, uint32_t b, uint32_t bits) { return {extend(r, bits), extend(g, bits), extend(b, bits)}; }

int32_t sign_extend3(uint32_t value) { return static_cast<int32_t>(value ^ 4) - 4; }

// Texels are written in memory order, indices are stored a, b, c, d, e ...: down the columns.
constexpr uint32_t texel_of(uint32_t pixel) { return (pixel & 3) * 4 + (pixel >> 2); }

uint32_t pixel_index(uint64_t block, uint32_t pixel) {
  return static_cast<uint32_t>(block >> (16 + pixel) & 1) << 1 | static_cast<uint32_t>(block >> pixel & 1);
}

void store(uint8_t* texels, uint32_t pixel, const Rgb& color, int32_t offset, uint8_t alpha) {
  uint8_t* texel = texels + 4 * texel_of(pixel);
  for (uint32_t c = 0; c < 3; ++c) texel[c] = clamp255(color[c] + offset);
  texel[3] = alpha;
}

constexpr int32_t kModifiers[8][2] = {{2, 8}, {5, 17}, {9, 29}, {13, 42}, {18, 60}, {24, 80}, {33, 106}, {47, 183}};
constexpr int32_t kDistances[8] = {3, 6, 11, 16, 23, 32, 41, 64};
constexpr uint32_t kTransparent = 2;  // pixel index, in blocks with punchthrough alpha that are not opaque

void decode_halves(uint64_t block, const Rgb (&base)[2], bool opaque, uint8_t* texels) {
  const uint32_t table[2] = {field(block, 39, 37), field(block, 36, 34)};
  const bool flip = field(block, 32, 32) != 0;
  for (uint32_t pixel = 0; pixel < 16; ++pixel) {
    const uint32_t half = flip ? pixel >> 1 & 1 : pixel >> 3, index = pixel_index(block, pixel);
    if (!opaque && index == kTransparent) {
      std::memset(texels + 4 * texel_of(pixel), 0, 4);
      continue;
    }
    const int32_t small = opaque ? kModifiers[table[half]][0] : 0, large = kModifiers[table[half]][1];
    const int32_t modifier[4] = {small, large, -small, -large};
    store(texels, pixel, base[half], modifier[index], 255);
  }
}

struct Paint {
  Rgb color;
  int32_t offset;
};

void decode_paint(uint64_t block, const Paint (&paint)[4], bool opaque, uint8_t* texels) {
  for (uint32_t pixel = 0; pixel < 16; ++pixel) {
    const uint32_t index = pixel_index(block, pixel);
    if (!opaque && index == kTransparent) {
      std::memset(texels + 4 * texel_of(pixel), 0, 4);
    } else {
      store(texels, pixel, paint[index].color, paint[index].offset, 255);
    }
  }
}

void decode_t(uint64_t block, bool opaque, uint8_t* texels) {
  const Rgb first = extend(field(block, 60, 59) << 2 | field(block, 57, 56), field(block, 55, 52), field(block, 51, 48), 4);
  const Rgb second = extend(field(block, 47, 44), field(block, 43, 40), field(block, 39, 36), 4);
  const int32_t d = kDistances[field(block, 35, 34) << 1 | field(block, 32, 32)];
  decode_paint(block, {{first, 0}, {second, d}, {second, 0}, {second, -d}}, opaque, texels);
}

void decode_h(uint64_t block, bool opaque, uint8_t* texels) {
  const uint32_t r1 = field(block, 62, 59), g1 = field(block, 58, 56) << 1 | field(block, 52, 52),
                 b1 = field(block, 51, 51) << 3 | field(block, 49, 47);
  const uint32_t r2 = field(block, 46, 43), g2 = field(block, 42, 39), b2 = field(block, 38, 35);
  const bool ordered = (r1 << 8 | g1 << 4 | b1) >= (r2 << 8 | g2 << 4 | b2);  // as the 8-bit colours
  const int32_t d = kDistances[field(block, 34, 34) << 2 | field(block, 32, 32) << 1 | ordered];
  const Rgb first = extend(r1, g1, b1, 4), second = extend(r2, g2, b2, 4);
  decode_paint(block, {{first, d}, {first, -d}, {second, d}, {second, -d}}, opaque, texels);
}

void decode_planar(uint64_t block, uint8_t* texels) {
  const Rgb origin = {extend(field(block, 62, 57), 6), extend(field(block, 56, 56) << 6 | field(block, 54, 49), 7),
                      extend(field(block, 48, 48) << 5 | field(block, 44, 43) << 3 | field(block, 41, 39), 6)};
  const Rgb right = {extend(field(block, 38, 34) << 1 | field(block, 32, 32), 6), extend(field(block, 31, 25), 7),
                     extend(field(block, 24, 19), 6)};
  const Rgb below = {extend(field(block, 18, 13), 6), extend(field(block, 12, 6), 7), extend(field(block, 5, 0), 6)};
  for (int32_t y = 0; y < 4; ++y) {
    for (int32_t x = 0; x < 4; ++x, texels += 4) {
      for (uint32_t c = 0; c < 3; ++c) {
        texels[c] = clamp255((x * (right[c] - origin[c]) + y * (below[c] - origin[c]) + 4 * origin[c] + 2) >> 2);
      }
      texels[3] = 255;
    }
  }
}

// `punchthrough`: bit 33 tells opaque blocks instead of the individual mode.
void decode_color(const uint8_t* bytes, bool punchthrough, uint8_t* texels) {
  const uint64_t block = read_big_endian(bytes);
  const bool bit33 = field(block, 33, 33) != 0, opaque = !punchthrough || bit33;
  if (!punchthrough && !bit33) {  // individual
    const Rgb base[2] = {extend(field(block, 63, 60), field(block, 55, 52), field(block, 47, 44), 4),
                         extend(field(block, 59, 56), field(block, 51, 48), field(block, 43, 40), 4)};
    decode_halves(block, base, true, texels);
    return;
  }
  const uint32_t r = field(block, 63, 59), g = field(block, 55, 51), b = field(block, 47, 43);
  const int32_t r2 = static_cast<int32_t>(r) + sign_extend3(field(block, 58, 56)),
                g2 = static_cast<int32_t>(g) + sign_extend3(field(block, 50, 48)),
                b2 = static_cast<int32_t>(b) + sign_extend3(field(block, 42, 40));
  const auto outside = [](int32_t value) { return value < 0 || value > 31; };
  if (outside(r2)) return decode_t(block, opaque, texels);
  if (outside(g2)) return decode_h(block, opaque, texels);
  if (outside(b2)) return decode_planar(block, texels);
  const Rgb base[2] = {extend(r, g, b, 5),
                       extend(static_cast<uint32_t>(r2), static_cast<uint32_t>(g2), static_cast<uint32_t>(b2), 5)};
  decode_halves(block, base, opaque, texels);
}

constexpr int8_t kAlphaModifiers[16][8] = {
    {-3, -6, -9, -15, 2, 5, 8, 14}, {-3, -7, -10, -13, 2, 6, 9, 12}, {-2, -5, -8, -13, 1, 4, 7, 12},
    {-2, -4, -6, -13, 1, 3, 5, 12}, {-3, -6, -8, -12, 2, 5, 7, 11},  {-3, -7, -9, -11, 2, 6, 8, 10},
    {-4, -7, -8, -11, 3, 6, 7, 10}, {-3, -5, -8, -11, 2, 4, 7, 10},  {-2, -6, -8, -10, 1, 5, 7, 9},
    {-2, -5, -8, -10, 1, 4, 7, 9},  {-2, -4, -8, -10, 1, 3, 7, 9},   {-2, -5, -7, -10, 1, 4, 6, 9},
    {-3, -4, -7, -10, 2, 3, 6, 9},  {-1, -2, -3, -10, 0, 1, 2, 9},   {-4, -6, -8, -9, 3, 5, 7, 8},
    {-3, -5, -7, -9, 2, 4, 6, 8}};

// One channel of EAC: base, multiplier and the modifier of each texel in memory order.
struct Eac {
  uint8_t base;
  int32_t multiplier;
  int8_t modifier[16];
};
Eac read_eac(const uint8_t* bytes) {
  const uint64_t block = read_big_endian(bytes);
  Eac eac{bytes[0], static_cast<int32_t>(field(block, 55, 52)), {}};
  const int8_t* table = kAlphaModifiers[field(block, 51, 48)];
  for (uint32_t pixel = 0; pixel < 16; ++pixel) eac.modifier[texel_of(pixel)] = table[block >> (45 - 3 * pixel) & 7];
  return eac;
}

// 11 bits to 16, into texels of `stride_bytes`.
void decode_eac11(const FormatInfo& format, const uint8_t* bytes, uint32_t stride_bytes, uint8_t* texels) {
  const bool is_signed = format.decoded == VK_FORMAT_R16_SNORM || format.decoded == VK_FORMAT_R16G16_SNORM;
  const Eac eac = read_eac(bytes);
  const int32_t scale = eac.multiplier == 0 ? 1 : 8 * eac.multiplier;
  const int32_t base = is_signed ? std::max<int32_t>(static_cast<int8_t>(eac.base), -127) * 8 : eac.base * 8 + 4;
  for (uint32_t i = 0; i < 16; ++i) {
    int32_t value = base + eac.modifier[i] * scale;
    if (is_signed) {
      value = std::clamp(value, -1023, 1023);
      const int32_t magnitude = value < 0 ? -value : value, wide = (magnitude << 5) + (magnitude >> 5);
      value = value < 0 ? -wide : wide;
    } else {
      value = std::clamp(value, 0, 2047);
      value = (value << 5) + (value >> 6);
    }
    const auto code = static_cast<uint16_t>(value);
    std::memcpy(texels + i * stride_bytes, &code, sizeof(code));
  }
}

}  // namespace

void decode_etc2_rgb(const FormatInfo&, const uint8_t* block, uint8_t* texels) { decode_color(block, false, texels); }

void decode_etc2_rgb_a1(const FormatInfo&, const uint8_t* block, uint8_t* texels) { decode_color(block, true, texels); }

void decode_etc2_rgba(const FormatInfo&, const uint8_t* block, uint8_t* texels) {
  decode_color(block + 8, false, texels);
  const Eac eac = read_eac(block);
  for (uint32_t i = 0; i < 16; ++i) texels[4 * i + 3] = clamp255(eac.base + eac.modifier[i] * eac.multiplier);
}

void decode_eac_r11(const FormatInfo& format, const uint8_t* block, uint8_t* texels) { decode_eac11(format, block, 2, texels); }

void decode_eac_rg11(const FormatInfo& format, const uint8_t* block, uint8_t* texels) {
  decode_eac11(format, block, 4, texels);
  decode_eac11(format, block + 8, 4, texels + 2);
}

}  // namespace pineda
