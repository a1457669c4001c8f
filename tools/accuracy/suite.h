// The scenes of `pineda report`: small enough that a reference renderer in double precision (reference.h) draws them too.
#pragma once

#include <array>
#include <span>
#include <string_view>
#include <vector>

namespace pineda::tools {

struct SuiteVertex {
  std::array<float, 4> place, data;  // what they mean is up to the scene (shaders/suite_body.glsl)
};

struct SuiteScene {
  const char *name, *title, *description;
  int shader;         // kScene of the shaders
  bool depth, blend;  // depth test and writes (less or equal); source over destination
  bool exact_area;    // disjoint triangles of colour 1 on black: the mean over a pixel is an area, computed exactly
  std::vector<SuiteVertex> (*triangles)();  // three vertices each; w > 0 everywhere, so nothing is clipped by the near plane
};

std::span<const SuiteScene> suite_scenes();
const SuiteScene& require_suite_scene(std::string_view name);  // throws ToolError

}  // namespace pineda::tools
