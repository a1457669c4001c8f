// Points and lines: coverage against the specification's rules, each written down a second time in another way.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <vector>

#include "raster/test_scene.h"

namespace pineda::raster {
namespace {

using namespace testing;

constexpr uint32_t kSize = 16;

struct Point {
  int32_t x, y;  // fx8
};

std::vector<uint32_t> draw_picture(TestDraw& draw, uint32_t tile = 16) {
  Target target(kSize, kSize);
  static ThreadPool pool(1);
  Options options = test_options();
  options.tile_px = tile;
  Pass pass(pool, target.desc(), options);
  pass.draw(draw.packet(kSize, kSize));
  pass.end();
  return target.color;
}

void add_point(TestDraw& draw, Point p) {
  add_window_vertex(draw, kSize, kSize, static_cast<float>(p.x) / 256, static_cast<float>(p.y) / 256);
}

std::vector<uint32_t> line_picture(Point a, Point b, LineMode mode, float width = 1) {
  TestDraw draw(4, count_kernel);
  draw.packet_base.topology = VK_PRIMITIVE_TOPOLOGY_LINE_LIST;
  draw.packet_base.line.mode = mode;
  draw.packet_base.line.width_px = width;
  add_point(draw, a);
  add_point(draw, b);
  return draw_picture(draw);
}

std::string text(const std::vector<uint32_t>& picture) {
  std::string out = "\n";
  for (uint32_t y = 0; y < kSize; ++y) {
    for (uint32_t x = 0; x < kSize; ++x)
      out += picture[y * kSize + x] > 9 ? '+' : static_cast<char>('0' + picture[y * kSize + x]);
    out += '\n';
  }
  return out;
}

// Ends on pixel centres, sides and corners of diamonds, and anywhere.
Point random_point(std::mt19937& rng) {
  const uint32_t step = std::array{1u, 32u, 64u, 128u, 256u}[rng() % 5];
  const auto coordinate = [&] { return static_cast<int32_t>(rng() % (14 * 256 / step) * step + 256 + (step == 256 ? 128 : 0)); };
  const int32_t x = coordinate();
  return {x, coordinate()};
}

// ---- Bresenham lines ------------------------------------------------------------------------------------------------------

// The diamond-exit rule, literally: the segment between the moved ends meets the open diamond, and the second is not in it. e is
// 1 / kScale of 1/256 px, so coordinates are exact integers in units of 1 / kScale^2.
constexpr __int128 kScale = 1 << 14;
bool leaves_diamond(Point a, Point b, int32_t px, int32_t py) {
  const auto moved = [](Point p) { return std::array<__int128, 2>{p.x * kScale * kScale - kScale, p.y * kScale * kScale - 1}; };
  const auto p = moved(a), q = moved(b);
  const __int128 xc = (px * 256 + 128) * kScale * kScale, yc = (py * 256 + 128) * kScale * kScale, half = 128 * kScale * kScale;
  const auto magnitude = [](__int128 v) { return v < 0 ? -v : v; };
  if (magnitude(q[0] - xc) + magnitude(q[1] - yc) < half) return false;
  // The part of the segment, low < t < high, that is on the inner side of all four sides: fractions with positive denominators.
  __int128 low[2] = {0, 1}, high[2] = {1, 1};
  bool closed_low = true, closed_high = true;  // the ends themselves count
  for (const int sx : {-1, 1}) {
    for (const int sy : {-1, 1}) {
      const __int128 fp = half - (sx * (p[0] - xc) + sy * (p[1] - yc)), fq = half - (sx * (q[0] - xc) + sy * (q[1] - yc));
      if (fp <= 0 && fq <= 0) return false;
      if (fp <= 0) {  // enters at fp / (fp - fq)
        const __int128 n = -fp, d = fq - fp;
        if (n * low[1] >= low[0] * d) low[0] = n, low[1] = d, closed_low = false;
      } else if (fq <= 0) {  // leaves
        const __int128 n = fp, d = fp - fq;
        if (n * high[1] <= high[0] * d) high[0] = n, high[1] = d, closed_high = false;
      }
    }
  }
  const __int128 l = low[0] * high[1], h = high[0] * low[1];
  return l < h || (l == h && closed_low && closed_high);
}

TEST(Lines, BresenhamIsTheDiamondExitRule) {
  std::mt19937 rng(41);
  for (int i = 0; i < 6000; ++i) {
    const Point a = random_point(rng), b = random_point(rng);
    std::vector<uint32_t> expected(kSize * kSize);
    for (int32_t y = 0; y < int32_t{kSize}; ++y) {
      for (int32_t x = 0; x < int32_t{kSize}; ++x) expected[static_cast<size_t>(y) * kSize + x] = leaves_diamond(a, b, x, y);
    }
    const std::vector<uint32_t> picture = line_picture(a, b, LineMode::kBresenham);
    ASSERT_EQ(picture, expected) << i << ": " << a.x << ' ' << a.y << " -> " << b.x << ' ' << b.y << text(picture)
                                 << text(expected);
  }
}

// Between pixel centres the rule reduces to Bresenham's algorithm without the last pixel. Two other ways to the same pixels,
// which differ in how they break ties: where the line runs exactly between two centres is asked of the rule's shift.
std::vector<uint32_t> dda(int32_t x0, int32_t y0, int32_t x1, int32_t y1) {
  std::vector<uint32_t> picture(kSize * kSize);
  const int32_t dx = x1 - x0, dy = y1 - y0, steps = std::max(std::abs(dx), std::abs(dy));
  const bool x_major = std::abs(dx) >= std::abs(dy);
  const bool tie_up = x_major && dx * dy > 0;  // the shift by -e raises the line where it falls from left to right
  for (int32_t i = 0; i < steps; ++i) {
    const auto at = [&](int32_t from, int32_t delta) {  // nearest to from + i * delta / steps
      const int32_t twice = 2 * i * delta + steps;
      const int32_t down = twice >= 0 ? twice / (2 * steps) : -((-twice + 2 * steps - 1) / (2 * steps));
      return from + down - (twice % (2 * steps) == 0 && !tie_up ? 1 : 0);
    };
    const int32_t x = x_major ? x0 + (dx > 0 ? i : -i) : at(x0, dx), y = x_major ? at(y0, dy) : y0 + (dy > 0 ? i : -i);
    picture[static_cast<size_t>(y) * kSize + x] += 1;
  }
  return picture;
}

std::vector<uint32_t> midpoint(int32_t x0, int32_t y0, int32_t x1, int32_t y1) {
  std::vector<uint32_t> picture(kSize * kSize);
  const int32_t dx = std::abs(x1 - x0), dy = std::abs(y1 - y0), sx = x1 > x0 ? 1 : -1, sy = y1 > y0 ? 1 : -1;
  const bool x_major = dx >= dy;
  const int32_t major = x_major ? dx : dy, minor = x_major ? dy : dx;
  // At a tie the step is taken when it goes the way of the shift.
  const bool step_at_tie = x_major ? (sx == sy ? sy > 0 : sy < 0) : sx < 0;
  int32_t x = x0, y = y0, error = 2 * minor - major;
  for (int32_t i = 0; i < major; ++i) {
    picture[static_cast<size_t>(y) * kSize + x] += 1;
    if (error > 0 || (error == 0 && step_at_tie)) {
      (x_major ? y : x) += x_major ? sy : sx;
      error -= 2 * major;
    }
    error += 2 * minor;
    (x_major ? x : y) += x_major ? sx : sy;
  }
  return picture;
}

TEST(Lines, DdaAndMidpointGiveTheSamePixels) {
  std::mt19937 rng(42);
  for (int i = 0; i < 4000; ++i) {
    int32_t c[4];
    for (int32_t& v : c) v = static_cast<int32_t>(rng() % kSize);
    const Point a{c[0] * 256 + 128, c[1] * 256 + 128}, b{c[2] * 256 + 128, c[3] * 256 + 128};
    const std::vector<uint32_t> picture = line_picture(a, b, LineMode::kBresenham);
    ASSERT_EQ(picture, dda(c[0], c[1], c[2], c[3])) << text(picture) << text(dda(c[0], c[1], c[2], c[3]));
    ASSERT_EQ(picture, midpoint(c[0], c[1], c[2], c[3])) << text(picture) << text(midpoint(c[0], c[1], c[2], c[3]));
  }
}

// A strip of lines through the same points touches each of its inner pixels once.
TEST(Lines, BresenhamStripsHaveNoPixelTwice) {
  TestDraw draw(4, count_kernel);
  draw.packet_base.topology = VK_PRIMITIVE_TOPOLOGY_LINE_STRIP;
  draw.packet_base.line.mode = LineMode::kBresenham;
  for (const int32_t x : {1, 4, 5, 9, 13, 14}) add_point(draw, {x * 256 + 77, x * 200 + 31});
  for (const uint32_t v : draw_picture(draw)) EXPECT_LE(v, 1u);
}

// Along a strip the stipple goes on from segment to segment, whichever way they run; in a list it begins anew.
TEST(Lines, StippleCountsPixelsAlongAStrip) {
  const std::vector<Point> path{
      {128, 4 * 256 + 128}, {10 * 256 + 128, 4 * 256 + 128}, {10 * 256 + 128, 14 * 256 + 128}, {3 * 256 + 128, 14 * 256 + 128}};
  for (const uint32_t factor : {1u, 2u, 3u}) {
    constexpr uint32_t kPattern = 0x2D5B;
    TestDraw strip(4, count_kernel);
    strip.packet_base.topology = VK_PRIMITIVE_TOPOLOGY_LINE_STRIP;
    strip.packet_base.line = {LineMode::kBresenham, true, kPattern, factor, 1};
    for (const Point p : path) add_point(strip, p);
    std::vector<uint32_t> expected(kSize * kSize);
    uint32_t s = 0;
    for (size_t i = 0; i + 1 < path.size(); ++i) {
      int32_t x = path[i].x >> 8, y = path[i].y >> 8;
      const int32_t x1 = path[i + 1].x >> 8, y1 = path[i + 1].y >> 8;
      for (; x != x1 || y != y1; x += (x1 > x) - (x1 < x), y += (y1 > y) - (y1 < y), ++s) {
        expected[static_cast<size_t>(y) * kSize + x] = kPattern >> s / factor % 16 & 1;
      }
    }
    EXPECT_EQ(draw_picture(strip), expected) << text(draw_picture(strip)) << text(expected);
    TestDraw list(4, count_kernel);
    list.packet_base.topology = VK_PRIMITIVE_TOPOLOGY_LINE_LIST;
    list.packet_base.line = strip.packet_base.line;
    for (const int32_t y : {2, 9}) {
      add_point(list, {128, y * 256 + 128});
      add_point(list, {15 * 256 + 128, y * 256 + 128});
    }
    const std::vector<uint32_t> rows = draw_picture(list);
    for (uint32_t x = 0; x < 15; ++x) {
      EXPECT_EQ(rows[2 * kSize + x], kPattern >> x / factor % 16 & 1);
      EXPECT_EQ(rows[9 * kSize + x], rows[2 * kSize + x]);
    }
  }
}

// ---- rectangular lines ----------------------------------------------------------------------------------------------------

// A pixel whose centre is inside the rectangle (in f64, from the ends and the width) by more than the rounding of the corners is
// covered, one outside by as much is not. The corners move by half a subpixel in each coordinate.
TEST(Lines, StrictLinesAreRectangles) {
  std::mt19937 rng(43);
  const double slack = 0.8 / 256;  // sqrt(2) / 2, and a little
  for (int i = 0; i < 3000; ++i) {
    const Point a = random_point(rng), b = random_point(rng);
    const float width = std::array{1.0f, 1.5f, 3.0f, 7.25f}[rng() % 4];
    const std::vector<uint32_t> picture = line_picture(a, b, LineMode::kStrict, width);
    const double dx = (b.x - a.x) / 256.0, dy = (b.y - a.y) / 256.0, length = std::sqrt(dx * dx + dy * dy);
    for (uint32_t y = 0; y < kSize; ++y) {
      for (uint32_t x = 0; x < kSize; ++x) {
        const uint32_t covered = picture[y * kSize + x];
        ASSERT_LE(covered, 1u);
        if (length == 0) {
          ASSERT_EQ(covered, 0u);
          continue;
        }
        const double px = x + 0.5 - a.x / 256.0, py = y + 0.5 - a.y / 256.0;
        const double along = (px * dx + py * dy) / length, across = std::fabs(px * dy - py * dx) / length;
        const double inside = std::min({along, length - along, width / 2.0 - across});
        if (std::fabs(inside) < slack) continue;
        ASSERT_EQ(covered, inside > 0 ? 1u : 0u)
            << a.x << ' ' << a.y << ' ' << b.x << ' ' << b.y << ' ' << width << text(picture);
      }
    }
  }
}

TEST(Lines, StrictLinesAreTheSameForwardsAndBackwards) {
  std::mt19937 rng(44);
  for (int i = 0; i < 2000; ++i) {
    const Point a = random_point(rng), b = random_point(rng);
    const float width = 1 + static_cast<float>(rng() % 64) / 16;
    ASSERT_EQ(line_picture(a, b, LineMode::kStrict, width), line_picture(b, a, LineMode::kStrict, width));
  }
}

// Varyings go from one end to the other; flat ones come from the provoking vertex, first or last.
TEST(Lines, AttributesRunAlongTheLine) {
  static std::vector<float> values, flat;
  for (const LineMode mode : {LineMode::kStrict, LineMode::kBresenham}) {
    for (const bool last : {false, true}) {
      values.assign(kSize * kSize, -1);
      flat.assign(kSize * kSize, -1);
      TestDraw draw(
          5, [](const KernelHandle*, const void*, void* thread, const PrimRecord* prims, uint32_t count, const void* w) {
            for_fragments(thread, prims, count, w, [](const FragmentPrim& p, uint32_t*, float*, uint32_t x, uint32_t y) {
              values[y * kSize + x] = attribute(p, barycentrics(p, x, y), 4);
              flat[y * kSize + x] = flat_attribute(p, 4);
            });
          });
      draw.packet_base.topology = VK_PRIMITIVE_TOPOLOGY_LINE_LIST;
      draw.packet_base.provoking_last = last;
      draw.packet_base.line.mode = mode;
      draw.add({-1, 0.0625f, 0.5f, 1, 3});  // from x = 0 to 16 through the row of pixels 8
      draw.add({1, 0.0625f, 0.5f, 1, 19});
      draw_picture(draw);
      // The Bresenham line ends in the last pixel's diamond.
      for (uint32_t x = 0; x < kSize - (mode == LineMode::kBresenham ? 1 : 0); ++x) {
        EXPECT_FLOAT_EQ(values[8 * kSize + x], 3.5f + static_cast<float>(x));
        EXPECT_EQ(flat[8 * kSize + x], last ? 19 : 3);
      }
    }
  }
}

// ---- points ---------------------------------------------------------------------------------------------------------------

std::vector<uint32_t> point_picture(Point p, float size) {
  TestDraw draw(5, count_kernel);
  draw.packet_base.topology = VK_PRIMITIVE_TOPOLOGY_POINT_LIST;
  draw.packet_base.outputs.point_size = 4;
  add_point(draw, p);
  draw.add({size});
  return draw_picture(draw);
}

TEST(Points, AreSquaresOfTheirSize) {
  std::mt19937 rng(45);
  for (int i = 0; i < 2000; ++i) {
    const Point p = random_point(rng);
    const float size = static_cast<float>(rng() % 20 * 64 + 256) / 256;
    const std::vector<uint32_t> picture = point_picture(p, size);
    for (int32_t y = 0; y < int32_t{kSize}; ++y) {
      for (int32_t x = 0; x < int32_t{kSize}; ++x) {
        const double dx = x + 0.5 - p.x / 256.0, dy = y + 0.5 - p.y / 256.0;
        const bool inside = dx >= -size / 2 && dx < size / 2 && dy >= -size / 2 && dy < size / 2;  // top and left sides belong
        ASSERT_EQ(picture[static_cast<size_t>(y) * kSize + x], inside ? 1u : 0u)
            << p.x << ' ' << p.y << ' ' << size << text(picture);
      }
    }
  }
}

TEST(Points, SizesOutsideTheRangeAreClamped) {
  const Point middle{8 * 256, 8 * 256};
  const auto pixels = [&](float size) {
    uint32_t sum = 0;
    for (const uint32_t v : point_picture(middle, size)) sum += v;
    return sum;
  };
  for (const float size : {0.0f, -3.0f, 0.25f, std::numeric_limits<float>::quiet_NaN()}) EXPECT_EQ(pixels(size), 1u) << size;
  for (const float size : {64.0f, 1e9f, std::numeric_limits<float>::infinity()}) EXPECT_EQ(pixels(size), kSize * kSize) << size;
}

TEST(Points, OutsideTheViewVolumeAreDiscarded) {
  EXPECT_EQ(point_picture({-1, 8 * 256}, 8), std::vector<uint32_t>(kSize * kSize));
  EXPECT_NE(point_picture({0, 8 * 256}, 8), std::vector<uint32_t>(kSize * kSize));
}

// gl_PointCoord is the linear barycentrics: 1/2 + (centre - position) / size.
TEST(Points, CoordinatesGoFromTopLeftToBottomRight) {
  static std::vector<std::array<float, 2>> values;
  values.assign(kSize * kSize, {-1, -1});
  TestDraw draw(
      5, [](const KernelHandle*, const void*, void* thread, const PrimRecord* prims, uint32_t count, const void* waves) {
        for_fragments(thread, prims, count, waves, [](const FragmentPrim& p, uint32_t*, float*, uint32_t x, uint32_t y) {
          const Barycentrics b = barycentrics(p, x, y);
          values[y * kSize + x] = {b.l1, b.l2};
          EXPECT_EQ(attribute(p, b, 4), 8.0f);
          EXPECT_EQ(b.z, 0.5f);
        });
      });
  draw.packet_base.topology = VK_PRIMITIVE_TOPOLOGY_POINT_LIST;
  draw.packet_base.outputs.point_size = 4;
  add_point(draw, {8 * 256, 8 * 256});
  draw.add({8});
  draw_picture(draw);
  for (uint32_t y = 4; y < 12; ++y) {
    for (uint32_t x = 4; x < 12; ++x) {
      EXPECT_FLOAT_EQ(values[y * kSize + x][0], (static_cast<float>(x) - 3.5f) / 8);
      EXPECT_FLOAT_EQ(values[y * kSize + x][1], (static_cast<float>(y) - 3.5f) / 8);
    }
  }
}

// ---- polygon modes --------------------------------------------------------------------------------------------------------

TEST(PolygonModes, LinesAndPointsOfATriangle) {
  for (const VkPolygonMode mode : {VK_POLYGON_MODE_LINE, VK_POLYGON_MODE_POINT}) {
    TestDraw draw(4, count_kernel);
    draw.packet_base.polygon_mode = mode;
    draw.packet_base.line.mode = LineMode::kBresenham;
    const Point corners[3] = {{2 * 256 + 128, 2 * 256 + 128}, {12 * 256 + 128, 2 * 256 + 128}, {2 * 256 + 128, 12 * 256 + 128}};
    for (const Point p : corners) add_point(draw, p);
    std::vector<uint32_t> expected(kSize * kSize);
    for (int k = 0; k < 3; ++k) {
      if (mode == VK_POLYGON_MODE_POINT) {
        expected[static_cast<size_t>(corners[k].y >> 8) * kSize + (corners[k].x >> 8)] = 1;
      } else {
        const std::vector<uint32_t> side = line_picture(corners[k], corners[(k + 1) % 3], LineMode::kBresenham);
        for (size_t i = 0; i < side.size(); ++i) expected[i] += side[i];
      }
    }
    EXPECT_EQ(draw_picture(draw), expected);
    draw.packet_base.cull = VK_CULL_MODE_FRONT_AND_BACK;
    EXPECT_EQ(draw_picture(draw), std::vector<uint32_t>(kSize * kSize));
  }
}

// ---- clip and cull distances ----------------------------------------------------------------------------------------------

TEST(Distances, ClipCutsAndCullDrops) {
  // A square over all pixels whose clip distance is x - 5 px: the pixels from column 5 on are left.
  const auto picture = [](bool cull, float offset) {
    TestDraw draw(5, count_kernel);
    draw.packet_base.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_STRIP;
    auto& outputs = draw.packet_base.outputs;
    (cull ? outputs.cull_distance : outputs.clip_distance) = 4;
    (cull ? outputs.cull_count : outputs.clip_count) = 1;
    for (const float y : {0.0f, 16.0f}) {
      for (const float x : {0.0f, 16.0f}) {
        add_window_vertex(draw, kSize, kSize, x, y);
        draw.add({x - offset});
      }
    }
    return draw_picture(draw);
  };
  const std::vector<uint32_t> cut = picture(false, 5);
  for (uint32_t i = 0; i < kSize * kSize; ++i) EXPECT_EQ(cut[i], i % kSize >= 5 ? 1u : 0u);
  EXPECT_EQ(picture(false, 17), std::vector<uint32_t>(kSize * kSize, 0));
  EXPECT_EQ(picture(true, 5), std::vector<uint32_t>(kSize * kSize, 1)) << "some vertices are inside";
  EXPECT_EQ(picture(true, 17), std::vector<uint32_t>(kSize * kSize, 0));
}

TEST(Distances, LinesAreCutAndPointsDropped) {
  TestDraw line(5, count_kernel);
  line.packet_base.topology = VK_PRIMITIVE_TOPOLOGY_LINE_LIST;
  line.packet_base.outputs.clip_distance = 4;
  line.packet_base.outputs.clip_count = 1;
  add_point(line, {0, 8 * 256 + 128});
  line.add({-4});
  add_point(line, {16 * 256, 8 * 256 + 128});
  line.add({12});
  const std::vector<uint32_t> cut = draw_picture(line);
  for (uint32_t x = 0; x < kSize; ++x) EXPECT_EQ(cut[8 * kSize + x], x >= 4 ? 1u : 0u);
  line.packet_base.topology = VK_PRIMITIVE_TOPOLOGY_POINT_LIST;
  const std::vector<uint32_t> points = draw_picture(line);
  EXPECT_EQ(points[8 * kSize], 0u);
}

}  // namespace
}  // namespace pineda::raster
