// Decoding one texel on the host: the same values as compiler/kernels/texel.cpp.
#include <bit>
#include <cstring>

#include "base/format.h"
#include "base/half.h"
#include "base/srgb.h"

namespace pineda {
namespace {

int32_t sign_extend(uint32_t value, uint32_t bits) { return static_cast<int32_t>(value << (32 - bits)) >> (32 - bits); }

// "Conversion From Normalized Fixed-Point to Floating-Point": division, which is exact to rounding.
float decode_float(const FormatInfo& format, uint32_t component, uint32_t raw) {
  const uint32_t bits = format.component[component].bits;
  switch (format.numeric) {
    case Numeric::kSrgb:
      if (component < 3) return srgb_decode_table()[raw];
      [[fallthrough]];
    case Numeric::kUnorm:
      return static_cast<float>(raw) / static_cast<float>((uint64_t{1} << bits) - 1);
    case Numeric::kSnorm: {
      const float value = static_cast<float>(sign_extend(raw, bits)) / static_cast<float>((1u << (bits - 1)) - 1);
      return value < -1.0f ? -1.0f : value;
    }
    case Numeric::kUscaled:
      return static_cast<float>(raw);
    case Numeric::kSscaled:
      return static_cast<float>(sign_extend(raw, bits));
    case Numeric::kSfloat:
      return bits == 16 ? half_to_float(static_cast<uint16_t>(raw)) : std::bit_cast<float>(raw);
    case Numeric::kUfloat:
      return half_to_float(static_cast<uint16_t>(raw << (15 - bits)));
    case Numeric::kSharedExp:
    case Numeric::kUint:
    case Numeric::kSint:
      break;
  }
  return 0;
}

}  // namespace

VkClearColorValue unpack_texel(const FormatInfo& format, const uint8_t* texel) {
  uint64_t words[2] = {0, 0};
  std::memcpy(words, texel, format.texel_bytes);
  VkClearColorValue out{};
  if (format.is_integer()) {
    out.uint32[3] = 1;
  } else {
    out.float32[3] = 1.0f;
  }
  for (uint32_t c = 0; c < 4; ++c) {
    const ComponentBits where = format.component[c];
    if (where.bits == 0) continue;
    const auto raw =
        static_cast<uint32_t>(words[where.first_bit / 64] >> where.first_bit % 64 & ((uint64_t{1} << where.bits) - 1));
    if (format.numeric == Numeric::kSint) {
      out.int32[c] = sign_extend(raw, where.bits);
    } else if (format.numeric == Numeric::kUint) {
      out.uint32[c] = raw;
    } else if (format.numeric == Numeric::kSharedExp) {
      const auto exponent = static_cast<uint32_t>(words[0] >> 27 & 31);
      out.float32[c] = static_cast<float>(raw) * std::bit_cast<float>((exponent + 127 - 24) << 23);
    } else {
      out.float32[c] = decode_float(format, c, raw);
    }
  }
  return out;
}

}  // namespace pineda
