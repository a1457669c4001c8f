// Which pixels a Bresenham line covers: the diamond-exit rule (Vulkan 1.3, "Bresenham Line Segment Rasterization"), in integers.
//
// A pixel belongs to the line from a to b when the line leaves the pixel's diamond |x - xc| + |y - yc| < 1/2 between them: it
// meets the diamond, and b is not in it. Both ends are moved by (-e, -e^2) first, e as small as you like, which decides every
// tie.
//
// For an x-major line (|dx| >= |dy|) the infinite line meets the diamonds of one pixel in each column, the one whose centre is
// nearest to it along y: the half-width of the diamond along y is 1/2, and |slope| <= 1 keeps the line from passing beside it.
// Where the line lies exactly between two centres, the shift moves it by e * slope - e^2 along y: to the higher row if dy / dx >
// 0, else to the lower. For y-major lines the shift by -e decides for the lower column. coverage.cpp has these two edges. The
// ends are the columns (rows) below:
//   - a column whose centre is between a and b belongs to the line, as the line is in the diamond there and leaves it later;
//   - the column whose centre the line has just passed at a belongs to it if a is still in the diamond;
//   - the column whose centre it has just passed at b belongs to it unless b is still in the diamond.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstdlib>

#include "raster/geometry_types.h"

namespace pineda::raster {

// Pixels [first, end) along the major axis.
struct PixelLine {
  Shape shape;
  int32_t first, end;
};

// Whether the moved point is in a diamond of column (row, if `major_is_y`) `pixel`. The moved point lies in the pixel below when
// its minor coordinate is on the boundary of two.
inline bool in_diamond(int32_t major_fx8, int32_t minor_fx8, int32_t pixel, bool major_is_y) {
  constexpr int32_t kHalf = kSubpixels / 2;
  const int32_t along = major_fx8 - (pixel * kSubpixels + kHalf);
  const int32_t across = minor_fx8 - (((minor_fx8 - 1) >> 8) * kSubpixels + kHalf);
  const int32_t distance = std::abs(along) + std::abs(across);
  if (distance != kHalf) return distance < kHalf;
  // On the diamond's side: the larger part of the shift, -e along x, points inside where x > xc.
  return (major_is_y ? across : along) > 0;
}

// "The actual width w of Bresenham lines is determined by rounding the line width to the nearest integer ..."
inline int32_t bresenham_width(float width_px) {
  return width_px < kMaxLineWidth ? std::max(1, static_cast<int32_t>(width_px + 0.5f)) : static_cast<int32_t>(kMaxLineWidth);
}

inline PixelLine pixel_line(int32_t ax_fx8, int32_t ay_fx8, int32_t bx_fx8, int32_t by_fx8) {
  const int32_t dx = bx_fx8 - ax_fx8, dy = by_fx8 - ay_fx8;
  const bool y_major = std::abs(dx) < std::abs(dy);
  const int32_t a = y_major ? ay_fx8 : ax_fx8, b = y_major ? by_fx8 : bx_fx8;
  const int32_t a_minor = y_major ? ax_fx8 : ay_fx8, b_minor = y_major ? bx_fx8 : by_fx8;
  // The first column whose centre is at or after the end; moved ends are before a centre that they touch.
  const auto column = [](int32_t v) { return (v + kSubpixels / 2 - 1) >> 8; };
  const int32_t a_column = column(a), b_column = column(b);
  const auto inside = [&](int32_t v, int32_t minor, int32_t pixel) { return in_diamond(v, minor, pixel, y_major) ? 1 : 0; };
  PixelLine line{y_major ? Shape::kPixelLineY : Shape::kPixelLineX, 0, 0};
  if (a <= b) {
    line.first = a_column - inside(a, a_minor, a_column - 1);
    line.end = b_column - inside(b, b_minor, b_column - 1);
  } else {
    line.first = b_column + inside(b, b_minor, b_column);
    line.end = a_column + inside(a, a_minor, a_column);
  }
  return line;
}

}  // namespace pineda::raster
