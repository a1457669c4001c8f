// The fast ways of texel_converter and texel_row against base/format.h, texel by texel, bit for bit.
#include "raster/texel_converter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include "raster/texel_row.h"

namespace pineda::raster {
namespace {

constexpr uint32_t kSeed = 20250305;

TEST(TexelConverter, IsUnpackAndPack) {
  std::mt19937 random(kSeed);
  constexpr uint32_t kCount = 300;
  constexpr VkFormat kTargets[] = {VK_FORMAT_B8G8R8A8_UNORM,
                                   VK_FORMAT_R8G8B8A8_SRGB,
                                   VK_FORMAT_R16G16B16A16_SFLOAT,
                                   VK_FORMAT_R32G32B32A32_SFLOAT,
                                   VK_FORMAT_R5G6B5_UNORM_PACK16,
                                   VK_FORMAT_R8_SNORM,
                                   VK_FORMAT_B10G11R11_UFLOAT_PACK32,
                                   VK_FORMAT_E5B9G9R9_UFLOAT_PACK32,
                                   VK_FORMAT_R8G8B8A8_UINT,
                                   VK_FORMAT_R32G32B32A32_UINT,
                                   VK_FORMAT_R16G16_SINT,
                                   VK_FORMAT_A8B8G8R8_UNORM_PACK32};
  for (const FormatInfo& from : all_formats()) {
    if (!(from.uses & kUseSampled) || !from.is_plain() || from.is_depth_or_stencil()) continue;
    std::vector<uint8_t> row(size_t{kCount} * from.texel_bytes);
    for (uint8_t& byte : row) byte = static_cast<uint8_t>(random());
    std::vector<uint32_t> columns(kCount);
    for (uint32_t i = 0; i < kCount; ++i) columns[i] = i < 100 ? i : i < 200 ? 2 * (i - 100) : kCount - 1 - i % 7;
    for (const VkFormat target : kTargets) {
      const FormatInfo& to = *find_format(target);
      if (from.is_integer() != to.is_integer() || (from.is_integer() && from.numeric != to.numeric)) continue;
      for (const uint64_t work : {uint64_t{kCount}, uint64_t{1} << 20}) {  // without and with tables
        std::vector<uint8_t> got(size_t{kCount} * to.texel_bytes);
        TexelConverter(from, to, work).run(row.data(), columns.data(), kCount, got.data());
        for (uint32_t i = 0; i < kCount; ++i) {
          uint8_t want[16] = {};
          pack_clear_color(to, unpack_texel(from, &row[size_t{columns[i]} * from.texel_bytes]), want);
          ASSERT_EQ(std::memcmp(&got[size_t{i} * to.texel_bytes], want, to.texel_bytes), 0) << from.name << " to " << to.name;
        }
      }
    }
  }
}

TEST(TexelRow, WritesWhatPackingWrites) {
  std::mt19937 random(kSeed);
  constexpr uint32_t kCount = 4096;
  constexpr float kOdd[] = {std::numeric_limits<float>::quiet_NaN(),
                            std::numeric_limits<float>::infinity(),
                            -std::numeric_limits<float>::infinity(),
                            -0.0f,
                            1.0f,
                            1.5f,
                            0.5f / 255,
                            127.5f / 255,
                            1e-40f};
  std::vector<Float4> values(kCount);
  for (Float4& value : values) {
    for (int c = 0; c < 4; ++c) {
      value[c] = random() % 16 == 0 ? kOdd[random() % std::size(kOdd)] : static_cast<float>(random() / 0x1p32 * 1.25 - 0.125);
    }
  }
  for (const VkFormat name : {VK_FORMAT_R8G8B8A8_UNORM, VK_FORMAT_B8G8R8A8_UNORM, VK_FORMAT_R8G8B8A8_SRGB,
                              VK_FORMAT_B8G8R8A8_SRGB, VK_FORMAT_R16G16B16A16_SFLOAT}) {
    const FormatInfo& format = *find_format(name);
    std::vector<uint8_t> got(size_t{kCount} * format.texel_bytes);
    TexelRow(format).write_values(values.data(), kCount, got.data());
    for (uint32_t i = 0; i < kCount; ++i) {
      VkClearColorValue color;
      for (int c = 0; c < 4; ++c) color.float32[c] = values[i][c];
      uint8_t want[16];
      pack_clear_color(format, color, want);
      ASSERT_EQ(std::memcmp(&got[size_t{i} * format.texel_bytes], want, format.texel_bytes), 0) << format.name << " texel " << i;
    }
  }
}

TEST(TexelRow, ReadsWhatUnpackingReads) {
  std::mt19937 random(kSeed);
  constexpr uint32_t kCount = 1024;
  std::vector<uint32_t> columns(kCount);
  for (uint32_t i = 0; i < kCount; ++i) columns[i] = kCount - 1 - i;
  for (const VkFormat name : {VK_FORMAT_R8G8B8A8_UNORM, VK_FORMAT_B8G8R8A8_UNORM, VK_FORMAT_R8G8B8A8_SRGB,
                              VK_FORMAT_B8G8R8A8_SRGB, VK_FORMAT_R8G8_SRGB}) {
    const FormatInfo& format = *find_format(name);
    std::vector<uint8_t> row(size_t{kCount} * format.texel_bytes);
    for (uint8_t& byte : row) byte = static_cast<uint8_t>(random());
    const TexelRow reader(format);
    std::vector<Float4> got(kCount);
    reader.read(row.data(), columns.data(), kCount, got.data());
    for (uint32_t i = 0; i < kCount; ++i) {
      const VkClearColorValue want = unpack_texel(format, &row[size_t{columns[i]} * format.texel_bytes]);
      for (int c = 0; c < 4; ++c) ASSERT_EQ(got[i][c] / reader.scale()[c], want.float32[c]) << format.name << " texel " << i;
    }
  }
}

}  // namespace
}  // namespace pineda::raster
