#include "raster/texel_converter.h"

#include <tmmintrin.h>

#include <algorithm>
#include <cstring>

namespace pineda::raster {
namespace {

constexpr uint32_t kMaxTableBits = 10;
constexpr uint64_t kTexelsWorthTables = 1 << 14;

uint64_t low_bits(uint32_t bits) { return (uint64_t{1} << bits) - 1; }

}  // namespace

TexelConverter::TexelConverter(const FormatInfo& from, const FormatInfo& to, uint64_t texel_count) : from_(from), to_(to) {
  if (find_shuffle()) {
    way_ = Way::kShuffle;
  } else if (texel_count >= kTexelsWorthTables && make_tables()) {
    way_ = Way::kTables;
  }
}

// SNORM is left out: its lowest code becomes the next one.
bool TexelConverter::find_shuffle() {
  if (from_.numeric != to_.numeric || from_.numeric == Numeric::kSnorm || from_.texel_bytes != 4 || to_.texel_bytes != 4) {
    return false;
  }
  for (uint32_t c = 0; c < 4; ++c) {
    if (from_.component[c].bits != 8 || to_.component[c].bits != 8) return false;
    byte_from_[to_.component[c].first_bit / 8] = static_cast<uint8_t>(from_.component[c].first_bit / 8);
  }
  return true;
}

bool TexelConverter::make_tables() {
  if (from_.numeric == Numeric::kSharedExp || to_.numeric == Numeric::kSharedExp || from_.texel_bytes > 8) return false;
  for (uint32_t c = 0; c < 4; ++c) {
    if (to_.component[c].bits && from_.component[c].bits > kMaxTableBits) return false;
  }
  const auto part_of = [&](uint64_t texel, uint32_t c) {  // component c of a texel with the bits of that number, packed
    VkClearColorValue color{};
    color.uint32[c] = unpack_texel(from_, reinterpret_cast<const uint8_t*>(&texel)).uint32[c];
    uint64_t packed[2] = {0, 0};
    pack_clear_color(to_, color, reinterpret_cast<uint8_t*>(packed));
    const ComponentBits where = to_.component[c];
    Words out{};
    const uint64_t mask = low_bits(where.bits) << where.first_bit % 64;
    out.word[where.first_bit / 64] = packed[where.first_bit / 64] & mask;
    return out;
  };
  for (uint32_t c = 0; c < 4; ++c) {
    if (to_.component[c].bits == 0) continue;
    const ComponentBits source = from_.component[c];
    if (source.bits == 0) {
      const Words part = part_of(0, c);
      for (size_t w = 0; w < 2; ++w) base_.word[w] |= part.word[w];
      continue;
    }
    Component component{.shift = source.first_bit, .mask = low_bits(source.bits), .entries = {}};
    for (uint64_t code = 0; code <= component.mask; ++code) component.entries.push_back(part_of(code << source.first_bit, c));
    components_.push_back(std::move(component));
  }
  return true;
}

void TexelConverter::run(const uint8_t* row, const uint32_t* columns, size_t count, uint8_t* to) const {
  if (way_ == Way::kShuffle) return shuffle(row, columns, count, to);
  if (way_ == Way::kTables) {
    switch (from_.texel_bytes) {
      case 1:
        return look_up<1>(row, columns, count, to);
      case 2:
        return look_up<2>(row, columns, count, to);
      case 4:
        return look_up<4>(row, columns, count, to);
      default:
        return look_up<8>(row, columns, count, to);
    }
  }
  for (size_t i = 0; i < count; ++i) {
    pack_clear_color(to_, unpack_texel(from_, row + size_t{columns[i]} * from_.texel_bytes), to + i * to_.texel_bytes);
  }
}

void TexelConverter::shuffle(const uint8_t* row, const uint32_t* columns, size_t count, uint8_t* to) const {
  alignas(16) uint8_t places[16];
  for (uint8_t i = 0; i < 16; ++i) places[i] = static_cast<uint8_t>(i / 4 * 4 + byte_from_[i % 4]);
  const __m128i order = _mm_load_si128(reinterpret_cast<const __m128i*>(places));
  alignas(16) uint32_t words[4] = {};
  for (size_t i = 0; i < count; i += 4) {
    const size_t n = std::min<size_t>(4, count - i);
    if (n == 4 && columns[i + 3] == columns[i] + 3 && columns[i + 1] == columns[i] + 1 && columns[i + 2] == columns[i] + 2) {
      const __m128i texels = _mm_loadu_si128(reinterpret_cast<const __m128i*>(row + size_t{columns[i]} * 4));
      _mm_storeu_si128(reinterpret_cast<__m128i*>(to + i * 4), _mm_shuffle_epi8(texels, order));
      continue;
    }
    for (size_t k = 0; k < n; ++k) std::memcpy(&words[k], row + size_t{columns[i + k]} * 4, 4);
    const __m128i shuffled = _mm_shuffle_epi8(_mm_load_si128(reinterpret_cast<const __m128i*>(words)), order);
    _mm_store_si128(reinterpret_cast<__m128i*>(words), shuffled);
    std::memcpy(to + i * 4, words, n * 4);
  }
}

template <size_t kFromBytes>
void TexelConverter::look_up(const uint8_t* row, const uint32_t* columns, size_t count, uint8_t* to) const {
  switch (to_.texel_bytes) {
    case 1:
      return look_up_all<kFromBytes, 1>(row, columns, count, to);
    case 2:
      return look_up_all<kFromBytes, 2>(row, columns, count, to);
    case 4:
      return look_up_all<kFromBytes, 4>(row, columns, count, to);
    case 8:
      return look_up_all<kFromBytes, 8>(row, columns, count, to);
    default:
      return look_up_all<kFromBytes, 16>(row, columns, count, to);
  }
}

template <size_t kFromBytes, size_t kToBytes>
void TexelConverter::look_up_all(const uint8_t* row, const uint32_t* columns, size_t count, uint8_t* to) const {
  for (size_t i = 0; i < count; ++i) {
    uint64_t texel = 0;
    std::memcpy(&texel, row + size_t{columns[i]} * kFromBytes, kFromBytes);
    Words out = base_;
    for (const Component& c : components_) {
      const Words& part = c.entries[texel >> c.shift & c.mask];
      out.word[0] |= part.word[0];
      if constexpr (kToBytes > 8) out.word[1] |= part.word[1];
    }
    std::memcpy(to + i * kToBytes, &out, kToBytes);
  }
}

}  // namespace pineda::raster
