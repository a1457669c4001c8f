// Independent reference formulas that several tests share.
#include <bit>
#include <cmath>

#include "base/half.h"
#include "compiler/kernels/test_rig.h"

namespace pineda::kernels::test {

double decode_reference(const FormatInfo& format, uint32_t component, uint32_t code) {
  const uint32_t bits = format.component[component].bits;
  if (bits == 0) return component == 3 ? 1 : 0;
  const double unsigned_max = std::ldexp(1.0, static_cast<int>(bits)) - 1,
               signed_max = std::ldexp(1.0, static_cast<int>(bits) - 1) - 1;
  const double as_signed = code > signed_max ? code - unsigned_max - 1 : code;
  switch (format.numeric) {
    case Numeric::kUint:
    case Numeric::kUscaled:
      return code;
    case Numeric::kSint:
    case Numeric::kSscaled:
      return as_signed;
    case Numeric::kUnorm:
      return code / unsigned_max;
    case Numeric::kSnorm:
      return std::max(as_signed / signed_max, -1.0);
    case Numeric::kSfloat:
      return bits == 16 ? half_to_float(static_cast<uint16_t>(code)) : std::bit_cast<float>(code);
    case Numeric::kUfloat: {  // exponent bias 15
      const int mantissa_bits = static_cast<int>(bits) - 5, exponent = static_cast<int>(code >> mantissa_bits);
      const double mantissa = code & ((1u << mantissa_bits) - 1);
      if (exponent == 31) return mantissa != 0 ? NAN : INFINITY;
      if (exponent == 0) return std::ldexp(mantissa, -14 - mantissa_bits);
      return std::ldexp(1 + std::ldexp(mantissa, -mantissa_bits), exponent - 15);
    }
    case Numeric::kSharedExp:
      return code;
    case Numeric::kSrgb: {
      const double s = code / unsigned_max;
      if (component == 3) return s;
      return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
    }
  }
  return 0;
}

double decode_texel(const FormatInfo& format, uint32_t component, const uint8_t* texel) {
  const double value = decode_reference(format, component, code_of(format, component, texel));
  if (format.numeric != Numeric::kSharedExp || component == 3) return value;
  return std::ldexp(value, (texel[3] >> 3) - 15 - 9);
}

}  // namespace pineda::kernels::test
