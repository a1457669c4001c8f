// Hi-Z never hides a block that has a passing fragment: brute force over all fragments, depths as close to the triangle's as they
// can be.
#include "raster/hi_z.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

#include "raster/test_scene.h"

namespace pineda::raster {
namespace {

using namespace testing;

constexpr int32_t kSize = 32;
constexpr uint32_t kBlocks = kSize * kSize / 16;

// A stored depth, and how a fragment's depth becomes one.
struct DepthCodec {
  VkFormat format;
  uint32_t bytes, steps;  // steps == 0: float

  double round(float z) const { return steps == 0 ? z : std::nearbyint(std::clamp(double{z}, 0.0, 1.0) * steps); }
  void store(uint8_t* buffer, uint32_t texel, double stored) const {
    if (steps == 0) {
      const auto f = static_cast<float>(stored);
      std::memcpy(buffer + texel * 4, &f, 4);
    } else {
      const auto v = static_cast<uint32_t>(stored) | (bytes == 4 ? 0xAB000000u : 0);  // the unused bits of X8_D24 hold anything
      std::memcpy(buffer + texel * bytes, &v, bytes);
    }
  }
};

FragmentPrim random_prim(std::mt19937& rng, const TilePosition& tile, bool sliver) {
  std::uniform_real_distribution<float> at(-30, 62), z(0.0f, 1.0f);
  double x[3], y[3];
  for (int k = 0; k < 3; ++k) {
    x[k] = std::nearbyint((tile.x_px + at(rng)) * 256) / 256;
    y[k] = std::nearbyint((tile.y_px + at(rng)) * 256) / 256;
  }
  if (sliver) x[2] = (x[0] + x[1]) / 2, y[2] = (y[0] + y[1]) / 2 + 1.0 / 64;
  const double x1 = x[1] - x[0], y1 = y[1] - y[0], x2 = x[2] - x[0], y2 = y[2] - y[0], area = x1 * y2 - y1 * x2;
  FragmentPrim p{};
  p.x0_px = static_cast<float>(x[0]);
  p.y0_px = static_cast<float>(y[0]);
  p.l1_dx = static_cast<float>(y2 / area);
  p.l1_dy = static_cast<float>(-x2 / area);
  p.l2_dx = static_cast<float>(-y1 / area);
  p.l2_dy = static_cast<float>(x1 / area);
  const float spread = std::array{1.0f, 1e-4f, 1e-6f, 1e-7f}[rng() % 4];  // the flattest are nothing but rounding
  p.z0 = z(rng);
  p.dz1 = (z(rng) - p.z0) * spread;
  p.dz2 = (z(rng) - p.z0) * spread;
  return p;
}

// The depth at a pixel, by either of the ways a kernel may evaluate abi.h's formula: with and without fused multiply-adds.
float depth_at(const FragmentPrim& p, float dx, float dy, bool fused) {
  if (!fused) {
    const float l1 = p.l1_dx * dx + p.l1_dy * dy, l2 = p.l2_dx * dx + p.l2_dy * dy;
    return p.z0 + l1 * p.dz1 + l2 * p.dz2;
  }
  const float l1 = std::fma(p.l1_dx, dx, p.l1_dy * dy), l2 = std::fma(p.l2_dx, dx, p.l2_dy * dy);
  return std::fma(l2, p.dz2, std::fma(l1, p.dz1, p.z0));
}

TEST(HiZ, NeverHidesAPassingFragment) {
  constexpr uint32_t kSeed = 99;
  std::mt19937 rng(kSeed);
  const DepthCodec codecs[] = {
      {VK_FORMAT_D32_SFLOAT, 4, 0}, {VK_FORMAT_D16_UNORM, 2, 0xFFFF}, {VK_FORMAT_X8_D24_UNORM_PACK32, 4, 0xFFFFFF}};
  uint64_t hidden = 0, passing_blocks = 0;
  for (int i = 0; i < 3000; ++i) {
    const DepthCodec& codec = codecs[i % 3];
    const VkCompareOp op = std::array{VK_COMPARE_OP_LESS, VK_COMPARE_OP_LESS_OR_EQUAL, VK_COMPARE_OP_GREATER,
                                      VK_COMPARE_OP_GREATER_OR_EQUAL}[static_cast<size_t>(i / 3 % 4)];
    const bool greater = op == VK_COMPARE_OP_GREATER || op == VK_COMPARE_OP_GREATER_OR_EQUAL;
    const TilePosition tile{static_cast<int32_t>(rng() % 100) * kSize, static_cast<int32_t>(rng() % 100) * kSize, kSize, {}};
    const FragmentPrim prim = random_prim(rng, tile, i % 10 == 0);
    alignas(64) uint8_t buffer[kSize * kSize * 4];
    bool passes_somewhere[kBlocks] = {}, covered[kBlocks] = {};
    for (uint32_t block = 0; block < kBlocks; ++block) {
      // A block's depths lie a little in front of or behind the triangle at one of its pixels.
      const double offset = std::ldexp(1.0, -static_cast<int>(rng() % 26)) * (rng() % 2 ? 1 : -1) * (rng() % 3 != 0);
      for (uint32_t lane = 0; lane < kLanes; ++lane) {
        const float dx =
            static_cast<float>(tile.x_px) + static_cast<float>(morton_x(block) * 4 + morton_x(lane)) + 0.5f - prim.x0_px;
        const float dy =
            static_cast<float>(tile.y_px) + static_cast<float>(morton_y(block) * 4 + morton_y(lane)) + 0.5f - prim.y0_px;
        const float z = depth_at(prim, dx, dy, rng() % 2 != 0);
        const double stored = codec.round(static_cast<float>(std::clamp(z + offset, 0.0, 1.0)));
        codec.store(buffer, block * kLanes + lane, stored);
        const double l1 = double{prim.l1_dx} * dx + double{prim.l1_dy} * dy,
                     l2 = double{prim.l2_dx} * dx + double{prim.l2_dy} * dy;
        if (l1 < 0 || l2 < 0 || l1 + l2 > 1) continue;
        covered[block] = true;
        for (const bool fused : {false, true}) {
          passes_somewhere[block] |=
              passes(op, static_cast<float>(codec.round(depth_at(prim, dx, dy, fused))), static_cast<float>(stored));
        }
      }
    }
    Draw draw;
    draw.hi_z = greater ? HiZMode::kGreater : HiZMode::kLess;
    draw.packet.viewport = {0, 0, 1, 1, 0, 1};
    HiZ hi_z;
    hi_z.begin_tile(codec.format, buffer, kSize, 1, false);
    hi_z.begin_draw(draw);
    const TriangleDepth depth = triangle_depth(prim, draw, tile);
    const float least = least_depth(prim, draw, tile);
    for (uint32_t macro = 0; macro < kBlocks / kLanes; ++macro) {
      const uint32_t survivors = hi_z.survivors(macro, 0xFFFF, depth);
      for (uint32_t b = 0; b < kLanes; ++b) {
        const uint32_t block = macro * kLanes + b;
        const bool survives = (survivors >> b & 1) != 0;
        if (passes_somewhere[block]) {
          ++passing_blocks;
          ASSERT_FALSE(hi_z.hides(block, least)) << "case " << i << " format " << codec.format << " block " << block;
          ASSERT_TRUE(survives) << "case " << i << " format " << codec.format << " block " << block;
        }
        hidden += covered[block] && !survives;
      }
    }
  }
  EXPECT_GT(passing_blocks, 5000u);
  EXPECT_GT(hidden, 5000u) << "a test in which nothing is hidden proves nothing";
}

}  // namespace
}  // namespace pineda::raster
