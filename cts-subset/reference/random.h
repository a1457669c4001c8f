// Inputs of cases: a fixed seed for each, so that a failure repeats.
#pragma once

#include <cstdint>
#include <string_view>

namespace pineda::cts {

class Random {  // SplitMix64 (Steele, Lea, Flood 2014)
 public:
  explicit Random(std::string_view name) {
    for (const char c : name) state_ = state_ * 1099511628211u + static_cast<unsigned char>(c);
  }
  uint64_t next() {
    uint64_t z = state_ += 0x9E3779B97F4A7C15u;
    z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9u;
    z = (z ^ z >> 27) * 0x94D049BB133111EBu;
    return z ^ z >> 31;
  }
  uint32_t bits() { return static_cast<uint32_t>(next() >> 32); }
  uint32_t below(uint32_t bound) { return static_cast<uint32_t>((next() >> 32) * bound >> 32); }
  double unit() { return static_cast<double>(next() >> 11) * 0x1p-53; }  // [0, 1)
  double between(double low, double high) { return low + (high - low) * unit(); }

 private:
  uint64_t state_ = 0xCBF29CE484222325u;
};

}  // namespace pineda::cts
