// A million triangles that cover the plane without gap or overlap: every pixel is drawn exactly once, whatever the path (16 small
// ones at once, hierarchical, 32 or 64 bits, clipped at the guard band) and the instruction set.
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "raster/test_scene.h"

namespace pineda::raster {
namespace {

using namespace testing;

constexpr uint32_t kSize = 256;

struct Corner {
  float x, y, w;
};

class MeshMaker {
 public:
  MeshMaker(uint32_t seed, TestDraw& draw) : rng_(seed), draw_(draw) {}

  // Rows of vertices at falling heights; the strip between two rows is closed like a zip. Steps along a row and between rows run
  // from 1/256 px, which makes slivers, to hundreds of pixels; the first and the last vertex are far outside, some of them past
  // the guard band.
  void make(uint32_t triangles) {
    std::vector<Corner> above = row(-20);
    float y = -20;
    while (count_ < triangles && y < kSize + 20) {
      y += step();
      const std::vector<Corner> below = row(y);
      zip(above, below);
      above = below;
    }
    if (y < kSize + 20) zip(above, row(kSize + 20));
  }
  uint32_t count() const { return count_; }

 private:
  float step() {
    static constexpr float kSteps[] = {1.0f / 256, 3.0f / 256, 0.25f, 1, 5, 40};
    return kSteps[rng_() % 6];
  }
  std::vector<Corner> row(float y) {
    std::vector<Corner> corners;
    const auto add = [&](float x) { corners.push_back({x, y, 0.25f * static_cast<float>(1 + rng_() % 16)}); };
    const float far = rng_() % 2 != 0 ? 300.0f : 1e6f;
    add(-far - static_cast<float>(rng_() % 100));
    float x = -30 - static_cast<float>(rng_() % 8);
    while (x < kSize + 30) {
      add(x);
      x += step() * (rng_() % 3 == 0 ? 8 : 1);
    }
    add(far + kSize + static_cast<float>(rng_() % 100));
    return corners;
  }
  void zip(const std::vector<Corner>& above, const std::vector<Corner>& below) {
    size_t a = 0, b = 0;
    while (a + 1 < above.size() || b + 1 < below.size()) {
      const bool take_above = b + 1 == below.size() || (a + 1 < above.size() && rng_() % 2 != 0);
      add(above[a], below[b], take_above ? above[a + 1] : below[b + 1]);
      ++(take_above ? a : b);
    }
  }
  void add(Corner p, Corner q, Corner r) {
    if (rng_() % 2 != 0) std::swap(q, r);  // every winding
    for (auto k = rng_() % 3; k > 0; --k) {
      std::swap(p, q);
      std::swap(q, r);
    }
    for (const Corner& c : {p, q, r}) add_window_vertex(draw_, kSize, kSize, c.x, c.y, 0.5f, c.w);
    ++count_;
  }

  std::mt19937 rng_;
  TestDraw& draw_;
  uint32_t count_ = 0;
};

TEST(Watertight, AMillionTrianglesCoverEveryPixelOnce) {
  ThreadPool pool(2);
  uint32_t total = 0;
  for (uint32_t seed = 0; total < 1'000'000; ++seed) {
    TestDraw draw(4, count_kernel);
    MeshMaker mesh(seed, draw);
    mesh.make(60'000);
    total += mesh.count();
    Options options = test_options();
    options.tile_px = 16u << seed % 3;
    options.isa = std::min(best_isa(), static_cast<Isa>(seed % 3));
    Target target(kSize, kSize);
    Pass pass(pool, target.desc(), options);
    pass.draw(draw.packet(kSize, kSize));
    pass.end();
    for (uint32_t i = 0; i < kSize * kSize; ++i) {
      ASSERT_EQ(target.color[i], 1u) << "seed " << seed << ", pixel " << i % kSize << ' ' << i / kSize;
    }
  }
}

}  // namespace
}  // namespace pineda::raster
