// Set-up of 16 triangles at once against the rules in 64 bits.
#include "raster/small_setup.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>

#include "raster/triangle_record.h"

namespace pineda::raster {
namespace {

constexpr Rect kRect{3, 5, 90, 70};
constexpr uint32_t kTileShift = 4, kTileColumns = 6;

SmallSetupState state_of(bool cull_clockwise, bool cull_counter_clockwise, bool one_sample) {
  return {kRect, cull_clockwise, cull_counter_clockwise, one_sample, false, 0, kTileShift, kTileColumns};
}

// Whether pixel (px, py)'s centre is inside; the triangle is oriented first. coverage.h's rule.
bool covers(const SmallSetup& g, uint32_t i, int32_t px, int32_t py, int64_t area) {
  for (int k = 0; k < 3; ++k) {
    const int n = (k + 1) % 3;
    const int64_t sign = area > 0 ? 1 : -1;
    const int64_t a = sign * (int64_t{g.y_fx8[k][i]} - g.y_fx8[n][i]), b = sign * (int64_t{g.x_fx8[n][i]} - g.x_fx8[k][i]);
    const int64_t e = a * (px * 256 + 128 - g.x_fx8[k][i]) + b * (py * 256 + 128 - g.y_fx8[k][i]);
    if (e < 0 || (e == 0 && !(a > 0 || (a == 0 && b > 0)))) return false;
  }
  return true;
}

void check(const SmallSetup& g, uint32_t i, const SmallSetupState& state) {
  const int32_t x0 = g.x_fx8[0][i], x1 = g.x_fx8[1][i], x2 = g.x_fx8[2][i];
  const int32_t y0 = g.y_fx8[0][i], y1 = g.y_fx8[1][i], y2 = g.y_fx8[2][i];
  const auto extent = [](int32_t a, int32_t b, int32_t c) { return std::max({a, b, c}) - std::min({a, b, c}); };
  const bool small = extent(x0, x1, x2) <= 64 * 256 && extent(y0, y1, y2) <= 64 * 256;
  ASSERT_EQ((g.small >> i & 1) != 0, small);
  if (!small) return;
  const int64_t area = int64_t{x1 - x0} * (y2 - y0) - int64_t{y1 - y0} * (x2 - x0);
  const Rect box =
      intersect(state.one_sample ? pixel_bounds(x0, x1, x2, y0, y1, y2) : touched_bounds(x0, x1, x2, y0, y1, y2), state.rect);
  bool drawn = area != 0 && !box.empty() && !(area > 0 ? state.cull_clockwise : state.cull_counter_clockwise);
  if (drawn && state.one_sample && box.x1 - box.x0 <= 2 && box.y1 - box.y0 <= 2) {
    bool any = false;
    for (int32_t y = box.y0; y < box.y1; ++y) {
      for (int32_t x = box.x0; x < box.x1; ++x) any |= covers(g, i, x, y, area);
    }
    drawn = any;
  }
  ASSERT_EQ((g.drawn >> i & 1) != 0, drawn) << x0 << ' ' << y0 << ' ' << x1 << ' ' << y1 << ' ' << x2 << ' ' << y2;
  if (!drawn) return;
  EXPECT_EQ((g.clockwise >> i & 1) != 0, area > 0);
  EXPECT_EQ((Rect{g.x0[i], g.y0[i], g.x1[i], g.y1[i]}), box);
  const auto tile_of = [](int32_t x, int32_t y) {
    return (y >> kTileShift) * static_cast<int32_t>(kTileColumns) + (x >> kTileShift);
  };
  const bool one_tile = tile_of(box.x0, box.y0) == tile_of(box.x1 - 1, box.y1 - 1);
  EXPECT_EQ(g.tile[i], one_tile ? tile_of(box.x0, box.y0) : -1);
}

TEST(SmallSetup, DecidesAsTheRulesDo) {
  for (const Isa isa : {Isa::kSse42, Isa::kAvx2, Isa::kAvx512}) {
    if (isa > best_isa()) continue;
    std::mt19937 rng(51);
    for (int round = 0; round < 6000; ++round) {
      const SmallSetupState state = state_of(rng() % 4 == 0, rng() % 4 == 0, rng() % 4 != 0);
      const int32_t span = std::array{300, 700, 5000, 40000}[rng() % 4], step = std::array{1, 64, 128}[rng() % 3];
      SmallSetup group{};
      for (int i = 0; i < 16; ++i) {
        const auto x = static_cast<int32_t>(rng() % 30000) - 3000, y = static_cast<int32_t>(rng() % 25000) - 3000;
        for (int k = 0; k < 3; ++k) {
          group.x_fx8[k][i] = (x + static_cast<int32_t>(rng() % static_cast<uint32_t>(span))) / step * step;
          group.y_fx8[k][i] = (y + static_cast<int32_t>(rng() % static_cast<uint32_t>(span))) / step * step;
        }
      }
      small_setup_function(isa)(state, group);
      for (uint32_t i = 0; i < 16; ++i) ASSERT_NO_FATAL_FAILURE(check(group, i, state));
    }
  }
}

// Coordinates at the ends of fixed point: large triangles, whose area does not fit 32 bits, are left to others.
TEST(SmallSetup, LargeTrianglesAreNotSmall) {
  for (const Isa isa : {Isa::kSse42, Isa::kAvx2, Isa::kAvx512}) {
    if (isa > best_isa()) continue;
    SmallSetup group{};
    for (int i = 0; i < 16; ++i) {
      group.x_fx8[0][i] = kMinFx8;
      group.x_fx8[1][i] = kMaxFx8;
      group.y_fx8[2][i] = i % 2 != 0 ? kMaxFx8 : kMinFx8;
    }
    small_setup_function(isa)(state_of(false, false, true), group);
    EXPECT_EQ(group.small, 0u);
  }
}

TEST(SmallSetup, GathersTheVerticesOfEachTriangle) {
  static WindowVertices window;
  static BatchPrims prims;
  std::mt19937 rng(52);
  for (uint32_t v = 0; v < kBatchVertices; ++v) {
    window.x_fx8[v] = static_cast<int32_t>(rng());
    window.y_fx8[v] = static_cast<int32_t>(rng());
    window.code[v] = rng() % 8 == 0 ? static_cast<uint16_t>(1u << rng() % 16) : uint16_t{0};
  }
  for (auto& vertex : prims.vertex) {
    for (uint16_t& v : vertex) v = static_cast<uint16_t>(rng() % kBatchVertices);
  }
  prims.vertex[2][17] = kBatchVertices - 1;  // the last word
  for (const Isa isa : {Isa::kSse42, Isa::kAvx2, Isa::kAvx512}) {
    if (isa > best_isa()) continue;
    for (uint32_t first = 0; first < kBatchPrims; first += 16) {
      SmallSetup group{};
      small_gather_function(isa)(window, prims, first, group);
      for (uint32_t i = 0; i < 16; ++i) {
        uint32_t codes = 0;
        for (int k = 0; k < 3; ++k) {
          const uint16_t v = prims.vertex[k][first + i];
          ASSERT_EQ(group.x_fx8[k][i], window.x_fx8[v]);
          ASSERT_EQ(group.y_fx8[k][i], window.y_fx8[v]);
          codes |= window.code[v];
        }
        ASSERT_EQ((group.unclipped >> i & 1) != 0, codes == 0);
      }
    }
  }
}

TEST(SmallSetup, RecordsEqualTheScalarOnes) {
  constexpr uint32_t kSeed = 53;
  SCOPED_TRACE(kSeed);
  static WindowVertices window;
  static BatchPrims prims;
  std::mt19937 rng(kSeed);
  std::uniform_real_distribution<float> unit(0, 1);
  for (uint32_t v = 0; v < kBatchVertices; ++v) {
    window.x_fx8[v] = static_cast<int32_t>(rng() % 5000);
    window.y_fx8[v] = static_cast<int32_t>(rng() % 5000);
    window.z[v] = unit(rng);
    window.iw[v] = v % 3 == 0 ? std::exp2(unit(rng) * 40 - 20) : unit(rng);  // some triangles are put in order of distance
  }
  for (auto& vertex : prims.vertex) {
    for (uint16_t& v : vertex) v = static_cast<uint16_t>(rng() % kBatchVertices);
  }
  uint32_t turned = 0;
  for (const Isa isa : {Isa::kSse42, Isa::kAvx2, Isa::kAvx512}) {
    if (isa > best_isa()) continue;
    for (uint32_t first = 0; first < kBatchPrims; first += 16) {
      SmallSetup group{};
      SmallSetupState state = state_of(false, false, true);
      state.front_is_clockwise = first / 16 % 2 != 0;
      state.batch = first;
      for (uint32_t& id : group.primitive_id) id = static_cast<uint32_t>(rng());
      small_gather_function(isa)(window, prims, first, group);
      small_setup_function(isa)(state, group);
      small_records_function(isa)(window, prims, first, state, group);
      for (uint32_t i = 0; i < 16; ++i) {
        const std::array<uint16_t, 3> v{prims.vertex[0][first + i], prims.vertex[1][first + i], prims.vertex[2][first + i]};
        const bool clockwise = (group.clockwise >> i & 1) != 0;
        if (!(group.small >> i & 1)) continue;
        Triangle expected{};
        fill_record(window, v, {group.primitive_id[i], first, v[0], clockwise == state.front_is_clockwise, clockwise}, expected);
        ASSERT_EQ(std::memcmp(&expected, &group.records[i], sizeof expected), 0) << "isa " << static_cast<int>(isa) << ' ' << i;
        turned += expected.vertex[0] != v[0];
      }
    }
  }
  EXPECT_GT(turned, 100u);
}

}  // namespace
}  // namespace pineda::raster
