// Every format that the driver advertises, for every use of it that goes through memory: upload and fetch, clear, blit from and
// to it. The oracle is the host's side of the table (base/format.h), which base and kernels tests hold against the
// specification's formulas, and base/block_codec.h, which its test holds against other decoders.
#include "format_client.h"

namespace pineda::test {
namespace {

TEST(IcdFormat, EverySampledFormatIsFetched) {
  uint32_t formats = 0;
  for (const FormatInfo& format : all_formats()) {
    FormatClient client;
    if (!(client.features(format) & VK_FORMAT_FEATURE_SAMPLED_IMAGE_BIT) || is_ycbcr(format)) continue;
    ++formats;
    for (const Aspect& aspect : aspects_of(format)) {
      const VkImage image = client.image(format.format, kExtent, 1, 1, VK_IMAGE_USAGE_SAMPLED_BIT);
      const std::vector<uint8_t> data = random_data(*aspect.stored), texels = decode(aspect, data);
      client.upload(image, aspect, data);
      const VkClearColorValue* got = client.fetch(client.view(image, format.format, {}, aspect.aspect), *aspect.shown);
      for (uint32_t i = 0; i < kTexels; ++i) {
        VkClearColorValue want = unpack_texel(*aspect.shown, &texels[size_t{i} * aspect.shown->texel_bytes]);
        const uint32_t components = aspect.aspect == VK_IMAGE_ASPECT_COLOR_BIT ? 4 : 1;  // depth: the others are undefined
        ASSERT_TRUE(equal(*aspect.shown, got[i], want, components)) << format.name << " texel " << i;
      }
      // X8_D24 has 8 undefined bits.
      if (aspect.stored->format == VK_FORMAT_X8_D24_UNORM_PACK32) continue;
      EXPECT_EQ(client.download(image, aspect), data) << format.name;
    }
  }
  EXPECT_GE(formats, 130u);
}

TEST(IcdFormat, EveryFormatIsCleared) {
  FormatClient client;
  for (const FormatInfo& format : all_formats()) {
    if (!(client.features(format) & VK_FORMAT_FEATURE_TRANSFER_DST_BIT) || format.is_compressed() || is_ycbcr(format)) continue;
    const VkImage image = client.image(format.format, kExtent);
    VkClearColorValue color{};
    for (uint32_t c = 0; c < 4; ++c) {
      if (format.is_integer()) {
        color.uint32[c] = 0x01020304u * (c + 1);
      } else {
        color.float32[c] = 0.3f + 0.17f * static_cast<float>(c);
      }
    }
    const VkClearDepthStencilValue depth_stencil{0.3f, 0xA7};
    client.run([&](VkCommandBuffer cb) {
      const VkImageSubresourceRange range{format.aspects, 0, 1, 0, 1};
      if (format.is_depth_or_stencil()) {
        VK(client, CmdClearDepthStencilImage)(cb, image, VK_IMAGE_LAYOUT_GENERAL, &depth_stencil, 1, &range);
      } else {
        VK(client, CmdClearColorImage)(cb, image, VK_IMAGE_LAYOUT_GENERAL, &color, 1, &range);
      }
    });
    for (const Aspect& aspect : aspects_of(format)) {
      uint8_t want[16] = {0xA7};
      if (aspect.aspect == VK_IMAGE_ASPECT_COLOR_BIT) pack_clear_color(*aspect.stored, color, want);
      if (aspect.aspect == VK_IMAGE_ASPECT_DEPTH_BIT) pack_depth(*aspect.stored, depth_stencil.depth, want);
      const std::vector<uint8_t> got = client.download(image, aspect);
      for (uint32_t i = 0; i < kTexels; ++i) {
        ASSERT_EQ(std::memcmp(&got[size_t{i} * aspect.stored->texel_bytes], want, aspect.stored->texel_bytes), 0) << format.name;
      }
    }
  }
}

// The widest format of the same kind.
VkFormat wide_format(const FormatInfo& shown) {
  return shown.numeric == Numeric::kUint   ? VK_FORMAT_R32G32B32A32_UINT
         : shown.numeric == Numeric::kSint ? VK_FORMAT_R32G32B32A32_SINT
                                           : VK_FORMAT_R32G32B32A32_SFLOAT;
}

TEST(IcdFormat, EveryFormatIsBlittedFrom) {
  FormatClient client;
  for (const FormatInfo& format : all_formats()) {
    if (!(client.features(format) & VK_FORMAT_FEATURE_BLIT_SRC_BIT) || format.is_depth_or_stencil() || is_ycbcr(format)) continue;
    const Aspect aspect = aspects_of(format)[0];
    const FormatInfo& wide = *find_format(wide_format(*aspect.shown));
    const VkImage source = client.image(format.format, kExtent), destination = client.image(wide.format, kExtent);
    const std::vector<uint8_t> data = random_data(*aspect.stored), texels = decode(aspect, data);
    client.upload(source, aspect, data);
    client.blit(source, destination);
    const std::vector<uint8_t> got = client.download(destination, {&wide, &wide, VK_IMAGE_ASPECT_COLOR_BIT});
    for (uint32_t i = 0; i < kTexels; ++i) {
      VkClearColorValue texel;
      std::memcpy(&texel, &got[16 * size_t{i}], 16);
      const VkClearColorValue want = unpack_texel(*aspect.shown, &texels[size_t{i} * aspect.shown->texel_bytes]);
      ASSERT_TRUE(equal(*aspect.shown, texel, want)) << format.name << " texel " << i;
    }
  }
}

TEST(IcdFormat, EveryFormatIsBlittedTo) {
  FormatClient client;
  std::mt19937 random(kFormatSeed);
  for (const FormatInfo& format : all_formats()) {
    if (!(client.features(format) & VK_FORMAT_FEATURE_BLIT_DST_BIT) || format.is_depth_or_stencil()) continue;
    const FormatInfo& wide = *find_format(wide_format(format));
    std::vector<VkClearColorValue> texels(kTexels);
    for (VkClearColorValue& texel : texels) {
      for (uint32_t c = 0; c < 4; ++c) {
        if (format.is_integer()) {  // what fits: other values are undefined
          const uint32_t bits = format.component[c].bits ? format.component[c].bits : 8;
          texel.uint32[c] = static_cast<uint32_t>(random()) >> (33 - bits);
        } else {
          texel.float32[c] = static_cast<float>(random() / 0x1p32 * 2.5 - 1.25);
        }
      }
    }
    std::vector<uint8_t> data(size_t{kTexels} * 16);
    std::memcpy(data.data(), texels.data(), data.size());
    const VkImage source = client.image(wide.format, kExtent), destination = client.image(format.format, kExtent);
    client.upload(source, {&wide, &wide, VK_IMAGE_ASPECT_COLOR_BIT}, data);
    client.blit(source, destination);
    const std::vector<uint8_t> got = client.download(destination, {&format, &format, VK_IMAGE_ASPECT_COLOR_BIT});
    for (uint32_t i = 0; i < kTexels; ++i) {
      uint8_t want[16] = {};
      pack_clear_color(format, texels[i], want);
      ASSERT_EQ(std::memcmp(&got[size_t{i} * format.texel_bytes], want, format.texel_bytes), 0) << format.name << " texel " << i;
    }
  }
}

// Stores and loads of images that the shader declares without a format.
TEST(IcdFormat, EveryStorageFormatIsWrittenAndRead) {
  FormatClient client;
  std::mt19937 random(kFormatSeed);
  const auto texels = client.buffer(size_t{kTexels} * 16);
  uint32_t formats = 0;
  for (const FormatInfo& format : all_formats()) {
    if (!(client.features(format) & VK_FORMAT_FEATURE_STORAGE_IMAGE_BIT)) continue;
    ++formats;
    const VkImage image = client.image(format.format, kExtent, 1, 1, VK_IMAGE_USAGE_STORAGE_BIT);
    const VkImageView view = client.view(image, format.format);
    auto* values = texels.as<VkClearColorValue>();
    for (uint32_t i = 0; i < kTexels; ++i) {
      for (uint32_t c = 0; c < 4; ++c) {
        if (format.is_integer()) {
          const uint32_t bits = format.component[c].bits ? format.component[c].bits : 8;
          values[i].uint32[c] = static_cast<uint32_t>(random()) >> (33 - bits);
        } else {
          values[i].float32[c] = static_cast<float>(random() / 0x1p32 * 2.5 - 1.25);
        }
      }
    }
    const Aspect aspect{&format, &format, VK_IMAGE_ASPECT_COLOR_BIT};
    std::vector<uint8_t> want(size_t{kTexels} * format.texel_bytes);
    for (uint32_t i = 0; i < kTexels; ++i) pack_clear_color(format, values[i], &want[size_t{i} * format.texel_bytes]);
    client.storage(view, format, texels, true);
    ASSERT_EQ(client.download(image, aspect), want) << format.name;
    client.storage(view, format, texels, false);
    for (uint32_t i = 0; i < kTexels; ++i) {
      ASSERT_TRUE(equal(format, values[i], unpack_texel(format, &want[size_t{i} * format.texel_bytes]))) << format.name;
    }
  }
  EXPECT_GE(formats, 40u);
}

TEST(IcdFormat, DepthAndStencilAreBlittedTogether) {
  FormatClient client;
  for (const FormatInfo& format : all_formats()) {
    if (!format.is_depth_or_stencil() || !(client.features(format) & VK_FORMAT_FEATURE_BLIT_SRC_BIT)) continue;
    const VkImage source = client.image(format.format, kExtent), destination = client.image(format.format, kExtent);
    for (const Aspect& aspect : aspects_of(format)) client.upload(source, aspect, random_data(*aspect.stored));
    client.blit(source, destination, VK_FILTER_NEAREST, format.aspects);
    for (const Aspect& aspect : aspects_of(format)) EXPECT_EQ(client.download(destination, aspect), random_data(*aspect.stored));
  }
}

}  // namespace
}  // namespace pineda::test
