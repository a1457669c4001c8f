// Clipping of one triangle or line against the view volume's depth planes, w > 0, the guard band and the shader's clip distances,
// by Sutherland and Hodgman (1974), all attributes along. Every cut is computed from the inside to the outside vertex, so two
// triangles that share an edge get the same new vertex.
#pragma once

#include <cstdint>
#include <vector>

#include "raster/geometry_types.h"

namespace pineda::raster {

inline constexpr uint32_t kMaxClipPlanes = 7 + kMaxClipDistances;
inline constexpr uint32_t kMaxClipVertices = 3 + kMaxClipPlanes;  // of the polygon that is left

class Clipper {
 public:
  // `vertex` are slot-0 addresses of the vertices (stride kVertexSlotBytes between slots), `codes` the union of their clip codes:
  // other planes are not looked at. Returns the number of vertices left, 0 when nothing is.
  uint32_t clip_triangle(const Draw& draw, const ViewportTransform& viewport, uint32_t codes, const float* const vertex[3]);
  uint32_t clip_line(const Draw& draw, const ViewportTransform& viewport, uint32_t codes, const float* const vertex[2]);

  // Slots of polygon vertex i, contiguous.
  const float* vertex(uint32_t i) const { return polygon_[i]; }
  // Vertex 0 of the triangle is polygon vertex 0.
  bool keeps_first() const { return count_ != 0 && polygon_[0] == pool_.data(); }
  // Polygon vertex i is a vertex of the triangle.
  bool is_original(uint32_t i) const { return polygon_[i] < pool_.data() + 3 * slots_; }

 private:
  void load(const Draw& draw, const ViewportTransform& viewport, const float* const* vertex, uint32_t count);
  float distance(uint32_t plane, const float* v) const;
  void snap_to_plane(uint32_t plane, float* v) const;
  const float* cut(uint32_t plane, const float* inside, const float* outside, float d_inside, float d_outside);
  void clip_polygon(uint32_t plane);
  bool is_plane(uint32_t plane) const;

  const ViewportTransform* viewport_ = nullptr;
  const VertexOutputs* outputs_ = nullptr;
  size_t slots_ = 0;

  std::vector<float> pool_;  // the triangle's vertices and every cut: at most two a plane
  const float* polygon_[kMaxClipVertices + 1];
  uint32_t count_ = 0, pool_used_ = 0;
};

}  // namespace pineda::raster
