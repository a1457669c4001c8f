// Images that are more than one level of one plane: blocks copied as texels, mip chains of blocks, volumes seen as layers,
// formats reinterpreted, rows written by the host.
#include "format_client.h"

namespace pineda::test {
namespace {

struct ViewOf {
  VkImage image;
  VkFormat format;
  VkImageViewType type = VK_IMAGE_VIEW_TYPE_2D;
  uint32_t level = 0, layer = 0;
};

VkImageView make_view(Client& client, const ViewOf& of) {
  const VkImageViewCreateInfo info{VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
                                   nullptr,
                                   0,
                                   of.image,
                                   of.type,
                                   of.format,
                                   {},
                                   {VK_IMAGE_ASPECT_COLOR_BIT, of.level, 1, of.layer, 1}};
  VkImageView view = VK_NULL_HANDLE;
  EXPECT_EQ(VK(client, CreateImageView)(client.device, &info, nullptr, &view), VK_SUCCESS);
  client.defer([&client, view] { VK(client, DestroyImageView)(client.device, view, nullptr); });
  return view;
}

struct ImageOf {
  VkFormat format;
  VkExtent3D extent;
  VkImageCreateFlags flags = 0;
  VkImageType type = VK_IMAGE_TYPE_2D;
  uint32_t levels = 1;
  VkImageTiling tiling = VK_IMAGE_TILING_OPTIMAL;
  VkImageUsageFlags usage = VK_IMAGE_USAGE_SAMPLED_BIT;
};

VkImage make_image(Client& client, const ImageOf& of, uint8_t** mapped = nullptr) {
  VkImageCreateInfo info{VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO};
  info.flags = of.flags;
  info.imageType = of.type;
  info.format = of.format;
  info.extent = of.extent;
  info.mipLevels = of.levels;
  info.arrayLayers = 1;
  info.samples = VK_SAMPLE_COUNT_1_BIT;
  info.tiling = of.tiling;
  info.usage = of.usage | VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT;
  VkImage image = VK_NULL_HANDLE;
  EXPECT_EQ(VK(client, CreateImage)(client.device, &info, nullptr, &image), VK_SUCCESS);
  VkMemoryRequirements requirements;
  VK(client, GetImageMemoryRequirements)(client.device, image, &requirements);
  void* data = nullptr;
  EXPECT_EQ(VK(client, BindImageMemory)(client.device, image, client.memory(requirements.size, &data), 0), VK_SUCCESS);
  if (mapped) *mapped = static_cast<uint8_t*>(data);
  client.defer([&client, image] { VK(client, DestroyImage)(client.device, image, nullptr); });
  client.to_general(image, of.format);
  return image;
}

// The first width x height texels of what was fetched, against texels in memory without gaps.
void expect_texels(const VkClearColorValue* got, const FormatInfo& shown, const uint8_t* texels, uint32_t texels_pitch,
                   uint32_t width, uint32_t height) {
  for (uint32_t y = 0; y < height; ++y) {
    for (uint32_t x = 0; x < width; ++x) {
      const VkClearColorValue want = unpack_texel(shown, texels + (size_t{y} * texels_pitch + x) * shown.texel_bytes);
      ASSERT_TRUE(equal(shown, got[y * kExtent.width + x], want)) << shown.name << " " << x << ", " << y;
    }
  }
}

// A compressed image filled from an image whose texels are its blocks, and back ("Copying Data Between Images", size-compatible).
// The last column and row of blocks are partly outside, and so is the region of the copy counted in the destination's texels.
TEST(IcdImageKinds, BlocksAreCopiedAsTexels) {
  breaks_on_purpose({"VUID-vkCmdCopyImage-dstOffset-00150", "VUID-vkCmdCopyImage-dstOffset-00151"});
  FormatClient client;
  const FormatInfo& format = *find_format(VK_FORMAT_BC7_UNORM_BLOCK);
  const Aspect blocks_aspect{&format, find_format(format.decoded), VK_IMAGE_ASPECT_COLOR_BIT};
  const std::vector<uint8_t> data = random_data(format);
  const uint32_t columns = blocks(kExtent.width, 4), rows = blocks(kExtent.height, 4);
  const VkImage compressed = make_image(client, {.format = format.format, .extent = kExtent});
  const VkImage texels = make_image(client, {.format = VK_FORMAT_R32G32B32A32_UINT, .extent = {columns, rows, 1}});
  const auto in = client.buffer(data.size()), out = client.buffer(data.size());
  std::memcpy(in.data, data.data(), data.size());
  client.run([&](VkCommandBuffer cb) {
    const VkBufferImageCopy region{0, 0, 0, color_layers(), {}, {columns, rows, 1}};
    VK(client, CmdCopyBufferToImage)(cb, in.handle, texels, VK_IMAGE_LAYOUT_GENERAL, 1, &region);
    client.barrier(cb);
    const VkImageCopy to_blocks{color_layers(), {}, color_layers(), {}, {columns, rows, 1}};
    VK(client, CmdCopyImage)(cb, texels, VK_IMAGE_LAYOUT_GENERAL, compressed, VK_IMAGE_LAYOUT_GENERAL, 1, &to_blocks);
  });
  EXPECT_EQ(client.download(compressed, blocks_aspect), data);
  const std::vector<uint8_t> decoded = decode(blocks_aspect, data);
  expect_texels(client.fetch(client.view(compressed, format.format), *blocks_aspect.shown), *blocks_aspect.shown, decoded.data(),
                kExtent.width, kExtent.width, kExtent.height);
  client.run([&](VkCommandBuffer cb) {
    const VkClearColorValue zero{};
    const VkImageSubresourceRange all{VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
    VK(client, CmdClearColorImage)(cb, texels, VK_IMAGE_LAYOUT_GENERAL, &zero, 1, &all);
    client.barrier(cb);
    const VkImageCopy to_texels{color_layers(), {}, color_layers(), {}, kExtent};
    VK(client, CmdCopyImage)(cb, compressed, VK_IMAGE_LAYOUT_GENERAL, texels, VK_IMAGE_LAYOUT_GENERAL, 1, &to_texels);
    client.barrier(cb);
    const VkBufferImageCopy region{0, 0, 0, color_layers(), {}, {columns, rows, 1}};
    VK(client, CmdCopyImageToBuffer)(cb, texels, VK_IMAGE_LAYOUT_GENERAL, out.handle, 1, &region);
  });
  EXPECT_EQ(std::memcmp(out.data, data.data(), data.size()), 0);
}

// Levels whose sizes are no multiples of a block, each uploaded on its own.
TEST(IcdImageKinds, EveryLevelOfABlockFormat) {
  FormatClient client;
  for (const VkFormat name : {VK_FORMAT_BC1_RGBA_UNORM_BLOCK, VK_FORMAT_ASTC_6x5_UNORM_BLOCK}) {
    const FormatInfo& format = *find_format(name);
    const FormatInfo& shown = *find_format(format.decoded);
    const VkImage image = make_image(client, {.format = name, .extent = {20, 12, 1}, .levels = 5});
    for (uint32_t level = 0; level < 5; ++level) {
      const VkExtent3D extent{std::max(20u >> level, 1u), std::max(12u >> level, 1u), 1};
      const uint32_t columns = blocks(extent.width, format.block_width), rows = blocks(extent.height, format.block_height);
      const auto in = client.buffer(size_t{columns} * rows * format.texel_bytes);
      std::mt19937 random(kFormatSeed + level);
      for (uint32_t i = 0; i < columns * rows * format.texel_bytes; ++i) in.data[i] = static_cast<uint8_t>(random());
      client.run([&](VkCommandBuffer cb) {
        const VkBufferImageCopy region{0, 0, 0, color_layers(level), {}, extent};
        VK(client, CmdCopyBufferToImage)(cb, in.handle, image, VK_IMAGE_LAYOUT_GENERAL, 1, &region);
      });
      const VkClearColorValue* got = client.fetch(make_view(client, {.image = image, .format = name, .level = level}), shown);
      for (uint32_t y = 0; y < extent.height; ++y) {
        for (uint32_t x = 0; x < extent.width; ++x) {
          uint8_t block[kMaxBlockBytes];
          const size_t index = size_t{y / format.block_height} * columns + x / format.block_width;
          block_decoder(format)(format, in.data + index * format.texel_bytes, block);
          const size_t texel = size_t{y % format.block_height} * format.block_width + x % format.block_width;
          ASSERT_TRUE(equal(shown, got[y * kExtent.width + x], unpack_texel(shown, block + texel * shown.texel_bytes)))
              << format.name << " level " << level;
        }
      }
    }
  }
}

TEST(IcdImageKinds, SlicesOfAVolumeAreLayers) {
  FormatClient client;
  const FormatInfo& format = *find_format(VK_FORMAT_R8G8B8A8_UNORM);
  const VkExtent3D extent{9, 7, 5};
  const VkImage image =
      make_image(client, {.format = format.format,
                          .extent = extent,
                          .flags = VK_IMAGE_CREATE_2D_ARRAY_COMPATIBLE_BIT | VK_IMAGE_CREATE_2D_VIEW_COMPATIBLE_BIT_EXT,
                          .type = VK_IMAGE_TYPE_3D});
  const uint32_t slice_bytes = extent.width * extent.height * 4;
  const auto in = client.buffer(slice_bytes * extent.depth);
  std::mt19937 random(kFormatSeed);
  for (uint32_t i = 0; i < slice_bytes * extent.depth; ++i) in.data[i] = static_cast<uint8_t>(random());
  client.run([&](VkCommandBuffer cb) {
    const VkBufferImageCopy region{0, 0, 0, color_layers(), {}, extent};
    VK(client, CmdCopyBufferToImage)(cb, in.handle, image, VK_IMAGE_LAYOUT_GENERAL, 1, &region);
  });
  for (uint32_t z = 0; z < extent.depth; ++z) {
    const VkImageView view = make_view(client, {.image = image, .format = format.format, .layer = z});
    expect_texels(client.fetch(view, format), format, in.data + z * slice_bytes, extent.width, extent.width, extent.height);
  }
}

TEST(IcdImageKinds, FormatsAreReinterpreted) {
  FormatClient client;
  struct Pair {
    VkFormat image, view;
  };
  for (const Pair pair : {Pair{VK_FORMAT_R8G8B8A8_UNORM, VK_FORMAT_R8G8B8A8_SRGB},
                          {VK_FORMAT_R32_SFLOAT, VK_FORMAT_R8G8B8A8_UINT},
                          {VK_FORMAT_R16G16_UNORM, VK_FORMAT_A2B10G10R10_UNORM_PACK32},
                          {VK_FORMAT_BC7_UNORM_BLOCK, VK_FORMAT_BC7_SRGB_BLOCK},
                          {VK_FORMAT_BC4_UNORM_BLOCK, VK_FORMAT_BC4_SNORM_BLOCK},
                          {VK_FORMAT_ASTC_5x5_UNORM_BLOCK, VK_FORMAT_ASTC_5x5_SRGB_BLOCK}}) {
    const FormatInfo& stored = *find_format(pair.image);
    const Aspect as_image = aspects_of(stored)[0], as_view = aspects_of(*find_format(pair.view))[0];
    const VkImage image =
        make_image(client, {.format = pair.image, .extent = kExtent, .flags = VK_IMAGE_CREATE_MUTABLE_FORMAT_BIT});
    const std::vector<uint8_t> data = random_data(stored), texels = decode(as_view, data);
    client.upload(image, as_image, data);
    const VkImageView view = make_view(client, {.image = image, .format = pair.view});
    expect_texels(client.fetch(view, *as_view.shown), *as_view.shown, texels.data(), kExtent.width, kExtent.width,
                  kExtent.height);
  }
}

// A view of another class would read the decoded copy as what it is not.
TEST(IcdImageKinds, OtherClassesAreRefused) {
  breaks_on_purpose({"VUID-VkImageViewCreateInfo-image-01761"});
  FormatClient client;
  const VkImage image =
      make_image(client, {.format = VK_FORMAT_BC7_UNORM_BLOCK, .extent = kExtent, .flags = VK_IMAGE_CREATE_MUTABLE_FORMAT_BIT});
  for (const VkFormat format : {VK_FORMAT_ASTC_4x4_UNORM_BLOCK, VK_FORMAT_BC6H_UFLOAT_BLOCK, VK_FORMAT_R8G8B8A8_UNORM}) {
    const VkImageViewCreateInfo info{
        VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO, nullptr, 0, image, VK_IMAGE_VIEW_TYPE_2D, format, {},
        {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1}};
    VkImageView view = VK_NULL_HANDLE;
    EXPECT_NE(VK(client, CreateImageView)(client.device, &info, nullptr, &view), VK_SUCCESS) << format;
  }
}

// vkGetImageSubresourceLayout tells where the host finds the texels of an image of linear tiling.
TEST(IcdImageKinds, TheHostWritesRows) {
  FormatClient client;
  const FormatInfo& format = *find_format(VK_FORMAT_R16G16_SINT);
  uint8_t* mapped = nullptr;
  const VkImage image =
      make_image(client, {.format = format.format, .extent = kExtent, .tiling = VK_IMAGE_TILING_LINEAR}, &mapped);
  const VkImageSubresource subresource{VK_IMAGE_ASPECT_COLOR_BIT, 0, 0};
  VkSubresourceLayout layout;
  VK(client, GetImageSubresourceLayout)(client.device, image, &subresource, &layout);
  const std::vector<uint8_t> data = random_data(format);
  const uint32_t row_bytes = kExtent.width * format.texel_bytes;
  for (uint32_t y = 0; y < kExtent.height; ++y) {
    std::memcpy(mapped + layout.offset + y * layout.rowPitch, &data[size_t{y} * row_bytes], row_bytes);
  }
  expect_texels(client.fetch(client.view(image, format.format), format), format, data.data(), kExtent.width, kExtent.width,
                kExtent.height);
}

}  // namespace
}  // namespace pineda::test
