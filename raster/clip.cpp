#include "raster/clip.h"

#include <cmath>

#include "raster/vertex_batch.h"

namespace pineda::raster {
namespace {

constexpr uint32_t kPoolVertices = 3 + 2 * kMaxClipPlanes;

// Signed distance, >= 0 inside. v: x y z w.
float distance(uint32_t plane, const ViewportTransform& t, const float* v) {
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
    default:
      return t.guard_y_max * v[3] - v[1];
  }
}

// Puts a cut exactly on its plane: what rounding left over could be a whole screen after the division by a small w.
void snap_to_plane(uint32_t plane, const ViewportTransform& t, float* v) {
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
    default:
      v[1] = t.guard_y_max * v[3];
      break;
  }
}

}  // namespace

void Clipper::clip_plane(uint32_t plane, const ViewportTransform& viewport, uint32_t slots) {
  const float* in[kMaxClipVertices + 1];
  float d[kMaxClipVertices + 1];
  const uint32_t n = count_;
  bool any_outside = false;
  for (uint32_t i = 0; i < n; ++i) {
    in[i] = polygon_[i];
    d[i] = distance(plane, viewport, in[i]);
    any_outside |= !(d[i] >= 0);
  }
  if (!any_outside) return;
  count_ = 0;
  for (uint32_t i = 0; i < n; ++i) {
    const uint32_t j = i + 1 == n ? 0 : i + 1;
    const bool i_inside = d[i] >= 0, j_inside = d[j] >= 0;
    if (i_inside && count_ <= kMaxClipVertices) polygon_[count_++] = in[i];
    if (i_inside == j_inside || count_ > kMaxClipVertices || pool_used_ == kPoolVertices) continue;
    const uint32_t inside = i_inside ? i : j, outside = i_inside ? j : i;
    const float t = d[inside] / (d[inside] - d[outside]);
    float* cut = pool_.data() + size_t{pool_used_++} * slots;
    for (uint32_t s = 0; s < slots; ++s) cut[s] = in[inside][s] + t * (in[outside][s] - in[inside][s]);
    snap_to_plane(plane, viewport, cut);
    polygon_[count_++] = cut;
  }
}

uint32_t Clipper::clip(const ViewportTransform& viewport, uint32_t slots, const float* const vertex[3]) {
  pool_.resize(size_t{kPoolVertices} * slots);
  for (uint32_t i = 0; i < 3; ++i) {
    float* v = pool_.data() + size_t{i} * slots;
    for (uint32_t s = 0; s < slots; ++s) v[s] = vertex[i][s * kLanes];
    polygon_[i] = v;
  }
  count_ = pool_used_ = 3;
  for (uint32_t plane = 0; plane < kMaxClipPlanes && count_ >= 3; ++plane) {
    if (!viewport.clip_depth && ((1u << plane) & (kClipNear | kClipFar))) continue;
    clip_plane(plane, viewport, slots);
  }
  if (count_ > kMaxClipVertices || count_ < 3) count_ = 0;
  return count_;
}

}  // namespace pineda::raster
