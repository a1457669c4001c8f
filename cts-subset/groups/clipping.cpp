// clipping.*: the clip volume, clip and cull distances, depth clamping, points behind the eye.
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstring>
#include <functional>

#include "cts-subset/groups/groups.h"
#include "cts-subset/harness/case.h"
#include "cts-subset/harness/pipelines.h"
#include "cts-subset/reference/random.h"

namespace pineda::cts {
namespace {

constexpr uint32_t kSize = 32;
constexpr const char* kWhite = "layout(location = 0) out vec4 c; void main() { c = vec4(1.0); }";

std::vector<bool> covered(const std::vector<std::byte>& pixels) {
  std::vector<bool> result(kSize * kSize);
  for (size_t i = 0; i < result.size(); ++i) result[i] = std::to_integer<int>(pixels[i * 4]) != 0;
  return result;
}

// Every pixel whose centre is not within 1/16 px of the border must be as `inside_px` says: covered where it is positive.
void expect_region(const std::vector<bool>& got, const std::function<double(double x, double y)>& inside_px) {
  for (uint32_t y = 0; y < kSize; ++y) {
    for (uint32_t x = 0; x < kSize; ++x) {
      const double distance = inside_px(x + 0.5, y + 0.5);
      if (std::abs(distance) < 1.0 / 16) continue;  // snapping to the sub-pixel grid may decide either way
      expect(got[y * kSize + x] == (distance > 0), fmt::format("pixel {}, {} is {}covered, {:.3f} px from the clip line", x, y,
                                                               got[y * kSize + x] ? "" : "not ", distance));
    }
  }
}

// A rectangle over the viewport whose depth runs along x from z0 to z1: what is outside [0, 1] is cut off.
void run_depth_planes(Device& device, float z0, float z1, float w, bool clamp) {
  if (clamp) require(device.caps().features.depthClamp, "depthClamp");
  DrawState state;
  state.vertex =
      compile_glsl(VK_SHADER_STAGE_VERTEX_BIT,
                   fmt::format("void main() {{ vec2 p = vec2(gl_VertexIndex & 1, gl_VertexIndex >> 1); float w = {:.6f};\n"
                               "gl_Position = vec4((p * 2.0 - 1.0) * w, mix({:.6f}, {:.6f}, p.x) * w, w); }}",
                               w, z0, z1));
  state.fragment = compile_glsl(VK_SHADER_STAGE_FRAGMENT_BIT, kWhite);
  state.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_STRIP;
  state.vertices = 4;
  state.rasterization.depthClampEnable = clamp;
  const auto got = covered(draw_once(device, state, {kSize, kSize}));
  expect_region(got, [&](double x, double) {
    if (clamp) return 1.0;
    const double z = z0 + (z1 - z0) * x / kSize;
    if (z0 == z1) return z >= 0 && z <= 1 ? 1.0 : -1.0;
    const double px_per_z = kSize / std::abs(z1 - z0);
    return std::min(z, 1 - z) * px_per_z;
  });
}

// `count` distances, each a plane across the viewport: negative where a x + b y + c < 0 (x, y in 0 .. 1).
struct Plane {
  double a, b, c;
};
void run_distances(Device& device, uint32_t count, bool cull, uint32_t seed) {
  const VkPhysicalDeviceFeatures& features = device.caps().features;
  require(cull ? features.shaderCullDistance : features.shaderClipDistance, "the feature");
  require(count <= (cull ? device.limits().maxCullDistances : device.limits().maxClipDistances), "as many distances");
  Random random(fmt::format("planes{}", seed));
  std::vector<Plane> planes(count);
  std::string writes;
  for (uint32_t i = 0; i < count; ++i) {
    const double angle = random.between(0, 6.28);
    planes[i] = {std::cos(angle), std::sin(angle), 0};
    planes[i].c = random.between(0.1, 0.4) - 0.5 * planes[i].a - 0.5 * planes[i].b;
    writes += fmt::format("gl_{}Distance[{}] = dot(p, vec2({:.9f}, {:.9f})) + {:.9f};\n", cull ? "Cull" : "Clip", i, planes[i].a,
                          planes[i].b, planes[i].c);
  }
  DrawState state;
  state.vertex = compile_glsl(VK_SHADER_STAGE_VERTEX_BIT,
                              fmt::format("out gl_PerVertex {{ vec4 gl_Position; float gl_{}Distance[{}]; }};\n"
                                          "void main() {{ int cell = gl_VertexIndex / 6, k = gl_VertexIndex % 6;\n"
                                          "vec2 p = (vec2(cell & 3, cell >> 2) + vec2(k == 1 || k == 2 || k == 4 ? 1.0 : 0.0,"
                                          " k == 2 || k == 4 || k == 5 ? 1.0 : 0.0)) / 4.0;\n"
                                          "gl_Position = vec4(p * 2.0 - 1.0, 0.5, 1.0); {} }}",
                                          cull ? "Cull" : "Clip", count, writes));
  state.fragment = compile_glsl(VK_SHADER_STAGE_FRAGMENT_BIT, kWhite);
  state.vertices = 16 * 6;
  const auto got = covered(draw_once(device, state, {kSize, kSize}));
  const auto distance_at = [](const Plane& p, double x, double y) { return p.a * x + p.b * y + p.c; };
  if (!cull) {
    expect_region(got, [&](double x, double y) {
      double least = 1e9;
      for (const Plane& p : planes) least = std::min(least, distance_at(p, x / kSize, y / kSize) * kSize);
      return least;
    });
    return;
  }
  // A triangle goes when one distance is negative at all its vertices.
  for (uint32_t y = 0; y < kSize; ++y) {
    for (uint32_t x = 0; x < kSize; ++x) {
      const double cx = x / 8, cy = y / 8, fx = (x % 8 + 0.5) / 8, fy = (y % 8 + 0.5) / 8;
      if (std::abs(fx + fy - 1) < 1e-6 || fx == fy) continue;  // near the diagonal either triangle's
      const bool lower = fy > fx;                              // triangle 3, 4, 5: (0,0) (1,1) (0,1)
      const double corners[3][2] = {{cx, cy}, {cx + 1, cy + 1}, {lower ? cx : cx + 1, lower ? cy + 1 : cy}};
      bool culled = false, unsure = false;
      for (const Plane& p : planes) {
        double most = -1e9;
        for (const auto& corner : corners) most = std::max(most, distance_at(p, corner[0] / 4, corner[1] / 4));
        unsure |= std::abs(most) < 1e-5;
        culled |= most < 0;
      }
      if (unsure) continue;
      expect(got[y * kSize + x] == !culled, fmt::format("pixel {}, {}", x, y));
    }
  }
}

using Homogeneous = std::array<double, 3>;  // x, y, w
Homogeneous cross(const Homogeneous& a, const Homogeneous& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
double dot(const Homogeneous& a, const Homogeneous& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

// `behind`: how many vertices are not in front. Others are drawn until the triangle has an area: seen edge-on it would cover
// nothing, or anything.
std::array<Homogeneous, 3> triangle_around_the_eye(Random& random, size_t behind, bool exactly_zero) {
  constexpr double kLeastDeterminant = 1e-3;
  const auto on_grid = [&](double low, double high) { return std::round(random.between(low, high) * 64) / 64; };
  std::array<Homogeneous, 3> v;
  do {
    for (size_t i = 0; i < 3; ++i) {
      v[i] = {on_grid(-3, 3), on_grid(-3, 3), i >= behind ? on_grid(0.5, 2) : exactly_zero ? 0.0 : -on_grid(0.25, 2)};
    }
  } while (std::abs(dot(v[0], cross(v[1], v[2]))) < kLeastDeterminant);
  return v;
}

// Triangles with a vertex behind the eye (w < 0) or at it (w = 0): only what lies in front appears, with homogeneous
// coordinates deciding. Pixel (x, y) is covered when the solution of the three vertices has positive weights and w > 0.
void run_behind_the_eye(Device& device, uint32_t seed, bool exactly_zero) {
  Random random(fmt::format("behind{}", seed));
  const std::array<Homogeneous, 3> v = triangle_around_the_eye(random, seed % 2 ? 2 : 1, exactly_zero);
  std::string array;
  for (const Homogeneous& p : v)
    array += fmt::format("{}vec3({:.6f}, {:.6f}, {:.6f})", array.empty() ? "" : ", ", p[0], p[1], p[2]);
  DrawState state;
  // z = w / 2 keeps every point that is in front away from the near and far planes, except w = 0 itself.
  state.vertex = compile_glsl(VK_SHADER_STAGE_VERTEX_BIT, fmt::format("void main() {{ vec3 p = vec3[]({})[gl_VertexIndex];"
                                                                      " gl_Position = vec4(p.xy, p.z * 0.5, p.z); }}",
                                                                      array));
  state.fragment = compile_glsl(VK_SHADER_STAGE_FRAGMENT_BIT, kWhite);
  const auto got = covered(draw_once(device, state, {kSize, kSize}));
  const double sign = dot(v[0], cross(v[1], v[2])) > 0 ? 1 : -1;
  expect_region(got, [&](double x, double y) {
    const Homogeneous pixel = {x / kSize * 2 - 1, y / kSize * 2 - 1, 1};
    double least = 1e9;
    for (size_t i = 0; i < 3; ++i) {
      const Homogeneous e = cross(v[(i + 1) % 3], v[(i + 2) % 3]);
      least = std::min(least, sign * dot(e, pixel) / (std::hypot(e[0], e[1]) + 1e-30) * kSize / 2);
    }
    return least;  // all weights positive: w is too, because 1/w is their sum
  });
}

// Far outside the viewport, with all kinds of sizes: coverage inside the viewport is that of the half-plane.
void run_huge(Device& device, double scale, double angle) {
  DrawState state;
  // A triangle with one edge through the middle of the viewport, the others `scale` viewports away.
  state.vertex = compile_glsl(
      VK_SHADER_STAGE_VERTEX_BIT,
      fmt::format(
          "void main() {{ vec2 d = vec2({0:.9f}, {1:.9f}), n = vec2(-d.y, d.x);\n"
          "vec2 p = gl_VertexIndex == 0 ? -d : gl_VertexIndex == 1 ? d : n; gl_Position = vec4(p * {2:.3f}, 0.5, 1.0); }}",
          std::cos(angle), std::sin(angle), scale));
  state.fragment = compile_glsl(VK_SHADER_STAGE_FRAGMENT_BIT, kWhite);
  const auto got = covered(draw_once(device, state, {kSize, kSize}));
  // The end points are rounded to floats and to the sub-pixel grid; at the middle that moves the edge by less than a step.
  expect_region(got, [&](double x, double y) {
    const double nx = x - kSize / 2.0, ny = y - kSize / 2.0;
    return -std::sin(angle) * nx + std::cos(angle) * ny;
  });
}

std::string depth_case_name(float z0, float z1, float w, bool clamp) {
  const auto number = [](float v) { return v < 0 ? fmt::format("minus_{}", -v) : fmt::format("{}", v); };  // '-' is a filter's
  return fmt::format("depth_{}_to_{}_w_{}{}", number(z0), number(z1), w, clamp ? "_clamp" : "");
}

}  // namespace

void register_clipping() {
  constexpr const char* kVolume = "27.4 Primitive Clipping";
  for (const auto& [z0, z1] : {std::pair{-1.0f, 1.0f},
                               {0.0f, 2.0f},
                               {-1.0f, 2.0f},
                               {2.0f, -3.0f},
                               {-2.0f, -1.0f},
                               {1.5f, 3.0f},
                               {0.25f, 0.75f},
                               {-0.125f, 1.125f}}) {
    for (const float w : {1.0f, 3.0f, 0.0078125f}) {
      for (const bool clamp : {false, true}) {
        add_case("clipping.clip_volume", depth_case_name(z0, z1, w, clamp), kVolume,
                 [=, z0 = z0, z1 = z1](Device& device) { run_depth_planes(device, z0, z1, w, clamp); });
      }
    }
  }
  for (uint32_t count = 1; count <= 8; ++count) {
    for (uint32_t seed = 0; seed < 4; ++seed) {
      for (const bool cull : {false, true}) {
        add_case(cull ? "clipping.cull_distance" : "clipping.clip_distance", fmt::format("{}_planes_{}", count, seed),
                 cull ? "27.3 Primitive Culling" : kVolume,
                 [=](Device& device) { run_distances(device, count, cull, seed * 10 + count); });
      }
    }
  }
  for (uint32_t seed = 0; seed < 24; ++seed) {
    add_case("clipping.clip_volume", fmt::format("behind_the_eye_{}", seed), kVolume,
             [=](Device& device) { run_behind_the_eye(device, seed, false); });
    if (seed < 8) {
      add_case("clipping.clip_volume", fmt::format("at_the_eye_{}", seed), kVolume,
               [=](Device& device) { run_behind_the_eye(device, seed * 2, true); });
    }
  }
  for (const double scale : {2.0, 64.0, 1024.0, 32768.0}) {
    for (int step = 0; step < 6; ++step) {
      add_case("clipping.clip_volume", fmt::format("triangle_of_{}_viewports_{}", scale, step), kVolume,
               [=](Device& device) { run_huge(device, scale, 0.1 + step); });
    }
  }
}

}  // namespace pineda::cts
