// The encoders of scenes and benchmark rows against the driver's decoders, which base/block_codec_test.cpp holds against others.
#include "tools/block_encoder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "base/block_codec.h"
#include "base/format.h"

namespace pineda::tests {
namespace {

using tools::BlockFormat;

struct Case {
  BlockFormat blocks;
  VkFormat format;
};

TEST(BlockEncoder, BlocksDecodeToWhatItSays) {
  std::mt19937 random(20250306);
  tools::Image image{.width = 41, .height = 22, .rgba = std::vector<uint8_t>(41 * 22 * 4)};
  for (uint32_t i = 0; i < image.rgba.size(); ++i) {  // noise, ramps and one flat block
    const uint32_t x = i / 4 % 41, y = i / 4 / 41;
    image.rgba[i] = static_cast<uint8_t>(x < 4 && y < 4 ? 77 : x < 20 ? random() : 6 * x + 3 * y + 20 * (i % 4));
  }
  for (const Case c : {Case{BlockFormat::kBc1, VK_FORMAT_BC1_RGB_UNORM_BLOCK},
                       {BlockFormat::kBc7, VK_FORMAT_BC7_UNORM_BLOCK},
                       {BlockFormat::kEtc2, VK_FORMAT_ETC2_R8G8B8_UNORM_BLOCK},
                       {BlockFormat::kAstc4x4, VK_FORMAT_ASTC_4x4_UNORM_BLOCK}}) {
    const tools::EncodedImage encoded = tools::encode_blocks(c.blocks, image);
    const FormatInfo& format = *find_format(c.format);
    const FormatInfo& shown = *find_format(format.decoded);
    const uint32_t columns = (image.width + 3) / 4, rows = (image.height + 3) / 4;
    ASSERT_EQ(tools::block_bytes(c.blocks), format.texel_bytes);
    ASSERT_EQ(encoded.blocks.size(), size_t{columns} * rows * format.texel_bytes);
    for (uint32_t y = 0; y < image.height; ++y) {
      for (uint32_t x = 0; x < image.width; ++x) {
        uint8_t block[kMaxBlockBytes];
        block_decoder(format)(format, &encoded.blocks[size_t{y / 4 * columns + x / 4} * format.texel_bytes], block);
        const VkClearColorValue texel = unpack_texel(shown, block + size_t{y % 4 * 4 + x % 4} * shown.texel_bytes);
        // ASTC decodes to 16-bit floats; the encoder says the nearest of 8 bits.
        for (uint32_t i = 0; i < 4; ++i) {
          ASSERT_NEAR(texel.float32[i] * 255, encoded.decoded.pixel(x, y)[i], 0.6) << format.name << " " << x << ", " << y;
        }
      }
    }
  }
}

}  // namespace
}  // namespace pineda::tests
