#include "tools/accuracy/accuracy.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tools/accuracy/plot.h"
#include "tools/accuracy/reference.h"

namespace pineda::tools {
namespace {

TEST(AccuracyMeasures, DistanceInUnitsInTheLastPlace) {
  EXPECT_EQ(distance_ulp(1.0, 1.0), 0);
  EXPECT_EQ(distance_ulp(std::nextafter(1.0f, 2.0f), 1.0), 1);
  EXPECT_EQ(distance_ulp(std::nextafter(1.0f, 0.0f), 1.0), 0.5);  // below a power of two floats lie twice as close
  EXPECT_EQ(distance_ulp(0.1f, 0.1), 0);                          // correctly rounded
  EXPECT_NEAR(distance_ulp(std::nextafter(0.1f, 1.0f), 0.1), 1.0, 0.5);
  EXPECT_EQ(distance_ulp(std::ldexp(1.0, -30), 0.0, 1.0 / 256), std::ldexp(1.0, -30 + 31));
}

TEST(AccuracyMeasures, ErrorOfAPicture) {
  const std::vector<float> floats{0.5f, 0.5f, 0.5f, 9, 0.25f, 0.25f, 1, 9};
  const std::vector<glm::dvec4> truth{{0.5, 0.5, 0.5, 0}, {0.25, 0.25, 0.25, 0}};
  const PictureError all = measure_error(floats, truth, {});
  EXPECT_EQ(all.largest, 0.75);
  EXPECT_DOUBLE_EQ(all.rmse, std::sqrt(0.75 * 0.75 / 6));
  EXPECT_EQ(all.ulp_histogram[0], 5u);
  EXPECT_EQ(all.ulp_histogram[kUlpBins - 1], 1u);
  const PictureError first = measure_error(floats, truth, {false, true});
  EXPECT_EQ(first.largest, 0);
  EXPECT_EQ(first.skipped_share, 0.5);
}

TEST(AccuracyMeasures, DominatedPoints) {
  const CostPoint points[] = {{1, 1}, {2, 0.5}, {2, 1}, {4, 0.5}, {8, 0.25}, {1.01, 1}, {8, 0.26}};
  // The last but one is slower by less than the timing noise; the last is further away by 4 %.
  EXPECT_EQ(dominated(points), (std::vector<bool>{false, false, true, true, false, false, false}));
}

TEST(AccuracyReference, SamplesApproachTheExactArea) {
  const SuiteScene& edges = require_suite_scene("edges");
  const std::vector<double> exact = exact_coverage(edges, 96, 72);
  double total = 0, previous = 1;
  for (const double share : exact) {
    total += share;
    EXPECT_LE(share, 1 + 1e-12);
  }
  // Half of an ellipse's area, less what chords cut off; the sum of 56 triangles in closed form.
  double sum = 0;
  const std::vector<SuiteVertex> vertices = edges.triangles();
  for (size_t i = 0; i < vertices.size(); i += 3) {
    const auto corner = [&](size_t k) { return glm::dvec2(vertices[i + k].place[0] * 48.0, vertices[i + k].place[1] * 36.0); };
    const glm::dvec2 a = corner(1) - corner(0), b = corner(2) - corner(0);
    sum += std::abs(a.x * b.y - a.y * b.x) / 2;
  }
  EXPECT_NEAR(total, sum, 1e-9);
  for (const uint32_t count : {1u, 16u, 256u}) {
    const ReferencePicture picture = render_reference(edges, 96, 72, area_samples(count), Shading::kSample);
    double squares = 0;
    for (size_t i = 0; i < exact.size(); ++i) squares += std::pow(picture.colours[i].x - exact[i], 2);
    const double rmse = std::sqrt(squares / static_cast<double>(exact.size()));
    EXPECT_LT(rmse, previous / 3);
    previous = rmse;
  }
  EXPECT_LT(previous, 0.005);
}

TEST(AccuracyReference, SharedEdgesAreCoveredOnce) {
  // A quad of two triangles whose diagonal and sides run through sample points: every one belongs to one triangle.
  constexpr SuiteScene kQuad{"quad", "", "", 3, false, true, false, [] {
                               const auto at = [](float x, float y) { return SuiteVertex{{x, y, 0, 1}, {1, 1, 1, 0.5f}}; };
                               return std::vector{at(-0.5f, -0.5f), at(0.5f, -0.5f), at(-0.5f, 0.5f),
                                                  at(-0.5f, 0.5f),  at(0.5f, -0.5f), at(0.5f, 0.5f)};
                             }};
  const ReferencePicture picture = render_reference(kQuad, 8, 8, {{0, 0}}, Shading::kSample);
  for (uint32_t y = 0; y < 8; ++y) {
    for (uint32_t x = 0; x < 8; ++x) {
      const bool inside = x >= 2 && x < 6 && y >= 2 && y < 6;
      EXPECT_EQ(picture.colours[y * 8 + x].x, inside ? 0.5 : 0.0) << x << " " << y;
    }
  }
}

// A plane of depth 0.5, and one that crosses it 1 / kReciprocal_px right of the centres of column 3 and rises by 0.03 a pixel.
template <int kReciprocal_px>
std::vector<SuiteVertex> crossing_planes() {
  std::vector<SuiteVertex> vertices;
  for (const double slope : {0.0, 0.03}) {
    for (const auto& [x, y] : {std::pair{-1.0f, -1.0f}, {3.0f, -1.0f}, {-1.0f, 3.0f}}) {
      const double x_px = 4 * (double{x} + 1), z = 0.5 + slope * (x_px - 3.5 - 1.0 / kReciprocal_px);
      vertices.push_back({{x, y, static_cast<float>(z), 1}, {1, 1, 1, 1}});
    }
  }
  return vertices;
}

// In depth the planes are 3e-5 and 2e-4 apart at the centres of column 3, far more than binary32 rounds. But vertices moved by
// 1/512 px put the crossing on either side of them in the first scene.
TEST(AccuracyReference, SnappedVerticesMayDecideDepth) {
  constexpr SuiteScene kNear{"near", "", "", 3, true, false, false, crossing_planes<1024>};
  constexpr SuiteScene kFar{"far", "", "", 3, true, false, false, crossing_planes<128>};
  const ReferencePicture near = render_reference(kNear, 8, 8, standard_samples(1), Shading::kPixelCentre);
  const ReferencePicture far = render_reference(kFar, 8, 8, standard_samples(1), Shading::kPixelCentre);
  for (uint32_t y = 0; y < 8; ++y) {
    for (uint32_t x = 0; x < 8; ++x) {
      EXPECT_EQ(near.undecided[y * 8 + x], x == 3) << x << " " << y;
      EXPECT_FALSE(far.undecided[y * 8 + x]) << x << " " << y;
    }
  }
}

TEST(AccuracyPlot, TicksOfLogarithmicAxes) {
  EXPECT_EQ(log_ticks(0.9, 30), (std::vector<double>{1, 2, 5, 10, 20}));
  EXPECT_EQ(log_ticks(0.5, 2000).size(), 4u);  // decades only
}

TEST(AccuracyPlot, MarksDominatedPoints) {
  const Plot plot{"t<", "x", "y", {{"a", "#123456", Mark::kCircle, {{1, 1, "1", "one", false}, {2, 2, "2", "two", true}}}}, 0};
  const std::string text = svg(plot);
  EXPECT_NE(text.find("t&lt;"), std::string::npos);
  EXPECT_NE(text.find("<title>two</title><circle"), std::string::npos);
  EXPECT_EQ(text.find("fill='var(--card, #ffffff)'"), text.rfind("fill='var(--card, #ffffff)'"));  // one hollow mark
}

}  // namespace
}  // namespace pineda::tools
