// Coverage with several samples a pixel: which samples of each pixel of a tile a triangle covers. The integers are coverage.h's:
// at the sample (X + x / 16, Y + y / 16), E = 256 * (A X + B Y) + const + 16 * (A x + B y), so each sample is a constant of its
// own, floored exactly, and E >= 0 <=> A X + B Y + c[sample] >= 0. Over all samples of a tile of 64 px an edge varies by less
// than 64 *
// (|A| + |B|) < 2^30.59, so 32 bits suffice as they do there.
#pragma once

#include "base/sample_locations.h"
#include "raster/coverage.h"

namespace pineda::raster {

struct SampleEdges {
  int32_t a[4], b[4];         // the fourth is for parallelograms only
  int32_t c[4][kMaxSamples];  // of each sample
  int32_t c_max[4], c_min[4];
  int32_t count;  // edges: 3, or 4
};

// Pixels that a record may have a sample in.
Rect touched_rect(const Triangle& record);

// `samples` > 1. kFull: all samples of all pixels of the tile are covered. Edges that hold on the whole tile come out as 0.
TileCover make_sample_edges(const Triangle& triangle, int32_t tile_x_px, int32_t tile_y_px, int32_t size_px, uint32_t samples,
                            SampleEdges& edges);

// As CoverFn.
using CoverSamplesFn = uint32_t (*)(const SampleEdges& edges, const BlockRange& range, uint32_t tile_xy_px,
                                    FragmentSampleWave* out);
CoverSamplesFn cover_samples_function(Isa isa, uint32_t samples);

}  // namespace pineda::raster
