// Groups of 16 triangles against the scalar reference of coverage, fragment_prim.h, and the scalar Hi-Z.
#include "raster/small_group.h"

#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <limits>
#include <map>
#include <random>
#include <vector>

#include "raster/fragment_prim.h"
#include "raster/hi_z.h"
#include "raster/test_coverage.h"

namespace pineda::raster {
namespace {

using namespace testing;

struct RandomGroup {
  int32_t size_px, tile_x, tile_y;
  std::array<Point, 3> vertices[kLanes];
  Triangle triangles[kLanes];
  Draw draws[2];
  Batch batches[kLanes];

  RandomGroup(std::mt19937& rng, int i) : size_px(16 << i % 3) {
    tile_x = static_cast<int32_t>(rng() % 200) * size_px;
    tile_y = static_cast<int32_t>(rng() % 200) * size_px;
    draws[0].packet.vertex_slots = 4;
    draws[1].packet.vertex_slots = 9 + static_cast<uint32_t>(i % 3);
    const uint32_t several = i % 2;  // batches in the group
    for (uint32_t k = 0; k < kLanes; ++k) {
      add(rng, k);
      const uint32_t batch = several * k / 3;
      // Addresses only; some carry into the upper half when vertices are added.
      batches[k] = {&draws[batch % 2], reinterpret_cast<const float*>(uintptr_t{0x7F01FFFFFFC0u} + batch * 64), batch % 3,
                    batch % 5};
    }
  }

  SmallGroup group() {
    SmallGroup g{};
    g.x_px = tile_x;
    g.y_px = tile_y;
    g.size_px = size_px;
    g.samples = 1;
    for (uint32_t k = 0; k < kLanes; ++k) {
      g.triangles[k] = &triangles[k];
      g.batches.set(k, batches[k]);
    }
    return g;
  }

 private:
  void add(std::mt19937& rng, uint32_t k) {
    auto& v = vertices[k];
    const int64_t radius = std::array{100, 500, 1000, 3000, 9000}[rng() % 5];
    const auto in_tile = [&](int32_t first_px) {
      return first_px * 256 + static_cast<int64_t>(rng() % (static_cast<uint32_t>(size_px) * 256));
    };
    const Point center{in_tile(tile_x), in_tile(tile_y)};
    do {
      for (Point& p : v) {
        const Point d = random_point(rng, 0, radius);
        p = {center.x + d.x, center.y + d.y};
        if (k % 3 == 0) p = {p.x / 128 * 128, p.y / 128 * 128};  // samples on edges and vertices
      }
    } while ((v[1].x - v[0].x) * (v[2].y - v[0].y) == (v[1].y - v[0].y) * (v[2].x - v[0].x));
    Triangle& t = triangles[k] = make_triangle(v);
    std::uniform_real_distribution<float> depth(0, 1);
    t.z0 = depth(rng);
    t.dz1 = depth(rng) - t.z0;
    t.dz2 = (depth(rng) - t.z0) * 1e-6f;
    for (float& iw : t.iw) iw = depth(rng);
    t.primitive_id = static_cast<uint32_t>(rng());
    for (uint16_t& vertex : t.vertex) vertex = rng() % 1536;
    t.set_flags(rng() % 3 == 0 ? 1535 : t.vertex[0], rng() % 2, (t.provoking_and_flags & Triangle::kClockwise) != 0,
                rng() % 16 == 0 ? Shape::kParallelogram : Shape::kTriangle);
  }
};

std::vector<bool> expected_pixels(const RandomGroup& random, uint32_t k) {
  const int32_t size = random.size_px;
  std::vector<bool> pixels(static_cast<size_t>(size * size));
  for (int32_t p = 0; p < size * size; ++p) {
    pixels[static_cast<size_t>(p)] =
        covers(random.vertices[k], {(random.tile_x + p % size) * 256 + 128, (random.tile_y + p / size) * 256 + 128});
  }
  return pixels;
}

void add_wave(const RandomGroup& random, uint32_t mask, uint32_t xy_px, uint32_t block, std::vector<bool>& pixels) {
  const auto size = static_cast<uint32_t>(random.size_px);
  const uint32_t x = (xy_px & 0xFFFF) - static_cast<uint32_t>(random.tile_x),
                 y = (xy_px >> 16) - static_cast<uint32_t>(random.tile_y);
  EXPECT_EQ(morton(x / 4, y / 4), block);
  for (uint32_t lane = 0; lane < kLanes; ++lane) {
    if (!(mask >> lane & 1)) continue;
    const uint32_t px = x + morton_x(lane), py = y + morton_y(lane);
    ASSERT_LT(px, size);
    ASSERT_LT(py, size);
    pixels[py * size + px] = true;
  }
}

std::vector<bool> group_pixels(const RandomGroup& random, const SmallGroup& group, uint32_t k, Isa isa) {
  std::vector<bool> pixels(static_cast<size_t>(random.size_px * random.size_px));
  if (group.small >> k & 1) {
    for (uint32_t b = 0; b < 4; ++b) {
      const auto mask = static_cast<uint32_t>(group.masks[b][k]);
      if (mask != 0)
        add_wave(random, mask, static_cast<uint32_t>(group.xy_px[b][k]), static_cast<uint32_t>(group.block[b][k]), pixels);
    }
  } else {
    FragmentWave waves[kMaxTileBlocks + 1];
    const uint32_t tile_xy_px = static_cast<uint32_t>(random.tile_x) + (static_cast<uint32_t>(random.tile_y) << 16);
    const uint32_t count = coverage_functions(isa).cover(group.edges[k], group.blocks[k], tile_xy_px, waves);
    for (uint32_t i = 0; i < count; ++i) {
      add_wave(random, waves[i].coverage, waves[i].x_px + (static_cast<uint32_t>(waves[i].y_px) << 16), waves[i].block_index,
               pixels);
    }
  }
  return pixels;
}

TEST(SmallGroup, EqualsScalarReference) {
  constexpr uint32_t kSeed = 31;
  SCOPED_TRACE(kSeed);
  std::mt19937 rng(kSeed);
  uint32_t small_count = 0, near_count = 0, far_count = 0;
  for (int i = 0; i < 600; ++i) {
    RandomGroup random(rng, i);
    for (const Isa isa : isas()) {
      SmallGroup group = random.group();
      small_group_function(isa)(group);
      EXPECT_EQ(group.small & ~group.near, 0u);
      for (uint32_t k = 0; k < kLanes; ++k) {
        const Triangle& t = random.triangles[k];
        if (!(group.near >> k & 1)) {
          EXPECT_EQ(group.seen >> k & 1, 0u);
          ++far_count;
          continue;
        }
        ASSERT_EQ(t.shape(), Shape::kTriangle);
        ++(group.small >> k & 1 ? small_count : near_count);
        const std::vector<bool> got = group_pixels(random, group, k, isa), expected = expected_pixels(random, k);
        ASSERT_EQ(got, expected) << "group " << i << " triangle " << k << " isa " << static_cast<int>(isa);
        const bool covered = std::count(got.begin(), got.end(), true) != 0;
        if (group.small >> k & 1) {
          EXPECT_EQ((group.seen >> k & 1) != 0, covered);
        }
        if (!covered) continue;
        FragmentPrim prim;
        std::memset(static_cast<void*>(&prim), 0, sizeof prim);
        fill_planes(t, prim);
        fill_prim(t, random.batches[k], prim);
        ASSERT_EQ(std::memcmp(&prim, &group.prims[k], sizeof prim), 0)
            << "group " << i << " triangle " << k << " isa " << static_cast<int>(isa);
      }
    }
  }
  EXPECT_GT(small_count, 5000u);
  EXPECT_GT(near_count, 5000u);
  EXPECT_GT(far_count, 1000u);
}

// The scalar Hi-Z decides the same, whatever the bounds are.
TEST(SmallGroup, HidesWhatTheScalarHiZHides) {
  constexpr uint32_t kSeed = 37;
  SCOPED_TRACE(kSeed);
  std::mt19937 rng(kSeed);
  std::uniform_real_distribution<float> depth(0, 1);
  uint32_t hidden_count = 0, seen_count = 0;
  for (int i = 0; i < 200; ++i) {
    RandomGroup random(rng, i);
    Draw draw;
    draw.hi_z = i % 4 < 2 ? HiZMode::kLess : HiZMode::kGreater;
    const float sign = draw.hi_z == HiZMode::kLess ? 1.0f : -1.0f;
    draw.packet.viewport = {0, 0, 1, 1, 0.25f, 0.75f};
    if (i % 8 == 0) random.triangles[3].dz1 = std::numeric_limits<float>::quiet_NaN();
    float farthest[kMaxTileBlocks];
    for (float& z : farthest) z = sign * depth(rng);
    const SmallHiZ hi_z{sign, depth_ceiling(draw, 0), farthest};
    const TilePosition tile{random.tile_x, random.tile_y, random.size_px, {}, 0};
    for (const Isa isa : isas()) {
      SmallGroup open = random.group(), group = random.group();
      small_group_function(isa)(open);
      group.hi_z = &hi_z;
      small_group_function(isa)(group);
      uint32_t hidden = 0;
      for (uint32_t k = 0; k < kLanes; ++k) {
        if (!(open.seen >> k & 1)) continue;
        FragmentPrim prim = open.prims[k];
        prim.viewport_index = 0;
        const float least = least_depth(prim, draw, tile);
        if (least == least) {
          EXPECT_EQ(group.least[k], least);
        }
        for (uint32_t b = 0; b < 4; ++b) {
          const bool hides = open.masks[b][k] != 0 && least > farthest[open.block[b][k]];
          hidden += hides;
          EXPECT_EQ(group.masks[b][k], hides ? 0 : open.masks[b][k]);
        }
      }
      EXPECT_EQ(group.hidden, hidden);
      hidden_count += hidden;
      seen_count += static_cast<uint32_t>(__builtin_popcount(group.seen));
    }
  }
  EXPECT_GT(hidden_count, 500u);
  EXPECT_GT(seen_count, 500u);
}

// Covered samples of the tile, by block.
using BlockSamples = std::map<uint32_t, std::array<uint16_t, kLanes>>;
BlockSamples covered_samples(const RandomGroup& random, CoverSamplesFn cover, const SampleEdges& edges, const BlockRange& range) {
  static FragmentSampleWave waves[kMaxTileBlocks + 1];
  const uint32_t tile_xy_px = static_cast<uint32_t>(random.tile_x) + (static_cast<uint32_t>(random.tile_y) << 16);
  const uint32_t count = cover(edges, range, tile_xy_px, waves);
  BlockSamples samples;
  for (uint32_t i = 0; i < count; ++i) std::copy_n(waves[i].samples, kLanes, samples[waves[i].wave.block_index].begin());
  return samples;
}

// coverage_samples_test.cpp holds make_sample_edges() against the rule.
TEST(SmallGroup, SampleEdgesCoverAsTheScalarOnes) {
  constexpr uint32_t kSeed = 41;
  SCOPED_TRACE(kSeed);
  std::mt19937 rng(kSeed);
  uint32_t covered_count = 0, empty_count = 0;
  for (int i = 0; i < 400; ++i) {
    RandomGroup random(rng, i);
    const uint32_t samples = 2u << i % 4, side = static_cast<uint32_t>(random.size_px) / kBlockDim;
    for (const Isa isa : isas()) {
      const CoverSamplesFn cover = cover_samples_function(isa, samples);
      SmallGroup group = random.group();
      group.samples = samples;
      small_group_function(isa)(group);
      EXPECT_EQ(group.small | group.seen, 0u);
      for (uint32_t k = 0; k < kLanes; ++k) {
        if (!(group.near >> k & 1)) continue;
        BlockSamples expected;
        SampleEdges edges;
        if (make_sample_edges(random.triangles[k], random.tile_x, random.tile_y, random.size_px, samples, edges) !=
            TileCover::kNone)
          expected = covered_samples(random, cover, edges, {0, 0, side, side});
        ASSERT_EQ(covered_samples(random, cover, group.sample_edges[k], group.blocks[k]), expected)
            << "group " << i << " triangle " << k << " samples " << samples << " isa " << static_cast<int>(isa);
        ++(expected.empty() ? empty_count : covered_count);
      }
    }
  }
  EXPECT_GT(covered_count, 5000u);
  EXPECT_GT(empty_count, 100u);
}

}  // namespace
}  // namespace pineda::raster
