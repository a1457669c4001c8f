// The geometry phase: one chunk of primitives -> shaded vertices -> clipped, culled, set-up triangles -> entries by tile.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "raster/binner.h"
#include "raster/clip.h"
#include "raster/geometry_types.h"
#include "raster/small_setup.h"
#include "raster/vertex_batch.h"

namespace pineda::raster {

// One thread's geometry. Reused from chunk to chunk.
class GeometryWorker {
 public:
  // Runs the ranges into `chunk`, which is empty. Returns how many primitives of the concatenated ranges were done: fewer than
  // all when the chunk has more bin entries than Options::max_chunk_entries (huge triangles over many tiles).
  uint64_t run(const TileGrid& grid, std::span<const PrimRange> ranges, const Options& options, Chunk& chunk);

  PassStatistics statistics{};

 private:
  void run_batch(const Draw& draw, uint64_t first, uint32_t count);
  void count_for_draw(const Draw& draw, const PassStatistics& before, size_t binned_before);
  bool sees_nothing(const Draw& draw, uint32_t vertices) const;
  void run_clear(const Draw& draw, uint64_t first, uint32_t count);

  // Vertices of a batch: its number, their records and window coordinates.
  struct BatchView {
    const WindowVertices* window;
    const float* vertices;
    uint32_t slots;  // of a record
    uint32_t batch;
    uint32_t viewport, layer;
    const float* vertex(uint32_t v) const { return vertices + size_t{v / kLanes} * slots * kLanes + v % kLanes; }
  };
  // What the lines and points of a primitive have in common.
  struct Outline {
    uint32_t primitive_id;
    uint16_t provoking;
    bool front;
    float depth_bias;
  };

  // Where a primitive goes.
  struct Route {
    uint32_t viewport, layer;
    bool operator==(const Route&) const = default;
  };
  // Primitives [begin, begin + count) of the batch, whose first has number `first` in its instance.
  void run_routed(const Draw& draw, const BatchView& view, uint64_t first, uint32_t count);
  void run_primitives(const Draw& draw, const BatchView& view, uint64_t first, uint32_t begin, uint32_t count);
  void run_triangles(const Draw& draw, const BatchView& view, uint64_t first, uint32_t begin, uint32_t count);
  void run_outlines(const Draw& draw, const BatchView& view, uint64_t first, uint32_t begin, uint32_t count);
  Route route_of(const Draw& draw, const BatchView& view, uint32_t i) const;
  void transform_to_viewports(const Draw& draw, uint32_t count);
  uint32_t batch_for(const Draw& draw, const BatchView& view, Route route);
  void outline(const Draw& draw, const BatchView& view, uint32_t primitive_id, const std::array<uint16_t, 3>& v);
  void emit(const Draw& draw, const BatchView& view, uint32_t primitive_id, const std::array<uint16_t, 3>& v, uint16_t provoking,
            bool clockwise, const Rect& bounds);
  void emit_small(const Draw& draw, const Rect& rect, uint32_t i);
  void clip(const Draw& draw, const BatchView& view, uint32_t primitive_id, const std::array<uint16_t, 3>& v);
  void setup_clipped(const Draw& draw, const BatchView& view, uint32_t primitive_id, uint16_t first, uint32_t count,
                     uint16_t provoking);
  BatchView add_clipped(const Draw& draw, Route route, uint32_t count, const float* extra, uint16_t& first);
  void begin_clip_batch(const Draw& draw, Route route, uint32_t vertices);

  // Culls, fills a record and bins it. `facing`: 0 or the sign that the triangle's area must have (pieces of a clipped triangle).
  void setup(const Draw& draw, const BatchView& view, uint32_t primitive_id, const std::array<uint16_t, 3>& v, uint16_t provoking,
             int facing);
  // Polygon modes LINE and POINT: the sides or corners of a polygon of vertices [first, first + count) or of v.
  void setup_outline(const Draw& draw, const BatchView& view, uint32_t primitive_id, std::span<const uint16_t> v,
                     uint16_t provoking);
  void bin(const Draw& draw, const BatchView& view, const Triangle& record);

  // line_setup.cpp
  void setup_line(const Draw& draw, const BatchView& view, uint16_t a, uint16_t b, const Outline& outline);
  void bin_pixel_line(const Draw& draw, const BatchView& view, Triangle& record, const Outline& outline);
  void bin_rectangle(const Draw& draw, const BatchView& view, Triangle& record, const Outline& outline);
  double advance_stipple(const Draw& draw, double length_px);
  void setup_point(const Draw& draw, const BatchView& view, uint16_t v, const Outline& outline);

  Chunk* chunk_ = nullptr;
  const Options* options_ = nullptr;
  Binner binner_;
  TransformFn transform_ = nullptr;
  SmallGatherFn small_gather_ = nullptr;
  SmallSetupFn small_setup_ = nullptr;
  SmallRecordsFn small_records_ = nullptr;
  SmallSetup small_group_{};
  VertexBatch batch_;
  Clipper clipper_;
  ThreadContext context_{};
  double stipple_position_ = 0;  // px
  // Clipped triangles keep their vertices in batches of their own, filled bit by bit.
  static constexpr uint32_t kClipBatchVertices = 512;
  const Draw* clip_draw_ = nullptr;
  float* clip_vertices_ = nullptr;
  uint32_t clip_used_ = 0, clip_batch_ = 0;
  Route clip_route_{};
  WindowVertices clip_window_;
  // Of the batch at hand, when its primitives choose: window coordinates in the viewports behind the first, and the records of
  // the pairs that occur.
  std::array<std::unique_ptr<WindowVertices>, kMaxViewports> windows_;
  struct RoutedBatch {
    Route route;
    uint32_t batch;
  };
  std::vector<RoutedBatch> routed_;
};

}  // namespace pineda::raster
