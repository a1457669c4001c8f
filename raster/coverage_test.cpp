// Coverage against a scalar 64-bit reference written from the rule alone.
#include "raster/coverage.h"

#include <gtest/gtest.h>

#include <array>
#include <random>
#include <vector>

#include "raster/test_coverage.h"
#include "raster/test_scene.h"

namespace pineda::raster {
namespace {

using namespace testing;

// The tile's pixels by the code under test, as a bit for each pixel.
std::vector<bool> tile_pixels(CoverFn cover, const Triangle& t, int32_t x, int32_t y, int32_t size) {
  std::vector<bool> pixels(static_cast<size_t>(size * size));
  TileEdges edges{};
  const TileCover kind = make_tile_edges(t, x, y, size, edges);
  if (kind == TileCover::kNone) return pixels;
  FragmentWave blocks[kMaxTileBlocks + 1];
  const auto all = static_cast<uint32_t>(size) / 4;
  const uint32_t count = cover(edges, {0, 0, all, all}, static_cast<uint32_t>(x) + (static_cast<uint32_t>(y) << 16), blocks);
  for (uint32_t i = 0; i < count; ++i) {
    EXPECT_EQ(blocks[i].exec_mask, 0xFFFFu);
    EXPECT_EQ(blocks[i].x_px, static_cast<uint32_t>(x) + morton_x(blocks[i].block_index) * 4);
    EXPECT_EQ(blocks[i].y_px, static_cast<uint32_t>(y) + morton_y(blocks[i].block_index) * 4);
    for (uint32_t lane = 0; lane < kLanes; ++lane) {
      if (!(blocks[i].coverage >> lane & 1)) continue;
      const uint32_t px = morton_x(blocks[i].block_index) * 4 + morton_x(lane),
                     py = morton_y(blocks[i].block_index) * 4 + morton_y(lane);
      EXPECT_FALSE(pixels[py * static_cast<uint32_t>(size) + px]) << "a block was reported twice";
      pixels[py * static_cast<uint32_t>(size) + px] = true;
    }
  }
  if (kind == TileCover::kFull) {
    EXPECT_EQ(std::count(pixels.begin(), pixels.end(), true), size * size);
  }
  return pixels;
}

TEST(Coverage, EqualsScalarReferenceOnEveryIsa) {
  constexpr uint32_t kSeed = 20240601;
  SCOPED_TRACE(kSeed);
  std::mt19937 rng(kSeed);
  const int64_t radii_fx8[] = {40,    200,    900,     5000,
                               20000, 200000, 4000000, 12000000};  // from below a pixel to the whole guard band
  for (int i = 0; i < 4000; ++i) {
    const int64_t radius = radii_fx8[i % 8];
    const int32_t size = 16 << i / 8 % 3;
    const int32_t tile_x = static_cast<int32_t>(rng() % 8) * size, tile_y = static_cast<int32_t>(rng() % 8) * size;
    const int64_t center = tile_x + size / 2;
    std::array<Point, 3> v{random_point(rng, center, radius), random_point(rng, center, radius),
                           random_point(rng, center, radius)};
    if (i % 5 == 0) v[2] = {v[0].x + static_cast<int64_t>(rng() % 300), v[0].y + static_cast<int64_t>(rng() % 300)};  // slivers
    if (i % 7 == 0)
      for (Point& p : v) p = {p.x / 128 * 128, p.y / 128 * 128};  // samples on edges
    if (i % 3 == 0) {                                             // an upright or level edge through samples
      v[0] = {v[0].x / 256 * 256 + 128, v[0].y / 256 * 256 + 128};
      if (i % 2) {
        v[1].y = v[0].y;
      } else {
        v[1].x = v[0].x;
      }
    }
    for (Point& p : v) p.y += (tile_y - tile_x) * 256;
    for (Point& p : v) p = {std::clamp<int64_t>(p.x, kMinFx8, kMaxFx8), std::clamp<int64_t>(p.y, kMinFx8, kMaxFx8)};
    const Triangle t = make_triangle(v);
    if ((v[1].x - v[0].x) * (v[2].y - v[0].y) == (v[1].y - v[0].y) * (v[2].x - v[0].x)) continue;  // setup drops these
    std::vector<bool> expected(static_cast<size_t>(size * size));
    for (int32_t y = 0; y < size; ++y) {
      for (int32_t x = 0; x < size; ++x) {
        expected[static_cast<size_t>(y * size + x)] = covers(v, {(tile_x + x) * 256 + 128, (tile_y + y) * 256 + 128});
      }
    }
    for (const Isa isa : isas()) {
      ASSERT_EQ(tile_pixels(coverage_functions(isa).cover, t, tile_x, tile_y, size), expected)
          << "triangle " << i << " isa " << static_cast<int>(isa);
    }
  }
}

TEST(Coverage, ExtremeTrianglesDoNotOverflow) {
  const int64_t lo = kMinFx8, hi = kMaxFx8;
  const std::array<std::array<Point, 3>, 4> extremes{{{{{lo, lo}, {hi, lo}, {lo, hi}}},
                                                      {{{lo, lo}, {hi, hi}, {lo + 1, lo}}},
                                                      {{{hi, lo}, {lo, hi}, {hi, lo + 1}}},
                                                      {{{lo, hi}, {hi, lo}, {hi, hi}}}}};
  for (const auto& v : extremes) {
    for (const int32_t at : {0, 64, 8192, 16320}) {
      for (const Isa isa : isas()) {
        const std::vector<bool> got = tile_pixels(coverage_functions(isa).cover, make_triangle(v), at, at, 64);
        for (int32_t i = 0; i < 64 * 64; ++i) {
          ASSERT_EQ(got[static_cast<size_t>(i)], covers(v, {(at + i % 64) * 256 + 128, (at + i / 64) * 256 + 128}))
              << at << " pixel " << i;
        }
      }
    }
  }
}

// Random triangulations of a rectangle, drawn through the whole pipeline: every pixel exactly once, whatever the tile size.
TEST(Coverage, SharedEdgesCoverEveryPixelOnce) {
  constexpr uint32_t kSeed = 77;
  constexpr uint32_t kSize = 128;
  std::mt19937 rng(kSeed);
  for (const uint32_t tile : {16u, 32u, 64u}) {
    for (const int cells : {3, 17, 60}) {
      // Positions are multiples of 1/256 px in a 128 px viewport, so every shared vertex snaps alike by construction of the
      // pipeline too.
      std::vector<Point> grid;
      const int n = cells + 1;
      const double step = 128.0 * 256 / cells;
      for (int y = 0; y < n; ++y) {
        for (int x = 0; x < n; ++x) {
          const bool rim_x = x == 0 || x == cells, rim_y = y == 0 || y == cells;
          std::uniform_real_distribution<double> jitter(-0.3 * step, 0.3 * step);
          grid.push_back({std::lround(x * step + (rim_x ? 0 : jitter(rng))), std::lround(y * step + (rim_y ? 0 : jitter(rng)))});
        }
      }
      TestDraw draw(4, count_kernel);
      const auto add = [&](int x, int y) {
        const Point p = grid[static_cast<size_t>(y * n + x)];
        add_window_vertex(draw, kSize, kSize, static_cast<float>(p.x) / 256, static_cast<float>(p.y) / 256);
      };
      for (int y = 0; y < cells; ++y) {
        for (int x = 0; x < cells; ++x) {
          if (rng() & 1) {
            add(x, y), add(x + 1, y), add(x, y + 1), add(x, y + 1), add(x + 1, y), add(x + 1, y + 1);
          } else {
            add(x, y), add(x + 1, y), add(x + 1, y + 1), add(x, y), add(x + 1, y + 1), add(x, y + 1);
          }
        }
      }
      Target target(kSize, kSize);
      ThreadPool pool(2);
      Options options = test_options();
      options.tile_px = tile;
      Pass pass(pool, target.desc(), options);
      pass.draw(draw.packet(kSize, kSize));
      pass.end();
      for (uint32_t i = 0; i < kSize * kSize; ++i)
        ASSERT_EQ(target.color[i], 1u) << "pixel " << i << " tile " << tile << " cells " << cells;
    }
  }
}

}  // namespace
}  // namespace pineda::raster
