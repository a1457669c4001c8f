#include "tools/accuracy/suite.h"

#include <cmath>
#include <numbers>
#include <random>
#include <string_view>

#include "tools/error.h"

namespace pineda::tools {
namespace {

using Vertices = std::vector<SuiteVertex>;

float to_float(double value) { return static_cast<float>(value); }

// Spokes around the centre, as thin as edges of scenes get: every slope, and a centre where many meet in one pixel.
Vertices edges() {
  constexpr int kSpokes = 56;
  constexpr std::array<float, 4> kWhite{1, 1, 1, 1};
  Vertices vertices;
  for (int i = 0; i < kSpokes; ++i) {
    const double begin = 2 * std::numbers::pi * (i + 0.15) / kSpokes, end = begin + std::numbers::pi / kSpokes;
    const auto rim = [](double angle) {
      return std::array<float, 4>{to_float(0.71 * std::cos(angle)), to_float(0.94 * std::sin(angle)), 0, 1};
    };
    vertices.push_back({{0.0123f, -0.0071f, 0, 1}, kWhite});
    vertices.push_back({rim(begin), kWhite});
    vertices.push_back({rim(end), kWhite});
  }
  return vertices;
}

Vertices quad(const std::array<SuiteVertex, 4>& corners) {
  return {corners[0], corners[1], corners[2], corners[2], corners[1], corners[3]};
}

Vertices plane() {  // a floor from w = 1 to w = 128
  constexpr float kFar = 128, kSkyline = -0.75f;
  return quad({{{{-1.5f, 1, 0, 1}, {-3, 0, 0, 0}},
                {{1.5f, 1, 0, 1}, {3, 0, 0, 0}},
                {{-1.5f * kFar, kSkyline * kFar, 0, kFar}, {-3 * kFar, 24, 0, 0}},
                {{1.5f * kFar, kSkyline * kFar, 0, kFar}, {3 * kFar, 24, 0, 0}}}});
}

Vertices marble() {
  return quad({{{{-1, -1, 0, 1}, {-2, -1.5f, 0, 0}},
                {{1, -1, 0, 1}, {2, -1.5f, 0, 0}},
                {{-1, 1, 0, 1}, {-2, 1.5f, 0, 0}},
                {{1, 1, 0, 1}, {2, 1.5f, 0, 0}}}});
}

Vertices glass() {
  constexpr int kPanes = 48;
  std::mt19937 random(20261);
  const auto uniform = [&](double low, double high) {
    return to_float(low + (high - low) * static_cast<double>(random() >> 8) / 16777216.0);
  };
  Vertices vertices;
  for (int i = 0; i < kPanes; ++i) {
    const std::array<float, 4> colour{uniform(0, 1), uniform(0, 1), uniform(0, 1), uniform(0.1, 0.5)};
    for (int corner = 0; corner < 3; ++corner) vertices.push_back({{uniform(-1.1, 1.1), uniform(-1.1, 1.1), 0, 1}, colour});
  }
  return vertices;
}

Vertices spheres() {
  constexpr int kRings = 20, kSegments = 32;
  Vertices vertices;
  const std::array<std::array<float, 5>, 3> balls{// centre, radius, tint
                                                  std::array<float, 5>{-0.75f, 0.125f, -4, 1.25f, 0.75f},
                                                  {0.75f, -0.25f, -4.25f, 1.375f, 0.25f},
                                                  {0.25f, 0.75f, -3.25f, 0.5f, 0.5f}};
  for (const auto& [x, y, z, radius, tint] : balls) {
    const auto vertex = [&](int ring, int segment) {
      return SuiteVertex{{x, y, z, radius},
                         {to_float(std::numbers::pi * ring / kRings),
                          to_float(2 * std::numbers::pi * (segment % kSegments) / kSegments), tint, 0}};
    };
    for (int ring = 0; ring < kRings; ++ring) {
      for (int segment = 0; segment < kSegments; ++segment) {
        const Vertices patch =
            quad({vertex(ring, segment), vertex(ring, segment + 1), vertex(ring + 1, segment), vertex(ring + 1, segment + 1)});
        vertices.insert(vertices.end(), patch.begin(), patch.end());
      }
    }
  }
  return vertices;
}

constexpr SuiteScene kScenes[] = {
    {"edges", "Edges", "A star of 56 white spokes: nothing but coverage; the exact area is known", 0, false, false, true, edges},
    {"plane", "Receding plane", "Stripes in perspective 1 : 128, additions and multiplications only", 1, false, false, false,
     plane},
    {"marble", "Marble", "sin, cos, pow, exp, log2, atan and tanh at every fragment", 2, false, false, false, marble},
    {"glass", "Glass", "48 translucent panes, blended in order", 3, false, true, false, glass},
    {"spheres", "Spheres", "Three lit spheres that cut each other: sin and cos at vertices, depth, pow at fragments", 4, true,
     false, false, spheres},
};

}  // namespace

std::span<const SuiteScene> suite_scenes() { return kScenes; }

const SuiteScene& require_suite_scene(std::string_view name) {
  std::string names;
  for (const SuiteScene& scene : kScenes) {
    if (name == scene.name) return scene;
    names += fmt::format(" {}", scene.name);
  }
  fail("no scene '{}' in the accuracy suite (there are:{})", name, names);
}

}  // namespace pineda::tools
