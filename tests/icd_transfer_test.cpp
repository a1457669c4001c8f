// Copies, fills, clears and blits against plain loops.
#include <cmath>
#include <random>

#include "icd_client.h"

namespace pineda::test {
namespace {

constexpr uint32_t kSeed = 20240611;

void fill_random(uint8_t* data, size_t size_bytes, uint32_t seed = kSeed) {
  std::mt19937 random(seed);
  for (size_t i = 0; i < size_bytes; ++i) data[i] = static_cast<uint8_t>(random());
}

TEST(IcdMemory, NewMemoryReadsAsZeroAndStaysMapped) {
  breaks_on_purpose({"VUID-vkGetDeviceMemoryCommitment-memory-00690"});
  Client client;
  constexpr VkDeviceSize kBytes = 5u << 20;  // above the huge-page threshold
  void* data = nullptr;
  const VkDeviceMemory memory = client.memory(kBytes, &data);
  auto* bytes = static_cast<uint8_t*>(data);
  for (VkDeviceSize i = 0; i < kBytes; i += 4093) ASSERT_EQ(bytes[i], 0);
  std::memset(bytes, 0xA5, kBytes);
  VK(client, UnmapMemory)(client.device, memory);
  void* again = nullptr;
  EXPECT_EQ(VK(client, MapMemory)(client.device, memory, 4096, 16, 0, &again), VK_SUCCESS);
  EXPECT_EQ(static_cast<uint8_t*>(again)[15], 0xA5);
  VkDeviceSize committed = 0;
  VK(client, GetDeviceMemoryCommitment)(client.device, memory, &committed);
  EXPECT_EQ(committed, kBytes);
}

TEST(IcdMemory, MoreThanTheHeapIsRefused) {
  breaks_on_purpose({"VUID-vkAllocateMemory-pAllocateInfo-01713"});
  Client client;
  VkPhysicalDeviceMemoryProperties properties;
  VK(client, GetPhysicalDeviceMemoryProperties)(client.physical, &properties);
  VkMemoryAllocateInfo info{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, nullptr, properties.memoryHeaps[0].size + 1, 0};
  VkDeviceMemory memory;
  EXPECT_EQ(VK(client, AllocateMemory)(client.device, &info, nullptr, &memory), VK_ERROR_OUT_OF_DEVICE_MEMORY);
  info.allocationSize = ~VkDeviceSize{0};
  EXPECT_EQ(VK(client, AllocateMemory)(client.device, &info, nullptr, &memory), VK_ERROR_OUT_OF_DEVICE_MEMORY);
  EXPECT_EQ(memory, VkDeviceMemory(VK_NULL_HANDLE));
}

TEST(IcdTransfer, BufferCopyFillAndUpdate) {
  Client client;
  const auto source = client.buffer(1024), destination = client.buffer(1024);
  fill_random(source.data, 1024);
  const uint32_t update[3] = {1, 2, 3};
  client.run([&](VkCommandBuffer cb) {
    const VkBufferCopy regions[] = {{0, 512, 100}, {700, 0, 17}};
    VK(client, CmdCopyBuffer)(cb, source.handle, destination.handle, 2, regions);
    client.barrier(cb);
    VK(client, CmdFillBuffer)(cb, destination.handle, 800, VK_WHOLE_SIZE, 0xDEADBEEF);
    VK(client, CmdUpdateBuffer)(cb, destination.handle, 200, sizeof(update), update);
  });
  EXPECT_EQ(std::memcmp(destination.data + 512, source.data, 100), 0);
  EXPECT_EQ(std::memcmp(destination.data, source.data + 700, 17), 0);
  EXPECT_EQ(destination.data[17], 0);
  for (int i = 200; i < 256; ++i) EXPECT_EQ(destination.as<uint32_t>()[i], 0xDEADBEEFu);
  EXPECT_EQ(std::memcmp(destination.data + 200, update, sizeof(update)), 0);
}

// Buffer -> image -> image -> buffer, with row lengths, offsets, levels and layers.
TEST(IcdTransfer, ImagesKeepTheirTexels) {
  Client client;
  constexpr VkFormat kFormats[] = {VK_FORMAT_R8_UNORM, VK_FORMAT_R5G6B5_UNORM_PACK16, VK_FORMAT_R8G8B8A8_UNORM,
                                   VK_FORMAT_R16G16B16A16_SFLOAT, VK_FORMAT_R32G32B32A32_SFLOAT};
  constexpr uint32_t kTexelBytes[] = {1, 2, 4, 8, 16};
  for (size_t f = 0; f < std::size(kFormats); ++f) {
    const VkImage first = client.image(kFormats[f], {64, 32, 1}, 3, 2), second = client.image(kFormats[f], {40, 40, 1}, 1, 4);
    constexpr uint32_t kRowLength = 24, kImageHeight = 12, kWidth = 13, kHeight = 7, kLayers = 2;
    const uint32_t texel = kTexelBytes[f];
    const size_t bytes = size_t(kRowLength) * kImageHeight * kLayers * texel;
    const auto in = client.buffer(bytes), out = client.buffer(bytes);
    fill_random(in.data, bytes);
    client.run([&](VkCommandBuffer cb) {
      VkBufferImageCopy upload{0, kRowLength, kImageHeight, color_layers(1, 0, kLayers), {5, 3, 0}, {kWidth, kHeight, 1}};
      VK(client, CmdCopyBufferToImage)(cb, in.handle, first, VK_IMAGE_LAYOUT_GENERAL, 1, &upload);
      client.barrier(cb);
      const VkImageCopy copy{
          color_layers(1, 0, kLayers), {5, 3, 0}, color_layers(0, 1, kLayers), {20, 30, 0}, {kWidth, kHeight, 1}};
      VK(client, CmdCopyImage)(cb, first, VK_IMAGE_LAYOUT_GENERAL, second, VK_IMAGE_LAYOUT_GENERAL, 1, &copy);
      client.barrier(cb);
      VkBufferImageCopy download{0, kRowLength, kImageHeight, color_layers(0, 1, kLayers), {20, 30, 0}, {kWidth, kHeight, 1}};
      VK(client, CmdCopyImageToBuffer)(cb, second, VK_IMAGE_LAYOUT_GENERAL, out.handle, 1, &download);
    });
    for (uint32_t layer = 0; layer < kLayers; ++layer) {
      for (uint32_t y = 0; y < kHeight; ++y) {
        const size_t row = (size_t(layer) * kImageHeight + y) * kRowLength * texel;
        ASSERT_EQ(std::memcmp(in.data + row, out.data + row, size_t(kWidth) * texel), 0) << "format " << f << " row " << y;
        EXPECT_EQ(out.data[row + size_t(kWidth) * texel], 0) << "bytes between rows stay";
      }
    }
  }
}

TEST(IcdTransfer, VolumesCopySliceBySlice) {
  Client client;
  const VkImage volume = client.image(VK_FORMAT_R8_UNORM, {8, 4, 6}, 1, 1, 0, VK_IMAGE_TYPE_3D);
  const auto in = client.buffer(8 * 4 * 6), out = client.buffer(8 * 4 * 2);
  fill_random(in.data, 8 * 4 * 6);
  client.run([&](VkCommandBuffer cb) {
    const VkBufferImageCopy upload{0, 0, 0, color_layers(), {}, {8, 4, 6}};
    VK(client, CmdCopyBufferToImage)(cb, in.handle, volume, VK_IMAGE_LAYOUT_GENERAL, 1, &upload);
    client.barrier(cb);
    const VkBufferImageCopy download{0, 0, 0, color_layers(), {0, 0, 3}, {8, 4, 2}};
    VK(client, CmdCopyImageToBuffer)(cb, volume, VK_IMAGE_LAYOUT_GENERAL, out.handle, 1, &download);
  });
  EXPECT_EQ(std::memcmp(out.data, in.data + 3 * 32, 64), 0);
}

TEST(IcdTransfer, ClearsLevelsAndLayers) {
  Client client;
  const VkImage image = client.image(VK_FORMAT_R8G8B8A8_UNORM, {16, 16, 1}, 3, 3);
  const auto out = client.buffer(16 * 16 * 4);
  const auto texel_of = [&](uint32_t level, uint32_t layer) {
    client.run([&](VkCommandBuffer cb) {
      const VkBufferImageCopy region{0, 0, 0, color_layers(level, layer), {}, {16u >> level, 16u >> level, 1}};
      VK(client, CmdCopyImageToBuffer)(cb, image, VK_IMAGE_LAYOUT_GENERAL, out.handle, 1, &region);
    });
    const uint32_t last = (16u >> level) * (16u >> level) - 1;
    EXPECT_EQ(out.as<uint32_t>()[0], out.as<uint32_t>()[last]);
    return out.as<uint32_t>()[0];
  };
  client.run([&](VkCommandBuffer cb) {
    const VkClearColorValue color{{1.0f, 0.5f, 0.0f, 2.0f}};  // 0.5 * 255 = 127.5 rounds to the even 128; 2 clamps
    const VkImageSubresourceRange range{VK_IMAGE_ASPECT_COLOR_BIT, 1, VK_REMAINING_MIP_LEVELS, 2, VK_REMAINING_ARRAY_LAYERS};
    VK(client, CmdClearColorImage)(cb, image, VK_IMAGE_LAYOUT_GENERAL, &color, 1, &range);
  });
  EXPECT_EQ(texel_of(1, 2), 0xFF0080FFu);
  EXPECT_EQ(texel_of(2, 2), 0xFF0080FFu);
  EXPECT_EQ(texel_of(0, 2), 0u);
  EXPECT_EQ(texel_of(1, 1), 0u);
}

TEST(IcdTransfer, DepthClear) {
  Client client;
  const VkImage image = client.image(VK_FORMAT_D16_UNORM, {4, 4, 1}, 1, 1, VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT);
  const auto out = client.buffer(32);
  client.run([&](VkCommandBuffer cb) {
    const VkClearDepthStencilValue value{0.25f, 0};
    const VkImageSubresourceRange range{VK_IMAGE_ASPECT_DEPTH_BIT, 0, 1, 0, 1};
    VK(client, CmdClearDepthStencilImage)(cb, image, VK_IMAGE_LAYOUT_GENERAL, &value, 1, &range);
    client.barrier(cb);
    const VkBufferImageCopy region{0, 0, 0, {VK_IMAGE_ASPECT_DEPTH_BIT, 0, 0, 1}, {}, {4, 4, 1}};
    VK(client, CmdCopyImageToBuffer)(cb, image, VK_IMAGE_LAYOUT_GENERAL, out.handle, 1, &region);
  });
  for (int i = 0; i < 16; ++i) EXPECT_EQ(out.as<uint16_t>()[i], 16384);  // 0.25 * 65535 = 16383.75
}

// Regions outside the resources are invalid usage; they must not touch memory.
TEST(IcdTransfer, RegionsOutsideAreDropped) {
  breaks_on_purpose({"VUID-vkCmdCopyBuffer-size-00116", "VUID-vkCmdCopyBufferToImage-imageOffset-00200",
                     "VUID-vkCmdCopyBufferToImage-imageSubresource-01701", "VUID-vkCmdCopyBufferToImage-pRegions-00171",
                     "VUID-vkCmdCopyBufferToImage-pRegions-06217", "VUID-vkCmdCopyBufferToImage-pRegions-06218",
                     "VUID-vkCmdCopyBufferToImage-pRegions-06219", "VUID-vkCmdCopyImageToBuffer-imageOffset-00200",
                     "VUID-vkCmdCopyImageToBuffer-imageSubresource-01703", "VUID-vkCmdCopyImageToBuffer-pRegions-00183",
                     "VUID-vkCmdCopyImageToBuffer-pRegions-06220", "VUID-vkCmdCopyImageToBuffer-pRegions-06221",
                     "VUID-vkCmdCopyImageToBuffer-pRegions-06222"});
  Client client;
  const VkImage image = client.image(VK_FORMAT_R8G8B8A8_UNORM, {8, 8, 1});
  const auto buffer = client.buffer(256);
  client.run([&](VkCommandBuffer cb) {
    const VkBufferImageCopy wide{0, 0, 0, color_layers(), {4, 0, 0}, {8, 8, 1}}, deep{0, 0, 0, color_layers(3), {}, {8, 8, 1}},
        late{128, 0, 0, color_layers(), {}, {8, 8, 1}}, negative{0, 0, 0, color_layers(), {-1, 0, 0}, {8, 8, 1}};
    for (const auto& region : {wide, deep, late, negative}) {
      VK(client, CmdCopyImageToBuffer)(cb, image, VK_IMAGE_LAYOUT_GENERAL, buffer.handle, 1, &region);
      client.barrier(cb);
      VK(client, CmdCopyBufferToImage)(cb, buffer.handle, image, VK_IMAGE_LAYOUT_GENERAL, 1, &region);
      client.barrier(cb);
    }
    const VkBufferCopy beyond{0, 250, 100};
    VK(client, CmdCopyBuffer)(cb, client.buffer(256).handle, buffer.handle, 1, &beyond);
  });
}

struct BlitFixture {
  Client client;
  Client::Buffer in = client.buffer(64 * 64 * 4), out = client.buffer(64 * 64 * 4);

  // Blits a whole w0 x h0 image to a whole w1 x h1 one; `mirror` swaps the destination's x corners.
  void blit(VkFormat from_format, VkExtent3D from, VkFormat to_format, VkExtent3D to, VkFilter filter, bool mirror) {
    const VkImage source = client.image(from_format, from), destination = client.image(to_format, to);
    client.run([&](VkCommandBuffer cb) {
      const VkBufferImageCopy upload{0, 0, 0, color_layers(), {}, from}, download{0, 0, 0, color_layers(), {}, to};
      VK(client, CmdCopyBufferToImage)(cb, in.handle, source, VK_IMAGE_LAYOUT_GENERAL, 1, &upload);
      client.barrier(cb);
      VkImageBlit region{color_layers(),
                         {{}, {int32_t(from.width), int32_t(from.height), 1}},
                         color_layers(),
                         {{}, {int32_t(to.width), int32_t(to.height), 1}}};
      if (mirror) std::swap(region.dstOffsets[0].x, region.dstOffsets[1].x);
      VK(client, CmdBlitImage)(cb, source, VK_IMAGE_LAYOUT_GENERAL, destination, VK_IMAGE_LAYOUT_GENERAL, 1, &region, filter);
      client.barrier(cb);
      VK(client, CmdCopyImageToBuffer)(cb, destination, VK_IMAGE_LAYOUT_GENERAL, out.handle, 1, &download);
    });
  }
};

TEST(IcdBlit, NearestScalesAndMirrors) {
  BlitFixture fixture;
  fill_random(fixture.in.data, 16 * 8 * 4);
  for (const bool mirror : {false, true}) {
    fixture.blit(VK_FORMAT_R8G8B8A8_UNORM, {16, 8, 1}, VK_FORMAT_R8G8B8A8_UNORM, {24, 4, 1}, VK_FILTER_NEAREST, mirror);
    for (int y = 0; y < 4; ++y) {
      for (int x = 0; x < 24; ++x) {
        const int position = mirror ? 23 - x : x;
        const int sx = static_cast<int>(std::floor((position + 0.5) * 16 / 24)),
                  sy = static_cast<int>(std::floor((y + 0.5) * 8 / 4));
        EXPECT_EQ(fixture.out.as<uint32_t>()[y * 24 + x], fixture.in.as<uint32_t>()[sy * 16 + sx]) << x << ' ' << y;
      }
    }
  }
}

// Halving each side averages four texels: how applications make mip levels. Tolerance: one code, for the rounding of the mean.
TEST(IcdBlit, LinearHalvingIsTheMeanOfFour) {
  BlitFixture fixture;
  fill_random(fixture.in.data, 32 * 32 * 4);
  fixture.blit(VK_FORMAT_R8G8B8A8_UNORM, {32, 32, 1}, VK_FORMAT_R8G8B8A8_UNORM, {16, 16, 1}, VK_FILTER_LINEAR, false);
  for (int y = 0; y < 16; ++y) {
    for (int x = 0; x < 16; ++x) {
      for (int c = 0; c < 4; ++c) {
        const auto texel = [&](int dx, int dy) { return double(fixture.in.data[((2 * y + dy) * 32 + 2 * x + dx) * 4 + c]); };
        const double mean = (texel(0, 0) + texel(1, 0) + texel(0, 1) + texel(1, 1)) / 4;
        EXPECT_NEAR(fixture.out.data[(y * 16 + x) * 4 + c], mean, 1.0);
      }
    }
  }
}

TEST(IcdBlit, ConvertsBetweenFormats) {
  BlitFixture fixture;
  fill_random(fixture.in.data, 8 * 8 * 4);
  fixture.blit(VK_FORMAT_R8G8B8A8_UNORM, {8, 8, 1}, VK_FORMAT_B8G8R8A8_UNORM, {8, 8, 1}, VK_FILTER_NEAREST, false);
  for (int i = 0; i < 64; ++i) {
    const uint8_t* in = fixture.in.data + 4 * i;
    const uint8_t expected[4] = {in[2], in[1], in[0], in[3]};
    EXPECT_EQ(std::memcmp(fixture.out.data + 4 * i, expected, 4), 0);
  }
}

// Every format that says it can be blitted goes through float or integer and comes back as it was. Floats: only patterns that are
// numbers.
TEST(IcdBlit, EveryFormatSurvivesTheRoundTrip) {
  BlitFixture fixture;
  struct Pair {
    VkFormat format, through;
  };
  constexpr Pair kPairs[] = {{VK_FORMAT_R8_UNORM, VK_FORMAT_R32_SFLOAT},
                             {VK_FORMAT_R5G6B5_UNORM_PACK16, VK_FORMAT_R16G16B16A16_SFLOAT},
                             {VK_FORMAT_R8G8B8A8_SRGB, VK_FORMAT_R32G32B32A32_SFLOAT},
                             {VK_FORMAT_R8G8B8A8_UINT, VK_FORMAT_R16G16B16A16_UINT},
                             {VK_FORMAT_R8G8_SINT, VK_FORMAT_R32G32_SINT},
                             {VK_FORMAT_A2B10G10R10_UNORM_PACK32, VK_FORMAT_R32G32B32A32_SFLOAT}};
  for (const Pair& pair : kPairs) {
    fill_random(fixture.in.data, 16 * 16 * 4, kSeed + pair.format);
    VkFormatProperties properties;
    VK(fixture.client, GetPhysicalDeviceFormatProperties)(fixture.client.physical, pair.format, &properties);
    EXPECT_TRUE(properties.optimalTilingFeatures & VK_FORMAT_FEATURE_BLIT_SRC_BIT);
    Client& client = fixture.client;
    const VkImage a = client.image(pair.format, {16, 8, 1}), b = client.image(pair.through, {16, 8, 1}),
                  c = client.image(pair.format, {16, 8, 1});
    std::memset(fixture.out.data, 0, 16 * 8 * 4);
    client.run([&](VkCommandBuffer cb) {
      const VkBufferImageCopy whole{0, 0, 0, color_layers(), {}, {16, 8, 1}};
      VK(client, CmdCopyBufferToImage)(cb, fixture.in.handle, a, VK_IMAGE_LAYOUT_GENERAL, 1, &whole);
      client.barrier(cb);
      const VkImageBlit region{color_layers(), {{}, {16, 8, 1}}, color_layers(), {{}, {16, 8, 1}}};
      VK(client, CmdBlitImage)(cb, a, VK_IMAGE_LAYOUT_GENERAL, b, VK_IMAGE_LAYOUT_GENERAL, 1, &region, VK_FILTER_NEAREST);
      client.barrier(cb);
      VK(client, CmdBlitImage)(cb, b, VK_IMAGE_LAYOUT_GENERAL, c, VK_IMAGE_LAYOUT_GENERAL, 1, &region, VK_FILTER_NEAREST);
      client.barrier(cb);
      VK(client, CmdCopyImageToBuffer)(cb, c, VK_IMAGE_LAYOUT_GENERAL, fixture.out.handle, 1, &whole);
    });
    VkMemoryRequirements requirements;
    VK(client, GetImageMemoryRequirements)(client.device, a, &requirements);
    const size_t texel_bytes = pair.format == VK_FORMAT_R8_UNORM                                                    ? 1
                               : pair.format == VK_FORMAT_R5G6B5_UNORM_PACK16 || pair.format == VK_FORMAT_R8G8_SINT ? 2
                                                                                                                    : 4;
    EXPECT_EQ(std::memcmp(fixture.in.data, fixture.out.data, 16 * 8 * texel_bytes), 0) << "format " << pair.format;
  }
}

TEST(IcdImage, SubresourceLayoutDoesNotOverlap) {
  Client client;
  VkImageCreateInfo info{VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO};
  info.imageType = VK_IMAGE_TYPE_2D;
  info.format = VK_FORMAT_R8G8B8A8_UNORM;
  info.extent = {100, 30, 1};
  info.mipLevels = 7;
  info.arrayLayers = 3;
  info.samples = VK_SAMPLE_COUNT_1_BIT;
  info.tiling = VK_IMAGE_TILING_LINEAR;
  info.usage = VK_IMAGE_USAGE_SAMPLED_BIT;
  VkImage image;
  ASSERT_EQ(VK(client, CreateImage)(client.device, &info, nullptr, &image), VK_SUCCESS);
  client.defer([&client, image] { VK(client, DestroyImage)(client.device, image, nullptr); });
  VkMemoryRequirements requirements;
  VK(client, GetImageMemoryRequirements)(client.device, image, &requirements);
  VkDeviceSize end = 0;
  for (uint32_t layer = 0; layer < 3; ++layer) {
    for (uint32_t level = 0; level < 7; ++level) {
      const VkImageSubresource subresource{VK_IMAGE_ASPECT_COLOR_BIT, level, layer};
      VkSubresourceLayout layout;
      VK(client, GetImageSubresourceLayout)(client.device, image, &subresource, &layout);
      EXPECT_GE(layout.offset, end);
      EXPECT_GE(layout.rowPitch, std::max(100u >> level, 1u) * 4);
      EXPECT_EQ(layout.size, layout.rowPitch * std::max(30u >> level, 1u));
      end = layout.offset + layout.size;
    }
  }
  EXPECT_LE(end, requirements.size);
}

TEST(IcdImage, WhatIsNotAdvertisedIsNotCreated) {
  breaks_on_purpose({"UNASSIGNED-CoreValidation-Image-InvalidFormatLimitsViolation", "VUID-VkImageCreateInfo-extent-02252",
                     "VUID-VkImageCreateInfo-imageCreateMaxMipLevels-02251", "VUID-VkImageCreateInfo-samples-02258"});
  Client client;
  VkImageCreateInfo info{VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO};
  info.imageType = VK_IMAGE_TYPE_2D;
  info.format = VK_FORMAT_R8G8B8A8_UNORM;
  info.extent = {16, 16, 1};
  info.mipLevels = info.arrayLayers = 1;
  info.usage = VK_IMAGE_USAGE_SAMPLED_BIT;
  info.samples = VK_SAMPLE_COUNT_64_BIT;
  VkImage image;
  EXPECT_NE(VK(client, CreateImage)(client.device, &info, nullptr, &image), VK_SUCCESS);
  info.samples = VK_SAMPLE_COUNT_1_BIT;
  info.format = VK_FORMAT_R8G8B8_UNORM;  // vertex buffers only
  EXPECT_NE(VK(client, CreateImage)(client.device, &info, nullptr, &image), VK_SUCCESS);
  info.format = VK_FORMAT_R32G32B32A32_SFLOAT;
  info.extent = {16384, 16384, 1};  // 4 GiB: one byte beyond maxResourceSize
  EXPECT_EQ(VK(client, CreateImage)(client.device, &info, nullptr, &image), VK_ERROR_OUT_OF_DEVICE_MEMORY);
  info.extent = {16385, 1, 1};
  EXPECT_NE(VK(client, CreateImage)(client.device, &info, nullptr, &image), VK_SUCCESS);
  EXPECT_EQ(image, VkImage(VK_NULL_HANDLE));
}

}  // namespace
}  // namespace pineda::test
