#include "base/srgb.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>

#include "base/half.h"

namespace pineda {
namespace {

double decode(double s) { return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4); }
double encode(double l) { return l <= 0.0031308 ? 12.92 * l : 1.055 * std::pow(l, 1 / 2.4) - 0.055; }

TEST(Srgb, DecodesEveryCodeToNearest) {
  for (int c = 0; c < 256; ++c) EXPECT_EQ(srgb_decode_table()[c], static_cast<float>(decode(c / 255.0))) << c;
}

TEST(Srgb, EncodesToNearestCode) {
  // Every 97th float of [0, 1]; a double is far more precise than a float's distance from a code boundary.
  for (uint32_t bits = 0; bits <= 0x3f800000; bits += 97) {
    const float x = std::bit_cast<float>(bits);
    ASSERT_EQ(srgb_encode(x), static_cast<int>(std::floor(encode(x) * 255 + 0.5))) << x;
  }
}

TEST(Srgb, RoundTripsAndClamps) {
  for (int c = 0; c < 256; ++c) EXPECT_EQ(srgb_encode(srgb_decode_table()[c]), c);
  EXPECT_EQ(srgb_encode(-1), 0);
  EXPECT_EQ(srgb_encode(2), 255);
  EXPECT_EQ(srgb_encode(NAN), 0);
}

TEST(Half, RoundTripsEveryValue) {
  for (uint32_t h = 0; h < 0x10000; ++h) {
    const float f = half_to_float(static_cast<uint16_t>(h));
    if (f == f) {
      ASSERT_EQ(float_to_half(f), h);
    } else {
      ASSERT_EQ(float_to_half(f), 0x7e00);
    }
  }
}

TEST(Half, RoundsToNearestEven) {
  // Between each pair of neighbours: the midpoint goes to the even one, its neighbours to the nearer one.
  for (uint32_t h = 0; h < 0x7c00; ++h) {
    const double low = half_to_float(static_cast<uint16_t>(h));
    const double high = h == 0x7bff ? 65536.0 : half_to_float(static_cast<uint16_t>(h + 1));
    const float middle = static_cast<float>((low + high) / 2);
    ASSERT_EQ(float_to_half(middle), h + (h & 1)) << h;
    ASSERT_EQ(float_to_half(std::nextafter(middle, 0.0f)), h);
    ASSERT_EQ(float_to_half(std::nextafter(middle, 1e9f)), h + 1);
    ASSERT_EQ(float_to_half(-middle), 0x8000 | (h + (h & 1)));
  }
}

}  // namespace
}  // namespace pineda
