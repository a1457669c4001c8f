// BC6H and BC7: Khronos Data Format Specification, chapter "BPTC". Bit-exact, as it demands.
#include <array>
#include <string_view>

#include "base/block_decoders.h"

namespace pineda {
namespace {

struct Bc6hMode {
  uint8_t mode;
  bool transformed;
  uint8_t partition_bits, endpoint_bits;
  std::array<uint8_t, 3> delta_bits;
  std::string_view layout;
};

#include "base/bptc_tables.inc"

struct Partitions {
  std::array<std::array<uint8_t, 16>, 64> two{}, three{};
};
constexpr Partitions kPartitions = [] {
  Partitions p;
  for (int i = 0; i < 64; ++i) {
    for (int texel = 0; texel < 16; ++texel) {
      p.two[i][texel] = static_cast<uint8_t>(kTwoSubsets[i][texel] - '0');
      p.three[i][texel] = static_cast<uint8_t>(kThreeSubsets[i][texel] - '0');
    }
  }
  return p;
}();

constexpr uint8_t kWeights2[4] = {0, 21, 43, 64};
constexpr uint8_t kWeights3[8] = {0, 9, 18, 27, 37, 46, 55, 64};
constexpr uint8_t kWeights4[16] = {0, 4, 9, 13, 17, 21, 26, 30, 34, 38, 43, 47, 51, 55, 60, 64};

const uint8_t* weights_of(uint32_t index_bits) { return index_bits == 2 ? kWeights2 : index_bits == 3 ? kWeights3 : kWeights4; }

int32_t interpolate(int32_t e0, int32_t e1, int32_t weight) { return ((64 - weight) * e0 + weight * e1 + 32) >> 6; }

// Subset of each texel and the texels whose index is one bit shorter.
struct Subsets {
  const uint8_t* of_texel;
  uint32_t anchor[3];
};
constexpr uint8_t kOneSubset[16] = {};
constexpr uint32_t kNoAnchor = 16;

Subsets subsets_of(uint32_t count, uint32_t partition) {
  if (count == 1) return {kOneSubset, {0, kNoAnchor, kNoAnchor}};
  if (count == 2) return {kPartitions.two[partition].data(), {0, kAnchorOfTwo[partition], kNoAnchor}};
  return {kPartitions.three[partition].data(), {0, kSecondAnchorOfThree[partition], kThirdAnchorOfThree[partition]}};
}

// The weights of all texels; returns the bit after the indices.
uint32_t read_weights(const BlockBits& bits, uint32_t at, uint32_t index_bits, const Subsets& subsets, uint8_t* weights) {
  const uint8_t* table = weights_of(index_bits);
  for (uint32_t i = 0; i < 16; ++i) {
    const bool short_index = i == subsets.anchor[0] || i == subsets.anchor[1] || i == subsets.anchor[2];
    const uint32_t count = index_bits - short_index;
    weights[i] = table[bits.get(at, count)];
    at += count;
  }
  return at;
}

// ---- BC7 ------------------------------------------------------------------------------------------------------------------

struct Bc7Mode {
  uint8_t subsets, partition_bits, rotation_bits, selection_bits, color_bits, alpha_bits, endpoint_p_bits, shared_p_bits;
  uint8_t index_bits, second_index_bits;
};
constexpr Bc7Mode kBc7Modes[8] = {{3, 4, 0, 0, 4, 0, 1, 0, 3, 0}, {2, 6, 0, 0, 6, 0, 0, 1, 3, 0}, {3, 6, 0, 0, 5, 0, 0, 0, 2, 0},
                                  {2, 6, 0, 0, 7, 0, 1, 0, 2, 0}, {1, 0, 2, 1, 5, 6, 0, 0, 2, 3}, {1, 0, 2, 0, 7, 8, 0, 0, 2, 2},
                                  {1, 0, 0, 0, 7, 7, 1, 0, 4, 0}, {2, 6, 0, 0, 5, 5, 1, 0, 2, 0}};

struct Bc7Endpoints {
  uint8_t value[6][4];  // two of each subset, RGBA
};

Bc7Endpoints read_endpoints(const Bc7Mode& mode, const BlockBits& bits, uint32_t& at) {
  const uint32_t count = 2 * mode.subsets;
  uint32_t raw[6][4] = {};
  for (uint32_t c = 0; c < 4; ++c) {
    const uint32_t width = c < 3 ? mode.color_bits : mode.alpha_bits;
    for (uint32_t e = 0; e < count; ++e, at += width) raw[e][c] = bits.get(at, width);
  }
  uint32_t p[6] = {};
  const bool has_p = mode.endpoint_p_bits || mode.shared_p_bits;
  for (uint32_t e = 0; e < count; ++e) p[e] = bits.get(at + (mode.shared_p_bits ? e / 2 : e), 1);
  at += mode.shared_p_bits ? mode.subsets : mode.endpoint_p_bits ? count : 0;
  Bc7Endpoints endpoints{};
  for (uint32_t e = 0; e < count; ++e) {
    for (uint32_t c = 0; c < 4; ++c) {
      uint32_t width = c < 3 ? mode.color_bits : mode.alpha_bits;
      if (width == 0) {
        endpoints.value[e][c] = 255;
        continue;
      }
      uint32_t value = raw[e][c];
      if (has_p) value = value << 1 | p[e], ++width;
      value <<= 8 - width;
      endpoints.value[e][c] = static_cast<uint8_t>(value | value >> width);
    }
  }
  return endpoints;
}

// ---- BC6H -----------------------------------------------------------------------------------------------------------------

// Layouts as lists of channel << 6 | endpoint << 4 | bit, one for each bit after the mode's.
struct Bc6hLayout {
  std::array<uint8_t, 82> target{};
  uint8_t count = 0;
};

constexpr Bc6hLayout parse_layout(std::string_view text) {
  Bc6hLayout out;
  size_t i = 0;
  const auto number = [&] {
    int value = 0;
    for (; i < text.size() && text[i] >= '0' && text[i] <= '9'; ++i) value = 10 * value + (text[i] - '0');
    return value;
  };
  while (i < text.size()) {
    const int channel = text[i] == 'R' ? 0 : text[i] == 'G' ? 1 : 2, endpoint = text[i + 1] - '0';
    i += 3;
    const int left = number();
    int right = left;
    if (i < text.size() && text[i] == '-') ++i, right = number();
    // The right-hand bit comes first in the block.
    const int step = left >= right ? 1 : -1;
    for (int bit = right;; bit += step) {
      out.target[out.count++] = static_cast<uint8_t>(channel << 6 | endpoint << 4 | bit);
      if (bit == left) break;
    }
    while (i < text.size() && text[i] == ' ') ++i;
  }
  return out;
}

constexpr auto kLayouts = [] {
  std::array<Bc6hLayout, std::size(kBc6hModes)> layouts;
  for (size_t i = 0; i < layouts.size(); ++i) layouts[i] = parse_layout(kBc6hModes[i].layout);
  return layouts;
}();

int32_t sign_extend(uint32_t value, uint32_t bits) { return static_cast<int32_t>(value << (32 - bits)) >> (32 - bits); }

struct Bc6hEndpoints {
  int32_t value[4][3];
};

Bc6hEndpoints read_bc6h_endpoints(const Bc6hMode& mode, const Bc6hLayout& layout, const BlockBits& bits, uint32_t at,
                                  bool is_signed) {
  uint32_t raw[4][3] = {};
  for (uint32_t i = 0; i < layout.count; ++i) {
    const uint8_t target = layout.target[i];
    raw[target >> 4 & 3][target >> 6] |= bits.get(at + i, 1) << (target & 15);
  }
  Bc6hEndpoints endpoints{};
  const uint32_t mask = (1u << mode.endpoint_bits) - 1;
  for (uint32_t e = 0; e < (mode.partition_bits ? 4 : 2); ++e) {
    for (uint32_t c = 0; c < 3; ++c) {
      uint32_t value = raw[e][c];
      if (e > 0 && mode.transformed) {
        value = (raw[0][c] + static_cast<uint32_t>(sign_extend(value, mode.delta_bits[c]))) & mask;
      }
      endpoints.value[e][c] = is_signed ? sign_extend(value, mode.endpoint_bits) : static_cast<int32_t>(value);
    }
  }
  return endpoints;
}

int32_t unquantize(int32_t x, int32_t bits, bool is_signed) {
  if (!is_signed) {
    if (bits >= 15 || x == 0) return x;
    return x == (1 << bits) - 1 ? 0xffff : ((x << 15) + 0x4000) >> (bits - 1);
  }
  if (bits >= 16 || x == 0) return x;
  const int32_t magnitude = x < 0 ? -x : x;
  const int32_t value = magnitude >= (1 << (bits - 1)) - 1 ? 0x7fff : ((magnitude << 15) + 0x4000) >> (bits - 1);
  return x < 0 ? -value : value;
}

uint16_t to_half(int32_t value, bool is_signed) {
  if (!is_signed) return static_cast<uint16_t>(value * 31 >> 6);
  return static_cast<uint16_t>(value < 0 ? (-value * 31 >> 5) | 0x8000 : value * 31 >> 5);
}

int find_bc6h_mode(const BlockBits& bits) {
  const uint32_t low = bits.get(0, 2), mode = low < 2 ? low : bits.get(0, 5);
  for (size_t i = 0; i < std::size(kBc6hModes); ++i) {
    if (kBc6hModes[i].mode == mode) return static_cast<int>(i);
  }
  return -1;
}

}  // namespace

void decode_bc7(const FormatInfo&, const uint8_t* block, uint8_t* texels) {
  if (block[0] == 0) {  // reserved
    std::memset(texels, 0, 64);
    return;
  }
  const BlockBits bits(block);
  const auto mode_number = static_cast<uint32_t>(__builtin_ctz(block[0]));
  const Bc7Mode& mode = kBc7Modes[mode_number];
  uint32_t at = mode_number + 1;
  const auto take = [&](uint32_t count) {
    const uint32_t value = bits.get(at, count);
    at += count;
    return value;
  };
  const uint32_t partition = take(mode.partition_bits), rotation = take(mode.rotation_bits),
                 selection = take(mode.selection_bits);
  const Bc7Endpoints endpoints = read_endpoints(mode, bits, at);
  const Subsets subsets = subsets_of(mode.subsets, partition);
  uint8_t first[16], second[16];
  at = read_weights(bits, at, mode.index_bits, subsets, first);
  if (mode.second_index_bits) read_weights(bits, at, mode.second_index_bits, subsets, second);
  const uint8_t* color_weights = selection ? second : first;
  const uint8_t* alpha_weights = mode.second_index_bits && !selection ? second : first;
  for (uint32_t i = 0; i < 16; ++i) {
    const uint8_t* e0 = endpoints.value[2 * subsets.of_texel[i]];
    const uint8_t* e1 = endpoints.value[2 * subsets.of_texel[i] + 1];
    uint8_t* texel = texels + 4 * i;
    for (uint32_t c = 0; c < 4; ++c) {
      texel[c] = static_cast<uint8_t>(interpolate(e0[c], e1[c], c < 3 ? color_weights[i] : alpha_weights[i]));
    }
    if (rotation) std::swap(texel[3], texel[rotation - 1]);
  }
}

void decode_bc6h(const FormatInfo& format, const uint8_t* block, uint8_t* texels) {
  constexpr uint16_t kOne = 0x3c00;
  const bool is_signed = format.format == VK_FORMAT_BC6H_SFLOAT_BLOCK;
  const BlockBits bits(block);
  const int index = find_bc6h_mode(bits);
  uint16_t out[16][4];
  if (index < 0) {  // reserved
    for (auto& texel : out) texel[0] = texel[1] = texel[2] = 0, texel[3] = kOne;
    std::memcpy(texels, out, sizeof(out));
    return;
  }
  const Bc6hMode& mode = kBc6hModes[index];
  const Bc6hLayout& layout = kLayouts[index];
  const uint32_t at = mode.mode < 2 ? 2 : 5;
  Bc6hEndpoints endpoints = read_bc6h_endpoints(mode, layout, bits, at, is_signed);
  for (auto& endpoint : endpoints.value) {
    for (int32_t& value : endpoint) value = unquantize(value, mode.endpoint_bits, is_signed);
  }
  const uint32_t after = at + layout.count, partition = bits.get(after, mode.partition_bits);
  const Subsets subsets = subsets_of(mode.partition_bits ? 2 : 1, partition);
  uint8_t weights[16];
  read_weights(bits, after + mode.partition_bits, mode.partition_bits ? 3 : 4, subsets, weights);
  for (uint32_t i = 0; i < 16; ++i) {
    const auto& e0 = endpoints.value[2 * subsets.of_texel[i]];
    const auto& e1 = endpoints.value[2 * subsets.of_texel[i] + 1];
    for (uint32_t c = 0; c < 3; ++c) out[i][c] = to_half(interpolate(e0[c], e1[c], weights[i]), is_signed);
    out[i][3] = kOne;
  }
  std::memcpy(texels, out, sizeof(out));
}

}  // namespace pineda
