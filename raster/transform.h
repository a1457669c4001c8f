// Clip coordinates of 16 vertices become window coordinates and clip codes (Vulkan 1.3, chapter 27.6 "Coordinate Transformations"
// and 27.7 "Controlling the Viewport").
#pragma once

#include <cstdint>

#include "raster/geometry_types.h"
#include "raster/options.h"

namespace pineda::raster {

inline constexpr uint32_t kBatchPrims = 512;
inline constexpr uint32_t kBatchVertices = 3 * kBatchPrims;
inline constexpr uint32_t kBatchWaves = kBatchVertices / kLanes;

// A set bit: outside of this plane. Bits from kClipDistances on: a clip distance below 0; behind them the same for cull
// distances.
enum ClipCode : uint16_t {
  kClipNear = 1,
  kClipFar = 2,
  kClipW = 4,
  kClipLeft = 8,
  kClipRight = 16,
  kClipTop = 32,
  kClipBottom = 64,
  kClipDrop = 128,  // not finite, or too far away for fixed point: primitives with such a vertex are dropped
  kClipDistances = 256
};

// The smallest w that is not clipped away: its reciprocal is still finite.
inline constexpr float kMinW = 0x1p-126f;

// Window coordinates of the vertices of a batch.
struct WindowVertices {
  alignas(64) int32_t x_fx8[kBatchVertices];
  alignas(64) int32_t y_fx8[kBatchVertices];
  alignas(64) float z[kBatchVertices];
  alignas(64) float iw[kBatchVertices];
  alignas(64) uint16_t code[kBatchVertices + 2];  // gathers read words
};

// Vertices of the primitives of a batch; vertex k of primitive i is vertex[k][i]. Groups of 16 may begin anywhere.
struct BatchPrims {
  uint16_t vertex[3][kBatchPrims + kLanes];
};

// Transforms a wave of 16 vertices: clip coordinates are slots 0 to 3 at `wave`; results go to elements [first, first + 16). Only
// elements whose code has only cull distances are meaningful.
using TransformFn = void (*)(const ViewportTransform& viewport, const VertexOutputs& outputs, const float* wave,
                             WindowVertices& out, uint32_t first);
TransformFn transform_function(Isa isa);

}  // namespace pineda::raster
