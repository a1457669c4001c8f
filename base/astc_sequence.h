// Integer sequences of ASTC blocks and what their values stand for: Khronos Data Format Specification, "Integer Sequence
// Encoding", "Endpoint Unquantization" and "Weight Unquantization".
#pragma once

#include <cstdint>

#include "base/block_decoders.h"

namespace pineda::astc {

// Ranges 0..1, 0..2, 0..3, 0..4, 0..5, 0..7 ... 0..255 by index; weights use the first twelve.
inline constexpr uint32_t kRanges = 21, kWeightRanges = 12;
inline constexpr uint32_t kSmallestColorRange = 4;  // 0..5

uint32_t sequence_bits(uint32_t range, uint32_t count);

// Values number 0 to count - 1 of the sequence that begins at bit `first`.
void read_sequence(const BlockBits& bits, uint32_t first, uint32_t range, uint32_t count, uint8_t* values);

uint8_t unquantize_color(uint32_t range, uint32_t value);   // to 0..255
uint8_t unquantize_weight(uint32_t range, uint32_t value);  // to 0..64

}  // namespace pineda::astc
