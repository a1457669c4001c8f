#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "tools/error.h"
#include "tools/extreme/rig.h"

namespace pineda::tools {
namespace {

// Positions are binary32, pixel centres are dyadic, so edge functions need at most 24 + 24 + 9 bits: exact in a long double's 64.
using Real = long double;

struct Place {
  Real distance_px;  // to the nearest edge; > 0 inside
};

// Homogeneous rasterization (Olano and Greer, "Triangle Scan Conversion using 2D Homogeneous Coordinates", 1997): no clipping,
// and right for every sign of w.
Place classify(std::span<const RigVertex> triangle, const VkViewport& viewport, Real x_px, Real y_px) {
  const Real x = 2 * (x_px - viewport.x) / viewport.width - 1, y = 2 * (y_px - viewport.y) / viewport.height - 1;
  const auto component = [&](int vertex, int i) {
    return Real{triangle[static_cast<size_t>(vertex)].place[static_cast<size_t>(i)]};
  };
  Real edges[3][3], determinant = 0;
  for (int i = 0; i < 3; ++i) {
    const int a = (i + 1) % 3, b = (i + 2) % 3;
    edges[i][0] = component(a, 1) * component(b, 3) - component(a, 3) * component(b, 1);
    edges[i][1] = component(a, 3) * component(b, 0) - component(a, 0) * component(b, 3);
    edges[i][2] = component(a, 0) * component(b, 1) - component(a, 1) * component(b, 0);
  }
  for (int k = 0; k < 3; ++k) determinant += component(0, k == 2 ? 3 : k) * edges[0][k];
  Place place{std::numeric_limits<Real>::infinity()};
  if (determinant == 0) return {-std::numeric_limits<Real>::infinity()};
  const Real sign = determinant > 0 ? 1 : -1;
  for (const auto& edge : edges) {
    const Real value = sign * (edge[0] * x + edge[1] * y + edge[2]);
    const Real per_px = std::hypot(edge[0] * 2 / viewport.width, edge[1] * 2 / viewport.height);
    const Real distance = per_px == 0 ? value * std::numeric_limits<Real>::infinity() : value / per_px;
    place.distance_px = std::min(place.distance_px, distance);
  }
  return place;
}

VkViewport whole(VkExtent2D extent) { return {0, 0, static_cast<float>(extent.width), static_cast<float>(extent.height), 0, 1}; }

Image picture_of(const std::vector<float>& counts, VkExtent2D extent, size_t stride = 1) {
  constexpr uint8_t kColours[][3] = {{18, 22, 30}, {90, 150, 250}, {250, 200, 60}, {250, 80, 60}};
  Image image{.width = extent.width,
              .height = extent.height,
              .rgba = std::vector<uint8_t>(size_t{4} * extent.width * extent.height, 255)};
  for (size_t i = 0; i < size_t{extent.width} * extent.height; ++i) {
    const auto count = static_cast<size_t>(std::clamp(counts[i * stride], 0.0f, 3.0f));
    std::copy_n(kColours[count], 3, image.rgba.begin() + static_cast<ptrdiff_t>(4 * i));
  }
  return image;
}

// How often each pixel is covered, by additive blending.
std::vector<float> count(ExtremeRig& rig, const RigTarget& target, std::vector<RigVertex> vertices) {
  const RigDraw draws[] = {{.vertices = std::move(vertices), .blend = kAdditive}};
  return rig.draw_as<float>(target, draws);
}

bool lacks_counting(ExtremeRig& rig) {
  return !rig.has_format(VK_FORMAT_R32_SFLOAT, VK_FORMAT_FEATURE_COLOR_ATTACHMENT_BLEND_BIT);
}

Outcome judge_covered_once(const std::vector<float>& counts, VkExtent2D extent, const char* caption) {
  const auto gaps = std::ranges::count_if(counts, [](float n) { return n < 1; });
  const auto overlaps = std::ranges::count_if(counts, [](float n) { return n > 1; });
  return {.verdict = gaps || overlaps ? Verdict::kWrong : Verdict::kExact,
          .measured = fmt::format("{} gaps, {} overlaps in {} pixels", gaps, overlaps, counts.size()),
          .truth = "0 gaps, 0 overlaps",
          .bound = {},
          .bytes = bytes_of(counts),
          .pictures = {{caption, picture_of(counts, extent)}}};
}

// One triangle against exact arithmetic. Within: only where a vertex moved by 1/2 of the subpixel grid may decide.
Outcome judge_triangle(ExtremeRig& rig, const std::vector<float>& counts, std::span<const RigVertex> triangle, VkExtent2D extent,
                       const VkViewport& viewport, const char* caption) {
  const Real snap_px = std::numbers::sqrt2_v<Real> / static_cast<Real>(1u << rig.limits().subPixelPrecisionBits);
  size_t differing = 0, beyond = 0, covered = 0;
  for (uint32_t y = 0; y < extent.height; ++y) {
    for (uint32_t x = 0; x < extent.width; ++x) {
      const Place place = classify(triangle, viewport, x + 0.5L, y + 0.5L);
      const float wanted = place.distance_px > 0 ? 1 : 0;
      covered += wanted == 1;
      if (counts[size_t{y} * extent.width + x] == wanted) continue;
      ++differing;
      beyond += std::abs(place.distance_px) > snap_px;
    }
  }
  return {.verdict = beyond      ? Verdict::kWrong
                     : differing ? Verdict::kWithin
                                 : Verdict::kExact,
          .measured = fmt::format("{} pixels differ", differing),
          .truth = fmt::format("{} of {} pixels covered", covered, counts.size()),
          .bound = fmt::format("pixels within {:.4f} px of an edge", static_cast<double>(snap_px)),
          .bytes = bytes_of(counts),
          .pictures = {{caption, picture_of(counts, extent)}}};
}

Outcome draw_triangle(ExtremeRig& rig, std::vector<RigVertex> triangle, const char* caption, VkExtent2D extent = {64, 64},
                      std::optional<VkViewport> viewport = {}) {
  if (lacks_counting(rig)) return {};
  const std::vector<float> counts = count(rig, {.extent = extent, .viewport = viewport}, triangle);
  return judge_triangle(rig, counts, triangle, extent, viewport.value_or(whole(extent)), caption);
}

RigVertex at(float x, float y, float w = 1) { return {{x, y, 0, w}}; }

// ---- slivers
// -----------------------------------------------------------------------------------------------------------------------

Outcome sliver_fan(ExtremeRig& rig) {
  if (lacks_counting(rig)) return {};
  constexpr int kSides = 8192;
  const auto rim = [](int i) {
    const double angle = 2 * std::numbers::pi * (i % kSides) / kSides;
    return at(static_cast<float>(3 * std::cos(angle)), static_cast<float>(3 * std::sin(angle)));
  };
  std::vector<RigVertex> vertices;
  for (int i = 0; i < kSides; ++i) {
    for (const RigVertex& vertex : {at(0.1f, -0.2f), rim(i), rim(i + 1)}) vertices.push_back(vertex);
  }
  return judge_covered_once(count(rig, {}, vertices), {64, 64}, "8,192 slivers around a point");
}

Outcome sliver_strip(ExtremeRig& rig) {
  if (lacks_counting(rig)) return {};
  constexpr int kStrips = 20000;  // 0.0032 px wide
  std::vector<RigVertex> vertices;
  const auto edge = [](int i) { return static_cast<float>(2.2 * i / kStrips - 1.1); };
  for (int i = 0; i < kStrips; ++i) {
    // Slanted, so that a row's centre meets every strip at another place.
    const float a = edge(i), b = edge(i + 1);
    const RigVertex corners[] = {at(a - 0.05f, -1.5f), at(b - 0.05f, -1.5f), at(a + 0.05f, 1.5f), at(b + 0.05f, 1.5f)};
    for (const int corner : {0, 1, 2, 2, 1, 3}) vertices.push_back(corners[corner]);
  }
  return judge_covered_once(count(rig, {}, vertices), {64, 64}, "20,000 strips of 0.0035 px");
}

// ---- sizes
// -------------------------------------------------------------------------------------------------------------------------

Outcome huge_triangle(ExtremeRig& rig) {  // 2^20 px are 2^15 units here
  return draw_triangle(rig, {at(-32768, -16383.625f), at(32767.75f, 16384.5f), at(-32768, 32768)}, "a triangle of 2^20 px");
}

Outcome huge_shared_edges(ExtremeRig& rig) {
  if (lacks_counting(rig)) return {};
  // Eight sectors around a point in the picture, their rims 2^19 px away and more.
  const RigVertex centre = at(0.015625f, 0.046875f);
  const RigVertex rim[] = {at(32768, 0.3f),   at(30000, 31000.5f),     at(0.7f, 32768),    at(-31000.25f, 29000),
                           at(-32768, -0.1f), at(-29000, -32000.125f), at(0.2f, -32768.f), at(31234.5f, -30000)};
  std::vector<RigVertex> vertices;
  for (int i = 0; i < 8; ++i) {
    for (const RigVertex& vertex : {centre, rim[i], rim[(i + 1) % 8]}) vertices.push_back(vertex);
  }
  return judge_covered_once(count(rig, {}, vertices), {64, 64}, "sectors with rims 2^20 px away");
}

Outcome zero_area(ExtremeRig& rig) {
  if (lacks_counting(rig)) return {};
  const float c = 1.0f / 64;  // a pixel's centre
  const std::vector<float> counts = count(rig, {},
                                          {at(-1, -1), at(1, 1), at(0, 0),  // on a line through centres
                                           at(c, c), at(c, c), at(c, c),    // a point
                                           at(-1, c), at(1, c), at(-1, c),  // there and back
                                           at(-0.5f, 0.25f), at(0.5f, 0.25f), at(0.25f, 0.25f)});
  const auto covered = std::ranges::count_if(counts, [](float n) { return n != 0; });
  return {.verdict = covered ? Verdict::kWrong : Verdict::kExact,
          .measured = fmt::format("{} pixels covered", covered),
          .truth = "0 pixels covered",
          .bytes = bytes_of(counts)};
}

// ---- w
// -----------------------------------------------------------------------------------------------------------------------------

Outcome w_tiny(ExtremeRig& rig) {
  return draw_triangle(rig, {at(-0.6f, 0.7f), at(0.8f, 0.6f), at(0x1p-100f, -0x1.8p-100f, 0x1p-100f)},
                       "w = 2^-100 at one vertex");
}
Outcome w_zero(ExtremeRig& rig) {  // a vertex at infinity
  return draw_triangle(rig, {at(-0.55f, 0.7f), at(0.45f, 0.75f), at(0.25f, -1, 0)}, "a vertex at infinity");
}
Outcome w_negative(ExtremeRig& rig) {
  return draw_triangle(rig, {at(-0.7f, -0.8f), at(0.5f, -0.6f), at(0.3f, -0.9f, -0.5f)}, "one vertex behind the eye");
}
Outcome w_two_negative(ExtremeRig& rig) {
  return draw_triangle(rig, {at(0.1f, 0.2f), at(0.9f, 0.2f, -0.75f), at(-0.4f, 1.1f, -1.25f)}, "two vertices behind the eye");
}
Outcome w_scaled(ExtremeRig& rig) {  // the same triangle times 2^-120: homogeneous coordinates have no scale
  const float s = 0x1p-120f;
  return draw_triangle(rig, {at(-0.7f * s, -0.8f * s, s), at(0.9f * s, -0.3f * s, s), at(0.1f * s, 0.85f * s, s)},
                       "all coordinates times 2^-120");
}

// ---- what is no number
// -------------------------------------------------------------------------------------------------------------

Outcome among_bad(ExtremeRig& rig, float bad) {
  if (!rig.has_format(VK_FORMAT_R32G32_SFLOAT, VK_FORMAT_FEATURE_COLOR_ATTACHMENT_BLEND_BIT)) return {};
  const std::array<float, 4> kGood{1, 0, 0, 0}, kBad{0, 1, 0, 0};
  const std::vector<RigVertex> good{
      {{-0.71f, -0.83f, 0, 1}, kGood}, {{0.93f, -0.37f, 0, 1}, kGood}, {{0.11f, 0.87f, 0, 1}, kGood}};
  std::vector<RigVertex> vertices;
  for (int component = 0; component < 4; ++component) {
    for (int vertex = 0; vertex < 3; ++vertex) {
      std::vector<RigVertex> triangle{{{-0.5f, -0.5f, 0, 1}, kBad}, {{0.5f, -0.5f, 0, 1}, kBad}, {{0, 0.5f, 0, 1}, kBad}};
      triangle[static_cast<size_t>(vertex)].place[static_cast<size_t>(component)] = bad;
      vertices.insert(vertices.end(), triangle.begin(), triangle.end());
    }
  }
  vertices.insert(vertices.begin() + 18, good.begin(), good.end());
  const RigTarget target{.colour = VK_FORMAT_R32G32_SFLOAT, .bytes_per_pixel = 8};
  const RigDraw draws[] = {{.vertices = vertices, .blend = kAdditive}};
  const std::vector<float> both = rig.draw_as<float>(target, draws);
  std::vector<float> counts(both.size() / 2);
  for (size_t i = 0; i < counts.size(); ++i) counts[i] = both[2 * i];
  Outcome outcome = judge_triangle(rig, counts, good, {64, 64}, whole({64, 64}), "the good triangle among bad ones");
  outcome.measured += " in the good triangle";
  outcome.bytes = bytes_of(both);
  return outcome;
}

Outcome among_nan(ExtremeRig& rig) { return among_bad(rig, std::numeric_limits<float>::quiet_NaN()); }
Outcome among_infinity(ExtremeRig& rig) { return among_bad(rig, std::numeric_limits<float>::infinity()); }
Outcome among_negative_infinity(ExtremeRig& rig) { return among_bad(rig, -std::numeric_limits<float>::infinity()); }
Outcome among_largest(ExtremeRig& rig) { return among_bad(rig, std::numeric_limits<float>::max()); }
Outcome among_denormal(ExtremeRig& rig) { return among_bad(rig, std::numeric_limits<float>::denorm_min()); }

// ---- viewports
// ---------------------------------------------------------------------------------------------------------------------

Outcome viewport_largest(ExtremeRig& rig) {
  const VkPhysicalDeviceLimits limits = rig.limits();
  const uint32_t size = std::min({limits.maxViewportDimensions[0], limits.maxViewportDimensions[1], 16384u});
  const float side = static_cast<float>(size), corner = 32 - side / 2;
  const float px = 2 / side;  // the picture is the middle 64 px of the viewport
  return draw_triangle(rig, {at(-25.25f * px, -30.5f * px), at(28.75f * px, -3.25f * px), at(-3.5f * px, 29.75f * px)},
                       "in the middle of the largest viewport", {64, 64}, VkViewport{corner, corner, side, side, 0, 1});
}

Outcome viewport_far(ExtremeRig& rig) {  // only its last corner is in the picture
  const VkPhysicalDeviceLimits limits = rig.limits();
  const float side = std::min(static_cast<float>(limits.maxViewportDimensions[0]), 16384.0f), corner = 64 - side;
  const auto ndc = [&](float px) { return 2 * (px - corner) / side - 1; };
  return draw_triangle(rig, {at(ndc(5), ndc(3)), at(ndc(60), ndc(20)), at(ndc(20), ndc(61))},
                       "the last corner of a large viewport", {64, 64}, VkViewport{corner, corner, side, side, 0, 1});
}

Outcome viewport_flipped(ExtremeRig& rig) {
  if (!rig.context().has_maintenance1()) return {};
  return draw_triangle(rig, {at(-0.7f, -0.8f), at(0.9f, -0.3f), at(0.1f, 0.85f)}, "a viewport of negative height", {64, 64},
                       VkViewport{0, 64, 64, -64, 0, 1});
}

Outcome viewport_tiny(ExtremeRig& rig) {
  return draw_triangle(rig, {at(-1, -1), at(1, -1), at(-1, 1)}, "a viewport of 2^-6 px around a pixel's centre", {64, 64},
                       VkViewport{20.49609375f, 30.49609375f, 0.015625f, 0.015625f, 0, 1});
}

constexpr const char* kPolygons =
    "Vulkan 1.3, Basic Polygon Rasterization: a sample on a shared edge belongs to exactly one polygon";
constexpr const char* kExactEdges =
    "exact edge functions (long double); Vulkan 1.3, Basic Polygon Rasterization and subPixelPrecisionBits";
constexpr const char* kClipping =
    "homogeneous rasterization in exact arithmetic (Olano, Greer 1997); Vulkan 1.3, Primitive Clipping";
constexpr const char* kOthers = "Vulkan 1.3, Primitive Clipping: only the primitive with such a vertex is undefined";

constexpr ExtremeCase kCases[] = {
    {"geometry", "fan of slivers",
     "8,192 triangles around a point cover every pixel exactly once, though most are thinner than a subpixel", kPolygons,
     sliver_fan},
    {"geometry", "strip of slivers", "20,000 slanted strips of 0.0035 px cover every pixel exactly once", kPolygons,
     sliver_strip},
    {"geometry", "triangle of 2^20 px", "The edges of a triangle of 2^20 px are where exact arithmetic has them", kExactEdges,
     huge_triangle},
    {"geometry", "shared edges at 2^20 px", "Eight sectors whose rims are 2^20 px away cover every pixel exactly once", kPolygons,
     huge_shared_edges},
    {"geometry", "zero area", "Triangles without area cover nothing, even on lines through samples", kPolygons, zero_area},
    {"geometry", "w of 2^-100", "A vertex almost in the eye's plane", kClipping, w_tiny},
    {"geometry", "w of 0", "A vertex at infinity", kClipping, w_zero},
    {"geometry", "w below 0", "One vertex behind the eye", kClipping, w_negative},
    {"geometry", "two w below 0", "Two vertices behind the eye", kClipping, w_two_negative},
    {"geometry", "homogeneous scale 2^-120", "Scaling x, y and w together changes nothing", kClipping, w_scaled},
    {"geometry", "NaN", "12 triangles with a NaN in each component change nothing in the triangle among them", kOthers,
     among_nan},
    {"geometry", "infinity", "The same with infinity", kOthers, among_infinity},
    {"geometry", "-infinity", "The same with -infinity", kOthers, among_negative_infinity},
    {"geometry", "largest float", "The same with 3.4e38", kOthers, among_largest},
    {"geometry", "smallest denormal", "The same with 1.4e-45", kOthers, among_denormal},
    {"geometry", "largest viewport", "A triangle in the middle of a viewport of the largest size", kExactEdges, viewport_largest},
    {"geometry", "viewport far outside", "The last corner of a viewport that begins 16,320 px outside", kExactEdges,
     viewport_far},
    {"geometry", "flipped viewport", "A viewport of negative height", kExactEdges, viewport_flipped},
    {"geometry", "viewport of 2^-6 px", "A viewport much smaller than a pixel, around its centre", kExactEdges, viewport_tiny},
};

}  // namespace

std::span<const ExtremeCase> geometry_cases() { return kCases; }

}  // namespace pineda::tools
