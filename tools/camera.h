// Cameras from IEEE operations only (no libm), so that matrices are the same bits on every machine.
#pragma once

#define GLM_FORCE_DEPTH_ZERO_TO_ONE
#include <glm/glm.hpp>
#include <span>

namespace pineda::tools {

struct Camera {
  glm::mat4 view_projection{1};  // clip space of Vulkan: y down, depth 0..1
  glm::vec3 eye{0};
};

// The camera that looks along `direction` (from the eye, unit length) and sees all points as large as they fit: the perspective
// is fixed (`tan_half_fov` of the height), the eye moves. `fill` is the share of the frame to fill, as of 0.9.
Camera fit_camera(std::span<const glm::vec3> points, glm::vec3 direction, float aspect, float tan_half_fov, float fill);

}  // namespace pineda::tools
