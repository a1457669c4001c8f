#include "base/block_codec.h"

#include "base/block_decoders.h"

namespace pineda {

BlockDecoder block_decoder(const FormatInfo& format) {
  struct Family {
    VkFormat first, last;
    BlockDecoder decoder;
  };
  static constexpr Family kFamilies[] = {
      {VK_FORMAT_BC1_RGB_UNORM_BLOCK, VK_FORMAT_BC1_RGBA_SRGB_BLOCK, decode_bc1},
      {VK_FORMAT_BC2_UNORM_BLOCK, VK_FORMAT_BC2_SRGB_BLOCK, decode_bc2},
      {VK_FORMAT_BC3_UNORM_BLOCK, VK_FORMAT_BC3_SRGB_BLOCK, decode_bc3},
      {VK_FORMAT_BC4_UNORM_BLOCK, VK_FORMAT_BC4_SNORM_BLOCK, decode_bc4},
      {VK_FORMAT_BC5_UNORM_BLOCK, VK_FORMAT_BC5_SNORM_BLOCK, decode_bc5},
      {VK_FORMAT_BC6H_UFLOAT_BLOCK, VK_FORMAT_BC6H_SFLOAT_BLOCK, decode_bc6h},
      {VK_FORMAT_BC7_UNORM_BLOCK, VK_FORMAT_BC7_SRGB_BLOCK, decode_bc7},
      {VK_FORMAT_ETC2_R8G8B8_UNORM_BLOCK, VK_FORMAT_ETC2_R8G8B8_SRGB_BLOCK, decode_etc2_rgb},
      {VK_FORMAT_ETC2_R8G8B8A1_UNORM_BLOCK, VK_FORMAT_ETC2_R8G8B8A1_SRGB_BLOCK, decode_etc2_rgb_a1},
      {VK_FORMAT_ETC2_R8G8B8A8_UNORM_BLOCK, VK_FORMAT_ETC2_R8G8B8A8_SRGB_BLOCK, decode_etc2_rgba},
      {VK_FORMAT_EAC_R11_UNORM_BLOCK, VK_FORMAT_EAC_R11_SNORM_BLOCK, decode_eac_r11},
      {VK_FORMAT_EAC_R11G11_UNORM_BLOCK, VK_FORMAT_EAC_R11G11_SNORM_BLOCK, decode_eac_rg11},
      {VK_FORMAT_ASTC_4x4_UNORM_BLOCK, VK_FORMAT_ASTC_12x12_SRGB_BLOCK, decode_astc},
  };
  for (const Family& family : kFamilies) {
    if (format.format >= family.first && format.format <= family.last) return family.decoder;
  }
  return nullptr;
}

}  // namespace pineda
