// What the fragment kernel reads of a primitive, from its record. small_group.h makes the same of 16 triangles at once.
#pragma once

#include "raster/geometry_types.h"

namespace pineda::raster {

// Interpolation's planes from the snapped vertices (base/abi.h). Area and edges are exact in double; each derivative is rounded
// twice.
inline void fill_planes(const Triangle& t, FragmentPrim& p) {
  if (t.shape() >= Shape::kPixelLineX) {  // l1: the projection on the line
    const double dx = t.x_fx8[1] - t.x_fx8[0], dy = t.y_fx8[1] - t.y_fx8[0];
    const double per_px = kSubpixels / (dx * dx + dy * dy);
    p.l1_dx = static_cast<float>(dx * per_px);
    p.l1_dy = static_cast<float>(dy * per_px);
    p.l2_dx = p.l2_dy = 0;
    return;
  }
  const double x1 = t.x_fx8[1] - t.x_fx8[0], y1 = t.y_fx8[1] - t.y_fx8[0];
  const double x2 = t.x_fx8[2] - t.x_fx8[0], y2 = t.y_fx8[2] - t.y_fx8[0];  // 0 - x2: never -0, which integers do not know
  const double per_px = kSubpixels / (x1 * y2 - y1 * x2);
  p.l1_dx = static_cast<float>(y2 * per_px);
  p.l1_dy = static_cast<float>((0 - x2) * per_px);
  p.l2_dx = static_cast<float>((0 - y1) * per_px);
  p.l2_dy = static_cast<float>(x1 * per_px);
}

// Everything but the planes.
inline void fill_prim(const Triangle& t, const Batch& batch, FragmentPrim& p) {
  p.x0_px = static_cast<float>(t.x_fx8[0]) * (1.0f / kSubpixels);
  p.y0_px = static_cast<float>(t.y_fx8[0]) * (1.0f / kSubpixels);
  p.z0 = t.z0;
  p.dz1 = t.dz1;
  p.dz2 = t.dz2;
  p.iw0 = t.iw[0];
  p.iw1 = t.iw[1];
  p.iw2 = t.iw[2];
  const size_t wave_floats = size_t{batch.draw->packet.vertex_slots} * kLanes;
  const auto vertex = [&](uint32_t v) { return batch.vertices + v / kLanes * wave_floats + v % kLanes; };
  for (int k = 0; k < 3; ++k) p.vertex[k] = vertex(t.vertex[k]);
  p.front_facing = (t.provoking_and_flags & Triangle::kFront) != 0;
  p.primitive_id = t.primitive_id;
  p.layer = batch.layer;
  p.viewport_index = batch.viewport;
  p.reserved = 0;
  p.flat_offset_bytes = static_cast<int32_t>((vertex(t.provoking_and_flags & Triangle::kProvokingMask) - p.vertex[0]) *
                                             static_cast<ptrdiff_t>(sizeof(float)));
}

}  // namespace pineda::raster
