#include "raster/geometry.h"

#include <cmath>

#include "raster/assemble.h"
#include "raster/coverage_samples.h"
#include "raster/depth_bias.h"

namespace pineda::raster {
namespace {

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
  const Rect box = draw.samples > 1 ? touched_bounds(x0, x1, x2, y0, y1, y2) : pixel_bounds(x0, x1, x2, y0, y1, y2);
  const Rect bounds = intersect(box, draw.rect_at(view.viewport));
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

void GeometryWorker::bin(const Draw& draw, const BatchView& view, const Triangle& record) {
  const Rect bounds = intersect(draw.samples > 1 ? touched_rect(record) : pixel_rect(record), draw.rect_at(view.viewport));
  if (bounds.empty()) {
    ++statistics.triangles_culled;
    return;
  }
  const auto index = static_cast<uint32_t>(chunk_->triangles.size());
  chunk_->triangles.push_back(record);
  binner_.add(draw, record, index, bounds);
}

void GeometryWorker::setup_outline(const Draw& draw, const BatchView& view, uint32_t primitive_id, std::span<const uint16_t> v,
                                   uint16_t provoking) {
  const DrawPacket& packet = draw.packet;
  const WindowVertices& w = *view.window;
  const size_t n = v.size();
  int64_t area = 0;  // of the polygon, twice; positive when clockwise on the screen
  size_t widest = 1;
  int64_t widest_area = 0;  // of the pieces of its fan, for the depth slope
  for (size_t i = 1; i + 1 < n; ++i) {
    const int64_t x1 = w.x_fx8[v[i]] - w.x_fx8[v[0]], y1 = w.y_fx8[v[i]] - w.y_fx8[v[0]];
    const int64_t x2 = w.x_fx8[v[i + 1]] - w.x_fx8[v[0]], y2 = w.y_fx8[v[i + 1]] - w.y_fx8[v[0]];
    const int64_t piece = x1 * y2 - y1 * x2;
    area += piece;
    if (std::abs(piece) > std::abs(widest_area)) {
      widest = i;
      widest_area = piece;
    }
  }
  const bool front = (area < 0) == (packet.front_face == VK_FRONT_FACE_COUNTER_CLOCKWISE);
  if (area == 0 || is_culled(packet, front)) {
    ++statistics.triangles_culled;
    return;
  }
  Outline outline{primitive_id, provoking, front, 0};
  if (packet.depth_bias && widest_area != 0) {
    const std::array<uint16_t, 3> p{v[0], v[widest], v[widest + 1]};
    const int32_t x[3] = {w.x_fx8[p[0]], w.x_fx8[p[1]], w.x_fx8[p[2]]}, y[3] = {w.y_fx8[p[0]], w.y_fx8[p[1]], w.y_fx8[p[2]]};
    outline.depth_bias =
        depth_bias(packet, draw.depth_format, static_cast<double>(widest_area), x, y, {w.z[p[0]], w.z[p[1]], w.z[p[2]]});
  }
  for (size_t i = 0; i < n; ++i) {
    if (packet.polygon_mode == VK_POLYGON_MODE_LINE) {
      setup_line(draw, view, v[i], v[i + 1 == n ? 0 : i + 1], outline);
    } else {
      setup_point(draw, view, v[i], outline);
    }
  }
}

void GeometryWorker::begin_clip_batch(const Draw& draw, uint32_t viewport) {
  clip_draw_ = &draw;
  clip_viewport_ = viewport;
  clip_used_ = 0;
  const size_t floats = size_t{kClipBatchVertices} * draw.packet.vertex_slots;
  clip_vertices_ = static_cast<float*>(chunk_->vertices.allocate(floats * sizeof(float)));
  clip_batch_ = static_cast<uint32_t>(chunk_->batches.size());
  chunk_->batches.push_back({&draw, clip_vertices_, viewport});
}

// Copies the clipper's `count` vertices, and behind them `extra` if there is one, to the batch of clipped vertices, in fresh
// waves from vertex `first` on.
GeometryWorker::BatchView GeometryWorker::add_clipped(const Draw& draw, uint32_t viewport, uint32_t count, const float* extra,
                                                      uint16_t& first) {
  const uint32_t slots = draw.packet.vertex_slots, total = count + (extra ? 1 : 0);
  const uint32_t padded = (total + kLanes - 1) / kLanes * kLanes;
  if (clip_draw_ != &draw || clip_viewport_ != viewport || clip_used_ + padded > kClipBatchVertices)
    begin_clip_batch(draw, viewport);
  first = static_cast<uint16_t>(clip_used_);
  const BatchView view{&clip_window_, clip_vertices_, slots, clip_batch_, viewport};
  for (uint32_t i = 0; i < padded; ++i) {  // spare lanes repeat the first vertex
    float* to = clip_vertices_ + size_t{(first + i) / kLanes} * slots * kLanes + (first + i) % kLanes;
    for (uint32_t s = 0; s < slots; ++s) {
      to[s * kLanes] = i < count ? clipper_.vertex(i)[s] : i < total ? extra[s * kLanes] : clipper_.vertex(0)[s];
    }
  }
  for (uint32_t i = 0; i < padded; i += kLanes) {
    transform_wave(draw.viewport_at(viewport), draw.packet.outputs, clip_vertices_ + size_t{first + i} * slots, clip_window_,
                   first + i);
  }
  clip_used_ += padded;
  return view;
}

// A primitive that needs more than its vertices' window coordinates: it crosses a plane, or goes to another viewport than its
// batch. codes: of its vertices together.
void GeometryWorker::clip(const Draw& draw, uint32_t viewport, uint32_t primitive_id, uint32_t codes,
                          std::array<const float*, 3> vertex) {
  const bool is_line = draw.kind == PrimitiveKind::kLine;
  uint32_t count = 1;
  if (draw.kind == PrimitiveKind::kPoint) vertex[1] = vertex[2] = vertex[0];  // not clipped, but copied
  if (is_line) {
    count = clipper_.clip_line(draw, draw.viewport_at(viewport), codes, vertex.data());
  } else {
    count = clipper_.clip_triangle(draw, draw.viewport_at(viewport), codes, vertex.data());
    if (draw.kind == PrimitiveKind::kPoint) count = std::min(count, 1u);
  }
  ++statistics.triangles_clipped;
  if (count == 0) {
    ++statistics.triangles_culled;
    return;
  }
  // The provoking vertex stays for flat attributes even when it was cut off.
  const float* cut_off = nullptr;
  if (is_line) {
    cut_off = vertex[draw.packet.provoking_last ? 1 : 0];
  } else if (!clipper_.keeps_first()) {
    cut_off = vertex[0];
  }
  uint16_t first;
  const BatchView view = add_clipped(draw, viewport, count, cut_off, first);
  // Only rounding can leave a cut outside of a plane it was put on; what matters is that its window coordinates fit fixed point.
  for (uint32_t i = first; i < first + count; ++i) {
    const int32_t x = clip_window_.x_fx8[i], y = clip_window_.y_fx8[i];
    const bool fits = x >= kMinFx8 && x <= kMaxFx8 && y >= kMinFx8 && y <= kMaxFx8 && std::isfinite(clip_window_.z[i]) &&
                      std::isfinite(clip_window_.iw[i]);
    if (!fits || (clip_window_.code[i] & kClipDrop) != 0) {
      ++statistics.triangles_culled;
      return;
    }
  }
  const auto provoking = static_cast<uint16_t>(cut_off ? first + count : first);
  const Outline outline{primitive_id, provoking, true, 0};
  switch (draw.kind) {
    case PrimitiveKind::kPoint:
      setup_point(draw, view, first, outline);
      break;
    case PrimitiveKind::kLine:
      setup_line(draw, view, first, static_cast<uint16_t>(first + 1), outline);
      break;
    case PrimitiveKind::kTriangle:
      setup_clipped(draw, view, primitive_id, first, count, provoking);
      break;
  }
}

void GeometryWorker::setup_clipped(const Draw& draw, const BatchView& view, uint32_t primitive_id, uint16_t first, uint32_t count,
                                   uint16_t provoking) {
  if (draw.packet.polygon_mode != VK_POLYGON_MODE_FILL) {
    uint16_t polygon[kMaxClipVertices];
    for (uint32_t i = 0; i < count; ++i) polygon[i] = static_cast<uint16_t>(first + i);
    setup_outline(draw, view, primitive_id, {polygon, count}, provoking);
    return;
  }
  int64_t area = 0;
  for (uint32_t i = 0; i < count; ++i) {
    const uint32_t j = first + (i + 1 == count ? 0 : i + 1);
    area += int64_t{clip_window_.x_fx8[first + i]} * clip_window_.y_fx8[j] -
            int64_t{clip_window_.y_fx8[first + i]} * clip_window_.x_fx8[j];
  }
  if (area == 0) {
    ++statistics.triangles_culled;
    return;
  }
  for (uint16_t i = 1; i + 1u < count; ++i) {
    const std::array<uint16_t, 3> piece{first, static_cast<uint16_t>(first + i), static_cast<uint16_t>(first + i + 1)};
    setup(draw, view, primitive_id, piece, provoking, area < 0 ? -1 : 1);
  }
}

// One primitive whose vertices need no clipping.
inline void GeometryWorker::primitive(const Draw& draw, const BatchView& view, uint32_t primitive_id,
                                      const std::array<uint16_t, 3>& v) {
  switch (draw.kind) {
    case PrimitiveKind::kTriangle:
      if (draw.packet.polygon_mode == VK_POLYGON_MODE_FILL) [[likely]] {
        setup(draw, view, primitive_id, v, v[0], 0);
      } else {
        setup_outline(draw, view, primitive_id, v, v[0]);
      }
      break;
    case PrimitiveKind::kLine:
      setup_line(draw, view, v[0], v[1], {primitive_id, v[draw.packet.provoking_last ? 1 : 0], true, 0});
      break;
    case PrimitiveKind::kPoint:
      setup_point(draw, view, v[0], {primitive_id, v[0], true, 0});
      break;
  }
}

void GeometryWorker::run_batch(const Draw& draw, uint64_t first, uint32_t count) {
  statistics.vertices_shaded += batch_.shade(draw, first, count, *chunk_, context_);
  statistics.triangles_in += count;
  const DrawPacket& packet = draw.packet;
  const BatchView view{&batch_.window(), batch_.vertices(), packet.vertex_slots, static_cast<uint32_t>(chunk_->batches.size()),
                       0};
  chunk_->batches.push_back({&draw, batch_.vertices(), 0});
  const uint16_t* code = batch_.window().code;
  const uint32_t vertex_count = vertices_of(draw.kind);
  const uint32_t cull_codes = ((1u << packet.outputs.cull_count) - 1) * kClipDistances << packet.outputs.clip_count;
  // Points are never clipped: outside of one plane is outside.
  const uint32_t never = kClipDrop | (draw.kind == PrimitiveKind::kPoint ? 0xFFFF & ~cull_codes : 0);
  uint64_t in_instance = first % draw.prims_per_instance;
  for (uint32_t i = 0; i < count; ++i) {
    const auto primitive_id = static_cast<uint32_t>(in_instance);
    if (++in_instance == draw.prims_per_instance) in_instance = 0;
    std::array<uint16_t, 3> v = batch_.prim(i);
    for (uint32_t k = vertex_count; k < 3; ++k) v[k] = v[0];
    const uint32_t any = code[v[0]] | code[v[1]] | code[v[2]];
    if (any == 0) [[likely]] {
      primitive(draw, view, primitive_id, v);
    } else if ((any & never) != 0 || (code[v[0]] & code[v[1]] & code[v[2]]) != 0) {
      ++statistics.triangles_culled;
    } else if ((any & ~cull_codes) == 0) {
      primitive(draw, view, primitive_id, v);
    } else {
      clip(draw, 0, primitive_id, any, {view.vertex(v[0]), view.vertex(v[1]), view.vertex(v[2])});
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
