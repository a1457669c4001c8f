#include "raster/line_area.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace pineda::raster {

LineStipple::LineStipple(const Triangle& line, const LineState& state) {
  // Vertices 0 and 2 are half the width to either side of the first end.
  x0_ = (line.x_fx8[0] + line.x_fx8[2]) / 2.0;
  y0_ = (line.y_fx8[0] + line.y_fx8[2]) / 2.0;
  dx_ = line.x_fx8[1] - line.x_fx8[0];
  dy_ = line.y_fx8[1] - line.y_fx8[0];
  const double length_fx8 = std::sqrt(dx_ * dx_ + dy_ * dy_);
  per_length_ = 1 / (length_fx8 * kSubpixels);
  length_px_ = length_fx8 / kSubpixels;
  start_px_ = double{std::bit_cast<float>(line.stipple_start())};
  factor_ = state.stipple_factor;
  pattern_ = state.stipple_pattern;
}

int64_t LineStipple::unit(double along_px) const {
  return static_cast<int64_t>(std::floor(start_px_ + std::clamp(along_px, 0.0, length_px_)));
}

bool LineStipple::draws_unit(int64_t unit) const { return (pattern_ >> unit / factor_ % 16 & 1) != 0; }

bool LineStipple::draws(int32_t x_fx8, int32_t y_fx8) const { return draws_unit(unit(along_px(x_fx8, y_fx8))); }

LineArea::LineArea(const Triangle& line, const LineState& state, bool stippled) : stipple_(line, state), stippled_(stippled) {
  const auto px = [](int32_t fx8) { return fx8 / double{kSubpixels}; };
  const int32_t(&x)[3] = line.x_fx8, (&y)[3] = line.y_fx8;
  corner_[0] = {px(x[0]), px(y[0])};
  corner_[1] = {px(x[1]), px(y[1])};
  corner_[2] = {px(x[1] + x[2] - x[0]), px(y[1] + y[2] - y[0])};
  corner_[3] = {px(x[2]), px(y[2])};
  for (int k = 0; k < 4; ++k) {  // clockwise on the screen, as lines are set up
    const Point &p = corner_[k], &q = corner_[(k + 1) % 4];
    side_[k] = {p.y - q.y, q.x - p.x, 0};
    side_[k].c = -(side_[k].a * p.x + side_[k].b * p.y);
  }
}

bool LineArea::misses(int32_t x_px, int32_t y_px, int32_t size_px) const {
  for (const Side& s : side_) {
    const double x = s.a > 0 ? x_px + size_px : x_px, y = s.b > 0 ? y_px + size_px : y_px;
    if (s.a * x + s.b * y + s.c < 0) return true;
  }
  return false;
}

uint32_t LineArea::pixel(int32_t x_px, int32_t y_px) const {
  if (misses(x_px, y_px, 1)) return 0;
  const double part = stippled_ ? stippled_area(x_px, y_px) : area(corner_, x_px, y_px);
  return static_cast<uint32_t>(std::clamp(part, 0.0, 1.0) * kFull + 0.5);
}

// The sum over the rectangles of the stipple that are drawn and reach the pixel: four at most.
double LineArea::stippled_area(int32_t x_px, int32_t y_px) const {
  double least = 1e9, most = -1e9;
  for (int k = 0; k < 4; ++k) {
    const double along = stipple_.along_px((x_px + (k & 1)) * kSubpixels, (y_px + (k >> 1)) * kSubpixels);
    least = std::min(least, along);
    most = std::max(most, along);
  }
  const double length = stipple_.length_px(), start = stipple_.start_px();
  double sum = 0;
  for (int64_t u = stipple_.unit(least); u <= stipple_.unit(most); ++u) {
    if (!stipple_.draws_unit(u)) continue;
    const double begin = std::max(0.0, static_cast<double>(u) - start) / length;
    const double end = std::min(length, static_cast<double>(u) + 1 - start) / length;
    if (begin >= end) continue;
    const auto between = [&](const Point& p, const Point& q, double t) {
      return Point{p.x + (q.x - p.x) * t, p.y + (q.y - p.y) * t};
    };
    const Point piece[4] = {between(corner_[0], corner_[1], begin), between(corner_[0], corner_[1], end),
                            between(corner_[3], corner_[2], end), between(corner_[3], corner_[2], begin)};
    sum += area(piece, x_px, y_px);
  }
  return sum;
}

// Sutherland and Hodgman (1974) against the pixel's four sides, then the polygon's area, with the pixel's corner as origin.
double LineArea::area(const Point (&corner)[4], int32_t x_px, int32_t y_px) const {
  Point polygon[2][9];
  int count = 4, current = 0;
  for (int k = 0; k < 4; ++k) polygon[0][k] = {corner[k].x - x_px, corner[k].y - y_px};
  for (int side = 0; side < 4 && count != 0; ++side) {
    const Point* const in = polygon[current];
    Point* const out = polygon[current ^ 1];
    const auto inside = [&](const Point& p) {  // distance from the side
      const double v = (side & 1) != 0 ? p.y : p.x;
      return side < 2 ? v : 1 - v;
    };
    int kept = 0;
    for (int i = 0; i < count; ++i) {
      const Point &p = in[i], &q = in[i + 1 == count ? 0 : i + 1];
      const double dp = inside(p), dq = inside(q);
      if (dp >= 0) out[kept++] = p;
      if ((dp >= 0) == (dq >= 0)) continue;
      const double t = dp / (dp - dq);
      out[kept++] = {p.x + (q.x - p.x) * t, p.y + (q.y - p.y) * t};
    }
    count = kept;
    current ^= 1;
  }
  double twice = 0;
  for (int i = 0; i < count; ++i) {
    const Point &p = polygon[current][i], &q = polygon[current][i + 1 == count ? 0 : i + 1];
    twice += p.x * q.y - p.y * q.x;
  }
  return std::fabs(twice) / 2;
}

}  // namespace pineda::raster
