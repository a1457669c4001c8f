// The shaders of the accuracy suite in double precision: the text of shaders/suite_body.glsl, compiled as C++.
#pragma once

#include <glm/vec4.hpp>

namespace pineda::tools::reference {

glm::dvec4 position(int scene, const glm::dvec4& place, const glm::dvec4& data);
glm::dvec4 varying(int scene, const glm::dvec4& place, const glm::dvec4& data);
glm::dvec4 colour(int scene, const glm::dvec4& varying);

}  // namespace pineda::tools::reference
