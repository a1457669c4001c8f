#include "tools/errors/operands.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <random>

namespace pineda::tools {
namespace {

constexpr uint32_t kCount = SharedBlock::kElements;
constexpr uint64_t kSeed = 20261123;

float from_bits(uint32_t bits) { return std::bit_cast<float>(bits); }

// Significands at the ends of a binade and at its middle, each with its neighbours: where roundings change.
uint32_t edge_significand(uint32_t i) {
  constexpr uint32_t kEdges[] = {0, 1, 2, 0x3fffff, 0x400000, 0x400001, 0x555555, 0x2aaaaa, 0x3504f3, 0x7ffffe, 0x7fffff};
  return kEdges[i % std::size(kEdges)];
}

class Sampler {
 public:
  Sampler(const MeasuredFunction& function, uint32_t block)
      : limit_(std::min(function.exponent_limit, 127)), random_(kSeed + function.number * 1000003ull + block) {}

  float any() { return value(random_bits() & 0x7fffff); }
  float edge() { return value(edge_significand(random_bits())); }
  float moderate() {  // around one
    const int exponent = static_cast<int>(random_bits() % 17) - 8;
    return sign() *
           static_cast<float>(std::ldexp(1 + (random_bits() & 0x7fffff) * 0x1p-23, std::clamp(exponent, -limit_, limit_)));
  }
  float beside(float v) { return from_bits(std::bit_cast<uint32_t>(v) + (random_bits() % 9) - 4); }
  float operand() {
    switch (random_bits() % 4) {
      case 0:
        return any();
      case 1:
        return edge();
      default:
        return moderate();
    }
  }
  uint32_t random_bits() { return static_cast<uint32_t>(random_() >> 32); }

 private:
  float sign() { return random_() & 1 ? -1.0f : 1.0f; }
  float value(uint32_t significand) {
    const int exponent = static_cast<int>(random_bits() % (2 * static_cast<uint32_t>(limit_) + 1)) - limit_;
    return sign() * static_cast<float>(std::ldexp(1 + significand * 0x1p-23, std::max(exponent, -126)));
  }

  const int limit_;
  std::mt19937_64 random_;
};

void fill_unary(bool exhaustive, uint32_t block, float* x) {
  std::mt19937 random(static_cast<uint32_t>(kSeed));
  for (uint32_t i = 0; i < kCount; ++i) x[i] = from_bits(exhaustive ? block * kCount + i : i << 12 | (random() & 0xfff));
}

float from_half_bits(uint32_t bits) {
  const uint32_t exponent = bits >> 10 & 31, fraction = bits & 1023;
  const float magnitude = exponent == 31  ? (fraction ? NAN : INFINITY)
                          : exponent == 0 ? std::ldexp(static_cast<float>(fraction), -24)
                                          : std::ldexp(static_cast<float>(1024 + fraction), static_cast<int>(exponent) - 25);
  return bits & 0x8000 ? -magnitude : magnitude;
}

// Any values, and values within the exponents that the function wants; those only when it wants few.
void fill_halves(const MeasuredFunction& function, uint32_t block, float* x, float* y, float* z) {
  std::mt19937_64 random(kSeed + function.number * 1000003ull + block);
  const auto limit = static_cast<uint32_t>(function.exponent_limit);
  const bool unlimited = limit >= 15;
  const auto operand = [&] {
    const auto bits = static_cast<uint32_t>(random() >> 32);
    const uint32_t exponent = unlimited ? 15 + bits / 65536 % 9 - 4 : 15 + bits / 65536 % (2 * limit + 1) - limit;
    return from_half_bits(unlimited && bits & 1 ? bits >> 8 & 0xffff : (bits & 0x83ff) | exponent << 10);
  };
  for (uint32_t i = 0; i < kCount; ++i) {
    x[i] = unlimited ? from_half_bits(i & 0xffff) : operand();
    y[i] = operand();
    z[i] = operand();
    if (function.number == 165) x[i] = std::fabs(x[i]);  // pow
  }
}

void fill_doubles(const MeasuredFunction& function, uint32_t block, float* x, float* y, float* z) {
  std::mt19937_64 random(kSeed + function.number * 1000003ull + block);
  const auto limit = static_cast<uint32_t>(function.exponent_limit);
  const auto operand = [&] {
    const uint64_t bits = random(), kind = random();
    const uint64_t exponent = kind & 1 ? 1023 + kind / 8 % (2 * limit + 1) - limit : 1023 + kind / 8 % 17 - 8;
    const uint64_t edge = (uint64_t{edge_significand(kind >> 16 & 0xffff)} << 29) + (bits & 3);
    return bits >> 63 << 63 | exponent << 52 | (kind & 2 ? bits << 12 >> 12 : edge);
  };
  const auto put = [](float* array, uint32_t i, uint64_t bits) {
    array[i] = from_bits(static_cast<uint32_t>(bits));
    array[i + kCount / 2] = from_bits(static_cast<uint32_t>(bits >> 32));
  };
  for (uint32_t i = 0; i < kCount / 2; ++i) {
    for (float* array : {x, y, z}) put(array, i, operand());
  }
}

}  // namespace

void fill_operands(const MeasuredFunction& function, bool exhaustive, uint32_t block, float* x, float* y, float* z) {
  if (function.width == Width::k16) return fill_halves(function, block, x, y, z);
  if (function.width == Width::k64) return fill_doubles(function, block, x, y, z);
  if (function.operands == 1) return fill_unary(exhaustive, block, x);
  Sampler sampler(function, block);
  for (uint32_t i = 0; i < kCount; ++i) {
    x[i] = sampler.operand();
    y[i] = i % 8 == 0 ? sampler.beside(x[i]) : sampler.operand();
    z[i] = i % 8 == 1 && function.cancels ? sampler.beside(-x[i] * y[i]) : i % 8 == 2 ? sampler.beside(y[i]) : sampler.operand();
    if (function.number == 37) x[i] = std::fabs(x[i]);   // pow
    if (function.number == 39) y[i] = std::trunc(y[i]);  // ldexp
    if (function.number == 37 && i % 4) {                // exponents that keep the result in range
      const double log = std::log2(double{x[i]});
      y[i] = static_cast<float>((sampler.random_bits() * 0x1p-32 - 0.5) * 290 / (log == 0 ? 1 : log));
    }
  }
}

}  // namespace pineda::tools
