// Every format as source and destination of transfers, through the API: copies of regions, levels, layers and aspects, linear
// blits that scale and mirror, clears. Expected values: cts-subset/reference, and plain loops.
#include <gtest/gtest.h>

#include "base/block_codec.h"
#include "base/format.h"
#include "format_oracle.h"
#include "image_client.h"

namespace pineda::test {
namespace {

constexpr uint32_t kSeed = 20250303;

std::vector<uint8_t> random_bytes(size_t count, std::mt19937& random) {
  std::vector<uint8_t> out(count);
  for (uint8_t& byte : out) byte = static_cast<uint8_t>(random());
  return out;
}

std::vector<VkImageAspectFlags> aspects_of(const FormatInfo& format) {
  if (format.plane_count() == 1) return {format.aspects};
  if (format.is_depth_or_stencil()) return {VK_IMAGE_ASPECT_DEPTH_BIT, VK_IMAGE_ASPECT_STENCIL_BIT};
  std::vector<VkImageAspectFlags> planes{VK_IMAGE_ASPECT_PLANE_0_BIT, VK_IMAGE_ASPECT_PLANE_1_BIT};
  if (format.plane_count() == 3) planes.push_back(VK_IMAGE_ASPECT_PLANE_2_BIT);
  return planes;
}

// Layers 1 and 2 of level 1 of an image of 4x3 blocks, from block (1, 1) on, go to layers 0 and 1 of an image of 5x4 blocks, at
// block (2, 2); everything else stays.
TEST(IcdFormatTransfer, EveryFormatIsCopied) {
  ImageClient client;
  std::mt19937 random(kSeed);
  uint32_t formats = 0;
  for (const FormatInfo& format : all_formats()) {
    constexpr VkFormatFeatureFlags kBoth = VK_FORMAT_FEATURE_TRANSFER_SRC_BIT | VK_FORMAT_FEATURE_TRANSFER_DST_BIT;
    if ((client.format_properties(format.format).optimalTilingFeatures & kBoth) != kBoth) continue;
    ++formats;
    const bool ycbcr = format.plane_count() > 1 && !format.is_depth_or_stencil();  // one level, even sizes
    const uint32_t levels = ycbcr ? 1 : 2, bw = format.block_width << format.plane_shift_x,
                   bh = format.block_height << format.plane_shift_y;
    const VkExtent3D small{4 * bw, 3 * bh, 1}, large{5 * bw, 4 * bh, 1};
    const VkImage source = client.make({.format = format.format,
                                        .extent = ycbcr ? small : VkExtent3D{2 * small.width, 2 * small.height, 1},
                                        .levels = levels,
                                        .layers = 3,
                                        .usage = 0});
    const VkImage destination = client.make({.format = format.format, .extent = large, .layers = 2, .usage = 0});
    for (const VkImageAspectFlags aspect : aspects_of(format)) {
      const FormatInfo& stored = *find_format(aspect_format(format.format, aspect));
      const uint32_t plane = plane_of(format, aspect), bytes = stored.texel_bytes;
      const uint32_t shift_x = plane ? format.plane_shift_x : 0, shift_y = plane ? format.plane_shift_y : 0;
      const uint32_t texel_w = bw >> shift_x, texel_h = bh >> shift_y;                               // of one unit of the regions
      const uint32_t unit_w = texel_w / stored.block_width, unit_h = texel_h / stored.block_height;  // blocks
      const auto extent = [&](uint32_t columns, uint32_t rows) { return VkExtent3D{columns * texel_w, rows * texel_h, 1}; };
      const auto offset = [&](uint32_t x, uint32_t y) { return VkOffset3D{int32_t(x * texel_w), int32_t(y * texel_h), 0}; };
      const std::vector<uint8_t> from = random_bytes(size_t{12} * unit_w * unit_h * bytes * 3, random);
      std::vector<uint8_t> want = random_bytes(size_t{20} * unit_w * unit_h * bytes * 2, random);
      client.upload(source, from, {aspect, levels - 1, 0, 3}, extent(4, 3));
      client.upload(destination, want, {aspect, 0, 0, 2}, extent(5, 4));
      client.run([&](VkCommandBuffer cb) {
        const VkImageCopy region{{aspect, levels - 1, 1, 2}, offset(1, 1), {aspect, 0, 0, 2}, offset(2, 2), extent(3, 2)};
        VK(client, CmdCopyImage)(cb, source, VK_IMAGE_LAYOUT_GENERAL, destination, VK_IMAGE_LAYOUT_GENERAL, 1, &region);
      });
      for (uint32_t layer = 0; layer < 2; ++layer) {
        for (uint32_t y = 0; y < 2 * unit_h; ++y) {
          const size_t read = (((layer + 1) * 3 * unit_h + unit_h + y) * 4 * unit_w + unit_w) * size_t{bytes};
          const size_t write = ((layer * 4 * unit_h + 2 * unit_h + y) * 5 * unit_w + 2 * unit_w) * size_t{bytes};
          std::memcpy(&want[write], &from[read], size_t{3} * unit_w * bytes);
        }
      }
      std::vector<uint8_t> got = client.download(destination, want.size(), {aspect, 0, 0, 2}, extent(5, 4));
      if (stored.format == VK_FORMAT_X8_D24_UNORM_PACK32) {  // eight bits of each texel are undefined
        for (size_t i = 3; i < got.size(); i += 4) got[i] = want[i] = 0;
      }
      ASSERT_EQ(got, want) << format.name << " aspect " << aspect;
    }
  }
  EXPECT_GE(formats, 130u);
}

TEST(IcdFormatTransfer, EveryColourFormatIsCleared) {
  ImageClient client;
  std::mt19937 random(kSeed);
  for (const cts::FormatInfo& format : cts::colour_formats()) {
    constexpr VkFormatFeatureFlags kPlain = VK_FORMAT_FEATURE_TRANSFER_DST_BIT;
    if (!(client.format_properties(format.format).optimalTilingFeatures & kPlain)) continue;
    if (format.format == VK_FORMAT_E5B9G9R9_UFLOAT_PACK32) continue;  // has no encoder in the reference: see below
    const VkImage image = client.make({.format = format.format, .extent = {5, 3, 1}});
    for (uint32_t turn = 0; turn < 8; ++turn) {
      cts::Colour colour;
      VkClearColorValue value;
      for (uint32_t c = 0; c < 4; ++c) {
        colour[c] = random_channel(format, "rgba"[c], random);
        value.uint32[c] = shader_word(format, colour[c]);
      }
      client.run([&](VkCommandBuffer cb) {
        const VkImageSubresourceRange all = ImageClient::all();
        VK(client, CmdClearColorImage)(cb, image, VK_IMAGE_LAYOUT_GENERAL, &value, 1, &all);
      });
      const std::vector<uint8_t> got = client.download(image, size_t{15} * format.bytes, color_layers(), {5, 3, 1});
      for (uint32_t i = 0; i < 15; ++i) ASSERT_EQ(differs(format, &got[size_t{i} * format.bytes], colour, 0x1p-23), "");
    }
  }
}

// E5B9G9R9: the largest component decides the exponent, and each is within half a step of what it was.
TEST(IcdFormatTransfer, SharedExponents) {
  ImageClient client;
  std::mt19937 random(kSeed);
  const cts::FormatInfo& format = cts::info_of(VK_FORMAT_E5B9G9R9_UFLOAT_PACK32);
  const VkImage image = client.make({.format = format.format, .extent = {1, 1, 1}});
  for (uint32_t turn = 0; turn < 64; ++turn) {
    VkClearColorValue value;
    float largest = 0;
    for (float& v : value.float32) v = std::ldexp(static_cast<float>(random() / 0x1p32), static_cast<int>(random() % 24) - 8);
    for (uint32_t c = 0; c < 3; ++c) largest = std::max(largest, value.float32[c]);
    client.run([&](VkCommandBuffer cb) {
      const VkImageSubresourceRange all = ImageClient::all();
      VK(client, CmdClearColorImage)(cb, image, VK_IMAGE_LAYOUT_GENERAL, &value, 1, &all);
    });
    const std::vector<uint8_t> got = client.download(image, 4, color_layers(), {1, 1, 1});
    const cts::Colour colour = cts::decode(format, reinterpret_cast<const std::byte*>(got.data()));
    // Nine bits below the exponent of the largest, which rounding may have raised by one.
    const double half_step = std::ldexp(0.5, std::max(std::ilogb(largest) + 1, -15) - 9);
    for (uint32_t c = 0; c < 3; ++c) {
      const double want = std::min<double>(value.float32[c], 65408);
      ASSERT_NEAR(colour[c], want, half_step * (largest > want ? 2 : 1) * 1.001) << "of " << largest;
    }
  }
}

// ---- linear blits ----

constexpr int kFromW = 16, kFromH = 8, kToW = 23, kToH = 13;

// "Image Blits" and "Texel Filtering" in doubles; the destination is mirrored in x.
cts::Colour filtered(const std::vector<cts::Colour>& texels, int x, int y) {
  const double u = (kToW - (x + 0.5)) * kFromW / kToW - 0.5, v = (y + 0.5) * kFromH / kToH - 0.5;
  const double u0 = std::floor(u), v0 = std::floor(v);
  cts::Colour out{};
  for (int tap = 0; tap < 4; ++tap) {
    const int i = std::clamp(static_cast<int>(u0) + (tap & 1), 0, kFromW - 1);
    const int j = std::clamp(static_cast<int>(v0) + (tap >> 1), 0, kFromH - 1);
    const double weight = (tap & 1 ? u - u0 : 1 - (u - u0)) * (tap >> 1 ? v - v0 : 1 - (v - v0));
    for (size_t c = 0; c < 4; ++c) out[c] += weight * texels[static_cast<size_t>(j * kFromW + i)][c];
  }
  return out;
}

TEST(IcdFormatTransfer, EveryLinearFormatIsScaled) {
  ImageClient client;
  std::mt19937 random(kSeed);
  uint32_t formats = 0;
  for (const FormatInfo& format : all_formats()) {
    constexpr VkFormatFeatureFlags kFrom = VK_FORMAT_FEATURE_BLIT_SRC_BIT | VK_FORMAT_FEATURE_SAMPLED_IMAGE_FILTER_LINEAR_BIT;
    const VkFormatFeatureFlags features = client.format_properties(format.format).optimalTilingFeatures;
    if ((features & kFrom) != kFrom || format.is_depth_or_stencil()) continue;
    const bool same = (features & VK_FORMAT_FEATURE_BLIT_DST_BIT) && format.format != VK_FORMAT_E5B9G9R9_UFLOAT_PACK32;
    const cts::FormatInfo& to = cts::info_of(same ? format.format : VK_FORMAT_R32G32B32A32_SFLOAT);
    ++formats;
    std::vector<cts::Colour> texels;
    std::vector<uint8_t> data;
    if (format.is_compressed()) {
      const cts::FormatInfo& decoded = cts::info_of(format.decoded);
      const uint32_t columns = (kFromW + format.block_width - 1u) / format.block_width;
      data = random_bytes(size_t{columns} * ((kFromH + format.block_height - 1u) / format.block_height) * format.texel_bytes,
                          random);
      for (uint32_t i = 0; i < kFromW * kFromH; ++i) {
        const uint32_t x = i % kFromW, y = i / kFromW;
        uint8_t block[kMaxBlockBytes];
        block_decoder(format)(
            format, &data[(y / format.block_height * columns + x / format.block_width) * size_t{format.texel_bytes}], block);
        const size_t texel = size_t{y % format.block_height} * format.block_width + x % format.block_width;
        texels.push_back(cts::decode(decoded, reinterpret_cast<const std::byte*>(block + texel * decoded.bytes)));
      }
    } else {
      const cts::FormatInfo& from = cts::info_of(format.format);
      data = random_texels(from, kFromW * kFromH, random);
      for (uint32_t i = 0; i < kFromW * kFromH; ++i) {
        texels.push_back(cts::decode(from, reinterpret_cast<const std::byte*>(&data[size_t{i} * from.bytes])));
      }
    }
    const VkImage source = client.make({.format = format.format, .extent = {kFromW, kFromH, 1}});
    const VkImage destination = client.make({.format = to.format, .extent = {kToW, kToH, 1}});
    client.upload(source, data, color_layers(), {kFromW, kFromH, 1});
    client.run([&](VkCommandBuffer cb) {
      const VkImageBlit region{color_layers(), {{}, {kFromW, kFromH, 1}}, color_layers(), {{kToW, 0, 0}, {0, kToH, 1}}};
      VK(client, CmdBlitImage)
      (cb, source, VK_IMAGE_LAYOUT_GENERAL, destination, VK_IMAGE_LAYOUT_GENERAL, 1, &region, VK_FILTER_LINEAR);
    });
    const std::vector<uint8_t> got =
        client.download(destination, size_t{kToW} * kToH * to.bytes, color_layers(), {kToW, kToH, 1});
    double largest = 1;
    for (const cts::Colour& texel : texels) {
      for (const double v : texel) largest = std::max(largest, std::abs(v));
    }
    for (int i = 0; i < kToW * kToH; ++i) {
      // Weights and sums in binary32: eight roundings of the largest texel.
      ASSERT_EQ(differs(to, &got[static_cast<size_t>(i) * to.bytes], filtered(texels, i % kToW, i / kToW), 8 * largest * 0x1p-24),
                "")
          << "from " << format.name << " at " << i % kToW << ", " << i / kToW;
    }
  }
  EXPECT_GE(formats, 95u);
}

}  // namespace
}  // namespace pineda::test
