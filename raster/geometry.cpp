#include "raster/geometry.h"

#include <bit>
#include <cmath>

#include "raster/assemble.h"
#include "raster/coverage_samples.h"
#include "raster/depth_bias.h"
#include "raster/triangle_record.h"

namespace pineda::raster {
namespace {

// Clip codes that cut nothing.
uint32_t cull_distance_codes(const VertexOutputs& outputs) {
  return (((1u << outputs.cull_count) - 1) * kClipDistances) << outputs.clip_count;
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
  const Rect box = draw.samples > 1 ? touched_bounds(x0, x1, x2, y0, y1, y2) : pixel_bounds(x0, x1, x2, y0, y1, y2);
  const Rect bounds = intersect(box, draw.rect_at(view.viewport));
  if (area == 0 || (facing != 0 && (area < 0) != (facing < 0)) || is_culled(draw.packet, front) || bounds.empty()) {
    ++statistics.triangles_culled;
    if (!bounds.empty()) ++statistics.culled_facing;
    return;
  }
  emit(draw, view, primitive_id, v, provoking, area > 0, bounds);
}

// Fills the record of a triangle that is drawn, and bins it.
inline void GeometryWorker::emit(const Draw& draw, const BatchView& view, uint32_t primitive_id, const std::array<uint16_t, 3>& v,
                                 uint16_t provoking, bool clockwise, const Rect& bounds) {
  const WindowVertices& w = *view.window;
  const bool front = clockwise == (draw.packet.front_face == VK_FRONT_FACE_CLOCKWISE);
  const auto index = static_cast<uint32_t>(chunk_->triangles.size());
  Triangle& t = *chunk_->triangles.append(1);
  fill_record(w, v, {primitive_id, view.batch, provoking, front, clockwise}, t);
  if (draw.packet.depth_bias) {
    const float z[3] = {w.z[t.vertex[0]], w.z[t.vertex[1]], w.z[t.vertex[2]]};
    t.z0 += depth_bias(draw.packet, draw.depth_format, t.x_fx8, t.y_fx8, {z[0], z[1], z[2]});
  }
  binner_.add(draw, t, index, bounds, draw.rect_at(view.viewport));
}

// Triangle i of the group, whose record there is. It need not be small_setup()'s whole group, and stays in order.
inline void GeometryWorker::emit_small(const Draw& draw, const Rect& rect, uint32_t i) {
  const SmallSetup& group = small_group_;
  const auto index = static_cast<uint32_t>(chunk_->triangles.size());
  const Triangle& t =
      *static_cast<const Triangle*>(std::memcpy(chunk_->triangles.append(1), &group.records[i], sizeof(Triangle)));
  if (group.tile[i] >= 0) {
    binner_.add_to_tile(draw, static_cast<uint32_t>(group.tile[i]), index);
  } else {
    binner_.add(draw, t, index, {group.x0[i], group.y0[i], group.x1[i], group.y1[i]}, rect);
  }
}

void GeometryWorker::bin(const Draw& draw, const BatchView& view, const Triangle& record) {
  const Rect box = draw.samples > 1 || draw.smooth ? touched_rect(record) : pixel_rect(record);
  const Rect bounds = intersect(box, draw.rect_at(view.viewport));
  if (bounds.empty()) {
    ++statistics.triangles_culled;
    return;
  }
  const auto index = static_cast<uint32_t>(chunk_->triangles.size());
  chunk_->triangles.push_back(record);
  binner_.add(draw, record, index, bounds, draw.rect_at(view.viewport));
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
    outline.depth_bias = depth_bias(packet, draw.depth_format, x, y, {w.z[p[0]], w.z[p[1]], w.z[p[2]]});
  }
  for (size_t i = 0; i < n; ++i) {
    if (packet.polygon_mode == VK_POLYGON_MODE_LINE) {
      setup_line(draw, view, v[i], v[i + 1 == n ? 0 : i + 1], outline);
    } else {
      setup_point(draw, view, v[i], outline);
    }
  }
}

// A batch with room for `vertices` more. Batches of one draw share a block of memory.
void GeometryWorker::begin_clip_batch(const Draw& draw, Route route, uint32_t vertices) {
  if (clip_draw_ != &draw || clip_used_ + vertices > kClipBatchVertices) {
    clip_draw_ = &draw;
    clip_used_ = 0;
    const size_t floats = size_t{kClipBatchVertices} * draw.packet.vertex_slots;
    clip_vertices_ = static_cast<float*>(chunk_->vertices.allocate(floats * sizeof(float)));
  } else if (clip_route_ == route) {
    return;
  }
  clip_route_ = route;
  clip_batch_ = static_cast<uint32_t>(chunk_->batches.size());
  chunk_->batches.push_back({&draw, clip_vertices_, route.viewport, route.layer});
}

// Copies the clipper's `count` vertices, and behind them `extra` if there is one, to the batch of clipped vertices, in fresh
// waves from vertex `first` on.
GeometryWorker::BatchView GeometryWorker::add_clipped(const Draw& draw, Route route, uint32_t count, const float* extra,
                                                      uint16_t& first) {
  const uint32_t slots = draw.packet.vertex_slots, total = count + (extra ? 1 : 0);
  const uint32_t padded = (total + kLanes - 1) / kLanes * kLanes;
  begin_clip_batch(draw, route, padded);
  first = static_cast<uint16_t>(clip_used_);
  const BatchView view{&clip_window_, clip_vertices_, slots, clip_batch_, route.viewport, route.layer};
  for (uint32_t i = 0; i < padded; ++i) {  // spare lanes repeat the first vertex
    float* to = clip_vertices_ + size_t{(first + i) / kLanes} * slots * kLanes + (first + i) % kLanes;
    for (uint32_t s = 0; s < slots; ++s) {
      to[s * kLanes] = i < count ? clipper_.vertex(i)[s] : i < total ? extra[s * kLanes] : clipper_.vertex(0)[s];
    }
  }
  for (uint32_t i = 0; i < padded; i += kLanes) {
    transform_(draw.viewport_at(route.viewport), draw.packet.outputs, clip_vertices_ + size_t{first + i} * slots, clip_window_,
               first + i);
  }
  clip_used_ += padded;
  return view;
}

// A line or triangle that crosses a plane.
void GeometryWorker::clip(const Draw& draw, const BatchView& whole, uint32_t primitive_id, const std::array<uint16_t, 3>& v) {
  const bool is_line = draw.kind == PrimitiveKind::kLine;
  const uint16_t* const code = whole.window->code;
  const uint32_t codes = code[v[0]] | code[v[1]] | code[v[2]];
  const std::array<const float*, 3> vertex{whole.vertex(v[0]), whole.vertex(v[1]), whole.vertex(v[2])};
  const ViewportTransform& viewport = draw.viewport_at(whole.viewport);
  const uint32_t count = is_line ? clipper_.clip_line(draw, viewport, codes, vertex.data())
                                 : clipper_.clip_triangle(draw, viewport, codes, vertex.data());
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
  const BatchView view = add_clipped(draw, {whole.viewport, whole.layer}, count, cut_off, first);
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
  if (is_line) {
    setup_line(draw, view, first, static_cast<uint16_t>(first + 1), outline);
  } else {
    setup_clipped(draw, view, primitive_id, first, count, provoking);
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
void GeometryWorker::outline(const Draw& draw, const BatchView& view, uint32_t primitive_id, const std::array<uint16_t, 3>& v) {
  switch (draw.kind) {
    case PrimitiveKind::kTriangle:
      setup_outline(draw, view, primitive_id, v, v[0]);
      break;
    case PrimitiveKind::kLine:
      setup_line(draw, view, v[0], v[1], {primitive_id, v[draw.packet.provoking_last ? 1 : 0], true, 0});
      break;
    case PrimitiveKind::kPoint:
      setup_point(draw, view, v[0], {primitive_id, v[0], true, 0});
      break;
  }
}

// Filled triangles, 16 at a time.
void GeometryWorker::run_triangles(const Draw& draw, const BatchView& view, uint64_t first, uint32_t begin, uint32_t count) {
  const DrawPacket& packet = draw.packet;
  const WindowVertices& w = *view.window;
  const bool front_is_clockwise = packet.front_face == VK_FRONT_FACE_CLOCKWISE;
  const Rect& rect = draw.rect_at(view.viewport);
  const TileGrid& grid = binner_.grid();
  const SmallSetupState state{rect,
                              is_culled(packet, front_is_clockwise),
                              is_culled(packet, !front_is_clockwise),
                              draw.samples == 1 && options_->missed_triangles,
                              front_is_clockwise,
                              view.batch,
                              grid.shift,
                              grid.columns};
  if (state.cull_clockwise && state.cull_counter_clockwise) {  // their vertices may have had effects; they have none
    statistics.triangles_culled += count;
    statistics.culled_facing += count;
    return;
  }
  const uint32_t cull_codes = cull_distance_codes(packet.outputs);
  SmallSetup& group = small_group_;
  for (uint32_t base = 0; base < count; base += kLanes) {
    const uint32_t n = std::min(kLanes, count - base);
    const uint32_t present = (1u << n) - 1;
    small_gather_(w, batch_.prims(), begin + base, group);
    uint32_t inside = group.unclipped & present, clipped = 0;
    for (uint32_t others = present & ~inside; others != 0; others &= others - 1) {
      const auto i = static_cast<uint32_t>(__builtin_ctz(others));
      const std::array<uint16_t, 3> v = batch_.prim(begin + base + i);
      const uint32_t any = w.code[v[0]] | w.code[v[1]] | w.code[v[2]];
      if ((any & kClipDrop) == 0 && (w.code[v[0]] & w.code[v[1]] & w.code[v[2]]) == 0) {
        ((any & ~cull_codes) == 0 ? inside : clipped) |= 1u << i;
      }
    }
    small_setup_(state, group);
    uint32_t left = (inside & (group.drawn | ~group.small)) | clipped;
    const auto bits = [](uint32_t mask) { return static_cast<uint32_t>(__builtin_popcount(mask)); };
    statistics.triangles_culled += n - bits(left);
    statistics.culled_facing += bits(inside & group.averted);
    statistics.culled_no_sample += bits(inside & group.missed);
    if (left == 0) continue;
    const uint64_t number = first + begin + base;
    const auto id = [&](uint32_t i) {
      return static_cast<uint32_t>(number + i < draw.prims_per_instance ? number + i : (number + i) % draw.prims_per_instance);
    };
    const bool has_records = !packet.depth_bias;
    if (has_records) {
      for (uint32_t i = 0; i < kLanes; ++i) group.primitive_id[i] = id(i);
      small_records_(w, batch_.prims(), begin + base, state, group);
    }
    for (; left != 0; left &= left - 1) {
      const auto i = static_cast<uint32_t>(__builtin_ctz(left));
      if (has_records && (inside & group.small) >> i & 1) {
        emit_small(draw, rect, i);
        continue;
      }
      const std::array<uint16_t, 3> v = batch_.prim(begin + base + i);
      if (clipped >> i & 1) {
        ++statistics.triangles_clipped;
        clip(draw, view, id(i), v);
      } else if (group.small >> i & 1) {
        emit(draw, view, id(i), v, v[0], (group.clockwise >> i & 1) != 0, {group.x0[i], group.y0[i], group.x1[i], group.y1[i]});
      } else {
        setup(draw, view, id(i), v, v[0], 0);
      }
    }
  }
}

// Points, lines, and triangles of the other polygon modes.
void GeometryWorker::run_outlines(const Draw& draw, const BatchView& view, uint64_t first, uint32_t begin, uint32_t count) {
  const uint16_t* code = view.window->code;
  const uint32_t vertex_count = vertices_of(draw.kind), cull_codes = cull_distance_codes(draw.packet.outputs);
  // Points are never clipped: outside of one plane is outside.
  const uint32_t never = kClipDrop | (draw.kind == PrimitiveKind::kPoint ? 0xFFFF & ~cull_codes : 0);
  if (draw.in_order) stipple_position_ = draw.stipple_position;
  for (uint32_t i = begin; i < begin + count; ++i) {
    const auto primitive_id = static_cast<uint32_t>((first + i) % draw.prims_per_instance);
    const bool begins = draw.restart_prims.empty() ? primitive_id == 0 : draw.restart_prims[primitive_id].begins;
    if (!draw.in_order || begins) stipple_position_ = 0;
    std::array<uint16_t, 3> v = batch_.prim(i);
    for (uint32_t k = vertex_count; k < 3; ++k) v[k] = v[0];
    const uint32_t any = code[v[0]] | code[v[1]] | code[v[2]];
    if ((any & never) != 0 || (code[v[0]] & code[v[1]] & code[v[2]]) != 0) {
      ++statistics.triangles_culled;
    } else if ((any & ~cull_codes) == 0) {
      outline(draw, view, primitive_id, v);
    } else {
      ++statistics.triangles_clipped;
      clip(draw, view, primitive_id, v);
    }
  }
  if (draw.in_order) draw.stipple_position = stipple_position_;
}

void GeometryWorker::run_primitives(const Draw& draw, const BatchView& view, uint64_t first, uint32_t begin, uint32_t count) {
  if (draw.kind == PrimitiveKind::kTriangle && draw.packet.polygon_mode == VK_POLYGON_MODE_FILL) {
    run_triangles(draw, view, first, begin, count);
  } else {
    run_outlines(draw, view, first, begin, count);
  }
}

// Of primitive i of the batch, from its provoking vertex. A viewport or layer that is not there is the first: the specification
// leaves it undefined.
GeometryWorker::Route GeometryWorker::route_of(const Draw& draw, const BatchView& view, uint32_t i) const {
  const std::array<uint16_t, 3>& v = batch_.prim(i);
  const float* provoking = view.vertex(v[draw.kind == PrimitiveKind::kLine && draw.packet.provoking_last ? 1 : 0]);
  const auto read = [&](uint32_t slot, size_t count) {
    const uint32_t index = slot != 0 ? std::bit_cast<uint32_t>(provoking[slot * kLanes]) : 0;
    return index < count ? index : 0;
  };
  return {read(draw.packet.outputs.viewport_index, draw.viewports.size()), read(draw.packet.outputs.layer, draw.layers)};
}

// Window coordinates of the whole batch in each of the further viewports that its primitives choose.
void GeometryWorker::transform_to_viewports(const Draw& draw, uint32_t count) {
  const BatchView view{&batch_.window(), batch_.vertices(), draw.packet.vertex_slots, 0, 0, 0};
  uint32_t used = 0;
  for (uint32_t i = 0; i < count && !draw.viewports.empty(); ++i) used |= 1u << route_of(draw, view, i).viewport;
  for (used &= ~1u; used != 0; used &= used - 1) {
    const auto viewport = static_cast<uint32_t>(__builtin_ctz(used));
    std::unique_ptr<WindowVertices>& window = windows_[viewport];
    if (!window) window = std::make_unique<WindowVertices>();
    for (uint32_t first = 0; first < batch_.vertex_count(); first += kLanes) {
      transform_(draw.viewport_at(viewport), draw.packet.outputs, view.vertices + size_t{first} * view.slots, *window, first);
    }
  }
}

uint32_t GeometryWorker::batch_for(const Draw& draw, const BatchView& view, Route route) {
  for (const RoutedBatch& known : routed_) {
    if (known.route == route) return known.batch;
  }
  const auto batch = static_cast<uint32_t>(chunk_->batches.size());
  chunk_->batches.push_back({&draw, view.vertices, route.viewport, route.layer});
  routed_.push_back({route, batch});
  return batch;
}

// In API order, so that what overlaps stays in order: runs of primitives that go to the same place.
void GeometryWorker::run_routed(const Draw& draw, const BatchView& view, uint64_t first, uint32_t count) {
  routed_.assign(1, {{0, 0}, view.batch});
  for (uint32_t begin = 0; begin < count;) {
    const Route route = route_of(draw, view, begin);
    uint32_t end = begin + 1;
    while (end < count && route_of(draw, view, end) == route) ++end;
    const WindowVertices* window = route.viewport == 0 ? view.window : windows_[route.viewport].get();
    const BatchView routed{window, view.vertices, view.slots, batch_for(draw, view, route), route.viewport, route.layer};
    binner_.set_layer(route.layer);
    run_primitives(draw, routed, first, begin, end - begin);
    begin = end;
  }
}

// Whether all vertices of a batch of filled triangles are outside of one plane, or beyond one side of what may be drawn. A mesh
// that is seen is told by its first vertices.
bool GeometryWorker::sees_nothing(const Draw& draw, uint32_t vertices) const {
  if (draw.routes || draw.kind != PrimitiveKind::kTriangle || draw.packet.polygon_mode != VK_POLYGON_MODE_FILL) return false;
  const WindowVertices& w = batch_.window();
  const Rect& rect = draw.rect;
  uint32_t codes = 0xFFFF, sides = 0xF;
  for (uint32_t v = 0; v < vertices && (codes | sides) != 0; ++v) {
    codes &= w.code[v];
    const int32_t x = w.x_fx8[v] >> 8, y = w.y_fx8[v] >> 8;  // pixels: as touched_bounds()
    const uint32_t beyond = static_cast<uint32_t>(x < rect.x0) | static_cast<uint32_t>(x >= rect.x1) << 1 |
                            static_cast<uint32_t>(y < rect.y0) << 2 | static_cast<uint32_t>(y >= rect.y1) << 3;
    sides &= w.code[v] == 0 ? beyond : 0;  // only then there are coordinates
  }
  return (codes | sides) != 0;
}

void GeometryWorker::run_batch(const Draw& draw, uint64_t first, uint32_t count) {
  const PassStatistics before = statistics;
  const size_t binned = chunk_->triangles.size();
  const Arena::Mark vertices_mark = chunk_->vertices.mark();
  const size_t batches_mark = chunk_->batches.size();
  const uint32_t vertices = batch_.shade(draw, first, count, *chunk_, context_, transform_);
  statistics.vertices_shaded += vertices;
  statistics.triangles_in += count;
  if (options_->outside_batches && sees_nothing(draw, vertices)) {
    ++statistics.batches_outside;
    statistics.triangles_culled += count;
    chunk_->vertices.rewind(vertices_mark);
    return count_for_draw(draw, before, binned);
  }
  const BatchView view{
      &batch_.window(), batch_.vertices(), draw.packet.vertex_slots, static_cast<uint32_t>(chunk_->batches.size()), 0, 0};
  chunk_->batches.push_back({&draw, batch_.vertices()});
  const uint64_t in_instance = first % draw.prims_per_instance;
  if (draw.routes) [[unlikely]] {
    transform_to_viewports(draw, count);
    run_routed(draw, view, in_instance, count);
  } else {
    binner_.set_layer(0);
    run_primitives(draw, view, in_instance, 0, count);
  }
  count_for_draw(draw, before, binned);
  if (chunk_->triangles.size() == binned) {  // nothing is left of the batch: the next one's vertices take its place in the cache
    chunk_->vertices.rewind(vertices_mark);
    chunk_->batches.truncate(batches_mark);
    if (clip_batch_ >= batches_mark) clip_draw_ = nullptr;
  }
}

void GeometryWorker::count_for_draw(const Draw& draw, const PassStatistics& before, size_t binned_before) {
  if (!draw.counters) [[likely]]
    return;
  DrawCounters& c = *draw.counters;
  c.vertices_shaded += statistics.vertices_shaded - before.vertices_shaded;
  c.primitives_in += statistics.triangles_in - before.triangles_in;
  c.triangles_clipped += statistics.triangles_clipped - before.triangles_clipped;
  c.triangles_culled += statistics.triangles_culled - before.triangles_culled;
  c.triangles_binned += chunk_->triangles.size() - binned_before;
}

void GeometryWorker::run_clear(const Draw& draw, uint64_t first, uint32_t count) {
  const auto batch = static_cast<uint32_t>(chunk_->batches.size());
  chunk_->batches.push_back({&draw, nullptr});
  for (uint64_t i = first; i < first + count; ++i) {
    const Rect& r = draw.clear_rects[i / draw.clear_layers];
    binner_.set_layer(draw.clear_first_layer + static_cast<uint32_t>(i % draw.clear_layers));
    Triangle t{};
    t.x_fx8[0] = r.x0;  // a clear's record holds its rectangle in pixels
    t.y_fx8[0] = r.y0;
    t.x_fx8[1] = r.x1;
    t.y_fx8[1] = r.y1;
    t.batch = batch;
    t.set_flags(0, false, false, Shape::kParallelogram);  // anything but a triangle, which small ones are looked for among
    const auto index = static_cast<uint32_t>(chunk_->triangles.size());
    chunk_->triangles.push_back(t);
    binner_.add_rect(draw, index, r);
  }
}

uint64_t GeometryWorker::run(const TileGrid& grid, std::span<const PrimRange> ranges, const Options& options, Chunk& chunk) {
  const size_t max_entries = options.max_chunk_entries;
  transform_ = transform_function(options.isa);
  small_gather_ = small_gather_function(options.isa);
  small_setup_ = small_setup_function(options.isa);
  small_records_ = small_records_function(options.isa);
  chunk_ = &chunk;
  options_ = &options;
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
