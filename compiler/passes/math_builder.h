// Float arithmetic for the polynomials of lower_math: every operation is exactly as written (kNoContract), because compensated
// sums depend on it and the order of operations defines the bits.
#pragma once

#include <limits>
#include <span>

#include "compiler/ir/builder.h"

namespace pineda::passes {

struct Math {
  using Value = ir::Value;
  ir::Builder& b;

  Value f(double v) { return b.f32(v); }
  Value inf() { return b.f32(std::numeric_limits<double>::infinity()); }
  Value nan() { return b.f32(std::numeric_limits<double>::quiet_NaN()); }
  Value add(Value x, Value y) { return b.op(ir::Op::kFAdd, ir::Type::kF32, {x, y}, 0, ir::kNoContract); }
  Value sub(Value x, Value y) { return b.op(ir::Op::kFSub, ir::Type::kF32, {x, y}, 0, ir::kNoContract); }
  Value mul(Value x, Value y) { return b.op(ir::Op::kFMul, ir::Type::kF32, {x, y}, 0, ir::kNoContract); }
  Value fma(Value x, Value y, Value z) { return b.fma(x, y, z); }

  // c[0] + c[1] x + c[2] x^2 + ... by Horner's rule.
  Value poly(Value x, std::span<const double> c) {
    Value sum = f(c.back());
    for (size_t i = c.size() - 1; i-- > 0;) sum = fma(sum, x, f(c[i]));
    return sum;
  }

  // Bits as they are. A NaN's are unspecified, so what is made of them must not reach the result when x is a NaN.
  Value raw_bits(Value x) { return b.op(ir::Op::kBitcast, ir::Type::kI32, {x}); }
  Value from_bits(Value bits) { return b.op(ir::Op::kBitcast, ir::Type::kF32, {bits}); }

  // x rounded to an integer, for |x| < 2^21: as a float (never -0) and as an I32.
  struct Rounded {
    Value value, integer;
  };
  Rounded round_sum(Value x_plus_magic) {
    return {sub(x_plus_magic, f(kMagic)), b.isub(raw_bits(x_plus_magic), b.i32(kMagicBits))};
  }
  static constexpr double kMagic = 0x1.8p23;  // adding it leaves the integer in the low bits
  static constexpr uint32_t kMagicBits = 0x4B400000;

  // x * 2^n for -252 <= n <= 254, in two steps so that overflow and denormal results are rounded once.
  Value scale(Value x, Value n) {
    const Value half = b.ashr(n, b.i32(1));
    const auto power = [&](Value k) { return from_bits(b.shl(b.iadd(k, b.i32(127)), b.i32(23))); };
    return mul(mul(x, power(half)), power(b.isub(n, half)));
  }
};

}  // namespace pineda::passes
