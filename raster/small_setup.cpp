#include "raster/small_setup.h"

#include <cstring>

#if defined(__x86_64__)
#include <immintrin.h>
#else
#error "set-up has an x86-64 implementation only"
#endif

namespace pineda::raster {
namespace {

// One copy of the code for each instruction set.
namespace sse42 {
using Part = int32_t __attribute__((vector_size(16)));
using UPart = uint32_t __attribute__((vector_size(16)));
inline uint32_t part_sign_mask(Part v) { return static_cast<uint32_t>(_mm_movemask_ps((__m128)v)); }
#include "raster/small_setup_impl.inc"
}  // namespace sse42

#pragma GCC push_options
#pragma GCC target("avx2")
namespace avx2 {
using Part = int32_t __attribute__((vector_size(32)));
using UPart = uint32_t __attribute__((vector_size(32)));
inline uint32_t part_sign_mask(Part v) { return static_cast<uint32_t>(_mm256_movemask_ps((__m256)v)); }
#include "raster/small_setup_impl.inc"
}  // namespace avx2
#pragma GCC pop_options

#pragma GCC push_options
#pragma GCC target("avx512f,avx512dq,avx2")
namespace avx512 {
using Part = int32_t __attribute__((vector_size(64)));
using UPart = uint32_t __attribute__((vector_size(64)));
inline uint32_t part_sign_mask(Part v) { return _mm512_movepi32_mask((__m512i)v); }
#include "raster/small_setup_impl.inc"
}  // namespace avx512
#pragma GCC pop_options

}  // namespace

SmallSetupFn small_setup_function(Isa isa) {
  switch (isa) {
    case Isa::kAvx512:
      return avx512::small_setup;
    case Isa::kAvx2:
      return avx2::small_setup;
    case Isa::kSse42:
      return sse42::small_setup;
  }
  return sse42::small_setup;
}

}  // namespace pineda::raster
