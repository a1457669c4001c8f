#include "base/astc_sequence.h"

#include <algorithm>
#include <array>
#include <string_view>

namespace pineda::astc {
namespace {

struct Range {
  bool trits, quints;
  uint8_t bits;
};
constexpr Range kRange[kRanges] = {{0, 0, 1}, {1, 0, 0}, {0, 0, 2}, {0, 1, 0}, {1, 0, 1}, {0, 0, 3}, {0, 1, 1},
                                   {1, 0, 2}, {0, 0, 4}, {0, 1, 2}, {1, 0, 3}, {0, 0, 5}, {0, 1, 3}, {1, 0, 4},
                                   {0, 0, 6}, {0, 1, 4}, {1, 0, 5}, {0, 0, 7}, {0, 1, 5}, {1, 0, 6}, {0, 0, 8}};

constexpr uint32_t bit(uint32_t value, uint32_t i) { return value >> i & 1; }
constexpr uint32_t field(uint32_t value, uint32_t high, uint32_t low) { return value >> low & ((1u << (high - low + 1)) - 1); }

// "The five trits are obtained by bit manipulations of the 8 bits T".
constexpr std::array<uint8_t, 5> unpack_trits(uint32_t t) {
  std::array<uint32_t, 5> v{};
  uint32_t c = 0;
  if (field(t, 4, 2) == 7) {
    c = field(t, 7, 5) << 2 | field(t, 1, 0);
    v[4] = v[3] = 2;
  } else {
    c = field(t, 4, 0);
    if (field(t, 6, 5) == 3) {
      v[4] = 2, v[3] = bit(t, 7);
    } else {
      v[4] = bit(t, 7), v[3] = field(t, 6, 5);
    }
  }
  if (field(c, 1, 0) == 3) {
    v[2] = 2, v[1] = bit(c, 4), v[0] = bit(c, 3) << 1 | (bit(c, 2) & ~bit(c, 3) & 1);
  } else if (field(c, 3, 2) == 3) {
    v[2] = 2, v[1] = 2, v[0] = field(c, 1, 0);
  } else {
    v[2] = bit(c, 4), v[1] = field(c, 3, 2), v[0] = bit(c, 1) << 1 | (bit(c, 0) & ~bit(c, 1) & 1);
  }
  std::array<uint8_t, 5> out{};
  for (int i = 0; i < 5; ++i) out[i] = static_cast<uint8_t>(v[i]);
  return out;
}

constexpr std::array<uint8_t, 3> unpack_quints(uint32_t q) {
  uint32_t q0 = 0, q1 = 0, q2 = 0;
  if (field(q, 2, 1) == 3 && field(q, 6, 5) == 0) {
    const uint32_t not0 = bit(q, 0) ^ 1;
    q2 = bit(q, 0) << 2 | (bit(q, 4) & not0) << 1 | (bit(q, 3) & not0);
    q1 = q0 = 4;
  } else {
    uint32_t c = 0;
    if (field(q, 2, 1) == 3) {
      q2 = 4, c = field(q, 4, 3) << 3 | (field(q, 6, 5) ^ 3) << 1 | bit(q, 0);
    } else {
      q2 = field(q, 6, 5), c = field(q, 4, 0);
    }
    if (field(c, 2, 0) == 5) {
      q1 = 4, q0 = field(c, 4, 3);
    } else {
      q1 = field(c, 4, 3), q0 = field(c, 2, 0);
    }
  }
  return {static_cast<uint8_t>(q0), static_cast<uint8_t>(q1), static_cast<uint8_t>(q2)};
}

constexpr auto kTrits = [] {
  std::array<std::array<uint8_t, 5>, 256> table;
  for (uint32_t t = 0; t < 256; ++t) table[t] = unpack_trits(t);
  return table;
}();
constexpr auto kQuints = [] {
  std::array<std::array<uint8_t, 3>, 128> table;
  for (uint32_t q = 0; q < 128; ++q) table[q] = unpack_quints(q);
  return table;
}();

// Parameters B (letters are bits of the value, 'a' its lowest) and C of the unquantization, by the number of bits.
struct Unquantization {
  std::string_view b;
  uint16_t c;
};
constexpr Unquantization kColorTrits[7] = {
    {}, {"000000000", 204}, {"b000b0bb0", 93}, {"cb000cbcb", 44}, {"dcb000dcb", 22}, {"edcb000ed", 11}, {"fedcb000f", 5}};
constexpr Unquantization kColorQuints[6] = {
    {}, {"000000000", 113}, {"b0000bb00", 54}, {"cb0000cbc", 26}, {"dcb0000dc", 13}, {"edcb0000e", 6}};
constexpr Unquantization kWeightTrits[4] = {{}, {"0000000", 50}, {"b000b0b", 23}, {"cb000cb", 11}};
constexpr Unquantization kWeightQuints[3] = {{}, {"0000000", 28}, {"b0000b0", 13}};

constexpr uint32_t scramble(const Unquantization& u, uint32_t digit, uint32_t low, uint32_t sign_bit) {
  uint32_t b = 0;
  for (const char letter : u.b) b = b << 1 | (letter == '0' ? 0 : bit(low, static_cast<uint32_t>(letter - 'a')));
  const uint32_t a = bit(low, 0) ? (1u << u.b.size()) - 1 : 0;
  return (a & sign_bit) | ((digit * u.c + b) ^ a) >> 2;
}

constexpr uint32_t replicate(uint32_t value, uint32_t from_bits, uint32_t to_bits) {
  uint32_t out = 0;
  for (uint32_t i = 0; i < to_bits; ++i) out = out << 1 | bit(value, from_bits - 1 - i % from_bits);
  return out;
}

constexpr uint32_t largest(const Range& r) { return (r.trits ? 3u : r.quints ? 5u : 1u) * (1u << r.bits); }  // exclusive

constexpr auto kColors = [] {
  std::array<std::array<uint8_t, 256>, kRanges> table{};
  for (uint32_t range = kSmallestColorRange; range < kRanges; ++range) {
    const Range r = kRange[range];
    for (uint32_t v = 0; v < largest(r); ++v) {
      const uint32_t digit = v >> r.bits, low = v & ((1u << r.bits) - 1);
      table[range][v] = static_cast<uint8_t>(r.trits    ? scramble(kColorTrits[r.bits], digit, low, 0x80)
                                             : r.quints ? scramble(kColorQuints[r.bits], digit, low, 0x80)
                                                        : replicate(v, r.bits, 8));
    }
  }
  return table;
}();

constexpr auto kWeights = [] {
  constexpr uint8_t kThree[3] = {0, 32, 63}, kFive[5] = {0, 16, 32, 47, 63};
  std::array<std::array<uint8_t, 32>, kWeightRanges> table{};
  for (uint32_t range = 0; range < kWeightRanges; ++range) {
    const Range r = kRange[range];
    for (uint32_t v = 0; v < largest(r); ++v) {
      const uint32_t digit = v >> r.bits, low = v & ((1u << r.bits) - 1);
      uint32_t weight = 0;
      if (r.bits == 0) {
        weight = r.trits ? kThree[v] : kFive[v];
      } else if (r.trits || r.quints) {
        weight = scramble(r.trits ? kWeightTrits[r.bits] : kWeightQuints[r.bits], digit, low, 0x20);
      } else {
        weight = replicate(v, r.bits, 6);
      }
      table[range][v] = static_cast<uint8_t>(weight > 32 ? weight + 1 : weight);
    }
  }
  return table;
}();

}  // namespace

uint32_t sequence_bits(uint32_t range, uint32_t count) {
  const Range r = kRange[range];
  return count * r.bits + (r.trits ? (8 * count + 4) / 5 : r.quints ? (7 * count + 2) / 3 : 0);
}

void read_sequence(const BlockBits& bits, uint32_t first, uint32_t range, uint32_t count, uint8_t* values) {
  const Range r = kRange[range];
  uint32_t at = first;
  const uint32_t end = first + sequence_bits(range, count);
  // "If there are insufficient bits in the stream to fill the final block, then unused bits are assumed to be 0".
  const auto take = [&](uint32_t width) {
    const uint32_t available = at < end ? std::min(width, end - at) : 0;
    const uint32_t value = bits.get(at, available);
    at += width;
    return value;
  };
  if (!r.trits && !r.quints) {
    for (uint32_t i = 0; i < count; ++i) values[i] = static_cast<uint8_t>(take(r.bits));
    return;
  }
  // Between the values' own bits lie these many bits of the packed digits.
  constexpr uint32_t kTritBits[5] = {2, 2, 1, 2, 1}, kQuintBits[3] = {3, 2, 2};
  const uint32_t group = r.trits ? 5 : 3;
  for (uint32_t i = 0; i < count; i += group) {
    uint32_t low[5] = {}, packed = 0, packed_bits = 0;
    for (uint32_t k = 0; k < group; ++k) {
      low[k] = take(r.bits);
      const uint32_t width = r.trits ? kTritBits[k] : kQuintBits[k];
      packed |= take(width) << packed_bits;
      packed_bits += width;
    }
    for (uint32_t k = 0; k < std::min(group, count - i); ++k) {
      const uint32_t digit = r.trits ? kTrits[packed][k] : kQuints[packed][k];
      values[i + k] = static_cast<uint8_t>(digit << r.bits | low[k]);
    }
  }
}

uint8_t unquantize_color(uint32_t range, uint32_t value) { return kColors[range][value]; }
uint8_t unquantize_weight(uint32_t range, uint32_t value) { return kWeights[range][value]; }

}  // namespace pineda::astc
