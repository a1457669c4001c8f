#include "tools/accuracy/reference_shaders.h"

#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <glm/vec3.hpp>

namespace pineda::tools::reference {
namespace {

using real = double;
using vec3 = glm::dvec3;
using vec4 = glm::dvec4;
using glm::abs, glm::atan, glm::cos, glm::dot, glm::exp, glm::floor, glm::log2, glm::max, glm::normalize, glm::pow, glm::sin,
    glm::tanh;

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-parameter"  // GLSL has no unnamed ones
#include "tools/accuracy/shaders/suite_body.glsl"
#pragma GCC diagnostic pop

}  // namespace

glm::dvec4 position(int scene, const glm::dvec4& place, const glm::dvec4& data) { return suite_position(scene, place, data); }
glm::dvec4 varying(int scene, const glm::dvec4& place, const glm::dvec4& data) { return suite_varying(scene, place, data); }
glm::dvec4 colour(int scene, const glm::dvec4& varying) { return suite_colour(scene, varying); }

}  // namespace pineda::tools::reference
