#include "tools/block_encoder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

namespace pineda::tools {
namespace {

constexpr uint32_t kTexels = kBlockSide * kBlockSide;

using Rgb = std::array<int, 3>;
using Texels = std::array<Rgb, kTexels>;  // row by row

int sum(const Rgb& c) { return c[0] + c[1] + c[2]; }

int distance(const Rgb& a, const Rgb& b) {
  int out = 0;
  for (size_t c = 0; c < 3; ++c) out += (a[c] - b[c]) * (a[c] - b[c]);
  return out;
}

// Bits of a block, numbered from the least significant bit of its first byte.
class Bits {
 public:
  explicit Bits(size_t bytes) : bytes_(bytes) {}
  void put(uint32_t value, uint32_t count) {
    for (uint32_t i = 0; i < count; ++i, ++at_) set(at_, value >> i & 1);
  }
  void set(uint32_t at, uint32_t bit) { bytes_[at / 8] = static_cast<uint8_t>(bytes_[at / 8] | bit << at % 8); }
  const std::vector<uint8_t>& bytes() const { return bytes_; }

 private:
  std::vector<uint8_t> bytes_;
  uint32_t at_ = 0;
};

struct Block {
  std::vector<uint8_t> bytes;
  Texels decoded;
};

size_t nearest(const Rgb& texel, const std::vector<Rgb>& palette) {
  const auto closer = [&](const Rgb& a, const Rgb& b) { return distance(texel, a) < distance(texel, b); };
  return static_cast<size_t>(std::ranges::min_element(palette, closer) - palette.begin());
}

Block encode_bc1(const Texels& texels) {
  const auto darker = [](const Rgb& a, const Rgb& b) { return sum(a) < sum(b); };
  const auto code = [](const Rgb& c) {
    return static_cast<uint32_t>((c[0] * 31 + 127) / 255 << 11 | (c[1] * 63 + 127) / 255 << 5 | (c[2] * 31 + 127) / 255);
  };
  uint32_t code0 = code(*std::ranges::max_element(texels, darker)), code1 = code(*std::ranges::min_element(texels, darker));
  if (code0 < code1) std::swap(code0, code1);  // four colours; equal ones leave only index 0
  const auto channel = [](uint32_t c, size_t i) {
    return i == 0 ? (c >> 11) / 31.0 : i == 1 ? (c >> 5 & 63) / 63.0 : (c & 31) / 31.0;
  };
  std::vector<Rgb> palette(code0 == code1 ? 1 : 4);
  constexpr double kWeight[4] = {0, 1, 1.0 / 3, 2.0 / 3};
  for (size_t k = 0; k < palette.size(); ++k) {
    for (size_t i = 0; i < 3; ++i) {
      palette[k][i] =
          static_cast<int>(std::lround(255 * (channel(code0, i) * (1 - kWeight[k]) + channel(code1, i) * kWeight[k])));
    }
  }
  Block out;
  Bits bits(8);
  bits.put(code0, 16);
  bits.put(code1, 16);
  for (size_t t = 0; t < kTexels; ++t) {
    const size_t index = nearest(texels[t], palette);
    bits.put(static_cast<uint32_t>(index), 2);
    out.decoded[t] = palette[index];
  }
  out.bytes = bits.bytes();
  return out;
}

// Mode 6: one pair of endpoints of 7 bits and a shared lowest bit, 16 weights.
Block encode_bc7(const Texels& texels) {
  constexpr int kWeights[16] = {0, 4, 9, 13, 17, 21, 26, 30, 34, 38, 43, 47, 51, 55, 60, 64};
  const auto darker = [](const Rgb& a, const Rgb& b) { return sum(a) < sum(b); };
  Rgb end0 = *std::ranges::min_element(texels, darker), end1 = *std::ranges::max_element(texels, darker);
  for (size_t c = 0; c < 3; ++c) end0[c] |= 1, end1[c] |= 1;
  const auto palette_of = [&] {
    std::vector<Rgb> palette(16);
    for (size_t k = 0; k < 16; ++k) {
      for (size_t c = 0; c < 3; ++c) palette[k][c] = (end0[c] * (64 - kWeights[k]) + end1[c] * kWeights[k] + 32) >> 6;
    }
    return palette;
  };
  std::vector<Rgb> palette = palette_of();
  if (nearest(texels[0], palette) >= 8) {  // the first index has no highest bit
    std::swap(end0, end1);
    palette = palette_of();
  }
  Block out;
  Bits bits(16);
  bits.put(1 << 6, 7);
  for (size_t c = 0; c < 3; ++c) {
    bits.put(static_cast<uint32_t>(end0[c]) >> 1, 7);
    bits.put(static_cast<uint32_t>(end1[c]) >> 1, 7);
  }
  bits.put(127, 7);
  bits.put(127, 7);
  bits.put(3, 2);
  for (size_t t = 0; t < kTexels; ++t) {
    size_t index = nearest(texels[t], palette);
    if (t == 0) index = std::min<size_t>(index, 7);  // where two entries are equal the swap may not have helped
    bits.put(static_cast<uint32_t>(index), t == 0 ? 3 : 4);
    out.decoded[t] = palette[index];
  }
  out.bytes = bits.bytes();
  return out;
}

// The individual mode: two halves of 2x4 texels, each a colour of 4 bits a channel and one of eight pairs of steps in brightness.
Block encode_etc2(const Texels& texels) {
  constexpr int kSteps[8][2] = {{2, 8}, {5, 17}, {9, 29}, {13, 42}, {18, 60}, {24, 80}, {33, 106}, {47, 183}};
  Block out;
  uint64_t word = 0;  // big-endian
  for (uint32_t half = 0; half < 2; ++half) {
    Rgb base{};
    for (uint32_t t = 0; t < kTexels; ++t) {
      for (size_t c = 0; c < 3 && t % 4 / 2 == half; ++c) base[c] += texels[t][c];
    }
    for (size_t c = 0; c < 3; ++c) {
      const int code = (base[c] / 8 * 15 + 127) / 255;
      base[c] = code * 17;
      word |= static_cast<uint64_t>(code) << (60 - 8 * c - 4 * half);
    }
    int best = 1 << 30;
    uint64_t best_bits = 0;
    for (uint64_t table = 0; table < 8; ++table) {
      std::vector<Rgb> palette(4, base);  // index: sign, then which step
      for (size_t k = 0; k < 4; ++k) {
        const int step = k & 2 ? -kSteps[table][k & 1] : kSteps[table][k & 1];
        for (int& c : palette[k]) c = std::clamp(c + step, 0, 255);
      }
      int error = 0;
      uint64_t bits = table << (half ? 34 : 37);
      Texels decoded = out.decoded;
      for (uint32_t t = 0; t < kTexels; ++t) {
        const uint32_t x = t % 4, y = t / 4, place = x * 4 + y;
        if (x / 2 != half) continue;
        const size_t index = nearest(texels[t], palette);
        error += distance(texels[t], palette[index]);
        bits |= static_cast<uint64_t>(index >> 1) << (16 + place) | static_cast<uint64_t>(index & 1) << place;
        decoded[t] = palette[index];
      }
      if (error >= best) continue;
      best = error, best_bits = bits, out.decoded = decoded;
    }
    word |= best_bits;
  }
  for (int shift = 56; shift >= 0; shift -= 8) out.bytes.push_back(static_cast<uint8_t>(word >> shift));
  return out;
}

// One partition, direct RGB endpoints of 8 bits, a grid of 4x4 weights of 3 bits.
Block encode_astc(const Texels& texels) {
  const auto darker = [](const Rgb& a, const Rgb& b) { return sum(a) < sum(b); };
  const Rgb end0 = *std::ranges::min_element(texels, darker), end1 = *std::ranges::max_element(texels, darker);
  std::vector<Rgb> palette(8);
  for (int k = 0; k < 8; ++k) {
    int weight = k << 3 | k;
    weight += weight > 32;
    for (size_t c = 0; c < 3; ++c) {
      const int value = (end0[c] * 257 * (64 - weight) + end1[c] * 257 * weight + 32) / 64;  // of 16 bits
      palette[static_cast<size_t>(k)][c] = static_cast<int>(std::lround(value * 255.0 / 65535));
    }
  }
  Block out;
  Bits bits(16);
  constexpr uint32_t kBlockMode = 0x53, kDirectRgb = 8;  // 4x4 weights of range 0 to 7
  bits.put(kBlockMode, 11);
  bits.put(0, 2);
  bits.put(kDirectRgb, 4);
  for (size_t c = 0; c < 3; ++c) {
    bits.put(static_cast<uint32_t>(end0[c]), 8);
    bits.put(static_cast<uint32_t>(end1[c]), 8);
  }
  for (uint32_t t = 0; t < kTexels; ++t) {  // from the last bit on, backwards
    const size_t index = nearest(texels[t], palette);
    for (uint32_t i = 0; i < 3; ++i) bits.set(127 - (3 * t + i), index >> i & 1);
    out.decoded[t] = palette[index];
  }
  out.bytes = bits.bytes();
  return out;
}

Block encode(BlockFormat format, const Texels& texels) {
  switch (format) {
    case BlockFormat::kBc1:
      return encode_bc1(texels);
    case BlockFormat::kBc7:
      return encode_bc7(texels);
    case BlockFormat::kEtc2:
      return encode_etc2(texels);
    case BlockFormat::kAstc4x4:
      return encode_astc(texels);
  }
  std::abort();
}

}  // namespace

uint32_t block_bytes(BlockFormat format) { return format == BlockFormat::kBc1 || format == BlockFormat::kEtc2 ? 8 : 16; }

EncodedImage encode_blocks(BlockFormat format, const Image& image) {
  EncodedImage out{.blocks = {}, .decoded = image};
  for (uint32_t y0 = 0; y0 < image.height; y0 += kBlockSide) {
    for (uint32_t x0 = 0; x0 < image.width; x0 += kBlockSide) {
      Texels texels;
      for (uint32_t t = 0; t < kTexels; ++t) {  // beyond the edge its last texel is repeated
        const uint8_t* from =
            image.pixel(std::min(x0 + t % kBlockSide, image.width - 1), std::min(y0 + t / kBlockSide, image.height - 1));
        texels[t] = {from[0], from[1], from[2]};
      }
      const Block block = encode(format, texels);
      out.blocks.insert(out.blocks.end(), block.bytes.begin(), block.bytes.end());
      for (uint32_t t = 0; t < kTexels; ++t) {
        const uint32_t x = x0 + t % kBlockSide, y = y0 + t / kBlockSide;
        if (x >= image.width || y >= image.height) continue;
        for (size_t c = 0; c < 3; ++c) out.decoded.pixel(x, y)[c] = static_cast<uint8_t>(block.decoded[t][c]);
        out.decoded.pixel(x, y)[3] = 255;
      }
    }
  }
  return out;
}

}  // namespace pineda::tools
