// Set-up of 16 triangles at once, for those whose vertices lie within 64 px of each other: facing, bounds, and whether any sample
// is covered at all. All in integers, so it decides what GeometryWorker's scalar set-up would, and drops besides what covers no
// pixel's centre.
#pragma once

#include <cstdint>

#include "raster/geometry_types.h"
#include "raster/options.h"
#include "raster/transform.h"

namespace pineda::raster {

struct alignas(64) SmallSetup {
  // in: window coordinates of vertex k of triangle i at [k][i]
  int32_t x_fx8[3][16], y_fx8[3][16];
  uint32_t unclipped;  // bit i: no vertex of triangle i has a clip code
  // out
  int32_t x0[16], y0[16], x1[16], y1[16];  // pixels that may be covered, inside the draw's rectangle
  uint32_t small;                          // bit i: triangle i is small; the rest says nothing of others
  uint32_t drawn;                          // small, faces the right way, and some sample may be covered
  uint32_t clockwise;                      // on the screen
  uint32_t averted, missed;                // small, not outside, but culled by its face; not culled, but without a sample
};

// Fills in the vertices of 16 triangles from number `first` on.
using SmallGatherFn = void (*)(const WindowVertices& window, const BatchPrims& prims, uint32_t first, SmallSetup& group);
SmallGatherFn small_gather_function(Isa isa);

struct SmallSetupState {
  Rect rect;  // of the draw
  bool cull_clockwise, cull_counter_clockwise;
  bool one_sample;  // at the pixel's centre; otherwise a sample may be anywhere in the pixel
};
using SmallSetupFn = void (*)(const SmallSetupState& state, SmallSetup& group);
SmallSetupFn small_setup_function(Isa isa);

}  // namespace pineda::raster
