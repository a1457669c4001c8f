#include "raster/fill_pattern.h"

#include <emmintrin.h>

#include <algorithm>
#include <cstring>
#include <numeric>

namespace pineda::raster {

FillPattern::FillPattern(const uint8_t* pattern, uint32_t pattern_bytes) : pattern_bytes_(pattern_bytes) {
  const uint32_t lines_and_patterns = std::lcm(kLineBytes, pattern_bytes);
  period_bytes_ = kMostBytes / lines_and_patterns * lines_and_patterns;
  std::memcpy(bytes_, pattern, pattern_bytes);
  const uint32_t end = period_bytes_ + kLineBytes;
  for (uint32_t done = pattern_bytes; done < end; done *= 2) std::memcpy(bytes_ + done, bytes_, std::min(done, end - done));
}

void FillPattern::fill(uint8_t* dst, uint64_t bytes, bool stream) const {
  if (!stream) {
    for (; bytes > period_bytes_; bytes -= period_bytes_, dst += period_bytes_) std::memcpy(dst, bytes_, period_bytes_);
    std::memcpy(dst, bytes_, bytes);
    return;
  }
  const uint64_t head = std::min<uint64_t>(bytes, -reinterpret_cast<uintptr_t>(dst) & (kLineBytes - 1));
  std::memcpy(dst, bytes_, head);
  dst += head, bytes -= head;
  const uint8_t* const first = bytes_ + head % pattern_bytes_;
  for (; bytes >= period_bytes_; bytes -= period_bytes_) {
    for (uint32_t i = 0; i < period_bytes_; i += 16, dst += 16)
      _mm_stream_si128(reinterpret_cast<__m128i*>(dst), _mm_loadu_si128(reinterpret_cast<const __m128i*>(first + i)));
  }
  std::memcpy(dst, first, bytes);
}

}  // namespace pineda::raster
