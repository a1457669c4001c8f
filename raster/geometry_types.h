// What geometry hands to the tiles: triangles, batches, chunks and the draws they came from.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <vector>

#include "raster/raster.h"

namespace pineda::raster {

// ---- fixed point ----------------------------------------------------------------------------------------------------------
// Window coordinates are snapped to 1/256 px (subPixelPrecisionBits = 8), "fx8". A vertex that reaches setup lies inside the
// guard band, so the difference of two coordinates stays below 49154 px * 256 < 2^23.6; coverage.h builds its overflow proof on
// that.
inline constexpr int32_t kSubpixels = 256;
inline constexpr float kGuardMinPx = -16384, kGuardMaxPx = 32768;
inline constexpr int32_t kMinFx8 = (-16384 - 1) * kSubpixels;  // one pixel of slack for the rounding of clipped coordinates
inline constexpr int32_t kMaxFx8 = (32768 + 1) * kSubpixels;

struct Rect {  // half open, px
  int32_t x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  bool empty() const { return x0 >= x1 || y0 >= y1; }
  bool contains(const Rect& r) const { return x0 <= r.x0 && y0 <= r.y0 && x1 >= r.x1 && y1 >= r.y1; }
  bool operator==(const Rect&) const = default;
};

inline Rect intersect(const Rect& a, const Rect& b) {
  return {std::max(a.x0, b.x0), std::max(a.y0, b.y0), std::min(a.x1, b.x1), std::min(a.y1, b.y1)};
}

inline Rect to_rect(const VkRect2D& r) {
  static constexpr int64_t kLimit = 1 << 20;  // larger than any framebuffer
  const auto clamp = [](int64_t v) { return static_cast<int32_t>(std::clamp<int64_t>(v, -kLimit, kLimit)); };
  return {clamp(r.offset.x), clamp(r.offset.y), clamp(int64_t{r.offset.x} + r.extent.width),
          clamp(int64_t{r.offset.y} + r.extent.height)};
}

// ---- memory ---------------------------------------------------------------------------------------------------------------

// A growing array of plain data that leaves new elements uninitialised and keeps its memory when cleared.
template <class T>
class PodBuffer {
 public:
  T* data() { return data_.get(); }
  const T* data() const { return data_.get(); }
  size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  T& operator[](size_t i) { return data_.get()[i]; }
  const T& operator[](size_t i) const { return data_.get()[i]; }
  size_t capacity_bytes() const { return capacity_ * sizeof(T); }
  void clear() { size_ = 0; }
  void truncate(size_t n) { size_ = n; }  // n <= size()
  void push_back(const T& value) {
    if (size_ == capacity_) grow(size_ + 1);
    data_.get()[size_++] = value;
  }
  T* append(size_t n) {
    if (size_ + n > capacity_) grow(size_ + n);
    T* first = data_.get() + size_;
    size_ += n;
    return first;
  }

 private:
  static_assert(std::is_trivially_copyable_v<T>);
  static constexpr size_t kAlignment = 64;
  struct Free {
    void operator()(T* p) const { std::free(p); }
  };
  void grow(size_t wanted) {
    const size_t capacity = std::max({wanted, capacity_ * 2, size_t{64}});
    const size_t bytes = (capacity * sizeof(T) + kAlignment - 1) / kAlignment * kAlignment;
    std::unique_ptr<T, Free> grown(static_cast<T*>(std::aligned_alloc(kAlignment, bytes)));
    if (!grown) std::abort();  // as operator new would, without exceptions
    if (size_ != 0) std::memcpy(static_cast<void*>(grown.get()), data_.get(), size_ * sizeof(T));
    data_ = std::move(grown);
    capacity_ = capacity;
  }
  std::unique_ptr<T, Free> data_;
  size_t size_ = 0, capacity_ = 0;
};

// Memory whose addresses stay valid until reset(); blocks are kept for the next use.
class Arena {
 public:
  static constexpr size_t kAlignment = 64;
  void* allocate(size_t bytes) {
    bytes = (bytes + kAlignment - 1) / kAlignment * kAlignment;
    while (block_ < blocks_.size() && used_ + bytes > blocks_[block_].bytes) {
      ++block_;
      used_ = 0;
    }
    if (block_ == blocks_.size()) {
      const size_t size = std::max(bytes, kBlockBytes);
      blocks_.push_back({std::unique_ptr<uint8_t, Free>(static_cast<uint8_t*>(std::aligned_alloc(kAlignment, size))), size});
      if (!blocks_.back().memory) std::abort();
      capacity_bytes_ += size;
    }
    void* memory = blocks_[block_].memory.get() + used_;
    used_ += bytes;
    used_bytes_ += bytes;
    return memory;
  }
  void reset() { block_ = used_ = used_bytes_ = 0; }
  // What was allocated after mark() is free again.
  struct Mark {
    size_t block, used, used_bytes;
  };
  Mark mark() const { return {block_, used_, used_bytes_}; }
  void rewind(const Mark& to) { block_ = to.block, used_ = to.used, used_bytes_ = to.used_bytes; }
  size_t used_bytes() const { return used_bytes_; }
  size_t capacity_bytes() const { return capacity_bytes_; }

 private:
  static constexpr size_t kBlockBytes = 256 << 10;
  struct Free {
    void operator()(uint8_t* p) const { std::free(p); }
  };
  struct Block {
    std::unique_ptr<uint8_t, Free> memory;
    size_t bytes;
  };
  std::vector<Block> blocks_;
  size_t block_ = 0, used_ = 0, used_bytes_ = 0, capacity_bytes_ = 0;
};

// ---- draws ----------------------------------------------------------------------------------------------------------------

// Viewport transform (Vulkan 1.3, "Controlling the Viewport") with the x and y scale in fx8, and the guard band in clip space.
struct ViewportTransform {
  float scale_x_fx8, offset_x_fx8, scale_y_fx8, offset_y_fx8;
  float scale_z, offset_z;
  float guard_x_min, guard_x_max, guard_y_min,
      guard_y_max;  // in normalised device coordinates: inside when min * w <= x <= max * w
  bool clip_depth;  // 0 <= z <= w
};
ViewportTransform make_viewport_transform(const VkViewport& viewport, bool clip_depth);
// Pixels whose centre is in the viewport: what clipping to the sides of the view volume leaves of a polygon or a line, which the
// guard band lets reach further.
Rect viewport_rect(const VkViewport& viewport);

// How a draw's depth test bounds what it can pass.
enum class HiZMode : uint8_t { kNone, kLess, kGreater };

// A primitive of a draw with primitive restart.
struct RestartPrimitive {
  std::array<uint32_t, 3> vertex;  // positions from the draw's first index on
  bool begins;                     // the first of its strip
};

// What a primitive's vertices make, before polygon modes.
enum class PrimitiveKind : uint8_t { kPoint, kLine, kTriangle };

// DrawStatistics that several threads add to.
struct DrawCounters {
  std::atomic<uint64_t> vertices_shaded = 0, primitives_in = 0, triangles_clipped = 0, triangles_culled = 0, triangles_binned = 0;
  std::atomic<uint64_t> blocks_shaded = 0;
};

struct Draw {
  DrawPacket packet;
  // Stippled line strips count their pixels from primitive to primitive, so one thread does all of such a draw, and where the
  // pattern stands is here.
  bool in_order = false;
  mutable double stipple_position = 0;
  bool stipples = false, smooth = false;  // its records are lines with a stipple; smooth ones
  DrawCounters* counters = nullptr;       // null: nobody asked
  PrimitiveKind kind = PrimitiveKind::kTriangle;
  ViewportTransform viewport;
  Rect rect;                                 // pixels that may be drawn: scissor, render area, framebuffer
  std::vector<ViewportTransform> viewports;  // of all viewports and their rectangles, when there are several
  std::vector<Rect> rects;
  bool routes = false;  // the vertex shader chooses each primitive's viewport or layer
  uint32_t layers = 1;  // that it may choose from
  const ViewportTransform& viewport_at(uint32_t i) const { return i == 0 ? viewport : viewports[i]; }
  const Rect& rect_at(uint32_t i) const { return i == 0 ? rect : rects[i]; }
  uint64_t prims_per_instance = 0;
  std::vector<RestartPrimitive> restart_prims;  // when restart is on
  HiZMode hi_z = HiZMode::kNone;
  VkFormat depth_format = VK_FORMAT_UNDEFINED;  // of the pass, for depth bias
  uint32_t samples = 1;                         // of a pixel
  bool writes_depth = false;
  bool can_cover = false;     // a full cover of a tile makes earlier work invisible
  bool blocks_cover = false;  // its work is visible whatever comes later (side effects, depth)
  // vkCmdClearAttachments instead of a draw
  bool is_clear = false;
  uint32_t clear_slot = 0;  // Scene::attachments
  std::array<uint8_t, 16> clear_texel{};
  std::vector<Rect> clear_rects;  // each for each of the layers
  uint32_t clear_first_layer = 0, clear_layers = 1;
};

// ---- geometry's output ----------------------------------------------------------------------------------------------------

// Primitives of one draw whose vertices lie in one block of memory and that go to one viewport and layer. Vertex v is lane v % 16
// of wave v / 16.
struct Batch {
  const Draw* draw;
  const float* vertices;
  uint32_t viewport = 0, layer = 0;
};

// What a record covers. A sample is covered by the rule of coverage.h.
enum class Shape : uint8_t {
  kTriangle,
  // Vertices 0, 1 and 2 and the fourth corner 1 + 2 - 0. Lines: 0 -> 1 goes along the line, 0 -> 2 across. Points: along x and y.
  kParallelogram,
  // A Bresenham line from vertex 0 to vertex 1 (raster/bresenham.h): pixels of columns (rows) [x_fx8[2], y_fx8[2]), which are
  // numbers of pixels, closest to the line.
  kPixelLineX,
  kPixelLineY,
};

// One primitive, one cache line. Vertex 0 is the origin of interpolation (and, for triangles, unless clipped away or
// far_near_order() turned it, the provoking vertex). Planes and edges are formed from it in the tiles that really draw it.
struct alignas(64) Triangle {
  int32_t x_fx8[3], y_fx8[3];
  float z0, dz1, dz2;  // window depth of vertex 0 with bias; differences without. A stippled line has its stipple's start in dz2
  float iw[3];         // 1 / w
  uint32_t primitive_id;
  uint32_t batch;                // in the chunk
  uint16_t vertex[3];            // in the batch
  uint16_t provoking_and_flags;  // vertex in the batch, and:
  static constexpr uint16_t kFront = 0x8000, kClockwise = 0x4000, kShapeBit = 12, kProvokingMask = 0x0FFF;
  void set_flags(uint16_t provoking, bool front, bool clockwise, Shape shape) {
    provoking_and_flags = static_cast<uint16_t>(provoking | (front ? kFront : 0) | (clockwise ? kClockwise : 0) |
                                                static_cast<uint32_t>(shape) << kShapeBit);
  }
  // Of stippled lines: where in the pattern they begin, below 2^12: a pixel line's counter, where l2 is 0 (as a float next to 0,
  // and harmless); a rectangle's distance, as the bits of a float, px.
  uint32_t stipple_start() const { return std::bit_cast<uint32_t>(dz2); }
  Shape shape() const { return static_cast<Shape>(provoking_and_flags >> kShapeBit & 3); }
};
static_assert(sizeof(Triangle) == 64);

// Pixels whose centre is inside the box of three vertices. A centre on the box's right or lower side is on no top or left edge.
inline Rect pixel_bounds(int32_t x0, int32_t x1, int32_t x2, int32_t y0, int32_t y1, int32_t y2) {
  constexpr int32_t kBelowHalf = kSubpixels / 2 - 1;
  return {(std::min(std::min(x0, x1), x2) + kBelowHalf) >> 8, (std::min(std::min(y0, y1), y2) + kBelowHalf) >> 8,
          (std::max(std::max(x0, x1), x2) + kBelowHalf) >> 8, (std::max(std::max(y0, y1), y2) + kBelowHalf) >> 8};
}

// Pixels that may have a sample inside the box, wherever in the pixel samples lie.
inline Rect touched_bounds(int32_t x0, int32_t x1, int32_t x2, int32_t y0, int32_t y1, int32_t y2) {
  return {std::min(std::min(x0, x1), x2) >> 8, std::min(std::min(y0, y1), y2) >> 8, (std::max(std::max(x0, x1), x2) >> 8) + 1,
          (std::max(std::max(y0, y1), y2) >> 8) + 1};
}

// The triangles of one chunk that touch one tile.
struct Segment {
  uint32_t tile;
  uint32_t first, count;  // in Chunk::entries
  uint32_t cover;         // 1 + position in the segment of the last cover that makes everything before it invisible; 0: none
  bool blocks_cover;
};

inline constexpr uint32_t kEntryCovers =
    1u << 31;  // the triangle covers the whole tile; the other bits are its index in Chunk::triangles

// A fixed amount of primitives, in API order: what one geometry job makes.
struct Chunk {
  Arena vertices;
  PodBuffer<Triangle> triangles;
  PodBuffer<Batch> batches;
  PodBuffer<uint32_t> entries;
  PodBuffer<Segment> segments;

  void reset() {
    vertices.reset();
    triangles.clear();
    batches.clear();
    entries.clear();
    segments.clear();
  }
  size_t used_bytes() const {
    return vertices.used_bytes() + triangles.size() * sizeof(Triangle) + batches.size() * sizeof(Batch) + entries.size() * 4 +
           segments.size() * sizeof(Segment);
  }
  size_t capacity_bytes() const {
    return vertices.capacity_bytes() + triangles.capacity_bytes() + batches.capacity_bytes() + entries.capacity_bytes() +
           segments.capacity_bytes();
  }
};

// Primitives [first, first + count) of a draw, counted through its instances.
struct PrimRange {
  const Draw* draw;
  uint64_t first;
  uint32_t count;
};

}  // namespace pineda::raster
