// What a texel may hold for an exact value, after cts-subset/reference/formats.h: doubles, written from the specification.
#pragma once

#include <algorithm>
#include <cmath>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "cts-subset/reference/formats.h"

namespace pineda::test {

// Of the two texels that `value` lies between, the nearer one is wanted: the encoding of any number within `slack` of `value`.
// The slack is what binary32 arithmetic before the conversion may lose; it decides only near the middle between two codes.
inline bool holds(const cts::Channel& channel, double got, double value, double slack) {
  cts::Channel code = channel;
  if (channel.numeric == cts::Numeric::kSrgb) {  // codes are evenly spaced after the transfer function
    code.numeric = cts::Numeric::kUnorm;
    const auto encoded = [](double v) { return cts::linear_to_srgb(std::clamp(v, 0.0, 1.0)); };
    got = encoded(got);
    // Near zero the function's slope is 12.92. The tables are right to 2^-24 of a linear value.
    const double low = cts::representable(code, encoded(value - slack) - 1e-6).nearest;
    const double high = cts::representable(code, encoded(value + slack) + 1e-6).nearest;
    return got >= low - 1e-9 && got <= high + 1e-9;
  }
  const double low = cts::representable(code, value - slack).nearest, high = cts::representable(code, value + slack).nearest;
  return got >= low && got <= high;
}

// An empty string, or which channel is wrong.
inline std::string differs(const cts::FormatInfo& format, const uint8_t* texel, const cts::Colour& value, double slack) {
  const cts::Colour got = cts::decode(format, reinterpret_cast<const std::byte*>(texel));
  for (size_t c = 0; c < 4; ++c) {
    const cts::Channel* channel = format.channel("rgba"[c]);
    if (!channel || holds(*channel, got[c], value[c], slack * (1 + std::abs(value[c])))) continue;
    return std::string(format.name) + " channel " + "rgba"[c] + " holds " + std::to_string(got[c]) + " for " +
           std::to_string(value[c]);
  }
  return {};
}

// Numbers for every channel: small integers that fit for integer formats; around [-1, 1], its ends and a few larger ones for the
// others.
inline double random_channel(const cts::FormatInfo& format, char name, std::mt19937& random) {
  const cts::Channel* channel = format.channel(name);
  const uint32_t bits = channel ? std::min(channel->bits, 24u) : 1;
  if (format.is_integer()) {
    const double unsigned_value = random() >> (32 - bits);
    return format.is_signed() ? unsigned_value - std::exp2(bits - 1) : unsigned_value;
  }
  static constexpr double kEnds[] = {0, 1, -1, 0.5, -0.5, 2, -2, 1000};
  if (random() % 8 == 0) return kEnds[random() % std::size(kEnds)];
  return static_cast<float>(random() / 0x1p32 * 2.5 - 1.25);
}

// Texels with random finite contents; of E5B9G9R9 any bits.
inline std::vector<uint8_t> random_texels(const cts::FormatInfo& format, size_t count, std::mt19937& random) {
  std::vector<uint8_t> out(count * format.bytes);
  const bool is_float =
      format.channels[0].numeric == cts::Numeric::kSfloat || format.channels[0].numeric == cts::Numeric::kUfloat;
  if (!is_float || format.format == VK_FORMAT_E5B9G9R9_UFLOAT_PACK32) {
    for (uint8_t& byte : out) byte = static_cast<uint8_t>(random());
    return out;
  }
  for (size_t i = 0; i < count; ++i) {
    cts::Colour colour;
    for (size_t c = 0; c < 4; ++c) colour[c] = random_channel(format, "rgba"[c], random);
    cts::encode(format, colour, reinterpret_cast<std::byte*>(&out[i * format.bytes]));
  }
  return out;
}

// As shaders see it: binary32, or the integer.
inline uint32_t shader_word(const cts::FormatInfo& format, double value) {
  if (!format.is_integer()) return std::bit_cast<uint32_t>(static_cast<float>(value));
  return static_cast<uint32_t>(static_cast<int64_t>(value));
}
inline double from_word(const cts::FormatInfo& format, uint32_t word) {
  if (!format.is_integer()) return std::bit_cast<float>(word);
  return format.is_signed() ? double{static_cast<double>(static_cast<int32_t>(word))} : double{static_cast<double>(word)};
}
// "", "u" or "i", as in uvec4.
inline const char* glsl_prefix(const cts::FormatInfo& format) {
  return !format.is_integer() ? "" : format.is_signed() ? "i" : "u";
}

// Whether a shader read what the texel holds. Conversions of codes round once, so binary32 is right to half an ulp; sRGB's table
// is the rounded value too, but of 8 bits the specification asks less.
inline bool reads(const cts::FormatInfo& format, uint32_t word, double want) {
  const double got = from_word(format, word);
  if (std::isnan(want)) return std::isnan(got);
  return got == want || std::abs(got - want) <= std::abs(want) * 0x1p-23;
}

}  // namespace pineda::test
