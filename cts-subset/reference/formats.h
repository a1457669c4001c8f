// What a texel of each uncompressed format means, written from the specification's chapter "Formats", in double precision.
#pragma once

#include <vulkan/vulkan_core.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace pineda::cts {

enum class Numeric { kUnorm, kSnorm, kUscaled, kSscaled, kUint, kSint, kSfloat, kUfloat, kSrgb };

struct Channel {
  char name = 'x';          // r g b a d s, x for padding
  uint32_t shift_bits = 0;  // from the least significant bit of the texel read as a little-endian number
  uint32_t bits = 0;
  Numeric numeric = Numeric::kUnorm;
};

struct FormatInfo {
  VkFormat format;
  const char* name;  // without VK_FORMAT_
  uint32_t bytes;
  std::vector<Channel> channels;

  bool is_integer() const { return channels[0].numeric == Numeric::kUint || channels[0].numeric == Numeric::kSint; }
  bool is_signed() const;
  const Channel* channel(char name) const;
};

// Colour formats without block compression. E5B9G9R9's shared exponent is decoded by name.
std::span<const FormatInfo> colour_formats();
const FormatInfo& info_of(VkFormat format);

// What GLSL calls the formats that a storage image can declare, of at most 32 bits a channel ("Compatibility Between SPIR-V Image
// Formats And Vulkan Formats").
struct StorageFormat {
  VkFormat format;
  const char* qualifier;
};
std::span<const StorageFormat> storage_formats();

using Colour = std::array<double, 4>;  // r, g, b, a; what a format lacks is 0, 0, 0, 1

Colour decode(const FormatInfo& info, const std::byte* texel);
// The two values that a channel may hold for `value` (below and above it, equal when it is exact), as decoded numbers:
// conversions to fixed point should round to nearest, but the specification demands only less than one step.
struct Bracket {
  double low, high, nearest;
};
Bracket representable(const Channel& channel, double value);
// The nearest encoding.
void encode(const FormatInfo& info, const Colour& colour, std::byte* texel);

double srgb_to_linear(double encoded);
double linear_to_srgb(double linear);

}  // namespace pineda::cts
