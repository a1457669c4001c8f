#include "tools/accuracy/reference.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <glm/common.hpp>
#include <limits>
#include <thread>
#include <vector>

#include "tools/accuracy/reference_shaders.h"

namespace pineda::tools {
namespace {

using glm::dvec2;
using glm::dvec4;

struct SampleLocation {
  int x, y;  // 1/16 px from the pixel's top left corner
};

// "Standard sample locations", Vulkan 1.3, section 25.3; written down again, as the reference shares no code with the driver.
std::vector<SampleLocation> sample_locations(uint32_t count) {
  switch (count) {
    case 2:
      return {{12, 12}, {4, 4}};
    case 4:
      return {{6, 2}, {14, 6}, {2, 10}, {10, 14}};
    case 8:
      return {{9, 5}, {7, 11}, {13, 9}, {5, 3}, {3, 13}, {1, 7}, {11, 15}, {15, 1}};
    case 16:
      return {{9, 9},  {7, 5}, {5, 10}, {12, 7}, {3, 6}, {10, 13}, {13, 11}, {11, 3},
              {6, 14}, {8, 1}, {4, 2},  {2, 12}, {0, 8}, {15, 4},  {14, 15}, {1, 0}};
    default:
      return {{8, 8}};
  }
}

constexpr double kDepthResolution = 1e-6;  // of binary32 near 1, with what interpolation loses

struct ScreenTriangle {
  dvec2 corner[3];       // px
  double depth[3];       // z / w
  double depth_shift;    // what snapping may add to a depth between the vertices
  double reciprocal[3];  // 1 / w
  dvec4 varying[3];
  double area2;  // twice the signed area, px²
  dvec2 low, high;
};

double cross(dvec2 a, dvec2 b) { return a.x * b.y - a.y * b.x; }

// Twice the signed area of (a, b, p). The rounding does not depend on the edge's direction, so that the two triangles at an edge
// agree about a sample on it.
double edge_function(dvec2 a, dvec2 b, dvec2 p) {
  const bool swapped = b.x < a.x || (b.x == a.x && b.y < a.y);
  if (swapped) std::swap(a, b);
  const double value = cross(b - a, p - a);
  return swapped ? -value : value;
}

// For y downwards and positive area: edges that go up, or right along a top (specification, "Basic Polygon Rasterization").
bool is_top_left(dvec2 a, dvec2 b) { return b.y < a.y || (b.y == a.y && b.x > a.x); }

double depth_shift(const ScreenTriangle& t) {
  const dvec2 a = t.corner[1] - t.corner[0], b = t.corner[2] - t.corner[0];
  const double da = t.depth[1] - t.depth[0], db = t.depth[2] - t.depth[0];
  return kVertexSnap_px * (std::abs(da * b.y - db * a.y) + std::abs(db * a.x - da * b.x)) / t.area2;
}

std::vector<ScreenTriangle> transform(const SuiteScene& scene, uint32_t width, uint32_t height) {
  const std::vector<SuiteVertex> vertices = scene.triangles();
  std::vector<ScreenTriangle> triangles;
  for (size_t first = 0; first + 2 < vertices.size(); first += 3) {
    ScreenTriangle triangle;
    const auto vertex = [&](size_t i) {
      const SuiteVertex& from = vertices[first + i];
      const dvec4 place(from.place[0], from.place[1], from.place[2], from.place[3]);
      const dvec4 data(from.data[0], from.data[1], from.data[2], from.data[3]);
      const dvec4 clip = reference::position(scene.shader, place, data);
      triangle.corner[i] = {(clip.x / clip.w + 1) / 2 * width, (clip.y / clip.w + 1) / 2 * height};
      triangle.depth[i] = clip.z / clip.w;
      triangle.reciprocal[i] = 1 / clip.w;
      triangle.varying[i] = reference::varying(scene.shader, place, data);
    };
    for (size_t i = 0; i < 3; ++i) vertex(i);
    triangle.area2 = edge_function(triangle.corner[0], triangle.corner[1], triangle.corner[2]);
    if (triangle.area2 == 0) continue;
    if (triangle.area2 < 0) {  // one orientation for all that follows; nothing is culled
      std::swap(triangle.corner[1], triangle.corner[2]);
      std::swap(triangle.depth[1], triangle.depth[2]);
      std::swap(triangle.reciprocal[1], triangle.reciprocal[2]);
      std::swap(triangle.varying[1], triangle.varying[2]);
      triangle.area2 = -triangle.area2;
    }
    triangle.depth_shift = depth_shift(triangle);
    triangle.low = glm::min(glm::min(triangle.corner[0], triangle.corner[1]), triangle.corner[2]);
    triangle.high = glm::max(glm::max(triangle.corner[0], triangle.corner[1]), triangle.corner[2]);
    triangles.push_back(triangle);
  }
  return triangles;
}

class RowRenderer {  // draws one row of pixels after the other
 public:
  RowRenderer(const SuiteScene& scene, const std::vector<ScreenTriangle>& triangles, const std::vector<dvec2>& samples,
              Shading shading, uint32_t width)
      : scene_(scene), triangles_(triangles), samples_(samples), shading_(shading), width_(width) {}

  void draw(uint32_t y, ReferencePicture& picture, std::vector<uint8_t>& undecided) {
    colours_.assign(size_t{width_} * samples_.size(), dvec4(0, 0, 0, 1));
    depths_.assign(colours_.size(), {1.0, 0.0});
    for (const ScreenTriangle& triangle : triangles_) {
      if (triangle.high.y < y - kSnap_px || triangle.low.y > y + 1 + kSnap_px) continue;
      const double first = std::clamp(std::floor(triangle.low.x - kSnap_px), 0.0, double(width_));
      const double last = std::clamp(std::ceil(triangle.high.x + kSnap_px), 0.0, double(width_));
      for (uint32_t x = uint32_t(first); x < uint32_t(last); ++x) {
        if (draw_pixel(triangle, x, y)) undecided[size_t{y} * width_ + x] = 1;
      }
    }
    for (uint32_t x = 0; x < width_; ++x) {
      dvec4 sum(0);
      for (size_t s = 0; s < samples_.size(); ++s) sum += colours_[x * samples_.size() + s];
      picture.colours[size_t{y} * width_ + x] = sum / double(samples_.size());
    }
  }

 private:
  // Whether a sample was too near to decide.
  bool draw_pixel(const ScreenTriangle& triangle, uint32_t x, uint32_t y) {
    bool near = false, shaded = false;
    dvec4 colour;
    for (size_t s = 0; s < samples_.size(); ++s) {
      const dvec2 p = dvec2(x, y) + samples_[s];
      bool inside = true;
      double nearest = std::numeric_limits<double>::infinity();
      double weight[3];
      for (int i = 0; i < 3; ++i) {
        const dvec2 a = triangle.corner[(i + 1) % 3], b = triangle.corner[(i + 2) % 3];
        const double value = edge_function(a, b, p);
        inside &= value > 0 || (value == 0 && is_top_left(a, b));
        nearest = std::min(nearest, value / std::hypot(b.x - a.x, b.y - a.y));
        weight[i] = value / triangle.area2;
      }
      near |= std::abs(nearest) < kSnap_px;
      if (!inside) continue;
      const size_t at = x * samples_.size() + s;
      if (scene_.depth) {
        const double depth = weight[0] * triangle.depth[0] + weight[1] * triangle.depth[1] + weight[2] * triangle.depth[2];
        StoredDepth& stored = depths_[at];
        near |= std::abs(depth - stored.depth) < kDepthResolution + triangle.depth_shift + stored.shift;
        if (!(depth <= stored.depth)) continue;
        stored = {depth, triangle.depth_shift};
      }
      if (!shaded || shading_ == Shading::kSample) {
        colour = shade(triangle, shading_ == Shading::kSample ? p : dvec2(x + 0.5, y + 0.5));
        shaded = true;
      }
      colours_[at] = scene_.blend ? over(colour, colours_[at]) : colour;
    }
    return near;
  }

  // Source alpha over destination, as tools/vk/pipelines.cpp sets it up.
  static dvec4 over(const dvec4& source, const dvec4& destination) {
    const double rest = 1 - source.w;
    return {source.x * source.w + destination.x * rest, source.y * source.w + destination.y * rest,
            source.z * source.w + destination.z * rest, source.w + destination.w * rest};
  }

  dvec4 shade(const ScreenTriangle& triangle, dvec2 p) const {
    dvec4 sum(0);
    double reciprocal = 0;
    for (int i = 0; i < 3; ++i) {
      const double weight =
          edge_function(triangle.corner[(i + 1) % 3], triangle.corner[(i + 2) % 3], p) / triangle.area2 * triangle.reciprocal[i];
      sum += weight * triangle.varying[i];
      reciprocal += weight;
    }
    return reference::colour(scene_.shader, sum / reciprocal);
  }

  const SuiteScene& scene_;
  const std::vector<ScreenTriangle>& triangles_;
  const std::vector<dvec2>& samples_;
  const Shading shading_;
  const uint32_t width_;
  std::vector<dvec4> colours_;  // of the row's samples
  struct StoredDepth {
    double depth, shift;
  };
  std::vector<StoredDepth> depths_;
};

// The part of a convex polygon where `sign` * (coordinate - bound) <= 0 (Sutherland and Hodgman, 1974).
std::vector<dvec2> cut(const std::vector<dvec2>& polygon, int axis, double bound, double sign) {
  std::vector<dvec2> result;
  for (size_t i = 0; i < polygon.size(); ++i) {
    const dvec2 a = polygon[i], b = polygon[(i + 1) % polygon.size()];
    const double from = sign * (a[axis] - bound), to = sign * (b[axis] - bound);
    if (from <= 0) result.push_back(a);
    if ((from < 0 && to > 0) || (from > 0 && to < 0)) result.push_back(a + (b - a) * (from / (from - to)));
  }
  return result;
}

double area(const std::vector<dvec2>& polygon) {
  double twice = 0;
  for (size_t i = 1; i + 1 < polygon.size(); ++i) twice += cross(polygon[i] - polygon[0], polygon[i + 1] - polygon[0]);
  return std::abs(twice) / 2;
}

}  // namespace

ReferencePicture render_reference(const SuiteScene& scene, uint32_t width, uint32_t height, const std::vector<dvec2>& samples,
                                  Shading shading) {
  const std::vector<ScreenTriangle> triangles = transform(scene, width, height);
  ReferencePicture picture{
      .width = width, .height = height, .colours = std::vector<dvec4>(size_t{width} * height), .undecided = {}};
  std::vector<uint8_t> undecided(picture.colours.size());
  std::atomic<uint32_t> next_row = 0;
  const auto work = [&] {
    RowRenderer renderer(scene, triangles, samples, shading, width);
    for (uint32_t y; (y = next_row++) < height;) renderer.draw(y, picture, undecided);
  };
  {
    std::vector<std::jthread> threads;
    for (unsigned i = 1; i < std::thread::hardware_concurrency(); ++i) threads.emplace_back(work);
    work();
  }
  if (shading == Shading::kPixelCentre) picture.undecided.assign(undecided.begin(), undecided.end());
  return picture;
}

std::vector<dvec2> standard_samples(uint32_t count) {
  std::vector<dvec2> samples;
  for (const SampleLocation& location : sample_locations(count)) samples.emplace_back(location.x / 16.0, location.y / 16.0);
  return samples;
}

std::vector<dvec2> area_samples(uint32_t count) {
  std::vector<dvec2> samples;
  for (uint32_t i = 0; i < count; ++i) {
    double radical_inverse = 0.5 / count;
    for (uint32_t bits = i, weight = 1; bits; bits >>= 1, weight *= 2) radical_inverse += (bits & 1) / (2.0 * weight);
    samples.emplace_back((i + 0.5) / count, radical_inverse);
  }
  return samples;
}

std::vector<double> exact_coverage(const SuiteScene& scene, uint32_t width, uint32_t height) {
  std::vector<double> coverage(size_t{width} * height);
  for (const ScreenTriangle& triangle : transform(scene, width, height)) {
    const std::vector<dvec2> whole(triangle.corner, triangle.corner + 3);
    const auto first = [](double low) { return uint32_t(std::max(0.0, std::floor(low))); };
    for (uint32_t y = first(triangle.low.y); y < std::min<double>(height, triangle.high.y); ++y) {
      const std::vector<dvec2> row = cut(cut(whole, 1, y, -1), 1, y + 1, 1);
      for (uint32_t x = first(triangle.low.x); x < std::min<double>(width, triangle.high.x); ++x) {
        coverage[size_t{y} * width + x] += area(cut(cut(row, 0, x, -1), 0, x + 1, 1));
      }
    }
  }
  return coverage;
}

}  // namespace pineda::tools
