// Two things that lines along their length and width have and triangles do not: the stipple of rectangular lines, and the part of
// a pixel that a smooth line covers (Vulkan 1.3, "Line Stipple" and "Smooth Lines").
//
// The arithmetic is binary64 in a fixed order, so every machine has the same bits; of the tile only whole pixels come in, so tile
// size cannot show.
#pragma once

#include <array>
#include <cstdint>

#include "raster/geometry_types.h"
#include "raster/options.h"

namespace pineda::raster {

// The rectangle of a record, cut into adjacent rectangles of one pixel's length from its first end on; the last may be shorter.
// Rectangle number s, counted through the strip, is drawn if bit s / factor (modulo 16) of the pattern is set.
class LineStipple {
 public:
  LineStipple(const Triangle& line, const LineState& state);
  // Whether the rectangle that the point lies in (or would, if it went on to all sides) is drawn.
  bool draws(int32_t x_fx8, int32_t y_fx8) const;

  // Number of the rectangle at a distance from the first end, and whether it is drawn.
  int64_t unit(double along_px) const;
  bool draws_unit(int64_t unit) const;
  // From the first end.
  double along_px(double x_fx8, double y_fx8) const { return ((x_fx8 - x0_) * dx_ + (y_fx8 - y0_) * dy_) * per_length_; }
  double start_px() const { return start_px_; }
  double length_px() const { return length_px_; }

 private:
  double x0_, y0_;     // of the first end, fx8
  double dx_, dy_;     // to the other end, fx8
  double per_length_;  // 1 / (length in fx8 * 256)
  double length_px_;
  double start_px_;  // where in the pattern the line begins
  static constexpr uint32_t kFactorBits = 40;
  uint64_t per_factor_;  // 2^40 / factor, rounded up
  uint32_t pattern_;
};

// A block is 5.7 px from corner to corner and so reaches into seven rectangles of a stipple at most, of which every other one
// begins a piece: four pieces of four sides.
inline constexpr uint32_t kMaxAreaSides = 16;

// A side of a polygon, from left to right.
struct AreaSide {
  double x0, y0, x1, y1;    // px; x0 < x1
  double slope, per_slope;  // dy / dx; dx / dy, or 0 for a level side
  double sign;              // 1: the polygon lies above it (at smaller y); -1: below
};

// For each pixel of the block at (x_px, y_px) the area of what the sides enclose of its square, in 1/65535 of the square, rounded
// to nearest; in lane order.
using AreaFn = void (*)(const AreaSide* sides, uint32_t count, int32_t x_px, int32_t y_px, uint16_t* parts);
AreaFn area_function(Isa isa);

// Coverage by area.
class LineArea {
 public:
  static constexpr uint32_t kFull = 65535;
  // `stippled`: state has a stipple.
  LineArea(const Triangle& line, const LineState& state, bool stippled, Isa isa);
  // The areas of the intersections of the line with the squares of a block's pixels, as AreaFn gives them.
  void block(int32_t x_px, int32_t y_px, uint16_t* parts) const;
  // No pixel of the square [x, x + size) x [y, y + size) is touched: never wrong when true.
  bool misses(int32_t x_px, int32_t y_px, int32_t size_px) const;

 private:
  struct Point {
    double x, y;  // px
  };
  struct Sides {
    std::array<AreaSide, kMaxAreaSides> side;
    uint32_t count = 0;
  };
  void add_rectangle(const Point (&corner)[4], Sides& to) const;
  void add_pieces(int32_t x_px, int32_t y_px, Sides& to) const;

  AreaFn areas_;
  Point corner_[4];
  // Of each side: inside where a * x + b * y + c >= 0.
  struct HalfPlane {
    double a, b, c;
  } half_plane_[4];
  double slope_[2], per_slope_[2];  // of the sides along the line and across
  Sides whole_;
  LineStipple stipple_;
  bool stippled_;
};

}  // namespace pineda::raster
