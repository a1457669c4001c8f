#include "raster/transform.h"

#include <cfloat>
#include <cstring>

#if defined(__x86_64__)
#include <immintrin.h>
#else
#error "the transform has an x86-64 implementation only"
#endif

namespace pineda::raster {
namespace {

// Adds the bits of clip and cull distances of 16 vertices. NaN is outside.
void code_distances(const VertexOutputs& outputs, const float* wave, uint16_t* codes) {
  const auto add = [&](uint32_t slot, uint32_t bit) {
    for (uint32_t lane = 0; lane < kLanes; ++lane) {
      if (!(wave[slot * kLanes + lane] >= 0)) codes[lane] |= static_cast<uint16_t>(kClipDistances << bit);
    }
  };
  for (uint32_t i = 0; i < outputs.clip_count; ++i) add(outputs.clip_distance + i, i);
  for (uint32_t i = 0; i < outputs.cull_count; ++i) add(outputs.cull_distance + i, outputs.clip_count + i);
}

namespace sse42 {
using Floats = float __attribute__((vector_size(16)));
using Words = int32_t __attribute__((vector_size(16)));
inline Words round_to_words(Floats v) { return (Words)_mm_cvtps_epi32((__m128)v); }
inline void narrow(Words v, uint16_t* out) {
  _mm_storel_epi64(reinterpret_cast<__m128i*>(out), _mm_packus_epi32((__m128i)v, (__m128i)v));
}
#include "raster/transform_impl.inc"
}  // namespace sse42

#pragma GCC push_options
#pragma GCC target("avx2")
namespace avx2 {
using Floats = float __attribute__((vector_size(32)));
using Words = int32_t __attribute__((vector_size(32)));
inline Words round_to_words(Floats v) { return (Words)_mm256_cvtps_epi32((__m256)v); }
inline void narrow(Words v, uint16_t* out) {
  const __m128i low = _mm256_castsi256_si128((__m256i)v), high = _mm256_extracti128_si256((__m256i)v, 1);
  _mm_storeu_si128(reinterpret_cast<__m128i*>(out), _mm_packus_epi32(low, high));
}
#include "raster/transform_impl.inc"
}  // namespace avx2
#pragma GCC pop_options

#pragma GCC push_options
#pragma GCC target("avx512f,avx512dq,avx2")
namespace avx512 {
using Floats = float __attribute__((vector_size(64)));
using Words = int32_t __attribute__((vector_size(64)));
inline Words round_to_words(Floats v) { return (Words)_mm512_cvtps_epi32((__m512)v); }
inline void narrow(Words v, uint16_t* out) {
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(out), _mm512_cvtepi32_epi16((__m512i)v));
}
#include "raster/transform_impl.inc"
}  // namespace avx512
#pragma GCC pop_options

}  // namespace

TransformFn transform_function(Isa isa) {
  return for_isa(isa, sse42::transform_wave, avx2::transform_wave, avx512::transform_wave);
}

}  // namespace pineda::raster
