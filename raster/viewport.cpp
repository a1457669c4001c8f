#include <cmath>

#include "raster/geometry_types.h"

namespace pineda::raster {
namespace {

// The guard band on one axis. A viewport without extent draws nothing but must not divide by zero.
void guard_band(float half_px, float center_px, float& min_ndc, float& max_ndc) {
  constexpr float kFar = 1e30f;
  min_ndc = -kFar;
  max_ndc = kFar;
  if (half_px == 0 || !std::isfinite(half_px) || !std::isfinite(center_px)) return;
  const float a = (kGuardMinPx - center_px) / half_px, b = (kGuardMaxPx - center_px) / half_px;
  min_ndc = std::clamp(std::min(a, b), -kFar, kFar);
  max_ndc = std::clamp(std::max(a, b), -kFar, kFar);
}

// The first pixel whose centre is at or behind a window coordinate.
int32_t first_pixel(double v) {
  constexpr double kFar = 1 << 20;  // larger than any framebuffer
  return static_cast<int32_t>(std::ceil(v - 0.5 > -kFar ? std::min(v - 0.5, kFar) : -kFar));
}

}  // namespace

Rect viewport_rect(const VkViewport& v) {
  const double x0 = v.x, x1 = x0 + v.width, y0 = v.y, y1 = y0 + v.height;
  return {first_pixel(std::min(x0, x1)), first_pixel(std::min(y0, y1)), first_pixel(std::max(x0, x1)),
          first_pixel(std::max(y0, y1))};
}

ViewportTransform make_viewport_transform(const VkViewport& viewport, bool clip_depth) {
  ViewportTransform t{};
  const float half_w = viewport.width * 0.5f, half_h = viewport.height * 0.5f;  // a negative height flips y
  const float center_x = viewport.x + half_w, center_y = viewport.y + half_h;
  t.scale_x_fx8 = half_w * kSubpixels;
  t.offset_x_fx8 = center_x * kSubpixels;
  t.scale_y_fx8 = half_h * kSubpixels;
  t.offset_y_fx8 = center_y * kSubpixels;
  t.scale_z = viewport.maxDepth - viewport.minDepth;
  t.offset_z = viewport.minDepth;
  t.clip_depth = clip_depth;
  guard_band(half_w, center_x, t.guard_x_min, t.guard_x_max);
  guard_band(half_h, center_y, t.guard_y_min, t.guard_y_max);
  return t;
}

}  // namespace pineda::raster
