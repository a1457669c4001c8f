#include "tools/errors/vector_math.h"

#include <immintrin.h>

#include <cmath>
#include <cstring>
#include <string_view>

// The vector ABI of x86-64 ("Vector Function Application Binary Interface Specification", 8 lanes of AVX-512).
#define PINEDA_DECLARE(name) extern "C" __attribute__((target("avx512f"))) __m512d _ZGVeN8v_##name(__m512d);
PINEDA_VECTOR_MATH(PINEDA_DECLARE)
#undef PINEDA_DECLARE

namespace pineda::tools {
namespace {

bool has_avx512() {
  static const bool has = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq");
  return has;
}

constexpr double kLargeAngle = 0x1p20;

using VectorFn = __m512d (*)(__m512d);

template <VectorFn kVector, double (*kScalar)(double), bool kIsAngle>
__attribute__((target("avx512f"))) void run_vector(const double* x, double* result, uint32_t count) {
  for (uint32_t i = 0; i + 8 <= count; i += 8) _mm512_storeu_pd(result + i, kVector(_mm512_loadu_pd(x + i)));
  for (uint32_t i = 0; i < count; ++i) {
    if (kIsAngle ? !(std::fabs(x[i]) < kLargeAngle) : i >= count / 8 * 8) result[i] = kScalar(x[i]);
  }
}

template <VectorFn kVector, double (*kScalar)(double), bool kIsAngle>
void run(const double* x, double* result, uint32_t count) {
  if (has_avx512()) return run_vector<kVector, kScalar, kIsAngle>(x, result, count);
  for (uint32_t i = 0; i < count; ++i) result[i] = kScalar(x[i]);
}

constexpr bool is_angle(std::string_view name) { return name == "sin" || name == "cos" || name == "tan"; }

}  // namespace

#define PINEDA_DEFINE(name)                                             \
  void vector_##name(const double* x, double* result, uint32_t count) { \
    run<_ZGVeN8v_##name, std::name, is_angle(#name)>(x, result, count); \
  }
PINEDA_VECTOR_MATH(PINEDA_DEFINE)
#undef PINEDA_DEFINE

}  // namespace pineda::tools
