// The record of a triangle, from its vertices. small_setup.h makes the same of 16 at once.
#pragma once

#include <algorithm>
#include <array>
#include <utility>

#include "raster/geometry_types.h"
#include "raster/transform.h"

namespace pineda::raster {

// The vertices in the order of a record; `mirrored`: their winding is the other one.
struct RecordOrder {
  std::array<uint16_t, 3> v;
  bool mirrored;
};

// Puts the farthest vertex first and the nearest one second, when that is more than twice as near.
//
// 1 / w is iw0 + l1 (iw1 - iw0) + l2 (iw2 - iw0). From the farthest vertex all terms are positive, so nothing is lost where 1 / w
// is small. Attributes are a1 + b0 (a0 - a1) + b2 (a2 - a1), rounded to the precision of a1 and of the differences, however small
// they are: an a1 at the horizon, of 10^6, say, would leave pixels before the eye, where a step of the attribute is finest, with
// errors of many pixels. From the nearest vertex, far values come in as far as the pixel is far: the cases "perspective 10^6 : 1"
// of `pineda report --extreme` and "plane" of `pineda report`.
inline RecordOrder far_near_order(const float* iw, const std::array<uint16_t, 3>& v) {
  const float iw0 = iw[v[0]], iw1 = iw[v[1]], iw2 = iw[v[2]];
  const float least = std::min(std::min(iw0, iw1), iw2);
  if (std::max(std::max(iw0, iw1), iw2) <= least + least) [[likely]]
    return {v, false};
  std::array<uint16_t, 3> turned = v;
  if (iw0 > least) turned = iw1 > least ? std::array{v[2], v[0], v[1]} : std::array{v[1], v[2], v[0]};
  const bool mirrored = iw[turned[2]] > iw[turned[1]];
  if (mirrored) std::swap(turned[1], turned[2]);
  return {turned, mirrored};
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
  const auto [v, mirrored] = far_near_order(w.iw, in_order);
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
  t.set_flags(facts.provoking, facts.front, facts.clockwise != mirrored, Shape::kTriangle);
}

}  // namespace pineda::raster
