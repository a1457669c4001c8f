// binary16 <-> binary32 in integer arithmetic: the definition that FConvert follows.
#pragma once

#include <bit>
#include <cstdint>

namespace pineda {

// To nearest even; NaN gives the positive quiet NaN 0x7E00, overflow gives infinity.
constexpr uint16_t float_to_half(float value) {
  const uint32_t bits = std::bit_cast<uint32_t>(value);
  const uint32_t sign = bits >> 16 & 0x8000;
  const uint32_t magnitude = bits & 0x7fffffff;
  if (magnitude > 0x7f800000) return 0x7e00;
  if (magnitude >= 0x477ff000) return static_cast<uint16_t>(sign | 0x7c00);  // 65520 and above round to infinity
  if (magnitude < 0x33000000) return static_cast<uint16_t>(sign);            // below 2^-25
  // Shift the significand so that its last kept bit is worth one unit of the result, then round to even.
  const uint32_t exponent = magnitude >> 23;
  const uint32_t shift = exponent < 113 ? 13 + 113 - exponent : 13;
  const uint32_t significand = (magnitude & 0x7fffff) | 0x800000;
  const uint32_t kept = significand >> shift;
  const uint32_t rest = significand & ((1u << shift) - 1), tie = 1u << (shift - 1);
  const uint32_t rounded = kept + (rest > tie || (rest == tie && (kept & 1)));
  // A normal result's implicit bit (1 << 10) adds one to the exponent field; so does the carry out of rounding.
  const uint32_t base = exponent < 113 ? 0 : (exponent - 113) << 10;
  return static_cast<uint16_t>(sign | (base + rounded));
}

constexpr float half_to_float(uint16_t half) {
  const uint32_t sign = (half & 0x8000u) << 16;
  const uint32_t exponent = half >> 10 & 0x1f, mantissa = half & 0x3ff;
  if (exponent == 31) return std::bit_cast<float>(mantissa ? 0x7fc00000u : sign | 0x7f800000u);
  if (exponent == 0) {
    const float magnitude = static_cast<float>(mantissa) * 0x1p-24f;
    return sign ? -magnitude : magnitude;
  }
  return std::bit_cast<float>(sign | (exponent + 112) << 23 | mantissa << 13);
}

}  // namespace pineda
