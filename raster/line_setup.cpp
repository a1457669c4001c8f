// Set-up of lines and points: what becomes of them is a parallelogram, or the pixels of a Bresenham line.
#include <bit>
#include <cmath>

#if defined(__x86_64__)
#include <immintrin.h>
#else
#error "the host float code has an x86-64 implementation only"
#endif

#include "raster/bresenham.h"
#include "raster/geometry.h"

namespace pineda::raster {
namespace {

// To nearest, halves to even: symmetric about 0, so that a line has the same corners forwards and backwards.
inline int32_t round_to_int(double v) { return _mm_cvtsd_si32(_mm_set_sd(v)); }

// VkPhysicalDeviceLimits::pointSizeRange; NaN becomes the least.
inline float clamp_point_size(float size) { return size > kMinPointSize ? std::min(size, kMaxPointSize) : kMinPointSize; }

// Vulkan 1.3, "Primitive Clipping": a point whose position is outside the view volume is discarded. Depth is up to the codes.
inline bool inside_view_volume(const float* vertex) {
  const float x = vertex[0], y = vertex[kLanes], w = vertex[3 * kLanes];
  return x >= -w && x <= w && y >= -w && y <= w;
}

}  // namespace

void GeometryWorker::setup_point(const Draw& draw, const BatchView& view, uint16_t v, const Outline& outline) {
  const WindowVertices& w = *view.window;
  const float* vertex = view.vertex(v);
  if (!inside_view_volume(vertex)) {
    ++statistics.triangles_culled;
    return;
  }
  const uint32_t slot = draw.packet.outputs.point_size;
  const float size_px = slot != 0 ? clamp_point_size(vertex[slot * kLanes]) : 1.0f;
  const int32_t half = round_to_int(double{size_px} * (kSubpixels / 2));
  const int32_t x = w.x_fx8[v], y = w.y_fx8[v];
  Triangle t;
  const int32_t xs[3] = {x - half, x + half, x - half}, ys[3] = {y - half, y - half, y + half};
  for (int k = 0; k < 3; ++k) {
    t.x_fx8[k] = xs[k];
    t.y_fx8[k] = ys[k];
    t.iw[k] = w.iw[v];
    t.vertex[k] = v;
  }
  t.z0 = w.z[v] + outline.depth_bias;
  t.dz1 = t.dz2 = 0;
  t.primitive_id = outline.primitive_id;
  t.batch = view.batch;
  t.set_flags(outline.provoking, outline.front, true, Shape::kParallelogram);
  bin(draw, view, t);
}

void GeometryWorker::setup_line(const Draw& draw, const BatchView& view, uint16_t a, uint16_t b, const Outline& outline) {
  const WindowVertices& w = *view.window;
  const int32_t ax = w.x_fx8[a], ay = w.y_fx8[a], bx = w.x_fx8[b], by = w.y_fx8[b];
  const int32_t dx = bx - ax, dy = by - ay;
  if (dx == 0 && dy == 0) {
    ++statistics.triangles_culled;
    return;
  }
  Triangle t;
  t.z0 = w.z[a] + outline.depth_bias;
  t.dz1 = w.z[b] - w.z[a];
  t.dz2 = 0;
  t.iw[0] = t.iw[2] = w.iw[a];
  t.iw[1] = w.iw[b];
  t.vertex[0] = t.vertex[2] = a;
  t.vertex[1] = b;
  t.primitive_id = outline.primitive_id;
  t.batch = view.batch;
  if (draw.packet.line.mode == LineMode::kBresenham) {
    const PixelLine line = pixel_line(ax, ay, bx, by);
    const int32_t xs[3] = {ax, bx, line.first}, ys[3] = {ay, by, line.end};
    for (int k = 0; k < 3; ++k) {
      t.x_fx8[k] = xs[k];
      t.y_fx8[k] = ys[k];
    }
    t.set_flags(outline.provoking, outline.front, false, line.shape);
    if (draw.packet.line.stippled) {  // the counter goes on after each pixel; the pattern repeats after 16 * factor
      t.dz2 = std::bit_cast<float>(stipple_count_);
      const auto pixels = static_cast<uint32_t>(std::max(0, line.end - line.first));
      stipple_count_ = (stipple_count_ + pixels) % (16 * draw.packet.line.stipple_factor);
    }
  } else {
    // Half the width to both sides. The same offset at both ends keeps the sides parallel to the line, so that l1 is exactly the
    // position along it but for the rounding of this vector.
    const double half = double{draw.packet.line.width_px} * (kSubpixels / 2);
    const double scale = half / std::sqrt(double{dx * 1.0} * dx + double{dy * 1.0} * dy);
    const int32_t hx = round_to_int(-dy * scale), hy = round_to_int(dx * scale);
    const int32_t xs[3] = {ax - hx, bx - hx, ax + hx}, ys[3] = {ay - hy, by - hy, ay + hy};
    for (int k = 0; k < 3; ++k) {
      t.x_fx8[k] = xs[k];
      t.y_fx8[k] = ys[k];
    }
    t.set_flags(outline.provoking, outline.front, true, Shape::kParallelogram);
  }
  bin(draw, view, t);
}

}  // namespace pineda::raster
