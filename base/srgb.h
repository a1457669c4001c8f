// The sRGB transfer function of 8-bit formats, exact in both directions: no polynomial, no libm. Tables are made by
// tools/math/srgb_tables.py. Kernels read them through DrawContext; the host functions below give the same bits.
#pragma once

#include <cstdint>

#include "base/abi.h"

namespace pineda {

// Linear value of each of the 256 codes, rounded to nearest.
const float* srgb_decode_table();

// Encoding looks a value's leading bits up, then decides with the rest. The value is first clamped to [kSrgbEncodeMin, 1]; below
// lies code 0 only. Entry i covers the floats whose bits >> 16 are kSrgbEncodeFirst + i (a sign, 8 exponent and 7 mantissa bits:
// so narrow that at most one code boundary lies inside) and holds  code | boundary << 8: the float's code is  code + ((bits &
// 0xffff) >= boundary).
inline constexpr float kSrgbEncodeMin = 0x1p-13f;
inline constexpr uint32_t kSrgbEncodeFirst = 0x3900;  // bits of 2^-13, shifted right by 16
inline constexpr uint32_t kSrgbEncodeEntries = 13 * 128 + 1;
const uint32_t* srgb_encode_table();

// The nearest code; values outside [0, 1] are clamped, NaN gives 0.
uint8_t srgb_encode(float linear);

// Every DrawContext that a kernel sees has these set.
inline void set_srgb_tables(DrawContext& draw) {
  draw.srgb_decode = srgb_decode_table();
  draw.srgb_encode = srgb_encode_table();
}

}  // namespace pineda
