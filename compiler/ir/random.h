// Sebastiano Vigna's SplitMix64: the same sequence everywhere, unlike the standard distributions.
#pragma once

#include <cstdint>
#include <iterator>

namespace pineda::ir {

class Random {
 public:
  explicit Random(uint64_t seed) : state_(seed) {}
  uint64_t next() {
    uint64_t z = state_ += 0x9E3779B97F4A7C15ull;
    z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9ull;
    z = (z ^ z >> 27) * 0x94D049BB133111EBull;
    return z ^ z >> 31;
  }
  uint32_t below(uint64_t n) { return static_cast<uint32_t>((next() >> 32) * n >> 32); }
  bool one_in(uint32_t n) { return below(n) == 0; }
  template <typename Table>
  auto pick(const Table& table) {
    return std::data(table)[below(std::size(table))];
  }

 private:
  uint64_t state_;
};

}  // namespace pineda::ir
