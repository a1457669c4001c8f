// Transcendental functions of binary32 as IR: fused multiply-adds and integer operations only, so that every back end computes
// the same bits. Largest errors, measured by lower_math_test.cpp against double precision over the whole range (ULP of the
// result):
//
//     exp2, exp 1.0    log2, log 1.0    pow 2.1    sin, cos 2.1    tan 3.5    asin 2.5    acos 2    atan 1.5    atan2 2
//
// Vulkan 1.3 ("Precision and Operation of SPIR-V Instructions") asks for 3 + 2|x| (exp2, exp), 3 (log2, log), 2^-11 absolute
// (sin, cos) and 4096 (atan2) ULP. Infinities, zeros and NaN follow C's Annex F, but for pow of a negative base, which is NaN.
// sin and tan of -0 are +0.
// Denormals are kept.
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

}  // namespace pineda::passes
