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
inline Part part_widen(const uint16_t* p) { return Part{p[0], p[1], p[2], p[3]}; }
// Words at base + index * kScale bytes.
template <int kScale>
inline Part part_gather(const void* base, Part index) {
  Part words;
  for (int i = 0; i < 4; ++i) {
    int32_t word;
    std::memcpy(&word, static_cast<const uint8_t*>(base) + index[i] * kScale, sizeof word);
    words[i] = word;
  }
  return words;
}
#include "raster/small_setup_impl.inc"
}  // namespace sse42

#pragma GCC push_options
#pragma GCC target("avx2")
namespace avx2 {
using Part = int32_t __attribute__((vector_size(32)));
using UPart = uint32_t __attribute__((vector_size(32)));
inline uint32_t part_sign_mask(Part v) { return static_cast<uint32_t>(_mm256_movemask_ps((__m256)v)); }
inline Part part_widen(const uint16_t* p) {
  return (Part)_mm256_cvtepu16_epi32(_mm_loadu_si128(reinterpret_cast<const __m128i*>(p)));
}
template <int kScale>
inline Part part_gather(const void* base, Part index) {
  return (Part)_mm256_i32gather_epi32(static_cast<const int*>(base), (__m256i)index, kScale);
}
#include "raster/small_setup_impl.inc"
}  // namespace avx2
#pragma GCC pop_options

#pragma GCC push_options
#pragma GCC target("avx512f,avx512dq,avx2")
namespace avx512 {
using Part = int32_t __attribute__((vector_size(64)));
using UPart = uint32_t __attribute__((vector_size(64)));
inline uint32_t part_sign_mask(Part v) { return _mm512_movepi32_mask((__m512i)v); }
inline Part part_widen(const uint16_t* p) {
  return (Part)_mm512_cvtepu16_epi32(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(p)));
}
template <int kScale>
inline Part part_gather(const void* base, Part index) {
  return (Part)_mm512_i32gather_epi32((__m512i)index, base, kScale);
}
#include "raster/small_setup_impl.inc"
}  // namespace avx512
#pragma GCC pop_options

}  // namespace

SmallGatherFn small_gather_function(Isa isa) {
  switch (isa) {
    case Isa::kAvx512:
      return avx512::small_gather;
    case Isa::kAvx2:
      return avx2::small_gather;
    case Isa::kSse42:
      return sse42::small_gather;
  }
  return sse42::small_gather;
}

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
