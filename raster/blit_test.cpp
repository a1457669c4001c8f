// Blits against the specification's equations in double, for formats of each kind, scaled, mirrored, clipped at edges, in two and
// three dimensions.
#include "raster/blit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>
#include <vector>

namespace pineda::raster {
namespace {

constexpr uint32_t kSeed = 20240623;

struct Picture {
  const FormatInfo& format;
  uint32_t width, height, depth;
  std::vector<uint8_t> bytes;

  Picture(VkFormat f, uint32_t w, uint32_t h, uint32_t d)
      : format(*find_format(f)), width(w), height(h), depth(d), bytes(size_t{w} * h * d * format.texel_bytes) {}
  BlitSide side() {
    const uint64_t row = uint64_t{width} * format.texel_bytes;
    return {&format, bytes.data(), row, row * height};
  }
  VkClearColorValue texel(uint32_t x, uint32_t y, uint32_t z) const {
    return unpack_texel(format, &bytes[((size_t{z} * height + y) * width + x) * format.texel_bytes]);
  }
};

struct Corners {
  int32_t from0, from1, to0, to1;
};

// One component, at one texel of the destination.
double reference(const Picture& source, const Corners (&c)[3], bool linear, bool linear_z, const int32_t (&at)[3],
                 uint32_t component) {
  const uint32_t size[3] = {source.width, source.height, source.depth};
  uint32_t texel[3][2];
  double weight[3];
  for (int a = 0; a < 3; ++a) {
    const double u = (at[a] + 0.5 - c[a].to0) * (double(c[a].from1) - c[a].from0) / (double(c[a].to1) - c[a].to0) + c[a].from0;
    const bool filter = a < 2 ? linear : linear_z;
    const double u0 = std::floor(filter ? u - 0.5 : u);
    weight[a] = filter ? u - 0.5 - u0 : 0;
    for (int i = 0; i < 2; ++i) texel[a][i] = static_cast<uint32_t>(std::clamp(u0 + i, 0.0, size[a] - 1.0));
  }
  double sum = 0;
  for (int i = 0; i < 8; ++i) {
    double w = 1;
    for (int a = 0; a < 3; ++a) w *= i >> a & 1 ? weight[a] : 1 - weight[a];
    if (w > 0) sum += w * source.texel(texel[0][i & 1], texel[1][i >> 1 & 1], texel[2][i >> 2]).float32[component];
  }
  return sum;
}

void expect_blit(ThreadPool& pool, Picture& source, Picture& destination, const Corners (&c)[3], bool linear) {
  const bool linear_z = linear && source.depth > 1;
  const auto axis = [&](int a, uint32_t limit) { return BlitAxis(c[a].from0, c[a].from1, c[a].to0, c[a].to1, limit); };
  blit(pool, {.source = source.side(),
              .destination = destination.side(),
              .x = axis(0, source.width),
              .y = axis(1, source.height),
              .z = axis(2, source.depth),
              .linear = linear,
              .linear_z = linear_z});
  int32_t at[3];
  for (at[2] = std::min(c[2].to0, c[2].to1); at[2] < std::max(c[2].to0, c[2].to1); ++at[2]) {
    for (at[1] = std::min(c[1].to0, c[1].to1); at[1] < std::max(c[1].to0, c[1].to1); ++at[1]) {
      for (at[0] = std::min(c[0].to0, c[0].to1); at[0] < std::max(c[0].to0, c[0].to1); ++at[0]) {
        const VkClearColorValue got =
            destination.texel(static_cast<uint32_t>(at[0]), static_cast<uint32_t>(at[1]), static_cast<uint32_t>(at[2]));
        for (uint32_t k = 0; k < 4; ++k) {
          if (!destination.format.component[k].bits) continue;
          const double want = reference(source, c, linear, linear_z, at, k);
          // Half a code of the destination and a few roundings of binary32; sRGB codes are at most 1/114 apart.
          const uint32_t bits = destination.format.component[k].bits;
          const double code = destination.format.is_float()                  ? (bits == 16 ? 0x1p-10 : 0x1p-22)
                              : destination.format.numeric == Numeric::kSrgb ? 1 / 57.0
                                                                             : 1 / (std::ldexp(1.0, bits) - 1);
          ASSERT_LE(std::fabs(got.float32[k] - want), 0.5 * code + 0x1p-22)
              << source.format.name << " to " << destination.format.name << " component " << k << " at " << at[0] << ", "
              << at[1];
        }
      }
    }
  }
}

void randomize(Picture& picture, std::mt19937& random) {
  for (size_t i = 0; i < picture.bytes.size(); i += picture.format.texel_bytes) {
    VkClearColorValue color;
    for (float& v : color.float32) v = static_cast<float>(random() / 0x1p32);
    pack_clear_color(picture.format, color, &picture.bytes[i]);
  }
}

TEST(Blit, IsTheSpecificationsFilter) {
  ThreadPool pool(2);
  std::mt19937 random(kSeed);
  constexpr VkFormat kFormats[] = {VK_FORMAT_R8G8B8A8_UNORM,      VK_FORMAT_B8G8R8A8_UNORM,      VK_FORMAT_R8G8B8A8_SRGB,
                                   VK_FORMAT_R16G16B16A16_SFLOAT, VK_FORMAT_R32G32B32A32_SFLOAT, VK_FORMAT_R8_UNORM,
                                   VK_FORMAT_R5G6B5_UNORM_PACK16, VK_FORMAT_R16G16_UNORM};
  for (const VkFormat from : kFormats) {
    for (const VkFormat to : {from, VK_FORMAT_R8G8B8A8_UNORM, VK_FORMAT_B8G8R8A8_UNORM, VK_FORMAT_R32G32B32A32_SFLOAT}) {
      for (const bool linear : {false, true}) {
        Picture source(from, 24, 20, 1), destination(to, 40, 30, 1);
        randomize(source, random);
        const Corners slice{0, 1, 0, 1};
        expect_blit(pool, source, destination, {{0, 24, 0, 40}, {0, 20, 0, 30}, slice}, linear);  // larger
        expect_blit(pool, source, destination, {{0, 24, 17, 3}, {2, 19, 5, 28}, slice}, linear);  // mirrored, smaller
        expect_blit(pool, source, destination, {{0, 24, 5, 17}, {20, 0, 0, 10}, slice}, linear);  // half, upside down
        expect_blit(pool, source, destination, {{2, 24, 1, 12}, {0, 20, 0, 10}, slice}, linear);  // half
        expect_blit(pool, source, destination, {{3, 9, 2, 8}, {7, 8, 0, 30}, slice}, linear);     // one row, stretched
        if (HasFatalFailure()) return;
      }
    }
  }
}

TEST(Blit, FiltersVolumes) {
  ThreadPool pool(2);
  std::mt19937 random(kSeed);
  for (const bool linear : {false, true}) {
    Picture source(VK_FORMAT_R8G8B8A8_UNORM, 9, 7, 6), destination(VK_FORMAT_R16G16B16A16_UNORM, 12, 5, 11);
    randomize(source, random);
    expect_blit(pool, source, destination, {{0, 9, 0, 12}, {7, 0, 0, 5}, {0, 6, 0, 11}}, linear);
    expect_blit(pool, source, destination, {{1, 8, 2, 5}, {0, 7, 0, 5}, {5, 1, 3, 9}}, linear);
    if (HasFatalFailure()) return;
  }
}

// The fast way for mip levels gives the bits of the general one.
TEST(Blit, HalvingIsTheGeneralFilter) {
  ThreadPool pool(2);
  std::mt19937 random(kSeed);
  Picture source(VK_FORMAT_R8G8B8A8_UNORM, 256, 64, 1), fast(VK_FORMAT_R8G8B8A8_UNORM, 128, 32, 1),
      wide(VK_FORMAT_B8G8R8A8_UNORM, 128, 32, 1);
  for (uint8_t& byte : source.bytes) byte = static_cast<uint8_t>(random());
  for (Picture* to : {&fast, &wide}) {
    blit(pool, {.source = source.side(),
                .destination = to->side(),
                .x = {0, 256, 0, 128, 256},
                .y = {0, 64, 0, 32, 64},
                .z = {0, 1, 0, 1, 1},
                .linear = true});
  }
  for (size_t i = 0; i < fast.bytes.size(); i += 4) {
    const uint8_t want[4] = {wide.bytes[i + 2], wide.bytes[i + 1], wide.bytes[i], wide.bytes[i + 3]};
    ASSERT_EQ(std::memcmp(&fast.bytes[i], want, 4), 0);
  }
}

}  // namespace
}  // namespace pineda::raster
