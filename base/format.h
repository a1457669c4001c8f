// Queries over the table of formats (formats.inc). Everything that depends on a format derives from a FormatInfo row:
// capabilities in icd, packing and unpacking in compiler/kernels, sizes in raster.
#pragma once

#include <vulkan/vulkan_core.h>

#include <array>
#include <cstdint>

namespace pineda {

enum class Numeric : uint8_t { kUnorm, kSnorm, kUscaled, kSscaled, kUint, kSint, kSfloat, kSrgb };

enum FormatUse : uint16_t { kUseSampled = 1, kUseLinear = 2, kUseColor = 4, kUseBlend = 8, kUseDepth = 16, kUseVertex = 32 };

struct ComponentBits {
  uint8_t first_bit, bits;  // bits == 0: absent
};

struct FormatInfo {
  VkFormat format;
  const char* name;  // "R8G8B8A8_UNORM"
  uint8_t texel_bytes;
  Numeric numeric;
  std::array<ComponentBits, 4> component;  // R, G, B, A
  uint16_t uses;                           // FormatUse bits

  bool is_depth() const { return (uses & kUseDepth) != 0; }
  bool is_integer() const { return numeric == Numeric::kUint || numeric == Numeric::kSint; }
};

// Null when the format is not supported at all.
const FormatInfo* find_format(VkFormat format);

// Bytes of one texel; 0 for an unsupported format.
inline uint32_t texel_bytes(VkFormat format) {
  const FormatInfo* info = find_format(format);
  return info ? info->texel_bytes : 0;
}

// Packs one texel, exactly as the kernels do (same rounding; the specification's "Conversion from ..." sections). For clears.
// `out` gets texel_bytes. color is VkClearColorValue for colour formats; for depth formats use pack_depth.
void pack_clear_color(const FormatInfo& format, const VkClearColorValue& color, uint8_t* out);
void pack_depth(const FormatInfo& format, float depth, uint8_t* out);

}  // namespace pineda
