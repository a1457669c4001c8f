// The operands that a function is measured on, block by block.
#pragma once

#include "tools/errors/functions.h"
#include "tools/errors/shared_block.h"

namespace pineda::tools {

// Blocks of SharedBlock::kElements that cover all 2^32 values.
inline constexpr uint32_t kExhaustiveBlocks = 4096;
inline constexpr uint32_t kSampledBlocks = 8;  // of functions of several operands; --quick takes one

// Unary functions: every value once (exhaustive), or every sign, exponent and 11 leading significand bits with random lower ones.
// Functions of several operands: a grid of signs, exponents and significands at and beside powers of two, then operands close to
// each other and to one, then random ones; all from fixed seeds.
// binary16: x goes through all values. binary64: as measured_double.comp wants it.
void fill_operands(const MeasuredFunction& function, bool exhaustive, uint32_t block, float* x, float* y, float* z);

}  // namespace pineda::tools
