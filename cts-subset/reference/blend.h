// Blend factors and operations, from the specification's tables "Blend Factors" and "Basic Blend Operations".
#pragma once

#include <vulkan/vulkan_core.h>

#include <algorithm>
#include <array>
#include <cstddef>

namespace pineda::cts {

using BlendColour = std::array<double, 4>;

// Of one channel: s is the source, s1 the second one, d the destination, k the blend constants.
inline double blend_factor(VkBlendFactor factor, size_t channel, const BlendColour& s, const BlendColour& s1,
                           const BlendColour& d, const BlendColour& k) {
  switch (factor) {
    case VK_BLEND_FACTOR_ZERO:
      return 0;
    case VK_BLEND_FACTOR_ONE:
      return 1;
    case VK_BLEND_FACTOR_SRC_COLOR:
      return s[channel];
    case VK_BLEND_FACTOR_ONE_MINUS_SRC_COLOR:
      return 1 - s[channel];
    case VK_BLEND_FACTOR_DST_COLOR:
      return d[channel];
    case VK_BLEND_FACTOR_ONE_MINUS_DST_COLOR:
      return 1 - d[channel];
    case VK_BLEND_FACTOR_SRC_ALPHA:
      return s[3];
    case VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA:
      return 1 - s[3];
    case VK_BLEND_FACTOR_DST_ALPHA:
      return d[3];
    case VK_BLEND_FACTOR_ONE_MINUS_DST_ALPHA:
      return 1 - d[3];
    case VK_BLEND_FACTOR_CONSTANT_COLOR:
      return k[channel];
    case VK_BLEND_FACTOR_ONE_MINUS_CONSTANT_COLOR:
      return 1 - k[channel];
    case VK_BLEND_FACTOR_CONSTANT_ALPHA:
      return k[3];
    case VK_BLEND_FACTOR_ONE_MINUS_CONSTANT_ALPHA:
      return 1 - k[3];
    case VK_BLEND_FACTOR_SRC1_COLOR:
      return s1[channel];
    case VK_BLEND_FACTOR_ONE_MINUS_SRC1_COLOR:
      return 1 - s1[channel];
    case VK_BLEND_FACTOR_SRC1_ALPHA:
      return s1[3];
    case VK_BLEND_FACTOR_ONE_MINUS_SRC1_ALPHA:
      return 1 - s1[3];
    default:
      return channel == 3 ? 1 : std::min(s[3], 1 - d[3]);
  }
}

// Of a source s with factor fs and a destination d with factor fd.
inline double blended(VkBlendOp op, double s, double fs, double d, double fd) {
  switch (op) {
    case VK_BLEND_OP_ADD:
      return s * fs + d * fd;
    case VK_BLEND_OP_SUBTRACT:
      return s * fs - d * fd;
    case VK_BLEND_OP_REVERSE_SUBTRACT:
      return d * fd - s * fs;
    case VK_BLEND_OP_MIN:
      return std::min(s, d);
    default:
      return std::max(s, d);
  }
}

}  // namespace pineda::cts
