#include "raster/geometry.h"

#include <cmath>

namespace pineda::raster {
namespace {

// Depth bias (Vulkan 1.3, "Depth Bias"): m * slope + r * constant, clamped; m is the larger of the two slopes' magnitudes.
float depth_bias(const DrawPacket& packet, VkFormat format, double area_fx16, const int32_t* x, const int32_t* y,
                 std::array<float, 3> z) {
  const double dz1 = double{z[1]} - z[0], dz2 = double{z[2]} - z[0];
  const double x1 = x[1] - x[0], x2 = x[2] - x[0], y1 = y[1] - y[0], y2 = y[2] - y[0];
  const double per_px = kSubpixels / area_fx16;
  const double dzdx = std::fabs((dz1 * y2 - dz2 * y1) * per_px), dzdy = std::fabs((dz2 * x1 - dz1 * x2) * per_px);
  const double slope = dzdx > dzdy ? dzdx : dzdy;
  double r;
  switch (format) {
    case VK_FORMAT_D16_UNORM:
      r = 0x1p-16;
      break;
    case VK_FORMAT_X8_D24_UNORM_PACK32:
      r = 0x1p-24;
      break;
    default: {
      const float largest = std::max({std::fabs(z[0]), std::fabs(z[1]), std::fabs(z[2])});
      r = largest > 0 ? std::ldexp(1.0, std::ilogb(largest) - 23) : 0;
    }
  }
  auto bias = static_cast<float>(slope * packet.depth_bias_slope + r * packet.depth_bias_constant);
  if (packet.depth_bias_clamp > 0) bias = std::min(bias, packet.depth_bias_clamp);
  if (packet.depth_bias_clamp < 0) bias = std::max(bias, packet.depth_bias_clamp);
  return bias;
}

bool is_culled(const DrawPacket& packet, bool front) {
  return (packet.cull & (front ? VK_CULL_MODE_FRONT_BIT : VK_CULL_MODE_BACK_BIT)) != 0;
}

}  // namespace

inline void GeometryWorker::setup(const Draw& draw, const BatchView& view, uint32_t primitive_id,
                                  const std::array<uint16_t, 3>& v, uint16_t provoking, int facing) {
  const WindowVertices& w = *view.window;
  // Scalars, not arrays: the compiler would copy arrays in wider pieces than it has just stored, and wait for them.
  const int32_t x0 = w.x_fx8[v[0]], x1 = w.x_fx8[v[1]], x2 = w.x_fx8[v[2]];
  const int32_t y0 = w.y_fx8[v[0]], y1 = w.y_fx8[v[1]], y2 = w.y_fx8[v[2]];
  // Twice the area, fx16; positive when clockwise on the screen. The specification's area has the other sign, and its positive is
  // counter-clockwise.
  const int64_t area = int64_t{x1 - x0} * (y2 - y0) - int64_t{y1 - y0} * (x2 - x0);
  const bool front = (area < 0) == (draw.packet.front_face == VK_FRONT_FACE_COUNTER_CLOCKWISE);
  const Rect bounds = intersect(pixel_bounds(x0, x1, x2, y0, y1, y2), draw.rect);
  if (area == 0 || (facing != 0 && (area < 0) != (facing < 0)) || is_culled(draw.packet, front) || bounds.empty()) {
    ++statistics.triangles_culled;
    return;
  }
  const auto index = static_cast<uint32_t>(chunk_->triangles.size());
  Triangle& t = *chunk_->triangles.append(1);
  t.x_fx8[0] = x0;
  t.x_fx8[1] = x1;
  t.x_fx8[2] = x2;
  t.y_fx8[0] = y0;
  t.y_fx8[1] = y1;
  t.y_fx8[2] = y2;
  const float z0 = w.z[v[0]];
  t.z0 = z0;
  t.dz1 = w.z[v[1]] - z0;
  t.dz2 = w.z[v[2]] - z0;
  t.iw[0] = w.iw[v[0]];
  t.iw[1] = w.iw[v[1]];
  t.iw[2] = w.iw[v[2]];
  t.primitive_id = primitive_id;
  t.batch = view.batch;
  t.vertex[0] = v[0];
  t.vertex[1] = v[1];
  t.vertex[2] = v[2];
  t.provoking_and_flags =
      static_cast<uint16_t>(provoking | (front ? Triangle::kFront : 0) | (area > 0 ? Triangle::kClockwise : 0));
  if (draw.packet.depth_bias)
    t.z0 += depth_bias(draw.packet, draw.depth_format, static_cast<double>(area), t.x_fx8, t.y_fx8, {z0, w.z[v[1]], w.z[v[2]]});
  binner_.add(draw, t, index, bounds);
}

void GeometryWorker::begin_clip_batch(const Draw& draw) {
  clip_draw_ = &draw;
  clip_used_ = 0;
  const size_t floats = size_t{kClipBatchVertices} * draw.packet.vertex_slots;
  clip_vertices_ = static_cast<float*>(chunk_->vertices.allocate(floats * sizeof(float)));
  clip_batch_ = static_cast<uint32_t>(chunk_->batches.size());
  chunk_->batches.push_back({&draw, clip_vertices_, 0});
}

void GeometryWorker::clip_triangle(const Draw& draw, uint32_t primitive_id, const std::array<uint16_t, 3>& v) {
  const uint32_t slots = draw.packet.vertex_slots;
  const float* vertex[3];
  for (int k = 0; k < 3; ++k) vertex[k] = batch_.vertices() + size_t{v[k] / kLanes} * slots * kLanes + v[k] % kLanes;
  const uint32_t count = clipper_.clip(draw.viewport, slots, vertex);
  ++statistics.triangles_clipped;
  if (count < 3) {
    ++statistics.triangles_culled;
    return;
  }
  // The polygon, starting at a fresh wave, then the provoking vertex when it was cut off.
  const bool keeps_first = clipper_.keeps_first();
  const uint32_t total = count + (keeps_first ? 0 : 1);
  static_assert(kMaxClipVertices + 1 <= kLanes);
  if (clip_draw_ != &draw || clip_used_ + kLanes > kClipBatchVertices) begin_clip_batch(draw);
  float* wave = clip_vertices_ + size_t{clip_used_} * slots;
  for (uint32_t i = 0; i < kLanes; ++i) {  // spare lanes repeat the first vertex
    for (uint32_t s = 0; s < slots; ++s) {
      wave[s * kLanes + i] = i < count ? clipper_.vertex(i)[s] : i < total ? vertex[0][s * kLanes] : clipper_.vertex(0)[s];
    }
  }
  transform_wave(draw.viewport, wave, clip_window_, clip_used_);
  const auto first = static_cast<uint16_t>(clip_used_);
  clip_used_ += kLanes;
  // Only rounding can leave a cut outside of a plane it was put on; what matters is that its window coordinates fit fixed point.
  int64_t area = 0;
  for (uint32_t i = 0; i < count; ++i) {
    const int32_t x = clip_window_.x_fx8[first + i], y = clip_window_.y_fx8[first + i];
    const bool fits = x >= kMinFx8 && x <= kMaxFx8 && y >= kMinFx8 && y <= kMaxFx8 && std::isfinite(clip_window_.z[first + i]) &&
                      std::isfinite(clip_window_.iw[first + i]);
    if (!fits || (clip_window_.code[first + i] & kClipDrop) != 0) {
      ++statistics.triangles_culled;
      return;
    }
    const uint32_t j = first + (i + 1 == count ? 0 : i + 1);
    area += int64_t{x} * clip_window_.y_fx8[j] - int64_t{y} * clip_window_.x_fx8[j];
  }
  if (area == 0) {
    ++statistics.triangles_culled;
    return;
  }
  const auto provoking = static_cast<uint16_t>(keeps_first ? first : first + count);
  for (uint16_t i = 1; i + 1u < count; ++i) {
    const std::array<uint16_t, 3> piece{first, static_cast<uint16_t>(first + i), static_cast<uint16_t>(first + i + 1)};
    setup(draw, {&clip_window_, clip_batch_}, primitive_id, piece, provoking, area < 0 ? -1 : 1);
  }
}

void GeometryWorker::run_batch(const Draw& draw, uint64_t first, uint32_t count) {
  statistics.vertices_shaded += batch_.shade(draw, first, count, *chunk_, context_);
  statistics.triangles_in += count;
  const BatchView view{&batch_.window(), static_cast<uint32_t>(chunk_->batches.size())};
  chunk_->batches.push_back({&draw, batch_.vertices(), 0});
  const uint8_t* code = batch_.window().code;
  uint64_t in_instance = first % draw.prims_per_instance;
  for (uint32_t i = 0; i < count; ++i) {
    const auto primitive_id = static_cast<uint32_t>(in_instance);
    if (++in_instance == draw.prims_per_instance) in_instance = 0;
    const std::array<uint16_t, 3> v = batch_.prim(i);
    const uint8_t any = code[v[0]] | code[v[1]] | code[v[2]];
    if (any == 0) [[likely]] {
      setup(draw, view, primitive_id, v, v[0], 0);
    } else if ((any & kClipDrop) != 0 || (code[v[0]] & code[v[1]] & code[v[2]]) != 0) {
      ++statistics.triangles_culled;
    } else {
      clip_triangle(draw, primitive_id, v);
    }
  }
}

void GeometryWorker::run_clear(const Draw& draw, uint64_t first, uint32_t count) {
  const auto batch = static_cast<uint32_t>(chunk_->batches.size());
  chunk_->batches.push_back({&draw, nullptr, 0});
  for (uint64_t i = first; i < first + count; ++i) {
    const Rect& r = draw.clear_rects[i];
    Triangle t{};
    t.x_fx8[0] = r.x0;  // a clear's record holds its rectangle in pixels
    t.y_fx8[0] = r.y0;
    t.x_fx8[1] = r.x1;
    t.y_fx8[1] = r.y1;
    t.batch = batch;
    const auto index = static_cast<uint32_t>(chunk_->triangles.size());
    chunk_->triangles.push_back(t);
    binner_.add_rect(draw, index, r);
  }
}

uint64_t GeometryWorker::run(const TileGrid& grid, std::span<const PrimRange> ranges, size_t max_entries, Chunk& chunk) {
  chunk_ = &chunk;
  clip_draw_ = nullptr;
  binner_.begin(grid);
  uint64_t done = 0;
  bool full = false;
  // On a grid of very many tiles even one batch of screen-sized triangles would be too much.
  const auto batch_prims =
      static_cast<uint32_t>(std::clamp<size_t>(2 * max_entries / std::max(1u, grid.count()), kLanes, kBatchPrims));
  for (const PrimRange& range : ranges) {
    for (uint32_t i = 0; i < range.count && !full;) {
      const uint32_t count = std::min(range.count - i, batch_prims);
      if (range.draw->is_clear) {
        run_clear(*range.draw, range.first + i, count);
      } else {
        run_batch(*range.draw, range.first + i, count);
      }
      i += count;
      done += count;
      full = binner_.entry_count() > max_entries;
    }
    if (full) break;
  }
  binner_.finish(chunk);
  return done;
}

}  // namespace pineda::raster
