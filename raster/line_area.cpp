#include "raster/line_area.h"

#include <immintrin.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

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
  per_factor_ = ((uint64_t{1} << kFactorBits) + state.stipple_factor - 1) / state.stipple_factor;
  pattern_ = state.stipple_pattern;
}

int64_t LineStipple::unit(double along_px) const {
  return static_cast<int64_t>(std::floor(start_px_ + std::clamp(along_px, 0.0, length_px_)));
}

// unit / factor by a multiplication: per_factor_ exceeds 2^40 / factor by less than 1, so the quotient is exact for unit * factor
// < 2^40, and the product has 64 bits for unit < 2^24. Factors end at 256; a pattern begins below 2^12, and a line of the guard
// band is shorter than 2^17 px.
bool LineStipple::draws_unit(int64_t unit) const {
  return (pattern_ >> (static_cast<uint64_t>(unit) * per_factor_ >> kFactorBits) % 16 & 1) != 0;
}

bool LineStipple::draws(int32_t x_fx8, int32_t y_fx8) const { return draws_unit(unit(along_px(x_fx8, y_fx8))); }

LineArea::LineArea(const Triangle& line, const LineState& state, bool stippled, Isa isa)
    : areas_(area_function(isa)), stipple_(line, state), stippled_(stippled) {
  const auto px = [](int32_t fx8) { return fx8 / double{kSubpixels}; };
  const int32_t(&x)[3] = line.x_fx8, (&y)[3] = line.y_fx8;
  corner_[0] = {px(x[0]), px(y[0])};
  corner_[1] = {px(x[1]), px(y[1])};
  corner_[2] = {px(x[1] + x[2] - x[0]), px(y[1] + y[2] - y[0])};
  corner_[3] = {px(x[2]), px(y[2])};
  for (int k = 0; k < 4; ++k) {  // clockwise on the screen, as lines are set up
    const Point &p = corner_[k], &q = corner_[(k + 1) % 4];
    half_plane_[k] = {p.y - q.y, q.x - p.x, 0};
    half_plane_[k].c = -(half_plane_[k].a * p.x + half_plane_[k].b * p.y);
    if (k >= 2) continue;
    slope_[k] = q.x == p.x ? 0 : (q.y - p.y) / (q.x - p.x);
    per_slope_[k] = q.y == p.y ? 0 : (q.x - p.x) / (q.y - p.y);
  }
  if (!stippled_) add_rectangle(corner_, whole_);
}

bool LineArea::misses(int32_t x_px, int32_t y_px, int32_t size_px) const {
  for (const HalfPlane& h : half_plane_) {
    const double x = h.a > 0 ? x_px + size_px : x_px, y = h.b > 0 ? y_px + size_px : y_px;
    if (h.a * x + h.b * y + h.c < 0) return true;
  }
  return false;
}

// A rectangle whose corners run clockwise and whose sides are parallel to the line's.
void LineArea::add_rectangle(const Point (&corner)[4], Sides& to) const {
  for (int k = 0; k < 4; ++k) {
    const Point &p = corner[k], &q = corner[(k + 1) % 4];
    if (p.x == q.x) continue;  // nothing lies above or below it
    const double slope = slope_[k % 2], per_slope = per_slope_[k % 2];
    to.side[to.count++] =
        p.x < q.x ? AreaSide{p.x, p.y, q.x, q.y, slope, per_slope, -1} : AreaSide{q.x, q.y, p.x, p.y, slope, per_slope, 1};
  }
}

// The runs of rectangles of the stipple that are drawn and reach a block.
void LineArea::add_pieces(int32_t x_px, int32_t y_px, Sides& to) const {
  double least = 1e9, most = -1e9;
  for (int k = 0; k < 4; ++k) {
    const int32_t x = x_px + (k & 1) * int32_t{kBlockDim}, y = y_px + (k >> 1) * int32_t{kBlockDim};
    const double along = stipple_.along_px(x * kSubpixels, y * kSubpixels);
    least = std::min(least, along);
    most = std::max(most, along);
  }
  const double length = stipple_.length_px(), start = stipple_.start_px();
  const int64_t last = stipple_.unit(most);
  for (int64_t u = stipple_.unit(least); u <= last && to.count + 4 <= kMaxAreaSides; ++u) {
    if (!stipple_.draws_unit(u)) continue;
    const double begin = std::max(0.0, static_cast<double>(u) - start) / length;
    while (u < last && stipple_.draws_unit(u + 1)) ++u;
    const double end = std::min(length, static_cast<double>(u) + 1 - start) / length;
    if (begin >= end) continue;
    const auto between = [&](const Point& p, const Point& q, double t) {
      return Point{p.x + (q.x - p.x) * t, p.y + (q.y - p.y) * t};
    };
    add_rectangle({between(corner_[0], corner_[1], begin), between(corner_[0], corner_[1], end),
                   between(corner_[3], corner_[2], end), between(corner_[3], corner_[2], begin)},
                  to);
  }
}

void LineArea::block(int32_t x_px, int32_t y_px, uint16_t* parts) const {
  if (!stippled_) return areas_(whole_.side.data(), whole_.count, x_px, y_px, parts);
  Sides pieces;
  add_pieces(x_px, y_px, pieces);
  areas_(pieces.side.data(), pieces.count, x_px, y_px, parts);
}

namespace {

// One copy of the code for each instruction set.
namespace sse42 {
using Reals = double __attribute__((vector_size(16)));
using Counts = int32_t __attribute__((vector_size(8)));
inline Reals lower(Reals a, Reals b) { return _mm_min_pd(a, b); }
inline Reals higher(Reals a, Reals b) { return _mm_max_pd(a, b); }
#include "raster/line_area_impl.inc"
}  // namespace sse42

#pragma GCC push_options
#pragma GCC target("avx2")
namespace avx2 {
using Reals = double __attribute__((vector_size(32)));
using Counts = int32_t __attribute__((vector_size(16)));
inline Reals lower(Reals a, Reals b) { return _mm256_min_pd(a, b); }
inline Reals higher(Reals a, Reals b) { return _mm256_max_pd(a, b); }
#include "raster/line_area_impl.inc"
}  // namespace avx2
#pragma GCC pop_options

#pragma GCC push_options
#pragma GCC target("avx512f,avx512dq,avx2")
namespace avx512 {
using Reals = double __attribute__((vector_size(64)));
using Counts = int32_t __attribute__((vector_size(32)));
inline Reals lower(Reals a, Reals b) { return _mm512_min_pd(a, b); }
inline Reals higher(Reals a, Reals b) { return _mm512_max_pd(a, b); }
#include "raster/line_area_impl.inc"
}  // namespace avx512
#pragma GCC pop_options

}  // namespace

AreaFn area_function(Isa isa) { return for_isa(isa, sse42::block_areas, avx2::block_areas, avx512::block_areas); }

}  // namespace pineda::raster
