#include "tools/camera.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "tools/error.h"

namespace pineda::tools {
namespace {

TEST(Camera, AllPointsFillTheFrame) {
  constexpr uint32_t kSeed = 7;
  std::mt19937 random(kSeed);
  for (const float size : {1e-3f, 1.0f, 1e4f}) {
    for (const float aspect : {0.5f, 1.0f, 1.8f}) {
      SCOPED_TRACE(fmt::format("seed {} size {} aspect {}", kSeed, size, aspect));
      std::uniform_real_distribution<float> coordinate(-size, size);
      std::vector<glm::vec3> points;
      for (int i = 0; i < 500; ++i)
        points.emplace_back(coordinate(random) + 3 * size, coordinate(random), 0.2f * coordinate(random));
      const Camera camera = fit_camera(points, glm::normalize(glm::vec3(-0.6f, -0.4f, -0.8f)), aspect, 0.35f, 0.9f);
      float largest = 0;
      for (const glm::vec3& point : points) {
        const glm::vec4 clip = camera.view_projection * glm::vec4(point, 1);
        ASSERT_GT(clip.w, 0);
        ASSERT_GE(clip.z, 0);
        ASSERT_LE(clip.z, clip.w);
        largest = std::max({largest, std::abs(clip.x / clip.w), std::abs(clip.y / clip.w)});
      }
      // As large as wanted, at the side that decides; 1e-3 is for the rounding of floats at ten times the model's size.
      EXPECT_NEAR(largest, 0.9f, 1e-3f);
    }
  }
}

TEST(Camera, DegenerateModelsStayFinite) {
  const glm::vec3 direction = glm::normalize(glm::vec3(-1, -1, -1));
  for (const std::vector<glm::vec3>& points : {std::vector<glm::vec3>{}, {glm::vec3(1, 2, 3)}, {glm::vec3(0), glm::vec3(0)}}) {
    const Camera camera = fit_camera(points, direction, 1, 0.35f, 0.9f);
    for (int column = 0; column < 4; ++column) {
      for (int row = 0; row < 4; ++row) EXPECT_TRUE(std::isfinite(camera.view_projection[column][row]));
    }
  }
}

TEST(Camera, YPointsDownAndNearIsZero) {
  const std::vector<glm::vec3> points{glm::vec3(-1), glm::vec3(1)};
  const Camera camera = fit_camera(points, glm::vec3(0, 0, -1), 1, 0.35f, 0.9f);
  const glm::vec4 high = camera.view_projection * glm::vec4(0, 1, 0, 1), low = camera.view_projection * glm::vec4(0, -1, 0, 1);
  EXPECT_LT(high.y / high.w, low.y / low.w);
  const glm::vec4 near = camera.view_projection * glm::vec4(0, 0, 1, 1), far = camera.view_projection * glm::vec4(0, 0, -1, 1);
  EXPECT_LT(near.z / near.w, far.z / far.w);
}

}  // namespace
}  // namespace pineda::tools
