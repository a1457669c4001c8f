// Coverage with several samples: every path against the edge functions in 64 bits, and watertight meshes.
#include "raster/coverage_samples.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "raster/edge_list.h"
#include "raster/tile_buffer.h"

namespace pineda::raster {
namespace {

constexpr uint32_t kSampleCountsToTest[] = {2, 4, 8, 16};

Triangle make_triangle(const int32_t (&x)[3], const int32_t (&y)[3], Shape shape = Shape::kTriangle) {
  Triangle t{};
  std::copy_n(x, 3, t.x_fx8);
  std::copy_n(y, 3, t.y_fx8);
  const int64_t area = int64_t{x[1] - x[0]} * (y[2] - y[0]) - int64_t{y[1] - y[0]} * (x[2] - x[0]);
  t.set_flags(0, true, area > 0, shape);
  return t;
}

// Bit s: sample s of pixel (x, y).
uint32_t reference(const Triangle& t, int32_t x_px, int32_t y_px, uint32_t samples) {
  const EdgeList edges(t);
  uint32_t mask = 0;
  for (uint32_t s = 0; s < samples; ++s) {
    const SampleLocation at = sample_locations(samples)[s];
    const int32_t x = x_px * kSubpixels + at.x * 16, y = y_px * kSubpixels + at.y * 16;
    bool in = true;
    for (int k = 0; k < edges.count; ++k) {
      const auto& [a, b, x0, y0, c] = edges.edge[k];
      in &= int64_t{a} * (x - x0) + int64_t{b} * (y - y0) + c >= 0;
    }
    mask |= static_cast<uint32_t>(in) << s;
  }
  return mask;
}

// Calls each(x, y, mask) for the pixels that cover_samples() finds in a tile.
template <class Each>
void cover_tile(const Triangle& t, const TilePosition& tile, uint32_t samples, Isa isa, const Each& each) {
  SampleEdges edges;
  if (make_sample_edges(t, tile.x_px, tile.y_px, tile.size_px, samples, edges) == TileCover::kNone) return;
  const Rect box = touched_rect(t);
  const Rect r = intersect({box.x0 - tile.x_px, box.y0 - tile.y_px, box.x1 - tile.x_px, box.y1 - tile.y_px},
                           {0, 0, tile.size_px, tile.size_px});
  if (r.empty()) return;
  const auto block = [](int32_t px) { return static_cast<uint32_t>(px) / kBlockDim; };
  std::vector<FragmentSampleWave> waves(kMaxTileBlocks + 1);
  const uint32_t xy_px = static_cast<uint32_t>(tile.x_px) + (static_cast<uint32_t>(tile.y_px) << 16);
  const uint32_t count = cover_samples_function(isa, samples)(edges, {block(r.x0), block(r.y0), block(r.x1 + 3), block(r.y1 + 3)},
                                                              xy_px, waves.data());
  for (uint32_t i = 0; i < count; ++i) {
    const FragmentSampleWave& w = waves[i];
    ASSERT_EQ(w.wave.x_px, tile.x_px + static_cast<int32_t>(morton_x(w.wave.block_index) * 4));
    ASSERT_EQ(w.wave.y_px, tile.y_px + static_cast<int32_t>(morton_y(w.wave.block_index) * 4));
    for (uint32_t lane = 0; lane < kLanes; ++lane) {
      ASSERT_EQ(w.samples[lane] != 0, (w.wave.coverage >> lane & 1) != 0);
      each(w.wave.x_px + static_cast<int32_t>(morton_x(lane)), w.wave.y_px + static_cast<int32_t>(morton_y(lane)),
           w.samples[lane]);
    }
  }
}

TEST(CoverageSamples, EveryPathEqualsTheEdgeFunctions) {
  std::mt19937 rng(11);
  const auto number = [&](int32_t low, int32_t high) {
    return low + static_cast<int32_t>(rng() % static_cast<uint32_t>(high - low));
  };
  for (int round = 0; round < 1500; ++round) {
    const int32_t size = round % 3 == 0 ? 16 : round % 3 == 1 ? 32 : 64;
    const TilePosition tile{number(0, 200) * size, number(0, 200) * size, size, {}};
    // From slivers to triangles of the whole guard band, corners on sample positions now and then.
    const int32_t reach = 1 << (4 + round % 20);
    int32_t x[3], y[3];
    for (int k = 0; k < 3; ++k) {
      x[k] = std::clamp(tile.x_px * 256 + number(0, size * 256) + number(-reach, reach), kMinFx8, kMaxFx8);
      y[k] = std::clamp(tile.y_px * 256 + number(0, size * 256) + number(-reach, reach), kMinFx8, kMaxFx8);
      if (round % 4 == 0) x[k] &= ~15, y[k] &= ~15;
    }
    const bool wide = round % 5 == 4 && reach < (1 << 20);
    const Triangle t = make_triangle(x, y, wide ? Shape::kParallelogram : Shape::kTriangle);
    for (const uint32_t samples : kSampleCountsToTest) {
      std::vector<uint32_t> want(static_cast<size_t>(size * size));
      for (int32_t py = 0; py < size; ++py)
        for (int32_t px = 0; px < size; ++px)
          want[static_cast<size_t>(py * size + px)] = reference(t, tile.x_px + px, tile.y_px + py, samples);
      for (const Isa isa : {Isa::kSse42, Isa::kAvx2, Isa::kAvx512}) {
        if (isa > best_isa()) continue;
        std::vector<uint32_t> got(want.size());
        cover_tile(t, tile, samples, isa, [&](int32_t px, int32_t py, uint32_t mask) {
          got[static_cast<size_t>((py - tile.y_px) * size + px - tile.x_px)] = mask;
        });
        ASSERT_EQ(got, want) << "round " << round << ", " << samples << " samples";
      }
    }
  }
}

// A jittered grid of vertices over a tile, both windings and diagonals: every sample is hit exactly once.
TEST(CoverageSamples, MeshesAreWatertight) {
  std::mt19937 rng(12);
  for (const uint32_t samples : kSampleCountsToTest) {
    for (int round = 0; round < 40; ++round) {
      constexpr int32_t kSize = 64;
      const TilePosition tile{kSize * (round % 7), kSize * (round % 5), kSize, {}};
      constexpr int kCells = 24;
      std::vector<std::array<int32_t, 2>> vertex((kCells + 1) * (kCells + 1));
      for (int j = 0; j <= kCells; ++j) {
        for (int i = 0; i <= kCells; ++i) {
          const auto jitter = [&](int k) { return k == 0 || k == kCells ? 0 : static_cast<int32_t>(rng() % 600) - 300; };
          auto& v = vertex[static_cast<size_t>(j * (kCells + 1) + i)];
          v = {tile.x_px * 256 - 512 + i * (kSize * 256 + 1024) / kCells + jitter(i),
               tile.y_px * 256 - 512 + j * (kSize * 256 + 1024) / kCells + jitter(j)};
          if (round % 3 == 0) v = {v[0] & ~15, v[1] & ~15};  // on sample positions
        }
      }
      std::vector<uint32_t> hits(size_t{kSize} * kSize * samples);
      const auto draw = [&](int a, int b, int c) {
        int32_t x[3], y[3];
        const int index[3] = {a, rng() % 2 ? b : c, 0};
        const int order[3] = {index[0], index[1], index[1] == b ? c : b};
        for (int k = 0; k < 3; ++k)
          x[k] = vertex[static_cast<size_t>(order[k])][0], y[k] = vertex[static_cast<size_t>(order[k])][1];
        const Triangle t = make_triangle(x, y);
        if (int64_t{x[1] - x[0]} * (y[2] - y[0]) == int64_t{y[1] - y[0]} * (x[2] - x[0])) return;
        cover_tile(t, tile, samples, best_isa(), [&](int32_t px, int32_t py, uint32_t mask) {
          for (uint32_t s = 0; s < samples; ++s)
            hits[static_cast<size_t>((py - tile.y_px) * kSize + px - tile.x_px) * samples + s] += mask >> s & 1;
        });
      };
      for (int j = 0; j < kCells; ++j) {
        for (int i = 0; i < kCells; ++i) {
          const int a = j * (kCells + 1) + i, b = a + 1, c = a + kCells + 1, d = c + 1;
          draw(a, b, c);
          draw(b, d, c);
        }
      }
      // Cells may fold over where the jitter turns a triangle around; then a sample is hit by three, twice forwards, once
      // backwards.
      size_t odd = 0;
      for (const uint32_t h : hits) odd += h % 2 == 1;
      ASSERT_EQ(odd, hits.size()) << samples << " samples, round " << round;
    }
  }
}

}  // namespace
}  // namespace pineda::raster
