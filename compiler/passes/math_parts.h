// Steps that several functions of lower_math share. Binary32 but for the last one.
#pragma once

#include "compiler/passes/math_builder.h"

namespace pineda::passes {

// ln 2: the high part has 16 bits, so its product with an exponent is exact
inline constexpr double kLn2High = 0x1.62e4p-1, kLn2Low = 0x1.7f7d1cp-20;

// Positive finite x = 2^exponent * (1 + t), t in [sqrt(1/2) - 1, sqrt(2) - 1]. Other x give rubbish.
struct LogParts {
  ir::Value exponent, t;  // I32, F32
};
LogParts split(Math& m, ir::Value x);

// ln(2^exponent * (1 + t)); exponent is F32.
ir::Value log_of_parts(Math& m, ir::Value exponent, ir::Value t);

// e^x * 2^shift, for -1 <= shift <= 0; overflows and underflows as that does.
ir::Value exp_shifted(Math& m, ir::Value x, int shift);

// x = quadrant * pi/2 + r, |r| <= pi/4 (a little more by rounding).
struct Reduced {
  ir::Value r, quadrant;  // F32, I32 (modulo 4 counts)
};
// `parts`: of pi/2 that are subtracted where |x| < 2^17. Two leave an absolute error of 2^-24, three a small relative one.
Reduced reduce_to_quadrant(Math& m, ir::Value x, uint32_t parts);

// |x| >= 2^17 as a multiple of pi/2: quadrant + (high * 2^-64 + low * 2^-128), high signed. Quadrant and fraction are of |x|.
struct Turns {
  ir::Value quadrant, high, low;  // I32, I64, I64 (without `wide`: none, and the last bits of high are cut off)
};
Turns quarter_turns(Math& m, ir::Value x, bool wide);

inline ir::Value bit_set(ir::Builder& b, ir::Value x, uint32_t bit) { return b.ine(b.and_(x, b.i32(bit)), b.i32(0)); }

}  // namespace pineda::passes
