#include "base/srgb.h"

#include <array>
#include <bit>

namespace pineda {
namespace {

#include "base/srgb_tables.inc"

constexpr auto kEncode = [] {
  std::array<uint32_t, kSrgbEncodeEntries> table{};
  uint32_t code = 0;
  for (uint32_t i = 0; i < kSrgbEncodeEntries; ++i) {
    const uint32_t first = (kSrgbEncodeFirst + i) << 16;
    uint32_t boundary = 0x10000;  // none inside
    while (code < 255 && std::bit_cast<uint32_t>(kThreshold[code + 1]) <= first) ++code;
    if (code < 255) {
      const uint32_t next = std::bit_cast<uint32_t>(kThreshold[code + 1]);
      if (next - first < 0x10000) boundary = next - first;
    }
    table[i] = code | boundary << 8;
  }
  return table;
}();

// At most one boundary in an entry: neighbouring thresholds never share their upper 16 bits.
static_assert([] {
  for (uint32_t c = 1; c < 255; ++c) {
    if (std::bit_cast<uint32_t>(kThreshold[c]) >> 16 == std::bit_cast<uint32_t>(kThreshold[c + 1]) >> 16) return false;
  }
  return std::bit_cast<uint32_t>(kSrgbEncodeMin) >> 16 == kSrgbEncodeFirst && kThreshold[1] > kSrgbEncodeMin;
}());

}  // namespace

const float* srgb_decode_table() { return kDecode; }
const uint32_t* srgb_encode_table() { return kEncode.data(); }

uint8_t srgb_encode(float linear) {
  float x = kSrgbEncodeMin < linear ? linear : kSrgbEncodeMin;
  x = 1.0f < x ? 1.0f : x;
  const uint32_t bits = std::bit_cast<uint32_t>(x);
  const uint32_t entry = kEncode[(bits >> 16) - kSrgbEncodeFirst];
  return static_cast<uint8_t>((entry & 0xff) + ((bits & 0xffff) >= entry >> 8));
}

}  // namespace pineda
