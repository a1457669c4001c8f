// Clipping of one triangle against the view volume's depth planes, w > 0 and the guard band, by Sutherland and Hodgman (1974),
// all attributes along. Every cut is computed from the inside to the outside vertex, so two triangles that share an edge get the
// same new vertex.
#pragma once

#include <cstdint>
#include <vector>

#include "raster/geometry_types.h"

namespace pineda::raster {

inline constexpr uint32_t kMaxClipPlanes = 7;
inline constexpr uint32_t kMaxClipVertices = 3 + kMaxClipPlanes;  // of the polygon that is left

class Clipper {
 public:
  // `vertex` are slot-0 addresses of the three vertices (stride kVertexSlotBytes between slots). Returns the number of vertices
  // left, 0 when the triangle is outside.
  uint32_t clip(const ViewportTransform& viewport, uint32_t slots, const float* const vertex[3]);

  // Slots of polygon vertex i, contiguous.
  const float* vertex(uint32_t i) const { return polygon_[i]; }
  // Vertex 0 of the triangle is polygon vertex 0.
  bool keeps_first() const { return count_ != 0 && polygon_[0] == pool_.data(); }

 private:
  void clip_plane(uint32_t plane, const ViewportTransform& viewport, uint32_t slots);

  std::vector<float> pool_;  // the triangle's vertices and every cut: at most two a plane
  const float* polygon_[kMaxClipVertices + 1];
  uint32_t count_ = 0, pool_used_ = 0;
};

}  // namespace pineda::raster
