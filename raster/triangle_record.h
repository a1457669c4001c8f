// The record of a triangle, from its vertices. small_setup.h makes the same of 16 at once.
#pragma once

#include <algorithm>
#include <array>

#include "raster/geometry_types.h"
#include "raster/transform.h"

namespace pineda::raster {

// Turns a triangle until its nearest vertex comes first, when that is more than twice as near as the first one.
//
// a0 + b1 (a1 - a0) + b2 (a2 - a0) is rounded to the precision of a0 and of the differences, however small it is. An a0 at the
// horizon, of 10^6, say, would leave pixels before the eye, where a step of the attribute is finest, with errors of many pixels:
// the case "perspective 10^6 : 1" of `pineda report --extreme`. Seen from the nearest vertex, far values come in as far as the
// pixel is far. Depth and 1 / w, which are linear in the window, are as good from any vertex.
inline std::array<uint16_t, 3> nearest_first(const float* iw, const std::array<uint16_t, 3>& v) {
  const float iw1 = iw[v[1]], iw2 = iw[v[2]];
  if (std::max(iw1, iw2) <= 2 * iw[v[0]]) [[likely]]
    return v;
  return iw1 > iw2 ? std::array{v[1], v[2], v[0]} : std::array{v[2], v[0], v[1]};
}

// What a record says of its triangle beside its vertices.
struct TriangleFacts {
  uint32_t primitive_id, batch;
  uint16_t provoking;
  bool front, clockwise;
};

// Everything but the depth bias. `in_order`: the vertices in the winding of the topology.
inline void fill_record(const WindowVertices& w, const std::array<uint16_t, 3>& in_order, const TriangleFacts& facts,
                        Triangle& t) {
  const std::array<uint16_t, 3> v = nearest_first(w.iw, in_order);
  const float z0 = w.z[v[0]];
  t.z0 = z0;
  t.dz1 = w.z[v[1]] - z0;
  t.dz2 = w.z[v[2]] - z0;
  for (int k = 0; k < 3; ++k) {
    t.x_fx8[k] = w.x_fx8[v[k]];
    t.y_fx8[k] = w.y_fx8[v[k]];
    t.iw[k] = w.iw[v[k]];
    t.vertex[k] = v[k];
  }
  t.primitive_id = facts.primitive_id;
  t.batch = facts.batch;
  t.set_flags(facts.provoking, facts.front, facts.clockwise, Shape::kTriangle);
}

}  // namespace pineda::raster
