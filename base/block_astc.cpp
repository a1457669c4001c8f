// ASTC, LDR profile: Khronos Data Format Specification, chapter "ASTC". Bit-exact; linear formats are decoded to binary16
// (decode_float16, the default without VK_EXT_astc_decode_mode), sRGB formats to 8-bit codes.
#include <algorithm>
#include <array>
#include <bit>

#include "base/astc_sequence.h"
#include "base/block_codec.h"
#include "base/block_decoders.h"

namespace pineda {
namespace {

constexpr uint32_t kMaxWeights = 64, kMaxColorValues = 18;

// Bits 0 to 10, "Block mode".
struct BlockMode {
  uint32_t grid_width, grid_height, weight_range;
  bool dual_plane;
};

// False for reserved modes.
bool read_mode(const BlockBits& bits, BlockMode* out) {
  const uint32_t low = bits.get(0, 2), a = bits.get(5, 2), b = bits.get(7, 2);
  bool precise = bits.get(9, 1) != 0;
  out->dual_plane = bits.get(10, 1) != 0;
  uint32_t rho = 0;
  if (low != 0) {
    rho = low << 1 | bits.get(4, 1);
    switch (bits.get(2, 2)) {
      case 0:
        out->grid_width = b + 4, out->grid_height = a + 2;
        break;
      case 1:
        out->grid_width = b + 8, out->grid_height = a + 2;
        break;
      case 2:
        out->grid_width = a + 2, out->grid_height = b + 8;
        break;
      default:
        if (b < 2) {
          out->grid_width = a + 2, out->grid_height = b + 6;
        } else {
          out->grid_width = b, out->grid_height = a + 2;  // b - 2 + 2
        }
        break;
    }
  } else {
    if (bits.get(2, 2) == 0) return false;
    rho = bits.get(2, 2) << 1 | bits.get(4, 1);
    switch (b) {
      case 0:
        out->grid_width = 12, out->grid_height = a + 2;
        break;
      case 1:
        out->grid_width = a + 2, out->grid_height = 12;
        break;
      case 2:
        out->grid_width = a + 6, out->grid_height = bits.get(9, 2) + 6;
        precise = out->dual_plane = false;
        break;
      default:
        if (a > 1) return false;
        out->grid_width = a == 0 ? 6 : 10, out->grid_height = a == 0 ? 10 : 6;
        break;
    }
  }
  out->weight_range = rho - 2 + (precise ? 6 : 0);
  return rho >= 2;
}

// "Color Endpoint Mode" of each partition, and where the colours are.
struct ColorModes {
  std::array<uint32_t, 4> mode{};
  uint32_t first_bit = 17;  // of the colours
  uint32_t extra_bits = 0;  // of the modes, below the weights
  uint32_t value_count = 0;
};

ColorModes read_color_modes(const BlockBits& bits, uint32_t partitions, uint32_t weight_bits) {
  ColorModes modes;
  if (partitions == 1) {
    modes.mode[0] = bits.get(13, 4);
  } else {
    modes.first_bit = 29;
    uint32_t field = bits.get(23, 6);
    if ((field & 3) == 0) {
      modes.mode.fill(field >> 2);
    } else {
      modes.extra_bits = 3 * partitions - 4;
      field |= bits.get(128 - weight_bits - modes.extra_bits, modes.extra_bits) << 6;
      for (uint32_t i = 0; i < partitions; ++i) {
        const uint32_t mode_class = (field & 3) - 1 + (field >> (2 + i) & 1);
        modes.mode[i] = mode_class << 2 | (field >> (2 + partitions + 2 * i) & 3);
      }
    }
  }
  for (uint32_t i = 0; i < partitions; ++i) modes.value_count += 2 * ((modes.mode[i] >> 2) + 1);
  return modes;
}

// ---- endpoints ------------------------------------------------------------------------------------------------------------

using Color = std::array<int32_t, 4>;
struct Endpoints {
  Color e0, e1;
  bool error = false;  // HDR modes
};

void bit_transfer_signed(int32_t& a, int32_t& b) {
  b = b >> 1 | (a & 0x80);
  a = a >> 1 & 0x3f;
  if (a & 0x20) a -= 0x40;
}

Color blue_contract(const Color& c) { return {(c[0] + c[2]) >> 1, (c[1] + c[2]) >> 1, c[2], c[3]}; }

Color clamp_unorm8(Color c) {
  for (int32_t& v : c) v = std::clamp(v, 0, 255);
  return c;
}

Endpoints luminance(uint32_t mode, int32_t v0, int32_t v1) {
  if (mode == 0) return {{v0, v0, v0, 255}, {v1, v1, v1, 255}};
  const int32_t l0 = v0 >> 2 | (v1 & 0xc0), l1 = std::min(l0 + (v1 & 0x3f), 255);
  return {{l0, l0, l0, 255}, {l1, l1, l1, 255}};
}

Endpoints base_offset(Color base, Color offset) {
  for (int c = 0; c < 4; ++c) bit_transfer_signed(offset[c], base[c]);
  const bool swapped = offset[0] + offset[1] + offset[2] < 0;
  const Color sum = {base[0] + offset[0], base[1] + offset[1], base[2] + offset[2], base[3] + offset[3]};
  if (swapped) return {clamp_unorm8(blue_contract(sum)), clamp_unorm8(blue_contract(base))};
  return {clamp_unorm8(base), clamp_unorm8(sum)};
}

Endpoints direct(const Color& c0, const Color& c1) {
  if (c1[0] + c1[1] + c1[2] >= c0[0] + c0[1] + c0[2]) return {c0, c1};
  return {blue_contract(c1), blue_contract(c0)};
}

// `v`: unquantized values.
Endpoints decode_endpoints(uint32_t mode, const int32_t* v) {
  switch (mode) {
    case 0:
    case 1:
      return luminance(mode, v[0], v[1]);
    case 4:
      return {{v[0], v[0], v[0], v[2]}, {v[1], v[1], v[1], v[3]}};
    case 5: {
      int32_t l0 = v[0], l1 = v[1], a0 = v[2], a1 = v[3];
      bit_transfer_signed(l1, l0);
      bit_transfer_signed(a1, a0);
      return {clamp_unorm8({l0, l0, l0, a0}), clamp_unorm8({l0 + l1, l0 + l1, l0 + l1, a0 + a1})};
    }
    case 6:
    case 10: {
      const int32_t a0 = mode == 6 ? 255 : v[4], a1 = mode == 6 ? 255 : v[5];
      return {{v[0] * v[3] >> 8, v[1] * v[3] >> 8, v[2] * v[3] >> 8, a0}, {v[0], v[1], v[2], a1}};
    }
    case 8:
      return direct({v[0], v[2], v[4], 255}, {v[1], v[3], v[5], 255});
    case 9: {
      Endpoints e = base_offset({v[0], v[2], v[4], 0}, {v[1], v[3], v[5], 0});
      e.e0[3] = e.e1[3] = 255;
      return e;
    }
    case 12:
      return direct({v[0], v[2], v[4], v[6]}, {v[1], v[3], v[5], v[7]});
    case 13:
      return base_offset({v[0], v[2], v[4], v[6]}, {v[1], v[3], v[5], v[7]});
    default:
      return {{}, {}, true};
  }
}

// ---- partitions and weights -----------------------------------------------------------------------------------------------

// "Partition Pattern Generation".
struct PartitionPattern {
  uint32_t random, count, seed;
  uint32_t factor[8];

  PartitionPattern(uint32_t index, uint32_t partitions) : count(partitions) {
    seed = index + (partitions - 1) * 1024;
    uint32_t p = seed;
    p ^= p >> 15, p -= p << 17, p += p << 7, p += p << 4;
    p ^= p >> 5, p += p << 16, p ^= p >> 7, p ^= p >> 3;
    p ^= p << 6, p ^= p >> 17;
    random = p;
    const uint32_t by_count = partitions == 3 ? 6 : 5, by_seed = seed & 2 ? 4 : 5;
    const uint32_t shift[2] = {seed & 1 ? by_seed : by_count, seed & 1 ? by_count : by_seed};
    for (uint32_t i = 0; i < 8; ++i) {
      const uint32_t nibble = p >> 4 * i & 15;
      factor[i] = nibble * nibble >> shift[i & 1];
    }
  }

  uint32_t of(uint32_t x, uint32_t y) const {
    const uint32_t a = (factor[0] * x + factor[1] * y + (random >> 14)) & 63;
    const uint32_t b = (factor[2] * x + factor[3] * y + (random >> 10)) & 63;
    const uint32_t c = count < 3 ? 0 : (factor[4] * x + factor[5] * y + (random >> 6)) & 63;
    const uint32_t d = count < 4 ? 0 : (factor[6] * x + factor[7] * y + (random >> 2)) & 63;
    if (a >= b && a >= c && a >= d) return 0;
    if (b >= c && b >= d) return 1;
    return c >= d ? 2 : 3;
  }
};

BlockBits reversed(const uint8_t* block) {
  uint8_t out[16];
  for (int i = 0; i < 16; ++i) {
    uint32_t v = block[15 - i];
    v = (v & 0xf0) >> 4 | (v & 0x0f) << 4;
    v = (v & 0xcc) >> 2 | (v & 0x33) << 2;
    out[i] = static_cast<uint8_t>((v & 0xaa) >> 1 | (v & 0x55) << 1);
  }
  return BlockBits(out);
}

// "Weight Infill": the weights of each texel from those of the grid. Grids of two planes alternate.
struct Infill {
  uint32_t grid_width, planes;
  const uint8_t* grid;  // with room to read one row and one weight too far: those have the factor 0

  uint32_t at(uint32_t gs, uint32_t gt, uint32_t plane) const {
    const uint32_t fs = gs & 15, ft = gt & 15, first = (gs >> 4) + (gt >> 4) * grid_width;
    const uint32_t w11 = (fs * ft + 8) >> 4, w10 = ft - w11, w01 = fs - w11, w00 = 16 - fs - ft + w11;
    const auto weight = [&](uint32_t i) { return uint32_t{grid[(first + i) * planes + plane]}; };
    return (weight(0) * w00 + weight(1) * w01 + weight(grid_width) * w10 + weight(grid_width + 1) * w11 + 8) >> 4;
  }
};

uint32_t grid_position(uint32_t texel, uint32_t block_size, uint32_t grid_size) {
  const uint32_t scale = (1024 + block_size / 2) / (block_size - 1);
  return (scale * texel * (grid_size - 1) + 32) >> 6;
}

// ---- output ---------------------------------------------------------------------------------------------------------------

// A 16-bit UNORM result of the interpolator as binary16: divided by 65536 and rounded toward zero, 65535 being 1.0.
uint16_t unorm16_to_half(uint32_t c) {
  if (c == 65535) return 0x3c00;
  if (c < 4) return static_cast<uint16_t>(c << 8);  // denormal
  const auto top = static_cast<uint32_t>(std::bit_width(c)) - 1;
  const uint32_t mantissa = top > 10 ? c >> (top - 10) : c << (10 - top);
  return static_cast<uint16_t>((top - 1) << 10 | (mantissa & 0x3ff));
}

class Output {
 public:
  Output(const FormatInfo& format, uint8_t* texels) : texels_(texels), srgb_(format.decoded == VK_FORMAT_R8G8B8A8_SRGB) {}

  bool srgb() const { return srgb_; }

  void store(uint32_t texel, const uint32_t (&unorm16)[4]) const {
    for (uint32_t c = 0; c < 4; ++c) {
      if (srgb_) {
        texels_[4 * texel + c] = static_cast<uint8_t>(unorm16[c] >> 8);
      } else {
        const uint16_t half = unorm16_to_half(unorm16[c]);
        std::memcpy(texels_ + 8 * texel + 2 * c, &half, sizeof(half));
      }
    }
  }
  void error(uint32_t texel) const { store(texel, {65535, 0, 65535, 65535}); }  // magenta

 private:
  uint8_t* texels_;
  bool srgb_;
};

void fill_error(const FormatInfo& format, const Output& out) {
  for (uint32_t i = 0; i < uint32_t{format.block_width} * format.block_height; ++i) out.error(i);
}

// "Void-Extent Blocks": one colour.
void decode_void_extent(const FormatInfo& format, const BlockBits& bits, const Output& out) {
  const uint32_t min_s = bits.get(12, 13), max_s = bits.get(25, 13), min_t = bits.get(38, 13), max_t = bits.get(51, 13);
  const bool no_extent = (min_s & max_s & min_t & max_t) == 0x1fff;
  const bool hdr = bits.get(9, 1) != 0, reserved_set = bits.get(10, 2) == 3;
  if (hdr || !reserved_set || (!no_extent && (min_s >= max_s || min_t >= max_t))) return fill_error(format, out);
  uint32_t color[4];
  for (uint32_t c = 0; c < 4; ++c) color[c] = bits.get(64 + 16 * c, 16);
  for (uint32_t i = 0; i < uint32_t{format.block_width} * format.block_height; ++i) out.store(i, color);
}

// Everything that a legal block says.
struct Block {
  BlockMode mode;
  uint32_t partitions;
  std::array<Endpoints, 4> endpoints;
  uint32_t second_plane_component = 4;  // none
  uint8_t weights[2 * kMaxWeights + 32] = {};
};

// False for illegal encodings, in the order of the specification's list.
bool read_block(const FormatInfo& format, const uint8_t* bytes, const BlockBits& bits, Block* block) {
  BlockMode& mode = block->mode;
  if (!read_mode(bits, &mode)) return false;
  const uint32_t planes = mode.dual_plane ? 2 : 1, weights = mode.grid_width * mode.grid_height * planes;
  if (weights > kMaxWeights || mode.grid_width > format.block_width || mode.grid_height > format.block_height) return false;
  const uint32_t weight_bits = astc::sequence_bits(mode.weight_range, weights);
  if (weight_bits < 24 || weight_bits > 96) return false;
  block->partitions = bits.get(11, 2) + 1;
  if (mode.dual_plane && block->partitions == 4) return false;
  const ColorModes colors = read_color_modes(bits, block->partitions, weight_bits);
  if (colors.value_count > kMaxColorValues) return false;
  const uint32_t selector_bits = mode.dual_plane ? 2 : 0,
                 taken = colors.first_bit + colors.extra_bits + selector_bits + weight_bits;
  const uint32_t available = taken < 128 ? 128 - taken : 0;
  if (available < (13 * colors.value_count + 4) / 5) return false;
  if (mode.dual_plane) block->second_plane_component = bits.get(128 - weight_bits - colors.extra_bits - 2, 2);

  uint32_t range = astc::kRanges - 1;
  while (astc::sequence_bits(range, colors.value_count) > available) --range;
  uint8_t raw[kMaxColorValues];
  int32_t values[kMaxColorValues];
  astc::read_sequence(bits, colors.first_bit, range, colors.value_count, raw);
  for (uint32_t i = 0; i < colors.value_count; ++i) values[i] = astc::unquantize_color(range, raw[i]);
  const int32_t* next = values;
  for (uint32_t i = 0; i < block->partitions; ++i) {
    block->endpoints[i] = decode_endpoints(colors.mode[i], next);
    next += 2 * ((colors.mode[i] >> 2) + 1);
  }
  astc::read_sequence(reversed(bytes), 0, mode.weight_range, weights, block->weights);
  for (uint32_t i = 0; i < weights; ++i) block->weights[i] = astc::unquantize_weight(mode.weight_range, block->weights[i]);
  return true;
}

// "Weight Application".
void store_texel(const Output& out, uint32_t texel, const Endpoints& e, const uint32_t (&weight)[4]) {
  uint32_t result[4];
  for (uint32_t c = 0; c < 4; ++c) {
    const auto widen = [&](int32_t v) {
      return static_cast<uint32_t>(v) << 8 | (out.srgb() && c < 3 ? 0x80u : static_cast<uint32_t>(v));
    };
    result[c] = (widen(e.e0[c]) * (64 - weight[c]) + widen(e.e1[c]) * weight[c] + 32) >> 6;
  }
  out.store(texel, result);
}

}  // namespace

void decode_astc(const FormatInfo& format, const uint8_t* bytes, uint8_t* texels) {
  const BlockBits bits(bytes);
  const Output out(format, texels);
  if (bits.get(0, 9) == 0x1fc) return decode_void_extent(format, bits, out);
  Block block;
  if (!read_block(format, bytes, bits, &block)) return fill_error(format, out);
  const uint32_t width = format.block_width, height = format.block_height;
  const uint32_t planes = block.mode.dual_plane ? 2 : 1, pattern_scale = width * height < 31 ? 2 : 1;
  const PartitionPattern pattern(bits.get(13, 10), block.partitions);
  const Infill infill{block.mode.grid_width, planes, block.weights};
  for (uint32_t y = 0; y < height; ++y) {
    const uint32_t gt = grid_position(y, height, block.mode.grid_height);
    for (uint32_t x = 0; x < width; ++x) {
      const uint32_t texel = y * width + x;
      const Endpoints& e = block.endpoints[block.partitions == 1 ? 0 : pattern.of(x * pattern_scale, y * pattern_scale)];
      if (e.error) {
        out.error(texel);
        continue;
      }
      const uint32_t gs = grid_position(x, width, block.mode.grid_width);
      const uint32_t first = infill.at(gs, gt, 0);
      uint32_t weight[4] = {first, first, first, first};
      if (planes == 2) weight[block.second_plane_component] = infill.at(gs, gt, 1);
      store_texel(out, texel, e, weight);
    }
  }
}

}  // namespace pineda
