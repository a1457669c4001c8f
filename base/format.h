// Queries over the table of formats (formats.inc). Everything that depends on a format derives from a FormatInfo row:
// capabilities in icd, packing and unpacking in compiler/kernels and here, sizes in raster.
//
// Three kinds of rows. A plain format (colour, depth or stencil) has texels with components. A format of several planes (depth
// with stencil, YCbCr) is kept as one plain image for each plane, so only icd/ ever sees it: attachments, descriptors and kernels
// get the format of a plane. A block-compressed format is kept with a decoded copy beside it (base/block_codec.h), and kernels
// get the decoded copy's format.
#pragma once

#include <vulkan/vulkan_core.h>

#include <array>
#include <cstdint>
#include <span>

namespace pineda {

// kUfloat: 5 exponent bits, no sign. kSharedExp: E5B9G9R9.
enum class Numeric : uint8_t { kUnorm, kSnorm, kUscaled, kSscaled, kUint, kSint, kSfloat, kSrgb, kUfloat, kSharedExp };

enum FormatUse : uint16_t {
  kUseSampled = 1,
  kUseLinear = 2,
  kUseColor = 4,
  kUseBlend = 8,
  kUseDepth = 16,  // depth or stencil attachment
  kUseVertex = 32,
  kUseStorage = 64,
  kUseStorageAtomic = 128,
  kUseUniformTexel = 256,
  kUseStorageTexel = 512
};

struct ComponentBits {
  uint8_t first_bit, bits;  // bits == 0: absent
};

struct FormatInfo {
  VkFormat format;
  const char* name;     // "R8G8B8A8_UNORM"
  uint8_t texel_bytes;  // of a texel; of a block; of all planes' first texels
  Numeric numeric;
  std::array<ComponentBits, 4> component;  // R, G, B, A; plain formats only
  uint16_t uses;                           // FormatUse bits
  VkImageAspectFlags aspects = VK_IMAGE_ASPECT_COLOR_BIT;
  uint8_t block_width = 1, block_height = 1;  // texels
  VkFormat decoded = VK_FORMAT_UNDEFINED;     // block-compressed formats only
  std::array<VkFormat, 3> planes{};           // formats of several planes only
  uint8_t plane_shift_x = 0, plane_shift_y = 0;

  bool is_depth() const { return (aspects & VK_IMAGE_ASPECT_DEPTH_BIT) != 0; }
  bool has_stencil() const { return (aspects & VK_IMAGE_ASPECT_STENCIL_BIT) != 0; }
  bool is_depth_or_stencil() const { return is_depth() || has_stencil(); }
  bool is_integer() const { return numeric == Numeric::kUint || numeric == Numeric::kSint; }
  bool is_float() const { return numeric == Numeric::kSfloat || numeric == Numeric::kUfloat || numeric == Numeric::kSharedExp; }
  bool is_scaled() const { return numeric == Numeric::kUscaled || numeric == Numeric::kSscaled; }
  bool is_compressed() const { return decoded != VK_FORMAT_UNDEFINED; }
  bool is_plain() const { return planes[0] == VK_FORMAT_UNDEFINED && !is_compressed(); }
  uint32_t plane_count() const { return planes[0] == VK_FORMAT_UNDEFINED ? 1 : planes[2] == VK_FORMAT_UNDEFINED ? 2 : 3; }
  VkFormat plane_format(uint32_t plane) const { return planes[0] == VK_FORMAT_UNDEFINED ? format : planes[plane]; }
};

// Every row of the table.
std::span<const FormatInfo> all_formats();

// Null when the format is not in the table.
const FormatInfo* find_format(VkFormat format);

// Bytes of one texel (or block); 0 for an unsupported format.
inline uint32_t texel_bytes(VkFormat format) {
  const FormatInfo* info = find_format(format);
  return info ? info->texel_bytes : 0;
}

// The plane that holds an aspect (one bit): depth 0; stencil 1, or 0 when there is no depth; PLANE_n n; colour 0.
uint32_t plane_of(const FormatInfo& format, VkImageAspectFlags aspect);

// How the aspect's plane is stored: X8_D24_UNORM_PACK32 for the depth of D24_UNORM_S8_UINT. UNDEFINED when it has none.
VkFormat aspect_format(VkFormat format, VkImageAspectFlags aspect);

// ---- texels on the host: plain formats, the same rounding as the kernels (compiler/kernels/texel.h) -----------------------

// Packs one texel (the specification's "Conversion from ..." sections). `out` gets texel_bytes. color is VkClearColorValue for
// colour formats; for depth formats use pack_depth. Scaled formats, which no image has, pack as zero.
void pack_clear_color(const FormatInfo& format, const VkClearColorValue& color, uint8_t* out);
void pack_depth(const FormatInfo& format, float depth, uint8_t* out);

// Components as float32, or for integer formats int32/uint32. Absent ones are 0, alpha 1. Depth or stencil is in the first.
VkClearColorValue unpack_texel(const FormatInfo& format, const uint8_t* texel);

}  // namespace pineda
