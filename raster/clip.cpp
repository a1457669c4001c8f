#include "raster/clip.h"

#include <cmath>

#include "raster/vertex_batch.h"

namespace pineda::raster {
namespace {

constexpr uint32_t kPoolVertices = 3 + 2 * kMaxClipPlanes;
constexpr uint32_t kFirstDistance = __builtin_ctz(kClipDistances);  // planes are numbered like the bits of the codes
constexpr uint32_t kPlaneEnd = kFirstDistance + kMaxClipDistances;

}  // namespace

bool Clipper::is_plane(uint32_t plane) const {
  if (plane >= kFirstDistance) return plane < kFirstDistance + outputs_->clip_count;
  const uint32_t code = 1u << plane;
  return code != kClipDrop && (viewport_->clip_depth || !(code & (kClipNear | kClipFar)));
}

// Signed distance, >= 0 inside. v: x y z w.
float Clipper::distance(uint32_t plane, const float* v) const {
  const ViewportTransform& t = *viewport_;
  switch (1u << plane) {
    case kClipW:
      return v[3] - kMinW;
    case kClipNear:
      return v[2];
    case kClipFar:
      return v[3] - v[2];
    case kClipLeft:
      return v[0] - t.guard_x_min * v[3];
    case kClipRight:
      return t.guard_x_max * v[3] - v[0];
    case kClipTop:
      return v[1] - t.guard_y_min * v[3];
    case kClipBottom:
      return t.guard_y_max * v[3] - v[1];
    default:
      return v[outputs_->clip_distance + plane - kFirstDistance];
  }
}

// Puts a cut exactly on its plane: what rounding left over could be a whole screen after the division by a small w.
void Clipper::snap_to_plane(uint32_t plane, float* v) const {
  const ViewportTransform& t = *viewport_;
  switch (1u << plane) {
    case kClipW:
      v[3] = kMinW;
      break;
    case kClipNear:
      v[2] = 0;
      break;
    case kClipFar:
      v[2] = v[3];
      break;
    case kClipLeft:
      v[0] = t.guard_x_min * v[3];
      break;
    case kClipRight:
      v[0] = t.guard_x_max * v[3];
      break;
    case kClipTop:
      v[1] = t.guard_y_min * v[3];
      break;
    case kClipBottom:
      v[1] = t.guard_y_max * v[3];
      break;
    default:
      v[outputs_->clip_distance + plane - kFirstDistance] = 0;
      break;
  }
}

// Where the edge between two vertices meets the plane.
const float* Clipper::cut(uint32_t plane, const float* inside, const float* outside, float d_inside, float d_outside) {
  const float t = d_inside / (d_inside - d_outside);
  float* v = pool_.data() + pool_used_++ * slots_;
  for (size_t s = 0; s < slots_; ++s) v[s] = inside[s] + t * (outside[s] - inside[s]);
  snap_to_plane(plane, v);
  return v;
}

void Clipper::clip_polygon(uint32_t plane) {
  const float* in[kMaxClipVertices + 1];
  float d[kMaxClipVertices + 1];
  const uint32_t n = count_;
  bool any_outside = false;
  for (uint32_t i = 0; i < n; ++i) {
    in[i] = polygon_[i];
    d[i] = distance(plane, in[i]);
    any_outside |= !(d[i] >= 0);
  }
  if (!any_outside) return;
  count_ = 0;
  for (uint32_t i = 0; i < n; ++i) {
    const uint32_t j = i + 1 == n ? 0 : i + 1;
    const bool i_inside = d[i] >= 0, j_inside = d[j] >= 0;
    if (i_inside && count_ <= kMaxClipVertices) polygon_[count_++] = in[i];
    if (i_inside == j_inside || count_ > kMaxClipVertices || pool_used_ == kPoolVertices) continue;
    polygon_[count_++] = i_inside ? cut(plane, in[i], in[j], d[i], d[j]) : cut(plane, in[j], in[i], d[j], d[i]);
  }
}

void Clipper::load(const Draw& draw, const ViewportTransform& viewport, const float* const* vertex, uint32_t count) {
  viewport_ = &viewport;
  outputs_ = &draw.packet.outputs;
  slots_ = draw.packet.vertex_slots;
  pool_.resize(kPoolVertices * slots_);
  for (uint32_t i = 0; i < count; ++i) {
    float* v = pool_.data() + i * slots_;
    for (size_t s = 0; s < slots_; ++s) v[s] = vertex[i][s * kLanes];
    polygon_[i] = v;
  }
  count_ = count;
  pool_used_ = 3;
}

uint32_t Clipper::clip_triangle(const Draw& draw, const ViewportTransform& viewport, uint32_t codes,
                                const float* const vertex[3]) {
  load(draw, viewport, vertex, 3);
  for (uint32_t plane = 0; plane < kPlaneEnd && count_ >= 3; ++plane) {
    if ((codes >> plane & 1) && is_plane(plane)) clip_polygon(plane);
  }
  if (count_ > kMaxClipVertices || count_ < 3) count_ = 0;
  return count_;
}

uint32_t Clipper::clip_line(const Draw& draw, const ViewportTransform& viewport, uint32_t codes, const float* const vertex[2]) {
  load(draw, viewport, vertex, 2);
  for (uint32_t plane = 0; plane < kPlaneEnd; ++plane) {
    if (!(codes >> plane & 1) || !is_plane(plane)) continue;
    const float d0 = distance(plane, polygon_[0]), d1 = distance(plane, polygon_[1]);
    const bool inside0 = d0 >= 0, inside1 = d1 >= 0;
    if (!inside0 && !inside1) return count_ = 0;
    if (!inside0) polygon_[0] = cut(plane, polygon_[1], polygon_[0], d1, d0);
    if (!inside1) polygon_[1] = cut(plane, polygon_[0], polygon_[1], d0, d1);
  }
  return count_;
}

}  // namespace pineda::raster
