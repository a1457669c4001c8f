#include "tools/image.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <random>

#include "tools/error.h"
#include "tools/image_metrics.h"

namespace pineda::tools {
namespace {

Image random_image(uint32_t width, uint32_t height, uint32_t seed) {
  std::mt19937 random(seed);
  Image image{.width = width, .height = height, .rgba = std::vector<uint8_t>(size_t{4} * width * height)};
  for (uint8_t& byte : image.rgba) byte = static_cast<uint8_t>(random());
  return image;
}

// The average of a texel's footprint in real numbers, by integration over a fine grid: an oracle that shares nothing with the
// code.
double area_average(const Image& source, double x0, double x1, double y0, double y1, int channel) {
  double sum = 0;
  for (uint32_t y = 0; y < source.height; ++y) {
    const double rows = std::max(0.0, std::min<double>(y + 1, y1) - std::max<double>(y, y0));
    for (uint32_t x = 0; x < source.width; ++x) {
      const double columns = std::max(0.0, std::min<double>(x + 1, x1) - std::max<double>(x, x0));
      sum += rows * columns * source.pixel(x, y)[channel];
    }
  }
  return sum / ((x1 - x0) * (y1 - y0));
}

TEST(Image, MipLevelsAreAreaAverages) {
  constexpr uint32_t kSeed = 20240607;
  for (const auto& [width, height] : {std::pair{8u, 8u}, {7u, 5u}, {1u, 9u}, {13u, 2u}, {3u, 3u}}) {
    SCOPED_TRACE(fmt::format("seed {} size {}x{}", kSeed, width, height));
    const std::vector<Image> levels = make_mip_chain(random_image(width, height, kSeed));
    ASSERT_EQ(levels.back().width, 1u);
    ASSERT_EQ(levels.back().height, 1u);
    for (size_t i = 1; i < levels.size(); ++i) {
      const Image &larger = levels[i - 1], &smaller = levels[i];
      ASSERT_EQ(smaller.width, std::max(1u, larger.width / 2));
      ASSERT_EQ(smaller.height, std::max(1u, larger.height / 2));
      const double step_x = double(larger.width) / smaller.width, step_y = double(larger.height) / smaller.height;
      for (uint32_t y = 0; y < smaller.height; ++y) {
        for (uint32_t x = 0; x < smaller.width; ++x) {
          for (int channel = 0; channel < 4; ++channel) {
            const double exact = area_average(larger, x * step_x, (x + 1) * step_x, y * step_y, (y + 1) * step_y, channel);
            EXPECT_NEAR(smaller.pixel(x, y)[channel], exact, 0.5 + 1e-9);  // half a step: rounded to nearest
          }
        }
      }
    }
  }
}

TEST(Image, PngKeepsEveryByte) {
  const std::string path = testing::TempDir() + "/pineda_image_test.png";
  const Image image = random_image(37, 21, 5);
  save_png(path, image);
  const Image loaded = load_image(path);
  std::filesystem::remove(path);
  EXPECT_EQ(loaded.width, 37u);
  EXPECT_EQ(loaded.height, 21u);
  EXPECT_EQ(loaded.rgba, image.rgba);
  EXPECT_EQ(hash_of(loaded), hash_of(image));
}

TEST(Image, BadFilesAreErrors) {
  EXPECT_THROW(load_image("/nonexistent/picture.png"), ToolError);
  const uint8_t garbage[] = {0x89, 'P', 'N', 'G', 1, 2, 3};
  EXPECT_THROW(decode_image(garbage, sizeof garbage, "garbage"), ToolError);
  EXPECT_THROW(save_png("/nonexistent/picture.png", random_image(2, 2, 1)), ToolError);
}

TEST(Image, HashIsXxh64) {
  // XXH64 of no bytes with seed 0, from the specification's test vectors: golden files must not change with the library's
  // version.
  EXPECT_EQ(hash_of(Image{}), "ef46db3751d8e999");
}

TEST(ImageMetrics, EqualPictures) {
  const Image image = random_image(16, 16, 3);
  const ImageMetrics metrics = measure(image, image);
  EXPECT_EQ(metrics.largest_difference, 0u);
  EXPECT_EQ(metrics.rmse, 0);
  EXPECT_EQ(metrics.psnr_db, std::numeric_limits<double>::infinity());
  EXPECT_EQ(metrics.within_one_share, 1);
}

TEST(ImageMetrics, CountsByHand) {
  Image a{.width = 4, .height = 1, .rgba = std::vector<uint8_t>(16, 100)};
  Image b = a;
  b.pixel(1, 0)[0] = 101;  // within one step
  b.pixel(2, 0)[1] = 97;   // three steps
  const ImageMetrics metrics = measure(a, b);
  EXPECT_EQ(metrics.largest_difference, 3u);
  EXPECT_DOUBLE_EQ(metrics.rmse, std::sqrt((1.0 + 9.0) / 16));
  EXPECT_DOUBLE_EQ(metrics.psnr_db, 20 * std::log10(255 / metrics.rmse));
  EXPECT_DOUBLE_EQ(metrics.differing_share, 0.5);
  EXPECT_DOUBLE_EQ(metrics.within_one_share, 0.75);
  EXPECT_EQ(metrics.beyond_one_count, 1u);
  const Image map = difference_map(a, b);
  EXPECT_EQ(std::vector<uint8_t>(map.pixel(0, 0), map.pixel(0, 0) + 3), (std::vector<uint8_t>{12, 14, 20}));
  EXPECT_NE(std::vector<uint8_t>(map.pixel(1, 0), map.pixel(1, 0) + 3),
            std::vector<uint8_t>(map.pixel(2, 0), map.pixel(2, 0) + 3));
}

TEST(ImageMetrics, SizesMustAgree) { EXPECT_THROW(measure(random_image(2, 3, 1), random_image(3, 2, 1)), ToolError); }

}  // namespace
}  // namespace pineda::tools
