#include "base/format.h"

namespace pineda {
namespace {

constexpr uint16_t S = kUseSampled, L = kUseLinear, C = kUseColor, B = kUseBlend, D = kUseDepth, V = kUseVertex, I = kUseStorage,
                   A = kUseStorageAtomic, U = kUseUniformTexel, T = kUseStorageTexel;

constexpr VkImageAspectFlags kDepthAspect = VK_IMAGE_ASPECT_DEPTH_BIT, kStencilAspect = VK_IMAGE_ASPECT_STENCIL_BIT;

constexpr FormatInfo planes(VkFormat format, const char* name, uint8_t bytes, uint8_t shift_x, uint8_t shift_y,
                            std::array<VkFormat, 3> formats, uint16_t uses) {
  FormatInfo info{format, name, bytes, Numeric::kUnorm, {}, uses};
  info.planes = formats;
  info.plane_shift_x = shift_x;
  info.plane_shift_y = shift_y;
  if (formats[1] == VK_FORMAT_S8_UINT) info.aspects = kDepthAspect | kStencilAspect;
  return info;
}

constexpr FormatInfo blocks(VkFormat format, const char* name, uint8_t bytes, uint8_t width, uint8_t height, VkFormat decoded,
                            uint16_t uses) {
  FormatInfo info{format, name, bytes, Numeric::kUnorm, {}, uses};
  info.block_width = width;
  info.block_height = height;
  info.decoded = decoded;
  return info;
}

constexpr FormatInfo kFormats[] = {
#define PINEDA_FORMAT(name, bytes, numeric, r, g, b, a, uses) \
  {VK_FORMAT_##name, #name, bytes, Numeric::k##numeric, {{r, g, b, a}}, uses},
#define PINEDA_DEPTH(name, bytes, numeric, bits, uses) \
  {VK_FORMAT_##name, #name, bytes, Numeric::k##numeric, {{{0, bits}}}, uses, kDepthAspect},
#define PINEDA_STENCIL(name, uses) {VK_FORMAT_##name, #name, 1, Numeric::kUint, {{{0, 8}}}, uses, kStencilAspect},
#define PINEDA_PLANES(name, bytes, shift_x, shift_y, formats, uses) \
  planes(VK_FORMAT_##name, #name, bytes, shift_x, shift_y, {formats}, uses),
#define PINEDA_BLOCKS(name, bytes, width, height, decoded, uses) \
  blocks(VK_FORMAT_##name, #name, bytes, width, height, VK_FORMAT_##decoded, uses),
#include "base/formats.inc"
};

// Formats of extensions are numbered from 1000000000 on; those of the table get indices behind the core formats.
constexpr int kCoreFormats = VK_FORMAT_ASTC_12x12_SRGB_BLOCK + 1;
constexpr int kYcbcrFormats = VK_FORMAT_G16_B16_R16_3PLANE_444_UNORM - VK_FORMAT_G8B8G8R8_422_UNORM + 1;
constexpr int kIndices = kCoreFormats + kYcbcrFormats + 2;

constexpr int index_of(VkFormat format) {
  if (format >= 0 && format < kCoreFormats) return format;
  const int ycbcr = format - VK_FORMAT_G8B8G8R8_422_UNORM, packed = format - VK_FORMAT_A4R4G4B4_UNORM_PACK16;
  if (ycbcr >= 0 && ycbcr < kYcbcrFormats) return kCoreFormats + ycbcr;
  if (packed >= 0 && packed < 2) return kCoreFormats + kYcbcrFormats + packed;
  return -1;
}

// Row of kFormats for each index, -1 where there is none.
constexpr auto kRows = [] {
  std::array<int16_t, kIndices> rows{};
  rows.fill(-1);
  for (size_t i = 0; i < std::size(kFormats); ++i) rows[index_of(kFormats[i].format)] = static_cast<int16_t>(i);
  return rows;
}();

}  // namespace

std::span<const FormatInfo> all_formats() { return kFormats; }

const FormatInfo* find_format(VkFormat format) {
  const int index = index_of(format);
  if (index < 0 || kRows[index] < 0) return nullptr;
  return &kFormats[kRows[index]];
}

uint32_t plane_of(const FormatInfo& format, VkImageAspectFlags aspect) {
  switch (aspect) {
    case VK_IMAGE_ASPECT_STENCIL_BIT:
      return format.is_depth() ? 1 : 0;
    case VK_IMAGE_ASPECT_PLANE_1_BIT:
      return 1;
    case VK_IMAGE_ASPECT_PLANE_2_BIT:
      return 2;
    default:
      return 0;
  }
}

VkFormat aspect_format(VkFormat format, VkImageAspectFlags aspect) {
  const FormatInfo* info = find_format(format);
  if (!info) return VK_FORMAT_UNDEFINED;
  constexpr VkImageAspectFlags kPlanes = VK_IMAGE_ASPECT_PLANE_0_BIT | VK_IMAGE_ASPECT_PLANE_1_BIT | VK_IMAGE_ASPECT_PLANE_2_BIT;
  const uint32_t plane = plane_of(*info, aspect);
  const bool known = (aspect & kPlanes) ? !info->is_depth_or_stencil() && info->plane_count() > 1 && plane < info->plane_count()
                                        : (info->aspects & aspect) != 0;
  return known ? info->plane_format(plane) : VK_FORMAT_UNDEFINED;
}

}  // namespace pineda
