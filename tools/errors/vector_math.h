// Eight binary64 values at once, for the exhaustive runs: glibc's libmvec, whose documented error of up to 4 ULP of a binary64 is
// 2^-27 ULP of a binary32. Falls back to the scalar functions, whose error is below 1 ULP, on CPUs without AVX-512 and for
// operands of sin, cos and tan beyond 2^20.
#pragma once

#include <cstdint>

namespace pineda::tools {

#define PINEDA_VECTOR_MATH(X) \
  X(sin) X(cos) X(tan) X(asin) X(acos) X(atan) X(sinh) X(cosh) X(tanh) X(asinh) X(acosh) X(atanh) X(exp) X(exp2) X(log) X(log2)

#define PINEDA_DECLARE(name) void vector_##name(const double* x, double* result, uint32_t count);
PINEDA_VECTOR_MATH(PINEDA_DECLARE)
#undef PINEDA_DECLARE

}  // namespace pineda::tools
