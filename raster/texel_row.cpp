#include "raster/texel_row.h"

#include <smmintrin.h>

#include <algorithm>
#include <cstring>

#include "base/half.h"
#include "base/srgb.h"

namespace pineda::raster {
namespace {

bool is_code(const FormatInfo& format, uint32_t component) {
  return format.numeric == Numeric::kUnorm || format.numeric == Numeric::kSnorm ||
         (format.numeric == Numeric::kSrgb && component == 3);
}

}  // namespace

TexelRow::Kind TexelRow::kind_of(const FormatInfo& format) {
  for (const ComponentBits& c : format.component) {
    if (c.bits == 0) continue;
    if (c.bits != format.component[0].bits || c.first_bit % c.bits != 0) return Kind::kOther;
  }
  const uint32_t bits = format.component[0].bits;
  if (bits == 8 && format.numeric == Numeric::kUnorm) return Kind::kBytes;
  if (bits == 8 && format.numeric == Numeric::kSrgb) return Kind::kSrgbBytes;
  if (bits == 32 && format.numeric == Numeric::kSfloat) return Kind::kFloats;
  if (bits == 16 && format.numeric == Numeric::kSfloat) return Kind::kHalves;
  return Kind::kOther;
}

TexelRow::TexelRow(const FormatInfo& format) : format_(format), kind_(kind_of(format)), scale_{1, 1, 1, 1} {
  for (uint32_t c = 0; c < 4; ++c) {
    const uint32_t bits = format.component[c].bits;
    if (bits == 0) continue;
    byte_of_[c] = format.component[c].first_bit / bits;
    const uint32_t code_bits = format.numeric == Numeric::kSnorm ? bits - 1 : bits;
    if (is_code(format, c)) scale_[c] = static_cast<float>((1u << code_bits) - 1);
  }
}

void TexelRow::read(const uint8_t* row, const uint32_t* columns, uint32_t count, Float4* out) const {
  const uint32_t texel_bytes = format_.texel_bytes;
  const Float4 absent = {0, 0, 0, 1};
  if (kind_ == Kind::kBytes && texel_bytes == 4) {
    const bool swapped = byte_of_[0] == 2;
    for (uint32_t i = 0; i < count; ++i) {
      int32_t word;
      std::memcpy(&word, row + size_t{columns[i]} * 4, 4);
      const __m128i zero = _mm_setzero_si128();
      const __m128i codes = _mm_unpacklo_epi16(_mm_unpacklo_epi8(_mm_cvtsi32_si128(word), zero), zero);
      const __m128 floats = _mm_cvtepi32_ps(codes);
      out[i] = swapped ? _mm_shuffle_ps(floats, floats, _MM_SHUFFLE(3, 0, 1, 2)) : floats;
    }
    return;
  }
  const float* const linear = srgb_decode_table();
  if (kind_ == Kind::kSrgbBytes && texel_bytes == 4) {
    const uint8_t* const colors[3] = {row + byte_of_[0], row + byte_of_[1], row + byte_of_[2]};
    for (uint32_t i = 0; i < count; ++i) {
      const size_t at = size_t{columns[i]} * 4;
      out[i] = Float4{linear[colors[0][at]], linear[colors[1][at]], linear[colors[2][at]], static_cast<float>(row[at + 3])};
    }
    return;
  }
  for (uint32_t i = 0; i < count; ++i) {
    const uint8_t* texel = row + size_t{columns[i]} * texel_bytes;
    Float4 value = absent;
    if (kind_ == Kind::kOther) {
      const VkClearColorValue color = unpack_texel(format_, texel);
      for (uint32_t c = 0; c < 4; ++c) value[c] = color.float32[c];
      // unpack_texel divides; the product is within half a unit of the code.
      for (uint32_t c = 0; c < 4; ++c) {
        if (format_.component[c].bits && is_code(format_, c))
          value[c] = _mm_cvtss_f32(_mm_cvtepi32_ps(_mm_cvtps_epi32(_mm_set1_ps(value[c] * scale_[c]))));
      }
      out[i] = value;
      continue;
    }
    for (uint32_t c = 0; c < 4; ++c) {
      if (format_.component[c].bits == 0) continue;
      uint16_t half = 0;
      switch (kind_) {
        case Kind::kBytes:
          value[c] = texel[byte_of_[c]];
          break;
        case Kind::kSrgbBytes:
          value[c] = c == 3 ? static_cast<float>(texel[byte_of_[c]]) : linear[texel[byte_of_[c]]];
          break;
        case Kind::kFloats:
          std::memcpy(&value[c], texel + 4 * byte_of_[c], 4);
          break;
        default:
          std::memcpy(&half, texel + 2 * byte_of_[c], 2);
          value[c] = half_to_float(half);
          break;
      }
    }
    out[i] = value;
  }
}

void TexelRow::read_mixed(const uint8_t* row, const uint32_t* first, const uint32_t* second, const float* weight, uint32_t count,
                          Float4* out) const {
  if (!is_four_bytes()) {
    constexpr uint32_t kBatch = 64;
    Float4 texels[2][kBatch];
    for (uint32_t i = 0; i < count; i += kBatch) {
      const uint32_t n = std::min(kBatch, count - i);
      read(row, first + i, n, texels[0]);
      read(row, second + i, n, texels[1]);
      for (uint32_t k = 0; k < n; ++k) out[i + k] = mix(texels[0][k], texels[1][k], weight[i + k]);
    }
    return;
  }
  const bool swapped = byte_of_[0] == 2;
  const auto texel = [row](uint32_t column) {
    int32_t word;
    std::memcpy(&word, row + size_t{column} * 4, 4);
    return _mm_cvtepi32_ps(_mm_cvtepu8_epi32(_mm_cvtsi32_si128(word)));
  };
  for (uint32_t i = 0; i < count; ++i) {
    const __m128 w = _mm_load1_ps(weight + i), rest = _mm_sub_ps(_mm_set1_ps(1), w);
    const __m128 mixed = _mm_add_ps(_mm_mul_ps(texel(first[i]), rest), _mm_mul_ps(texel(second[i]), w));
    out[i] = swapped ? _mm_shuffle_ps(mixed, mixed, _MM_SHUFFLE(3, 0, 1, 2)) : mixed;
  }
}

void TexelRow::write_mixed_units(const Float4* top, const Float4* bottom, float weight, uint32_t count, uint8_t* row) const {
  if (!is_four_bytes()) {
    constexpr uint32_t kBatch = 64;
    Float4 texels[kBatch];
    for (uint32_t i = 0; i < count; i += kBatch) {
      const uint32_t n = std::min(kBatch, count - i);
      for (uint32_t k = 0; k < n; ++k) texels[k] = mix(top[i + k], bottom[i + k], weight);
      write_units(texels, n, row + size_t{i} * format_.texel_bytes);
    }
    return;
  }
  const bool swapped = byte_of_[0] == 2;
  const __m128 w = _mm_set1_ps(weight), rest = _mm_sub_ps(_mm_set1_ps(1), w);
  const auto codes = [&](uint32_t i) {
    __m128 mixed = _mm_add_ps(_mm_mul_ps(top[i], rest), _mm_mul_ps(bottom[i], w));
    if (swapped) mixed = _mm_shuffle_ps(mixed, mixed, _MM_SHUFFLE(3, 0, 1, 2));
    return _mm_cvtps_epi32(mixed);  // to nearest even: the thread's rounding mode is never changed
  };
  uint32_t i = 0;
  for (; i + 4 <= count; i += 4) {
    const __m128i low = _mm_packs_epi32(codes(i), codes(i + 1)), high = _mm_packs_epi32(codes(i + 2), codes(i + 3));
    _mm_storeu_si128(reinterpret_cast<__m128i*>(row + size_t{i} * 4), _mm_packus_epi16(low, high));
  }
  for (; i < count; ++i) {
    const __m128i words = _mm_packs_epi32(codes(i), _mm_setzero_si128());
    const int32_t texel = _mm_cvtsi128_si32(_mm_packus_epi16(words, words));
    std::memcpy(row + size_t{i} * 4, &texel, 4);
  }
}

void TexelRow::write_units(const Float4* texels, uint32_t count, uint8_t* row) const {
  if (kind_ != Kind::kBytes || format_.texel_bytes != 4) {
    for (uint32_t i = 0; i < count; ++i) {
      const Float4 value = texels[i] / scale_;
      write_values(&value, 1, row + size_t{i} * format_.texel_bytes);
    }
    return;
  }
  const bool swapped = byte_of_[0] == 2;
  for (uint32_t i = 0; i < count; ++i) {
    __m128 floats = texels[i];
    if (swapped) floats = _mm_shuffle_ps(floats, floats, _MM_SHUFFLE(3, 0, 1, 2));
    const __m128i codes = _mm_cvtps_epi32(floats);  // to nearest even: the thread's rounding mode is never changed
    const __m128i words = _mm_packs_epi32(codes, codes);
    const int32_t texel = _mm_cvtsi128_si32(_mm_packus_epi16(words, words));
    std::memcpy(row + size_t{i} * 4, &texel, 4);
  }
}

// Clamped, times 255 in binary64, where the product is exact, to nearest even; NaN gives 0.
void TexelRow::write_bytes(const Float4* texels, uint32_t count, uint8_t* row) const {
  const bool swapped = byte_of_[0] == 2;
  const __m128 zero = _mm_setzero_ps(), one = _mm_set1_ps(1);
  const __m128d scale = _mm_set1_pd(255);
  for (uint32_t i = 0; i < count; ++i) {
    __m128 value = _mm_min_ps(_mm_max_ps(texels[i], zero), one);
    if (swapped) value = _mm_shuffle_ps(value, value, _MM_SHUFFLE(3, 0, 1, 2));
    const __m128i low = _mm_cvtpd_epi32(_mm_mul_pd(_mm_cvtps_pd(value), scale));
    const __m128i high = _mm_cvtpd_epi32(_mm_mul_pd(_mm_cvtps_pd(_mm_movehl_ps(value, value)), scale));
    const __m128i words = _mm_packs_epi32(_mm_unpacklo_epi64(low, high), _mm_setzero_si128());
    const int32_t texel = _mm_cvtsi128_si32(_mm_packus_epi16(words, words));
    std::memcpy(row + size_t{i} * 4, &texel, 4);
  }
}

// srgb_encode (base/srgb.h) of three components at once; alpha as write_bytes does it.
void TexelRow::write_srgb_bytes(const Float4* texels, uint32_t count, uint8_t* row) const {
  const uint32_t* const table = srgb_encode_table();
  const bool swapped = byte_of_[0] == 2;
  const __m128 least = _mm_set_ps(0, kSrgbEncodeMin, kSrgbEncodeMin, kSrgbEncodeMin), one = _mm_set1_ps(1);
  const __m128i first = _mm_set1_epi32(kSrgbEncodeFirst), low_half = _mm_set1_epi32(0xffff), low_byte = _mm_set1_epi32(0xff);
  for (uint32_t i = 0; i < count; ++i) {
    const __m128 value = _mm_min_ps(_mm_max_ps(texels[i], least), one);  // NaN: the least
    const __m128i bits = _mm_castps_si128(value), index = _mm_sub_epi32(_mm_srli_epi32(bits, 16), first);
    const __m128i entry =
        _mm_set_epi32(0, static_cast<int>(table[_mm_extract_epi32(index, 2)]),
                      static_cast<int>(table[_mm_extract_epi32(index, 1)]), static_cast<int>(table[_mm_cvtsi128_si32(index)]));
    // code + (low half >= boundary)
    const __m128i below = _mm_cmpgt_epi32(_mm_srli_epi32(entry, 8), _mm_and_si128(bits, low_half));
    __m128i codes = _mm_add_epi32(_mm_add_epi32(_mm_and_si128(entry, low_byte), _mm_set1_epi32(1)), below);
    if (swapped) codes = _mm_shuffle_epi32(codes, _MM_SHUFFLE(3, 0, 1, 2));
    const double alpha = double{_mm_cvtss_f32(_mm_shuffle_ps(value, value, 3))} * 255;
    codes = _mm_insert_epi32(codes, _mm_cvtsd_si32(_mm_set_sd(alpha)), 3);
    const __m128i words = _mm_packs_epi32(codes, codes);
    const int32_t texel = _mm_cvtsi128_si32(_mm_packus_epi16(words, words));
    std::memcpy(row + size_t{i} * 4, &texel, 4);
  }
}

void TexelRow::write_values(const Float4* texels, uint32_t count, uint8_t* row) const {
  const uint32_t texel_bytes = format_.texel_bytes;
  if (kind_ == Kind::kBytes && texel_bytes == 4) return write_bytes(texels, count, row);
  if (kind_ == Kind::kSrgbBytes && texel_bytes == 4) return write_srgb_bytes(texels, count, row);
  if (kind_ != Kind::kFloats && kind_ != Kind::kHalves) {
    for (uint32_t i = 0; i < count; ++i) {
      VkClearColorValue color;
      for (uint32_t c = 0; c < 4; ++c) color.float32[c] = texels[i][c];
      pack_clear_color(format_, color, row + size_t{i} * texel_bytes);
    }
    return;
  }
  for (uint32_t i = 0; i < count; ++i) {
    uint8_t* texel = row + size_t{i} * texel_bytes;
    for (uint32_t c = 0; c < 4; ++c) {
      if (format_.component[c].bits == 0) continue;
      const float value = texels[i][c];
      const uint16_t half = float_to_half(value);
      if (kind_ == Kind::kFloats) {
        std::memcpy(texel + 4 * byte_of_[c], &value, 4);
      } else {
        std::memcpy(texel + 2 * byte_of_[c], &half, 2);
      }
    }
  }
}

}  // namespace pineda::raster
