#include "tools/camera.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace pineda::tools {
namespace {

struct Basis {
  glm::vec3 right, up, back;
};

Basis basis_for(glm::vec3 direction) {
  const glm::vec3 back = -direction;
  const glm::vec3 world_up = std::abs(direction.y) > 0.999f ? glm::vec3(0, 0, -1) : glm::vec3(0, 1, 0);
  const glm::vec3 right = glm::normalize(glm::cross(world_up, back));
  return {right, glm::cross(back, right), back};
}

// Of the points in eye space, the eye at `z` on the axis: the frame's sides as tangents. A side that is not centred is moved by
// the caller.
struct Sides {
  float low = 1e30f, high = -1e30f;
  void include(float tangent) {
    low = std::min(low, tangent);
    high = std::max(high, tangent);
  }
};

}  // namespace

Camera fit_camera(std::span<const glm::vec3> points, glm::vec3 direction, float aspect, float tan_half_fov, float fill) {
  const Basis basis = basis_for(direction);
  const float tan_y = tan_half_fov * fill, tan_x = tan_half_fov * aspect * fill;
  // In the camera's axes, about the origin of the world: (x, y) across, z towards the eye.
  std::vector<glm::vec3> local;
  local.reserve(points.size());
  glm::vec3 low(1e30f), high(-1e30f);
  for (const glm::vec3& p : points) {
    local.emplace_back(glm::dot(p, basis.right), glm::dot(p, basis.up), glm::dot(p, basis.back));
    low = glm::min(low, local.back());
    high = glm::max(high, local.back());
  }
  if (local.empty()) low = high = glm::vec3(0);
  const float size = std::max({high.x - low.x, high.y - low.y, high.z - low.z, 1e-6f});

  // The axis starts at the middle of the box; each round takes the nearest eye that sees all, then moves the axis to even the
  // margins.
  glm::vec3 eye(0.5f * (low.x + high.x), 0.5f * (low.y + high.y), 0);
  for (int round = 0; round < 8; ++round) {
    eye.z = high.z + 0.05f * size;
    for (const glm::vec3& p : local) {
      eye.z = std::max({eye.z, p.z + std::abs(p.x - eye.x) / tan_x, p.z + std::abs(p.y - eye.y) / tan_y});
    }
    Sides x, y;
    for (const glm::vec3& p : local) {
      x.include((p.x - eye.x) / (eye.z - p.z));
      y.include((p.y - eye.y) / (eye.z - p.z));
    }
    if (round == 7 || local.empty()) break;
    const float distance = eye.z - 0.5f * (low.z + high.z);
    eye.x += 0.5f * (x.low + x.high) * distance;
    eye.y += 0.5f * (y.low + y.high) * distance;
  }

  const float near_plane = std::max(0.9f * (eye.z - high.z), 1e-3f * size);
  const float far_plane = (eye.z - low.z) + 0.1f * size;
  const glm::vec3 world_eye = basis.right * eye.x + basis.up * eye.y + basis.back * eye.z;
  glm::mat4 view(1);
  for (int column = 0; column < 3; ++column) {
    view[column] = {basis.right[column], basis.up[column], basis.back[column], 0};
  }
  view[3] = {-eye, 1};
  glm::mat4 projection(0);
  projection[0][0] = 1 / (tan_half_fov * aspect);
  projection[1][1] = -1 / tan_half_fov;
  projection[2][2] = far_plane / (near_plane - far_plane);
  projection[2][3] = -1;
  projection[3][2] = near_plane * far_plane / (near_plane - far_plane);
  return {projection * view, world_eye};
}

}  // namespace pineda::tools
