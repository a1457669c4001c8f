// The decoders behind block_decoder(), and what they share. Not for other parts: see block_codec.h.
#pragma once

#include <cstdint>
#include <cstring>

#include "base/format.h"

namespace pineda {

void decode_bc1(const FormatInfo& format, const uint8_t* block, uint8_t* texels);
void decode_bc2(const FormatInfo& format, const uint8_t* block, uint8_t* texels);
void decode_bc3(const FormatInfo& format, const uint8_t* block, uint8_t* texels);
void decode_bc4(const FormatInfo& format, const uint8_t* block, uint8_t* texels);
void decode_bc5(const FormatInfo& format, const uint8_t* block, uint8_t* texels);
void decode_bc6h(const FormatInfo& format, const uint8_t* block, uint8_t* texels);
void decode_bc7(const FormatInfo& format, const uint8_t* block, uint8_t* texels);
void decode_etc2_rgb(const FormatInfo& format, const uint8_t* block, uint8_t* texels);
void decode_etc2_rgb_a1(const FormatInfo& format, const uint8_t* block, uint8_t* texels);
void decode_etc2_rgba(const FormatInfo& format, const uint8_t* block, uint8_t* texels);
void decode_eac_r11(const FormatInfo& format, const uint8_t* block, uint8_t* texels);
void decode_eac_rg11(const FormatInfo& format, const uint8_t* block, uint8_t* texels);
void decode_astc(const FormatInfo& format, const uint8_t* block, uint8_t* texels);

// A block's bits, bit 0 the lowest of the first byte.
class BlockBits {
 public:
  explicit BlockBits(const uint8_t* block) { std::memcpy(words_, block, 16); }

  // Bits [first, first + count), count at most 32; bits from 128 on are zero.
  uint32_t get(uint32_t first, uint32_t count) const {
    if (first >= 128 || count == 0) return 0;
    uint64_t bits = words_[first / 64] >> first % 64;
    if (first < 64 && first % 64 != 0) bits |= words_[1] << (64 - first % 64);
    return static_cast<uint32_t>(bits & ((uint64_t{1} << count) - 1));
  }

 private:
  uint64_t words_[2];
};

}  // namespace pineda
