// The functions whose error is measured: how to compute them exactly enough, and what Vulkan allows ("Precision and Operation of
// SPIR-V Instructions"). The one table; the shader (shaders/measured.comp) goes by its numbers.
#pragma once

#include <mpfr.h>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace pineda::tools {

enum class Width : uint8_t { k16, k32, k64 };  // of operands and results

struct Operands {
  double x = 0, y = 0, z = 0;  // values of the function's width
};

// Exact operands to a result in binary64.
using Reference = double (*)(const Operands& in);
// The same for eight values of x at once (AVX-512, glibc's libmvec), or null.
using VectorReference = void (*)(const double* x, double* result, uint32_t count);
// The same in MPFR. `x` holds the operand, `out` has the precision wanted. Null for functions that binary64 computes exactly
// before the last rounding, or nearly so.
using PreciseReference = int (*)(mpfr_t out, const mpfr_t x, mpfr_rnd_t rounding);
// The largest absolute error that Vulkan allows beside the exact result; infinity where it demands nothing.
using Allowed = double (*)(const Operands& in, double exact);

// Of binary64 operands; exact enough to tell the error of a binary64 result.
using WideReference = __float128 (*)(const Operands& in);

struct MeasuredFunction {
  const char* name;
  uint32_t number;  // in the shader: measured.comp below 128, measured_half.comp below 192, then measured_double.comp
  uint32_t operands;
  const char* demand;  // Vulkan's words, shortened
  double surely_ulp;   // errors up to this many ULP are allowed for every operand (saves calling `allowed`)
  Reference reference;
  Allowed allowed;
  VectorReference vector = nullptr;
  PreciseReference precise = nullptr;
  // Operands beyond +-2^limit are not sampled: intermediate results would overflow or vanish, of which Vulkan says nothing.
  int exponent_limit = 128;
  bool cancels = false;  // no ULP are told: terms of opposite sign may leave any number of ULP: the error is told as a share of
                         // what is allowed
  Width width = Width::k32;
  WideReference wide = nullptr;  // instead of `reference`, for binary64
};

std::span<const MeasuredFunction> measured_functions();
// Parts of the table.
std::span<const MeasuredFunction> scalar_functions();    // functions.cpp
std::span<const MeasuredFunction> compound_functions();  // vectors, matrices, conversions: functions_compound.cpp
std::span<const MeasuredFunction> half_functions();      // functions_half.cpp
std::span<const MeasuredFunction> double_functions();    // functions_double.cpp

// Distance of the two values around `exact`; below the normal ones that of the denormals.
double ulp_of(double exact, Width width = Width::k32);
double smallest_normal(Width width);
double largest_finite(Width width);

}  // namespace pineda::tools
