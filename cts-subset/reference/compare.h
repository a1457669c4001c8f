// Whether what an attachment holds is what an exact result allows.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "cts-subset/harness/case.h"
#include "cts-subset/reference/formats.h"

namespace pineda::cts {

// One step of the channel at `magnitude`, in the space where its codes are evenly spaced (the encoded one for sRGB).
inline double step_of(const Channel& channel, double magnitude) {
  switch (channel.numeric) {
    case Numeric::kUnorm:
    case Numeric::kSrgb:
      return 1 / (std::exp2(channel.bits) - 1);
    case Numeric::kSnorm:
      return 1 / (std::exp2(channel.bits - 1) - 1);
    case Numeric::kSfloat:
    case Numeric::kUfloat: {
      const int mantissa_bits = channel.bits == 32 ? 23 : channel.bits == 16 ? 10 : static_cast<int>(channel.bits) - 5;
      const int exponent = magnitude > 0 ? std::max(std::ilogb(magnitude), channel.bits == 32 ? -126 : -14) : -14;
      return std::ldexp(1.0, exponent - mantissa_bits);
    }
    default:
      return 1;
  }
}

// The channel's value for an exact result: clamped to what the format holds.
inline double clamp_to(const Channel& channel, double value) {
  switch (channel.numeric) {
    case Numeric::kUnorm:
    case Numeric::kSrgb:
      return std::clamp(value, 0.0, 1.0);
    case Numeric::kSnorm:
      return std::clamp(value, -1.0, 1.0);
    case Numeric::kUfloat:
      return std::max(value, 0.0);
    default:
      return value;
  }
}

// Throws Failure unless each channel that the format has is within `steps` of the exact colour (of floats: at the magnitude of
// the terms that were added, when that is larger than the result's).
inline void expect_colour(const FormatInfo& info, const std::byte* texel, const Colour& exact, double steps,
                          const std::string& where, double terms = 0) {
  const Colour got = decode(info, texel);
  for (size_t i = 0; i < 4; ++i) {
    const Channel* channel = info.channel("rgba"[i]);
    if (!channel) continue;
    double want = clamp_to(*channel, exact[i]), have = got[i];
    const double step = step_of(*channel, std::max(std::abs(want), terms));
    if (channel->numeric == Numeric::kSrgb) want = linear_to_srgb(want), have = linear_to_srgb(have);
    expect(std::abs(have - want) <= steps * step + 1e-9 || have == want,
           fmt::format("{}: channel {} holds {:.9g}, not {:.9g} ({:.2f} steps, allowed {})", where, "rgba"[i], have, want,
                       std::abs(have - want) / step, steps));
  }
}

}  // namespace pineda::cts
