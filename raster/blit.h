// Blits ("Image Blits" in the specification): for each texel of the destination the source is sampled at the point that
// corresponds to its centre, clamped to the edge of the source level, and converted to the destination's format.
//
// The result is defined, the same for any number of threads: weights are binary32 numbers rounded from the exact fraction, UNORM
// and SNORM components are filtered in code units, x before y before z, and the sum is rounded once more to the destination.
#pragma once

#include <array>
#include <cstdint>

#include "base/format.h"
#include "raster/thread_pool.h"

namespace pineda::raster {

// One axis: destination texel i, at its centre, is source coordinate (i + 0.5 - to0) * scale + from0. Corners may be swapped on
// either side, which mirrors. Doubles: products of 15-bit numbers and a quotient, far from any rounding that would move a texel.
struct BlitAxis {
  BlitAxis() = default;
  BlitAxis(int32_t source0, int32_t source1, int32_t to_0, int32_t to_1, uint32_t source_limit);

  double coordinate(int32_t i) const { return (i + 0.5 - to0) * scale + from0; }
  uint32_t clamp(double texel) const;
  uint32_t nearest(int32_t i) const;
  // Neighbours in the source and the weight of the second.
  struct Pair {
    uint32_t first, second;
    float weight;
  };
  Pair pair(int32_t i) const;

  double scale = 1, from0 = 0, to0 = 0;
  int32_t begin = 0, end = 1;  // destination texels, in ascending order
  uint32_t limit = 1;          // source texels of the level
};

struct BlitSide {
  const FormatInfo* format;  // plain
  uint8_t* address;          // texel (0, 0, 0) of the level
  uint64_t row_pitch_bytes, slice_pitch_bytes;
};

struct Blit {
  BlitSide source, destination;
  BlitAxis x, y, z;
  bool linear = false;    // never for integer formats
  bool linear_z = false;  // of volumes
};
void blit(ThreadPool& pool, const Blit& blit);

}  // namespace pineda::raster
