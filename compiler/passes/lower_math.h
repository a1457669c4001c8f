// Transcendental functions as IR: additions, multiplications, fused multiply-adds, divisions, square roots and integer operations
// only, so that every back end computes the same bits. Three sets of algorithms, chosen by PINEDA_PRECISION:
//
//     fast       binary32; what Vulkan demands ("Precision and Operation of SPIR-V Instructions") with room, and no more:
//     denormal
//                operands and results of exp, log and pow may become zero
//     (default)  binary32; within 1 to 4 ULP over all inputs, denormals included
//     exact      binary64, rounded once to the result's format: correctly rounded but where the exact value lies within about
//                2^-20 ULP (pow) to 2^-27 ULP (the others) of a tie
//
// docs/errors.md has the measured errors (`./run errors` writes it). Infinities, zeros with their signs and NaN follow C's Annex
// F in all three, but for pow of a negative base, which is NaN. Functions of binary16 are computed in the wider format and
// rounded once more; fast has functions of its own only where they are cheaper.
#pragma once

#include "compiler/ir/builder.h"

namespace pineda::passes {

// Appends the function's value at the builder's place. Operands are F32.
ir::Value emit_exp2(ir::Builder& b, ir::Value x);
ir::Value emit_exp(ir::Builder& b, ir::Value x);
ir::Value emit_log2(ir::Builder& b, ir::Value x);
ir::Value emit_log2_coarse(ir::Builder& b, ir::Value x);  // absolute error 2^-13.2: for levels of detail
ir::Value emit_log(ir::Builder& b, ir::Value x);
ir::Value emit_pow(ir::Builder& b, ir::Value x, ir::Value y);
ir::Value emit_sin(ir::Builder& b, ir::Value x);
ir::Value emit_cos(ir::Builder& b, ir::Value x);
ir::Value emit_tan(ir::Builder& b, ir::Value x);
ir::Value emit_asin(ir::Builder& b, ir::Value x);
ir::Value emit_acos(ir::Builder& b, ir::Value x);
ir::Value emit_atan(ir::Builder& b, ir::Value x);
ir::Value emit_atan2(ir::Builder& b, ir::Value y, ir::Value x);
ir::Value emit_sinh(ir::Builder& b, ir::Value x);
ir::Value emit_cosh(ir::Builder& b, ir::Value x);
ir::Value emit_tanh(ir::Builder& b, ir::Value x);
ir::Value emit_asinh(ir::Builder& b, ir::Value x);
ir::Value emit_acosh(ir::Builder& b, ir::Value x);
ir::Value emit_atanh(ir::Builder& b, ir::Value x);
ir::Value emit_rsqrt(ir::Builder& b, ir::Value x);

namespace fast {
ir::Value emit_exp2(ir::Builder& b, ir::Value x);
ir::Value emit_exp(ir::Builder& b, ir::Value x);
ir::Value emit_log2(ir::Builder& b, ir::Value x);
ir::Value emit_log(ir::Builder& b, ir::Value x);
ir::Value emit_pow(ir::Builder& b, ir::Value x, ir::Value y);
ir::Value emit_sin(ir::Builder& b, ir::Value x);
ir::Value emit_cos(ir::Builder& b, ir::Value x);
ir::Value emit_tan(ir::Builder& b, ir::Value x);
ir::Value emit_asin(ir::Builder& b, ir::Value x);
ir::Value emit_acos(ir::Builder& b, ir::Value x);
ir::Value emit_atan(ir::Builder& b, ir::Value x);
ir::Value emit_atan2(ir::Builder& b, ir::Value y, ir::Value x);
}  // namespace fast

// Operands are F32 (or widened halves); the value is F64.
namespace exact {
ir::Value emit_exp2(ir::Builder& b, ir::Value x);
ir::Value emit_exp(ir::Builder& b, ir::Value x);
ir::Value emit_log2(ir::Builder& b, ir::Value x);
ir::Value emit_log(ir::Builder& b, ir::Value x);
ir::Value emit_pow(ir::Builder& b, ir::Value x, ir::Value y);
ir::Value emit_sin(ir::Builder& b, ir::Value x);
ir::Value emit_cos(ir::Builder& b, ir::Value x);
ir::Value emit_tan(ir::Builder& b, ir::Value x);
ir::Value emit_asin(ir::Builder& b, ir::Value x);
ir::Value emit_acos(ir::Builder& b, ir::Value x);
ir::Value emit_atan(ir::Builder& b, ir::Value x);
ir::Value emit_atan2(ir::Builder& b, ir::Value y, ir::Value x);
ir::Value emit_sinh(ir::Builder& b, ir::Value x);
ir::Value emit_cosh(ir::Builder& b, ir::Value x);
ir::Value emit_tanh(ir::Builder& b, ir::Value x);
ir::Value emit_asinh(ir::Builder& b, ir::Value x);
ir::Value emit_acosh(ir::Builder& b, ir::Value x);
ir::Value emit_atanh(ir::Builder& b, ir::Value x);
ir::Value emit_rsqrt(ir::Builder& b, ir::Value x);
}  // namespace exact

}  // namespace pineda::passes
