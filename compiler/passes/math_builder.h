// Float arithmetic for the polynomials of lower_math: every operation is exactly as written (kNoContract), because compensated
// sums depend on it and the order of operations defines the bits.
#pragma once

#include <limits>
#include <span>

#include "compiler/ir/builder.h"

namespace pineda::passes {

// What all formats share. `type` is F32 or F64.
struct FloatMath {
  using Value = ir::Value;
  ir::Builder& b;
  ir::Type type;

  Value f(double v) { return b.fconst(type, v); }
  Value inf() { return f(std::numeric_limits<double>::infinity()); }
  Value nan() { return f(std::numeric_limits<double>::quiet_NaN()); }
  Value add(Value x, Value y) { return b.op(ir::Op::kFAdd, type, {x, y}, 0, ir::kNoContract); }
  Value sub(Value x, Value y) { return b.op(ir::Op::kFSub, type, {x, y}, 0, ir::kNoContract); }
  Value mul(Value x, Value y) { return b.op(ir::Op::kFMul, type, {x, y}, 0, ir::kNoContract); }

  Value is_nan(Value x) { return b.fne(x, x); }
  Value is_positive_finite(Value x) { return b.and_(b.flt(f(0), x), b.flt(x, inf())); }
  // The logarithm where x is not a positive finite number.
  Value log_special(Value x) { return b.select(b.feq(x, f(0)), b.fneg(inf()), b.select(b.flt(f(0), x), x, nan())); }
  // `magnitude` >= 0, with the sign of x where `negative` holds.
  Value with_sign(Value negative, Value magnitude) { return b.select(negative, b.fneg(magnitude), magnitude); }
};

struct Math : FloatMath {
  explicit Math(ir::Builder& builder) : FloatMath{builder, ir::Type::kF32} {}

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
  // Sign bit of x; that of a NaN does not matter where the result is a NaN.
  Value sign_bit(Value x) { return b.slt(raw_bits(x), b.i32(0)); }

  // x rounded to an integer, for |x| < 2^21: as a float (never -0) and as an I32.
  struct Rounded {
    Value value, integer;
  };
  Rounded round_sum(Value x_plus_magic) {
    return {sub(x_plus_magic, f(kMagic)), b.isub(raw_bits(x_plus_magic), b.i32(kMagicBits))};
  }
  static constexpr double kMagic = 0x1.8p23;  // adding it leaves the integer in the low bits
  static constexpr uint32_t kMagicBits = 0x4B400000;

  // 2^n, -126 <= n <= 127
  Value power_of_two(Value n) { return from_bits(b.shl(b.iadd(n, b.i32(127)), b.i32(23))); }

  // x * 2^n for -252 <= n <= 254, in two steps so that overflow and denormal results are rounded once.
  Value scale(Value x, Value n) {
    const Value half = b.ashr(n, b.i32(1));
    return mul(mul(x, power_of_two(half)), power_of_two(b.isub(n, half)));
  }
};

// Binary64 has no FMA here: without FMA hardware each is a call, and no bit of a binary32 result needs it.
struct Math64 : FloatMath {
  explicit Math64(ir::Builder& builder) : FloatMath{builder, ir::Type::kF64} {}

  Value mul_add(Value x, Value y, Value z) { return add(mul(x, y), z); }
  Value poly(Value x, std::span<const double> c) {
    Value sum = f(c.back());
    for (size_t i = c.size() - 1; i-- > 0;) sum = mul_add(sum, x, f(c[i]));
    return sum;
  }
  Value raw_bits(Value x) { return b.op(ir::Op::kBitcast, ir::Type::kI64, {x}); }
  Value from_bits(Value bits) { return b.op(ir::Op::kBitcast, ir::Type::kF64, {bits}); }
  Value sign_bit(Value x) { return b.slt(raw_bits(x), b.i64(0)); }

  // x rounded to an integer, for |x| < 2^50: as a float and as an I64.
  struct Rounded {
    Value value, integer;
  };
  Rounded round(Value x) {
    constexpr double kMagic = 0x1.8p52;
    const Value sum = add(x, f(kMagic));
    return {sub(sum, f(kMagic)), b.isub(raw_bits(sum), b.i64(0x4338000000000000))};
  }
  // 2^n, -1022 <= n <= 1023
  Value power_of_two(Value n) { return from_bits(b.shl(b.iadd(n, b.i64(1023)), b.i64(52))); }
};

}  // namespace pineda::passes
