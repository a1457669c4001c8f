// glsl.derivatives: of linear functions exactly, of others within the quad; fine, coarse and both axes, in divergent code, too.
#include <fmt/format.h>

#include <cmath>
#include <cstring>

#include "cts-subset/groups/groups.h"
#include "cts-subset/harness/case.h"
#include "cts-subset/harness/pipelines.h"

namespace pineda::cts {
namespace {

constexpr uint32_t kSize = 16;

struct Function {
  const char* name;
  const char* glsl;  // of vec2 p, the pixel's centre
  double (*value)(double x, double y);
};
constexpr Function kFunctions[] = {
    {"linear_x", "3.0 * p.x", [](double x, double) { return 3 * x; }},
    {"linear_y", "-0.25 * p.y", [](double, double y) { return -0.25 * y; }},
    {"linear_both", "p.x * 2.0 + p.y * 0.5 + 7.0", [](double x, double y) { return x * 2 + y * 0.5 + 7; }},
    {"product", "p.x * p.y", [](double x, double y) { return x * y; }},
    {"square", "p.x * p.x + 0.125 * p.y * p.y", [](double x, double y) { return x * x + 0.125 * y * y; }},
    {"constant", "4.5", [](double, double) { return 4.5; }},
    {"large", "p.x * 65536.0 - p.y * 4096.0", [](double x, double y) { return x * 65536 - y * 4096; }},
    {"small", "p.x * 0.0009765625", [](double x, double) { return x * 0.0009765625; }},
};
struct Op {
  const char* name;
  bool x, y, fine;
};
constexpr Op kOps[] = {{"dFdx", true, false, false},    {"dFdy", false, true, false},       {"dFdxFine", true, false, true},
                       {"dFdyFine", false, true, true}, {"dFdxCoarse", true, false, false}, {"dFdyCoarse", false, true, false},
                       {"fwidth", true, true, false},   {"fwidthFine", true, true, true},   {"fwidthCoarse", true, true, false}};

// In which way the value reaches the operation; the quad's lanes all take part in each.
struct Context {
  const char* name;
  const char* body;  // {0}: the operation, {1}: the function
};
constexpr Context kContexts[] = {
    {"main", "c = {0}({1});"},
    {"uniform_branch", "if (k > 0.0) c = {0}({1}); else c = 1e9;"},
    {"function", "c = f(p);"},
    {"quad_uniform_branch",
     "if ((int(gl_FragCoord.x) / 2 + int(gl_FragCoord.y) / 2) % 2 == 0) c = {0}({1}); else c = {0}({1} * 1.0);"},
    {"loop", "c = 0.0; for (int i = 0; i < 3; ++i) {{ float v = {1}; if (i == 2) c = {0}(v); }}"},
    {"vector", "c = {0}(vec3(0.0, {1}, p.x)).y;"},
};

void run(Device& device, const Function& function, const Op& op, const Context& context) {
  DrawState state;
  state.vertex = fullscreen_vertex();
  const std::string body = fmt::format(fmt::runtime(context.body), op.name, function.glsl);
  state.fragment = compile_glsl(VK_SHADER_STAGE_FRAGMENT_BIT,
                                fmt::format("layout(location = 0) out float c; layout(push_constant) uniform P {{ float k; }};\n"
                                            "float f(vec2 p) {{ return {}({}); }}\n"
                                            "void main() {{ vec2 p = gl_FragCoord.xy; {} }}",
                                            op.name, function.glsl, body));
  state.resources.push_constants = to_bytes(1.0f);
  const std::vector<std::byte> bytes = draw_once(device, state, {kSize, kSize}, VK_FORMAT_R32_SFLOAT);
  for (uint32_t y = 0; y < kSize; ++y) {
    for (uint32_t x = 0; x < kSize; ++x) {
      float got;
      std::memcpy(&got, bytes.data() + (y * kSize + x) * 4, 4);
      const double qx = x / 2 * 2 + 0.5, qy = y / 2 * 2 + 0.5;
      const auto dx = [&](double row) { return function.value(qx + 1, row) - function.value(qx, row); };
      const auto dy = [&](double column) { return function.value(column, qy + 1) - function.value(column, qy); };
      // Fine: the pixel's own row and column; otherwise those of any pixel of the quad.
      bool right = false;
      for (int k = 0; k < 4; ++k) {
        const double row = op.fine ? y + 0.5 : qy + (k & 1), column = op.fine ? x + 0.5 : qx + (k >> 1);
        const double want = op.x && op.y ? std::abs(dx(row)) + std::abs(dy(column)) : op.x ? dx(row) : dy(column);
        right |= std::abs(got - want) <= 1e-5 * std::abs(want) + 1e-5;
      }
      expect(right, fmt::format("pixel {}, {}: {}", x, y, got));
    }
  }
}

}  // namespace

void register_glsl_derivatives() {
  for (const Op& op : kOps) {
    for (const Function& function : kFunctions) {
      for (const Context& context : kContexts) {
        add_case("glsl.derivatives", fmt::format("{}.{}_{}", op.name, function.name, context.name),
                 "16.5.1 Derivative Operations", [&](Device& device) { run(device, function, op, context); });
      }
    }
  }
}

}  // namespace pineda::cts
