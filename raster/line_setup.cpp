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
  const int32_t xs[3] = {ax, bx, ax}, ys[3] = {ay, by, ay};
  for (int k = 0; k < 3; ++k) {
    t.x_fx8[k] = xs[k];
    t.y_fx8[k] = ys[k];
  }
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
    bin_pixel_line(draw, view, t, outline);
  } else {
    bin_rectangle(draw, view, t, outline);
  }
}

// Where in the pattern a line of this length begins; what follows it in its strip begins behind it.
double GeometryWorker::advance_stipple(const Draw& draw, double length_px) {
  const double begin = stipple_position_, period = 16.0 * draw.packet.line.stipple_factor, end = begin + length_px;
  stipple_position_ = std::max(0.0, end - period * std::floor(end / period));
  return begin;
}

// A Bresenham line: one record for each row (column) of its width. "Bresenham line segments of width other than one are
// rasterized by offsetting them in the minor direction ... and producing a row or column of fragments in the minor direction."
void GeometryWorker::bin_pixel_line(const Draw& draw, const BatchView& view, Triangle& t, const Outline& outline) {
  const int32_t ax = t.x_fx8[0], ay = t.y_fx8[0], bx = t.x_fx8[1], by = t.y_fx8[1];
  const bool y_major = std::abs(bx - ax) < std::abs(by - ay);
  const int32_t width = bresenham_width(draw.packet.line.width_px), offset = -(width - 1) * (kSubpixels / 2);
  const int32_t x_offset = y_major ? offset : 0, y_offset = y_major ? 0 : offset;
  const PixelLine line = pixel_line(ax + x_offset, ay + y_offset, bx + x_offset, by + y_offset);
  t.set_flags(outline.provoking, outline.front, false, line.shape);
  t.x_fx8[2] = line.first;
  t.y_fx8[2] = line.end;
  if (draw.stipples) {
    const auto count = static_cast<uint32_t>(advance_stipple(draw, std::max(0, line.end - line.first)));
    t.dz2 = std::bit_cast<float>(count);
  }
  for (int32_t i = 0; i < width; ++i) {
    const int32_t along_minor = i * kSubpixels;
    t.x_fx8[0] = ax + x_offset + (y_major ? along_minor : 0);
    t.x_fx8[1] = bx + x_offset + (y_major ? along_minor : 0);
    t.y_fx8[0] = ay + y_offset + (y_major ? 0 : along_minor);
    t.y_fx8[1] = by + y_offset + (y_major ? 0 : along_minor);
    bin(draw, view, t);
  }
}

// Half the width to both sides. The same offset at both ends keeps the sides parallel to the line, so that l1 is exactly the
// position along it but for the rounding of this vector.
void GeometryWorker::bin_rectangle(const Draw& draw, const BatchView& view, Triangle& t, const Outline& outline) {
  const int32_t ax = t.x_fx8[0], ay = t.y_fx8[0], bx = t.x_fx8[1], by = t.y_fx8[1];
  const double dx = bx - ax, dy = by - ay, length_fx8 = std::sqrt(dx * dx + dy * dy);
  const double scale = double{draw.packet.line.width_px} * (kSubpixels / 2) / length_fx8;
  const int32_t hx = round_to_int(-dy * scale), hy = round_to_int(dx * scale);
  const int32_t xs[3] = {ax - hx, bx - hx, ax + hx}, ys[3] = {ay - hy, by - hy, ay + hy};
  for (int k = 0; k < 3; ++k) {
    t.x_fx8[k] = xs[k];
    t.y_fx8[k] = ys[k];
  }
  if (draw.stipples) t.dz2 = static_cast<float>(advance_stipple(draw, length_fx8 / kSubpixels));
  t.set_flags(outline.provoking, outline.front, true, Shape::kParallelogram);
  bin(draw, view, t);
}

}  // namespace pineda::raster
