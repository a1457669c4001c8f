// The edges of a record, from which coverage is made.
#pragma once

#include "raster/geometry_types.h"

namespace pineda::raster {

// The edges of a record in 64 bits: inside where a * (x - x0) + b * (y - y0) + c >= 0.
struct EdgeList {
  struct Edge {
    int32_t a, b, x0, y0;
    int64_t c;
  };
  Edge edge[4];
  int count = 0;

  explicit EdgeList(const Triangle& t) {
    switch (t.shape()) {
      case Shape::kTriangle:
        for (int k = 0; k < 3; ++k) add_side(t, t.x_fx8[k], t.y_fx8[k], t.x_fx8[(k + 1) % 3], t.y_fx8[(k + 1) % 3]);
        break;
      case Shape::kParallelogram: {
        const int32_t x[4] = {t.x_fx8[0], t.x_fx8[1], t.x_fx8[1] + t.x_fx8[2] - t.x_fx8[0], t.x_fx8[2]};
        const int32_t y[4] = {t.y_fx8[0], t.y_fx8[1], t.y_fx8[1] + t.y_fx8[2] - t.y_fx8[0], t.y_fx8[2]};
        for (int k = 0; k < 4; ++k) add_side(t, x[k], y[k], x[(k + 1) % 4], y[(k + 1) % 4]);
        break;
      }
      case Shape::kPixelLineX:
      case Shape::kPixelLineY:
        add_pixel_line(t);
        break;
    }
  }

 private:
  void add_side(const Triangle& t, int32_t px, int32_t py, int32_t qx, int32_t qy) {
    const bool clockwise = (t.provoking_and_flags & Triangle::kClockwise) != 0;
    const int32_t a = clockwise ? py - qy : qy - py, b = clockwise ? qx - px : px - qx;
    const bool top_left = a > 0 || (a == 0 && b > 0);
    edge[count++] = {a, b, px, py, top_left ? 0 : -1};
  }

  // Half a pixel to both sides of the line, along the minor axis. Centres exactly between two pixels: bresenham.h.
  void add_pixel_line(const Triangle& t) {
    const bool is_x = t.shape() == Shape::kPixelLineX;
    int32_t dx = t.x_fx8[1] - t.x_fx8[0], dy = t.y_fx8[1] - t.y_fx8[0];
    if ((is_x ? dx : dy) < 0) {
      dx = -dx;
      dy = -dy;
    }
    // F = a * (x - x0) + b * (y - y0) is the pixel's distance from the line along the minor axis, times `major`.
    const int32_t major = is_x ? dx : dy, a = is_x ? -dy : dy, b = is_x ? dx : -dx;
    const bool high_side = is_x && dy > 0;  // of two pixels equally near the line takes the one at the higher row
    const int64_t half = int64_t{major} * (kSubpixels / 2);
    edge[count++] = {a, b, t.x_fx8[0], t.y_fx8[0], half - (high_side ? 1 : 0)};
    edge[count++] = {-a, -b, t.x_fx8[0], t.y_fx8[0], half - (high_side ? 0 : 1)};
  }
};

}  // namespace pineda::raster
