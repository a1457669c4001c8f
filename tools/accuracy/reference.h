// The truth of `pineda report`: the whole pipeline in binary64, by a renderer that shares nothing with any driver.
//
// Vertices, perspective division, viewport, interpolation, shading, depth, blending and resolve are binary64; the attachments are
// too. A sample is covered when it lies inside the triangle of the unrounded vertices (the top-left rule where it lies on an
// edge), not of vertices snapped to a grid of 1/256 px as drivers do. All of it follows the formulas of the Vulkan specification
// ("Rasterization", "Polygons"; "Multisampling"), none of it anybody's code.
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec4.hpp>
#include <vector>

#include "tools/accuracy/suite.h"

namespace pineda::tools {

enum class Shading {
  kPixelCentre,  // as multisampling does: once for each triangle and pixel, at the centre, even where only other samples are
                 // covered
  kSample,
};

struct ReferencePicture {
  uint32_t width = 0, height = 0;
  std::vector<glm::dvec4> colours;  // of the pixels: means of their samples
  // Pixels where a driver's coverage or order may rightly differ: a sample is nearer to an edge than kSnap_px, or two surfaces
  // are nearer in depth than binary32 and the grid of vertices tell apart. Empty for Shading::kSample.
  std::vector<bool> undecided;
};

// Snapping moves a vertex by at most 1/512 px along x and along y (subPixelPrecisionBits = 8), so an edge by at most sqrt(2)/512
// px; the rest is for the rounding of vertices in binary32.
inline constexpr double kSnap_px = 1.0 / 256;
// The same for a vertex, along one axis. A driver may interpolate from the moved vertices, as their framebuffer coordinates have
// that precision. With weights w_i of the moved vertices v_i + d_i, a depth at p is that of the unmoved plane at p - sum of
// w_i d_i; inside the triangle that is no farther than the largest d_i.
inline constexpr double kVertexSnap_px = 1.0 / 480;

// `samples`: places in the pixel, 0 to 1. The background is (0, 0, 0, 1).
ReferencePicture render_reference(const SuiteScene& scene, uint32_t width, uint32_t height,
                                  const std::vector<glm::dvec2>& samples, Shading shading);

std::vector<glm::dvec2> standard_samples(uint32_t count);  // the specification's standard sample locations
// `count` (a power of two) points of Hammersley's set. Its discrepancy falls as log(count) / count, so that means over it
// approach means over the pixel's area.
std::vector<glm::dvec2> area_samples(uint32_t count);

// The share of each pixel's area that the scene's triangles cover, which must not overlap: each triangle is cut to the pixel's
// square, and its area is taken by the shoelace formula. Exact but for binary64's rounding.
std::vector<double> exact_coverage(const SuiteScene& scene, uint32_t width, uint32_t height);

}  // namespace pineda::tools
