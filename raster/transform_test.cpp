// The transform gives the same bits on every instruction set, whatever the clip coordinates, and the codes that the planes
// demand.
#include "raster/transform.h"

#include <gtest/gtest.h>

#include <bit>
#include <cfloat>
#include <cmath>
#include <cstring>
#include <random>

namespace pineda::raster {
namespace {

float random_coordinate(std::mt19937& rng) {
  constexpr float kOdd[] = {0.0f, -0.0f, INFINITY, -INFINITY, NAN, FLT_MAX, FLT_MIN, 1e-42f, 1.0f, -1.0f};
  if (rng() % 8 == 0) return kOdd[rng() % std::size(kOdd)];
  if (rng() % 4 == 0) return std::bit_cast<float>(static_cast<uint32_t>(rng()));
  return (static_cast<float>(rng() % 20001) - 10000.0f) / 5000.0f;
}

uint32_t expected_code(const ViewportTransform& t, const float* p) {
  const float x = p[0], y = p[kLanes], z = p[2 * kLanes], w = p[3 * kLanes];
  uint32_t code = w < kMinW ? kClipW : 0;
  if (t.clip_depth) code |= (z < 0 ? kClipNear : 0) | (z > w ? kClipFar : 0);
  code |= (x < t.guard_x_min * w ? kClipLeft : 0) | (x > t.guard_x_max * w ? kClipRight : 0);
  code |= (y < t.guard_y_min * w ? kClipTop : 0) | (y > t.guard_y_max * w ? kClipBottom : 0);
  if (!std::isfinite(x) || !std::isfinite(y) || !std::isfinite(z) || !std::isfinite(w)) code |= kClipDrop;
  return code;
}

TEST(Transform, EveryInstructionSetGivesTheSameBits) {
  std::mt19937 rng(53);
  static WindowVertices reference, out;
  for (int round = 0; round < 5000; ++round) {
    const VkViewport viewport{static_cast<float>(rng() % 64), 8, 1920, rng() % 2 != 0 ? 1080.0f : -1080.0f, 0.25f, 0.75f};
    const ViewportTransform t = make_viewport_transform(viewport, rng() % 2 != 0);
    alignas(64) float wave[6 * kLanes];
    for (float& v : wave) v = random_coordinate(rng);
    VertexOutputs outputs;
    if (rng() % 2 != 0) outputs.clip_distance = 4, outputs.clip_count = 1, outputs.cull_distance = 5, outputs.cull_count = 1;
    const uint32_t first = rng() % kBatchWaves * kLanes;
    transform_function(Isa::kSse42)(t, outputs, wave, reference, first);
    for (uint32_t lane = 0; lane < kLanes; ++lane) {
      constexpr uint32_t kPlanes = kClipDistances - 1;
      const uint32_t code = reference.code[first + lane] & kPlanes, expected = expected_code(t, wave + lane);
      // A vertex inside of all planes may still be too far away for fixed point.
      ASSERT_TRUE(code == expected || (expected == 0 && code == kClipDrop)) << code << " " << expected;
    }
    for (const Isa isa : {Isa::kAvx2, Isa::kAvx512}) {
      if (isa > best_isa()) continue;
      transform_function(isa)(t, outputs, wave, out, first);
      ASSERT_EQ(std::memcmp(out.x_fx8 + first, reference.x_fx8 + first, kLanes * 4), 0);
      ASSERT_EQ(std::memcmp(out.y_fx8 + first, reference.y_fx8 + first, kLanes * 4), 0);
      ASSERT_EQ(std::memcmp(out.code + first, reference.code + first, kLanes * 2), 0);
      for (uint32_t i = first; i < first + kLanes; ++i) {  // a NaN's bits are nobody's
        if (!std::isnan(reference.z[i])) {
          ASSERT_EQ(std::bit_cast<uint32_t>(out.z[i]), std::bit_cast<uint32_t>(reference.z[i]));
        }
        if (!std::isnan(reference.iw[i])) {
          ASSERT_EQ(std::bit_cast<uint32_t>(out.iw[i]), std::bit_cast<uint32_t>(reference.iw[i]));
        }
      }
    }
  }
}

}  // namespace
}  // namespace pineda::raster
