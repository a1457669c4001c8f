// glsl.interpolation: inputs evaluated at other places of the pixel. The inputs are linear in the window's coordinates, so that
// their value at a place is known; what is asked for is a whole input, a part of it, or a part that the shader chooses at run
// time.
#include <fmt/format.h>

#include <cmath>
#include <cstring>

#include "cts-subset/groups/groups.h"
#include "cts-subset/harness/case.h"
#include "cts-subset/harness/pipelines.h"

namespace pineda::cts {
namespace {

constexpr uint32_t kSize = 16;

// Where the input is evaluated, as the shader says it; x and y: how far from the pixel's centre that is. The offsets' grid has at
// least four bits and they reach from -0.5 to 0.4375 ("Required Limits"). In a pixel that is covered whole, with one sample, the
// centroid and the sample are at the centre.
struct Place {
  const char* name;
  const char* glsl;  // {}: the input
  double x, y;
};
constexpr Place kPlaces[] = {
    {"centroid", "interpolateAtCentroid({})", 0, 0},
    {"sample", "interpolateAtSample({}, k)", 0, 0},
    {"offset_zero", "interpolateAtOffset({}, vec2(0.0))", 0, 0},
    {"offset_x", "interpolateAtOffset({}, vec2(0.25, 0.0))", 0.25, 0},
    {"offset_y", "interpolateAtOffset({}, vec2(0.0, -0.375))", 0, -0.375},
    {"offset_smallest", "interpolateAtOffset({}, vec2(-0.5))", -0.5, -0.5},
    {"offset_largest", "interpolateAtOffset({}, vec2(0.4375))", 0.4375, 0.4375},
    {"offset_dynamic", "interpolateAtOffset({}, vec2(float(k) + 0.125, 0.25))", 0.125, 0.25},
};

// Of `v`, whose x, y, z are the window's x, its y and their sum, and of the array `a` of {v, 2v, 3v}. k is 0, unknown to the
// compiler.
struct Operand {
  const char* name;
  const char* glsl;  // {}: what evaluates it
  const char* result;
  double (*value)(double x, double y, uint32_t column);  // column: the pixel's
};
constexpr Operand kOperands[] = {
    {"vector", "v", ".y", [](double, double y, uint32_t) { return y; }},
    {"component", "v.z", "", [](double x, double y, uint32_t) { return x + y; }},
    {"element", "a[1]", ".x", [](double x, double, uint32_t) { return 2 * x; }},
    {"dynamic_component", "v[k + 1]", "", [](double, double y, uint32_t) { return y; }},
    {"dynamic_element", "a[k + 2]", ".z", [](double x, double y, uint32_t) { return 3 * (x + y); }},
    {"dynamic_both", "a[k + 1][k + 1]", "", [](double, double y, uint32_t) { return 2 * y; }},
    {"divergent_element", "a[int(gl_FragCoord.x) % 3]", ".x",
     [](double x, double, uint32_t column) { return (column % 3 + 1) * x; }},
};

Spirv vertex_shader() {
  return compile_glsl(VK_SHADER_STAGE_VERTEX_BIT,
                      fmt::format("layout(location = 0) out vec3 v; layout(location = 1) out vec3 a[3];\n"
                                  "void main() {{ vec2 p = vec2(gl_VertexIndex & 1, gl_VertexIndex >> 1) * 4.0 - 1.0;\n"
                                  "  gl_Position = vec4(p, 0.0, 1.0);\n"
                                  "  vec2 w = (p * 0.5 + 0.5) * {0}.0; v = vec3(w, w.x + w.y);\n"
                                  "  for (int i = 0; i < 3; ++i) a[i] = v * float(i + 1); }}",
                                  kSize));
}

void run(Device& device, const Place& place, const Operand& operand) {
  require(device.caps().features.sampleRateShading, "sampleRateShading");  // InterpolationFunction needs it
  DrawState state;
  state.vertex = vertex_shader();
  const std::string value = fmt::format(fmt::runtime(place.glsl), operand.glsl);
  state.fragment = compile_glsl(VK_SHADER_STAGE_FRAGMENT_BIT,
                                fmt::format("layout(location = 0) in vec3 v; layout(location = 1) in vec3 a[3];\n"
                                            "layout(location = 0) out float c; layout(push_constant) uniform P {{ int k; }};\n"
                                            "void main() {{ c = {}{}; }}",
                                            value, operand.result));
  state.resources.push_constants = to_bytes(0);
  const std::vector<std::byte> bytes = draw_once(device, state, {kSize, kSize}, VK_FORMAT_R32_SFLOAT);
  for (uint32_t y = 0; y < kSize; ++y) {
    for (uint32_t x = 0; x < kSize; ++x) {
      float got;
      std::memcpy(&got, bytes.data() + (y * kSize + x) * 4, 4);
      const double want = operand.value(x + 0.5 + place.x, y + 0.5 + place.y, x);
      // Linear in numbers below 96: some ULP of those. A step of the offsets' grid would be 0.0625.
      expect(std::abs(got - want) <= 1e-3, fmt::format("pixel {}, {}: {}, not {}", x, y, got, want));
    }
  }
}

}  // namespace

void register_glsl_interpolation() {
  for (const Place& place : kPlaces) {
    for (const Operand& operand : kOperands) {
      add_case("glsl.interpolation", fmt::format("{}.{}", place.name, operand.name), "GLSL.std.450 InterpolateAt*; 46. Limits",
               [&](Device& device) { run(device, place, operand); });
    }
  }
}

}  // namespace pineda::cts
