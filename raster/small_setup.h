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
  int32_t tile[16];                        // the number, in its layer, of the only one that it may cover; -1: there are several
  int32_t facing[16];                      // of small ones: Triangle's flags kFront and kClockwise
  uint32_t primitive_id[16];               // in, for small_records()
  Triangle records[16];                    // of small ones, without depth bias
};

// Fills in the vertices of 16 triangles from number `first` on.
using SmallGatherFn = void (*)(const WindowVertices& window, const BatchPrims& prims, uint32_t first, SmallSetup& group);
SmallGatherFn small_gather_function(Isa isa);

struct SmallSetupState {
  Rect rect;  // of the draw
  bool cull_clockwise, cull_counter_clockwise;
  bool one_sample;  // at the pixel's centre; otherwise a sample may be anywhere in the pixel
  bool front_is_clockwise;
  uint32_t batch;
  uint32_t tile_shift, tile_columns;  // of TileGrid
};
using SmallSetupFn = void (*)(const SmallSetupState& state, SmallSetup& group);
SmallSetupFn small_setup_function(Isa isa);

// fill_record() for the 16 triangles from number `first` on, which small_setup() has seen.
using SmallRecordsFn = void (*)(const WindowVertices& window, const BatchPrims& prims, uint32_t first,
                                const SmallSetupState& state, SmallSetup& group);
SmallRecordsFn small_records_function(Isa isa);

}  // namespace pineda::raster
