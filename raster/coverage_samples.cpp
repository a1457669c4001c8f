#include "raster/coverage_samples.h"

#include <immintrin.h>

#include "raster/edge_list.h"

namespace pineda::raster {

Rect touched_rect(const Triangle& t) {
  const int32_t(&x)[3] = t.x_fx8, (&y)[3] = t.y_fx8;
  const Rect r = touched_bounds(x[0], x[1], x[2], y[0], y[1], y[2]);
  switch (t.shape()) {
    case Shape::kTriangle:
      return r;
    case Shape::kParallelogram: {
      const int32_t x3 = x[1] + x[2] - x[0], y3 = y[1] + y[2] - y[0];
      const Rect s = touched_bounds(x[0], x[1], x3, y[0], y[1], y3);
      return {std::min(r.x0, s.x0), std::min(r.y0, s.y0), std::max(r.x1, s.x1), std::max(r.y1, s.y1)};
    }
    default:
      return pixel_rect(t);
  }
}

TileCover make_sample_edges(const Triangle& tri, int32_t tile_x_px, int32_t tile_y_px, int32_t size_px, uint32_t samples,
                            SampleEdges& edges) {
  // A pixel line covers all samples of its pixels: as if they lay in the centre.
  constexpr SampleLocation kCentre[kMaxSamples] = {{8, 8}, {8, 8}, {8, 8}, {8, 8}, {8, 8}, {8, 8}, {8, 8}, {8, 8},
                                                   {8, 8}, {8, 8}, {8, 8}, {8, 8}, {8, 8}, {8, 8}, {8, 8}, {8, 8}};
  const SampleLocation* const locations = tri.shape() >= Shape::kPixelLineX ? kCentre : sample_locations(samples);
  const EdgeList list(tri);
  edges = {};
  edges.count = tri.shape() == Shape::kParallelogram ? 4 : 3;
  bool full = true;
  for (int k = 0; k < list.count; ++k) {
    const auto& [a, b, x0, y0, c0] = list.edge[k];
    const int64_t corner = int64_t{a} * (tile_x_px * kSubpixels - x0) + int64_t{b} * (tile_y_px * kSubpixels - y0) + c0;
    int64_t c[kMaxSamples], most = INT64_MIN, least = INT64_MAX;
    for (uint32_t s = 0; s < samples; ++s) {
      constexpr int64_t kPerSixteenth = kSubpixels / 16;
      c[s] = (corner + kPerSixteenth * (int64_t{a} * locations[s].x + int64_t{b} * locations[s].y)) >> 8;
      most = std::max(most, c[s]);
      least = std::min(least, c[s]);
    }
    const int64_t last = size_px - 1;
    if (most + last * (std::max(a, 0) + std::max(b, 0)) < 0) return TileCover::kNone;
    if (least + last * (std::min(a, 0) + std::min(b, 0)) >= 0) continue;  // holds on the whole tile
    full = false;
    edges.a[k] = a;
    edges.b[k] = b;
    for (uint32_t s = 0; s < samples; ++s) edges.c[k][s] = static_cast<int32_t>(c[s]);
    edges.c_max[k] = static_cast<int32_t>(most);
    edges.c_min[k] = static_cast<int32_t>(least);
  }
  return full ? TileCover::kFull : TileCover::kPartial;
}

namespace {

static_assert(offsetof(FragmentSampleWave, samples) == sizeof(FragmentWave));

#define PINEDA_ISA_CODE "raster/coverage_samples_impl.inc"
#include "raster/isa_copies.inc"

}  // namespace

CoverSamplesFn cover_samples_function(Isa isa, uint32_t samples) {
  return for_isa(isa, sse42::cover_samples_of, avx2::cover_samples_of, avx512::cover_samples_of)(samples);
}

}  // namespace pineda::raster
