// "Wrapping Operation" of the chapter "Image Operations".
#pragma once

#include <vulkan/vulkan_core.h>

#include <algorithm>

namespace pineda::cts {

// The texel's index after the address mode, or -1 for the border.
inline int wrapped(VkSamplerAddressMode mode, int i, int size) {
  const auto mirror = [](int n) { return n >= 0 ? n : -(1 + n); };
  const auto mod = [](int a, int n) { return (a % n + n) % n; };
  switch (mode) {
    case VK_SAMPLER_ADDRESS_MODE_REPEAT:
      return mod(i, size);
    case VK_SAMPLER_ADDRESS_MODE_MIRRORED_REPEAT:
      return size - 1 - mirror(mod(i, 2 * size) - size);
    case VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE:
      return std::clamp(i, 0, size - 1);
    case VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_BORDER:
      return i < 0 || i >= size ? -1 : i;
    default:
      return std::clamp(mirror(i), 0, size - 1);
  }
}

}  // namespace pineda::cts
