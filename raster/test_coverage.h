// For the tests of coverage: random triangles, and the scalar reference, written from the rule alone.
#pragma once

#include <algorithm>
#include <array>
#include <random>
#include <vector>

#include "raster/geometry_types.h"
#include "raster/options.h"

namespace pineda::raster::testing {

struct Point {
  int64_t x, y;  // fx8
};

// The top-left rule: a sample on an edge belongs to the triangle when the edge is its left one (the inside is to its right) or
// its top one (horizontal, the inside below).
inline bool covers(std::array<Point, 3> v, Point p) {
  const auto cross = [](Point a, Point b, Point c) { return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x); };
  const int64_t area = cross(v[0], v[1], v[2]);
  if (area == 0) return false;
  if (area < 0) std::swap(v[1], v[2]);
  for (int i = 0; i < 3; ++i) {
    const Point a = v[i], b = v[(i + 1) % 3];
    const int64_t e = cross(a, b, p);
    if (e < 0) return false;
    const bool goes_up = b.y < a.y, goes_right_level = b.y == a.y && b.x > a.x;  // clockwise on the screen: left edges go up
    if (e == 0 && !goes_up && !goes_right_level) return false;
  }
  return true;
}

inline Point random_point(std::mt19937& rng, int64_t center_px, int64_t radius_fx8) {
  std::uniform_int_distribution<int64_t> d(-radius_fx8, radius_fx8);
  const auto clamp = [](int64_t v) { return std::clamp<int64_t>(v, kMinFx8, kMaxFx8); };
  return {clamp(center_px * 256 + d(rng)), clamp(center_px * 256 + d(rng))};
}

inline Triangle make_triangle(const std::array<Point, 3>& v) {
  Triangle t{};
  for (int k = 0; k < 3; ++k) {
    t.x_fx8[k] = static_cast<int32_t>(v[k].x);
    t.y_fx8[k] = static_cast<int32_t>(v[k].y);
  }
  const int64_t area = (v[1].x - v[0].x) * (v[2].y - v[0].y) - (v[1].y - v[0].y) * (v[2].x - v[0].x);
  t.provoking_and_flags = area > 0 ? Triangle::kClockwise : 0;
  return t;
}

inline std::vector<Isa> isas() {
  std::vector<Isa> list{Isa::kSse42};
  for (const Isa isa : {Isa::kAvx2, Isa::kAvx512}) {
    if (best_isa() >= isa) list.push_back(isa);
  }
  return list;
}

}  // namespace pineda::raster::testing
