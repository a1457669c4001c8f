// Smooth lines, stipples along a length, wide Bresenham lines, and lines that leave the viewport, each against the
// specification's rule, evaluated another way.
#include "raster/line_area.h"

#include <gtest/gtest.h>

#include <random>

#include "raster/coverage.h"
#include "raster/test_scene.h"

namespace pineda::raster {
namespace {

using namespace testing;

constexpr uint32_t kSize = 16;

struct End {
  double x, y;  // px
};

// Where a point lies: along the line and across, px.
struct Place {
  double along, across, length;
};
Place place(End a, End b, double x, double y) {
  const double dx = b.x - a.x, dy = b.y - a.y, length = std::sqrt(dx * dx + dy * dy);
  return {((x - a.x) * dx + (y - a.y) * dy) / length, std::fabs((x - a.x) * dy - (y - a.y) * dx) / length, length};
}

bool pattern_draws(uint32_t pattern, uint32_t factor, double position) {
  return (pattern >> static_cast<uint64_t>(position) / factor % 16 & 1) != 0;
}

struct Picture {
  Target target{kSize, kSize};
  ThreadPool pool{1};
  Options options = test_options();
  PassDesc desc = target.desc();
  // Lines between the points, a list or a strip.
  void draw(TestDraw& draw, const std::vector<End>& ends, VkPrimitiveTopology topology) {
    draw.packet_base.topology = topology;
    for (const End& e : ends) add_window_vertex(draw, kSize, kSize, static_cast<float>(e.x), static_cast<float>(e.y));
    Pass pass(pool, desc, options);
    pass.draw(draw.packet(kSize, kSize));
    pass.end();
  }
};

double random_px(std::mt19937& rng) { return static_cast<double>(rng() % (14 * 256) + 256) / 256; }

// The texel becomes the area that FragmentSampleWave::samples carries.
void area_kernel(const KernelHandle*, const void*, void* thread, const PrimRecord* prims, uint32_t prim_count,
                 const void* waves) {
  auto* color = reinterpret_cast<uint32_t*>(static_cast<const ThreadContext*>(thread)->color[0]);
  for (uint32_t p = 0; p < prim_count; ++p) {
    for (uint32_t i = 0; i < prims[p].wave_count; ++i) {
      const FragmentSampleWave& wave = static_cast<const FragmentSampleWave*>(waves)[prims[p].first_wave + i];
      for (uint32_t lane = 0; lane < kLanes; ++lane) {
        EXPECT_EQ((wave.wave.coverage >> lane & 1) != 0, wave.samples[lane] != 0);
        color[wave.wave.block_index * kLanes + lane] += wave.samples[lane];
      }
    }
  }
}

// Against the share of 64x64 points of each pixel that lie in the rectangle (and in a part of it that the stipple draws). Points
// misjudge at most the cells that the outline crosses, 4 * 65 of 4096, and far fewer where the outline is one side; the snapped
// corners move the sides by 0.003 px.
TEST(SmoothLines, CoverageIsTheAreaInThePixel) {
  std::mt19937 rng(7);
  for (int round = 0; round < 120; ++round) {
    const End a{random_px(rng), random_px(rng)}, b{random_px(rng), random_px(rng)};
    const float width = std::array{1.0f, 2.0f, 4.5f}[rng() % 3];
    const bool stippled = round % 2 == 1;
    const auto pattern = static_cast<uint16_t>(rng());
    const uint32_t factor = 1 + rng() % 3;
    Picture picture;
    picture.options.tile_px = round % 3 == 0 ? 16 : 64;
    TestDraw draw(4, area_kernel);
    draw.packet_base.line = {LineMode::kSmooth, stippled, pattern, factor, width};
    picture.draw(draw, {a, b}, VK_PRIMITIVE_TOPOLOGY_LINE_LIST);
    if (place(a, b, 0, 0).length < 1) continue;
    for (uint32_t y = 0; y < kSize; ++y) {
      for (uint32_t x = 0; x < kSize; ++x) {
        constexpr int kGrid = 64;
        int hits = 0;
        for (int i = 0; i < kGrid * kGrid; ++i) {
          const Place p = place(a, b, x + (i % kGrid + 0.5) / kGrid, y + (i / kGrid + 0.5) / kGrid);
          const bool inside = p.along >= 0 && p.along < p.length && p.across <= width / 2;
          hits += inside && (!stippled || pattern_draws(pattern, factor, p.along));
        }
        ASSERT_NEAR(picture.target.at(x, y) / 65535.0, hits / double{kGrid * kGrid}, 0.03)
            << x << ' ' << y << " width " << width << " stippled " << stippled;
      }
    }
  }
}

// Sutherland and Hodgman (1974): a polygon cut by the four sides of the pixel's square; twice its area.
double clipped_area(std::vector<End> polygon, double x, double y) {
  for (int side = 0; side < 4; ++side) {
    std::vector<End> kept;
    const auto inside = [&](const End& p) {
      const double v = (side & 1) != 0 ? p.y - y : p.x - x;
      return side < 2 ? v : 1 - v;
    };
    for (size_t i = 0; i < polygon.size(); ++i) {
      const End &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
      const double dp = inside(p), dq = inside(q);
      if (dp >= 0) kept.push_back(p);
      if ((dp >= 0) != (dq >= 0)) kept.push_back({p.x + (q.x - p.x) * dp / (dp - dq), p.y + (q.y - p.y) * dp / (dp - dq)});
    }
    polygon = std::move(kept);
  }
  double twice = 0;
  for (size_t i = 0; i < polygon.size(); ++i) {
    const End &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
    twice += (p.x - x) * (q.y - y) - (p.y - y) * (q.x - x);
  }
  return std::fabs(twice) / 2;
}

// A line's record as line_setup.cpp makes it: from a to b, the rectangle's sides half the width away.
Triangle line_record(int32_t ax, int32_t ay, int32_t bx, int32_t by, double width_px) {
  const double dx = bx - ax, dy = by - ay, length = std::sqrt(dx * dx + dy * dy), half = width_px * kSubpixels / 2 / length;
  const auto round = [](double v) { return static_cast<int32_t>(std::nearbyint(v)); };
  const int32_t ux = round(-dy * half), uy = round(dx * half);
  Triangle t{};
  const int32_t x[3] = {ax - ux, bx - ux, ax + ux}, y[3] = {ay - uy, by - uy, ay + uy};
  std::ranges::copy(x, t.x_fx8);
  std::ranges::copy(y, t.y_fx8);
  return t;
}

// Every instruction set against the clipped polygon: lines of all slopes (along the axes, one subpixel off them, long ones), and
// stipples, whose pieces are clipped one by one. The rounding to 1/65535 may go the other way at a half: 1 unit.
TEST(LineArea, IsThatOfTheClippedPolygon) {
  std::mt19937 rng(16);
  uint32_t inside = 0, partial = 0;
  for (int round = 0; round < 4000; ++round) {
    const auto coordinate = [&](int32_t range) { return static_cast<int32_t>(rng() % (range * 256)); };
    const int32_t range = round % 4 == 0 ? 16000 : 24;
    const int32_t ax = coordinate(range), ay = coordinate(range), few = static_cast<int32_t>(rng() % 3) - 1;
    int32_t bx = coordinate(range), by = coordinate(range);
    if (round % 5 == 1) bx = ax + few;
    if (round % 5 == 2) by = ay + few;
    if (std::hypot(bx - ax, by - ay) < 2) continue;
    const Triangle line = line_record(ax, ay, bx, by, std::array{1.0, 3.5, 20.0}[rng() % 3]);
    const bool stippled = round % 3 == 0;
    const LineState state{LineMode::kSmooth, stippled, static_cast<uint16_t>(rng()), static_cast<uint32_t>(1 + rng() % 2), 1};
    const LineStipple stipple(line, state);
    const auto corner = [&](double t, double s) {  // of the record, in px: along and across
      return End{(line.x_fx8[0] + (line.x_fx8[1] - line.x_fx8[0]) * t + (line.x_fx8[2] - line.x_fx8[0]) * s) / kSubpixels,
                 (line.y_fx8[0] + (line.y_fx8[1] - line.y_fx8[0]) * t + (line.y_fx8[2] - line.y_fx8[0]) * s) / kSubpixels};
    };
    const double where = static_cast<double>(rng() % 1000) / 999;
    const End near = corner(where, static_cast<double>(rng() % 1000) / 999);
    const auto block_x = static_cast<int32_t>(std::floor(near.x / 4)) * 4,
               block_y = static_cast<int32_t>(std::floor(near.y / 4)) * 4;
    double expected[kLanes] = {};
    const double length = stipple.length_px();
    const auto first = static_cast<int64_t>(std::max(0.0, where * length - 40)), end = static_cast<int64_t>(where * length + 40);
    for (int64_t u = first; u < (stippled ? end : first + 1); ++u) {
      if (stippled && (static_cast<double>(u) >= length || !stipple.draws_unit(u))) continue;
      const double t0 = stippled ? static_cast<double>(u) / length : 0,
                   t1 = stippled ? std::min(1.0, static_cast<double>(u + 1) / length) : 1;
      for (uint32_t lane = 0; lane < kLanes; ++lane) {
        const auto x = block_x + static_cast<int32_t>(morton_x(lane)), y = block_y + static_cast<int32_t>(morton_y(lane));
        expected[lane] += clipped_area({corner(t0, 0), corner(t1, 0), corner(t1, 1), corner(t0, 1)}, x, y);
      }
    }
    uint16_t reference[kLanes];
    for (const Isa isa : {Isa::kSse42, Isa::kAvx2, Isa::kAvx512}) {
      if (isa > best_isa()) continue;
      uint16_t parts[kLanes];
      LineArea(line, state, stippled, isa).block(block_x, block_y, parts);
      if (isa == Isa::kSse42) std::ranges::copy(parts, reference);
      for (uint32_t lane = 0; lane < kLanes; ++lane) {
        ASSERT_EQ(parts[lane], reference[lane]) << "round " << round << " lane " << lane << " isa " << static_cast<int>(isa);
        ASSERT_NEAR(parts[lane], expected[lane] * 65535, 1) << "round " << round << " lane " << lane << " stippled " << stippled;
        inside += parts[lane] == LineArea::kFull;
        partial += parts[lane] != 0 && parts[lane] != LineArea::kFull;
      }
    }
  }
  EXPECT_GT(inside, 10000u);
  EXPECT_GT(partial, 10000u);
}

// Opposite halves of a rectangle, and the pieces of complementary stipples, make the whole, exactly but for the rounding to
// 1/65535.
TEST(SmoothLines, PiecesAddUp) {
  std::mt19937 rng(8);
  for (int round = 0; round < 100; ++round) {
    const End a{random_px(rng), random_px(rng)}, b{random_px(rng), random_px(rng)};
    const auto pattern = static_cast<uint16_t>(rng());
    Picture whole, pieces;
    TestDraw plain(4, area_kernel), some(4, area_kernel), others(4, area_kernel);
    plain.packet_base.line = {LineMode::kSmooth, false, 0, 1, 3};
    some.packet_base.line = {LineMode::kSmooth, true, pattern, 2, 3};
    others.packet_base.line = {LineMode::kSmooth, true, static_cast<uint16_t>(~pattern), 2, 3};
    whole.draw(plain, {a, b}, VK_PRIMITIVE_TOPOLOGY_LINE_LIST);
    pieces.draw(some, {a, b}, VK_PRIMITIVE_TOPOLOGY_LINE_LIST);
    pieces.draw(others, {a, b}, VK_PRIMITIVE_TOPOLOGY_LINE_LIST);
    for (uint32_t i = 0; i < kSize * kSize; ++i) ASSERT_NEAR(pieces.target.color[i], whole.target.color[i], 1);
  }
}

// "The rectangular region is subdivided into adjacent unit-length rectangles, and s is incremented once for each": in a strip the
// remainder carries over, in a list the pattern begins anew. With several samples, sample by sample.
TEST(RectangularLines, StippleRunsAlongTheLength) {
  std::mt19937 rng(9);
  for (int round = 0; round < 300; ++round) {
    const bool strip = round % 2 == 0;
    std::vector<End> ends;
    for (int i = 0; i < 4; ++i) ends.push_back({random_px(rng), random_px(rng)});
    const auto pattern = static_cast<uint16_t>(rng());
    const uint32_t factor = 1 + rng() % 4;
    constexpr float kWidth = 2.5f;
    Picture picture;
    TestDraw draw(4, count_kernel);
    draw.packet_base.line = {LineMode::kStrict, true, pattern, factor, kWidth};
    picture.draw(draw, ends, strip ? VK_PRIMITIVE_TOPOLOGY_LINE_STRIP : VK_PRIMITIVE_TOPOLOGY_LINE_LIST);
    for (uint32_t y = 0; y < kSize; ++y) {
      for (uint32_t x = 0; x < kSize; ++x) {
        uint32_t expected = 0;
        double start = 0;
        bool unclear = false;
        for (size_t i = 0; i + 1 < ends.size(); i += strip ? 1 : 2) {
          const Place p = place(ends[i], ends[i + 1], x + 0.5, y + 0.5);
          const double s = (strip ? start : 0) + p.along,
                       inside = std::min({p.along, p.length - p.along, kWidth / 2.0 - p.across});
          // The corners move by half a subpixel; the sides of the unit rectangles with them.
          constexpr double kSlack = 2.0 / 256;
          unclear |= std::fabs(inside) < kSlack || (inside > 0 && std::fabs(s - std::nearbyint(s)) < kSlack);
          expected += inside > 0 && pattern_draws(pattern, factor, s);
          start += p.length;
        }
        if (!unclear) {
          ASSERT_EQ(picture.target.at(x, y), expected) << x << ' ' << y << " round " << round;
        }
      }
    }
  }
}

// "The segment with endpoints (x0, y0 - (w - 1) / 2) ... is rasterized, but instead of a single fragment a column of fragments of
// height w is produced": by the pixels of the line of width 1 at those endpoints.
TEST(BresenhamLines, WideOnesAreColumns) {
  std::mt19937 rng(10);
  for (int round = 0; round < 400; ++round) {
    const End a{random_px(rng), random_px(rng)}, b{random_px(rng), random_px(rng)};
    const uint32_t width = 1 + rng() % 5;
    const bool y_major = std::fabs(a.x - b.x) < std::fabs(a.y - b.y);
    const double shift = (width - 1) / 2.0, dx = y_major ? shift : 0, dy = y_major ? 0 : shift;
    // On a larger target, so that nothing is cut: the base line moved by 8 px.
    Target base(32, 32), wide(32, 32);
    ThreadPool pool(1);
    const auto draw_line = [&](Target& target, float line_width, double ox, double oy) {
      TestDraw draw(4, count_kernel);
      draw.packet_base.topology = VK_PRIMITIVE_TOPOLOGY_LINE_LIST;
      draw.packet_base.line = {LineMode::kBresenham, false, 0, 1, line_width};
      for (const End& e : {a, b}) {
        add_window_vertex(draw, 32, 32, static_cast<float>(e.x + 8 - ox), static_cast<float>(e.y + 8 - oy));
      }
      Pass pass(pool, target.desc(), test_options());
      pass.draw(draw.packet(32, 32));
      pass.end();
    };
    draw_line(base, 1, dx, dy);
    draw_line(wide, static_cast<float>(width) - 0.25f, 0, 0);  // rounded
    std::vector<uint32_t> expected(32 * 32);
    for (uint32_t y = 0; y < 32; ++y) {
      for (uint32_t x = 0; x < 32; ++x) {
        for (uint32_t i = 0; base.at(x, y) != 0 && i < width; ++i)
          ++expected[(y + (y_major ? 0 : i)) * 32 + x + (y_major ? i : 0)];
      }
    }
    ASSERT_EQ(wide.color, expected) << "width " << width << " round " << round;
  }
}

// Lines are clipped to the view volume by their ends and then widened: what reaches over the viewport's side is drawn, as far as
// the scissor lets it, and a line beside the viewport is not there however wide it is.
TEST(RectangularLines, AreClippedBeforeTheyAreWidened) {
  for (const LineMode mode : {LineMode::kStrict, LineMode::kBresenham}) {
    ThreadPool pool(1);
    const auto draw_line = [&](End a, End b) {
      Target target(32, 32);
      TestDraw draw(4, count_kernel);
      draw.packet_base.topology = VK_PRIMITIVE_TOPOLOGY_LINE_LIST;
      draw.packet_base.line = {mode, false, 0, 1, 7};
      for (const End& e : {a, b}) add_window_vertex(draw, 16, 16, static_cast<float>(e.x - 8), static_cast<float>(e.y - 8));
      draw.packet_base.viewport = {8, 8, 16, 16, 0, 1};
      draw.packet_base.scissor = {{0, 0}, {32, 32}};
      DrawPacket packet = draw.packet(32, 32);
      packet.viewport = draw.packet_base.viewport;
      Pass pass(pool, target.desc(), test_options());
      pass.draw(packet);
      pass.end();
      return target;
    };
    // Along the upper side, from left of the viewport to right of it.
    const Target target = draw_line({0, 8.5}, {32, 8.5});
    for (uint32_t y = 0; y < 32; ++y) {
      for (uint32_t x = 0; x < 32; ++x) {
        // The clipped Bresenham line goes from 8 to 24 less a little: its start is still in the diamond of column 7, its end in
        // that of column 23.
        const uint32_t first = mode == LineMode::kStrict ? 8 : 7;
        const bool inside = x >= first && x < first + 16 && y >= 5 && y < 12;
        ASSERT_EQ(target.at(x, y), inside ? 1u : 0u) << x << ' ' << y << " mode " << static_cast<int>(mode);
      }
    }
    const Target beside = draw_line({0, 6.5}, {32, 6.5});
    for (const uint32_t v : beside.color) ASSERT_EQ(v, 0u);
  }
}

}  // namespace
}  // namespace pineda::raster
