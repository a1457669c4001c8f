// Memory filled with a texel or a word.
#pragma once

#include <cstdint>

namespace pineda::raster {

// What is larger than what caches keep is written past them: a store that fetches its line first moves half as many bytes again,
// and would push out what the application works on.
inline constexpr uint64_t kStreamBytes = 8 << 20;

class FillPattern {
 public:
  FillPattern(const uint8_t* pattern, uint32_t pattern_bytes);  // 1 to 16 bytes
  // Repeats the pattern from dst on. `stream`: past the caches; _mm_sfence() must follow the last one.
  void fill(uint8_t* dst, uint64_t bytes, bool stream) const;

 private:
  static constexpr uint32_t kLineBytes = 64, kMostBytes = 16 * kLineBytes;
  uint32_t pattern_bytes_, period_bytes_;               // whole lines and whole patterns
  alignas(64) uint8_t bytes_[kMostBytes + kLineBytes];  // a period and a line more
};

}  // namespace pineda::raster
