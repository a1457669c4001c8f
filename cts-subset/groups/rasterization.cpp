// rasterization.*: which samples triangles and points cover, by the rules applied in integers.
#include <fmt/format.h>

#include <cmath>
#include <cstring>

#include "cts-subset/groups/groups.h"
#include "cts-subset/harness/case.h"
#include "cts-subset/harness/pipelines.h"
#include "cts-subset/reference/random.h"

namespace pineda::cts {
namespace {

constexpr int kCells = 8, kCellSize = 16, kSize = kCells * kCellSize;  // each primitive has a cell of its own
constexpr int kUnits = 16;  // coordinates are multiples of 1/16 px: every driver has 4 bits

struct Point {
  int x, y;  // 1/kUnits px
};

int64_t edge(const Point& a, const Point& b, const Point& p) {
  return int64_t{b.x - a.x} * (p.y - a.y) - int64_t{b.y - a.y} * (p.x - a.x);
}

// With y pointing down and the area positive, an edge is a top one when it is horizontal and goes right, a left one when it goes
// up.
bool owns(const Point& a, const Point& b) { return (a.y == b.y && b.x > a.x) || b.y < a.y; }

bool covers(Point a, Point b, Point c, const Point& sample) {
  const int64_t area = edge(a, b, c);
  if (area == 0) return false;
  if (area < 0) std::swap(b, c);
  for (const auto& [from, to] : {std::pair{a, b}, {b, c}, {c, a}}) {
    const int64_t e = edge(from, to, sample);
    if (e < 0 || (e == 0 && !owns(from, to))) return false;
  }
  return true;
}

struct Vertex {
  float x, y;
};

Vertex to_clip(const Point& p) {  // exact: kSize is a power of two
  return {static_cast<float>(p.x) / (kUnits * kSize / 2) - 1, static_cast<float>(p.y) / (kUnits * kSize / 2) - 1};
}

DrawState make_state(const Buffer& vertices, uint32_t count) {
  DrawState state;
  state.vertex =
      compile_glsl(VK_SHADER_STAGE_VERTEX_BIT,
                   "layout(location = 0) in vec2 p; layout(location = 0) flat out uint id;\n"
                   "void main() { gl_Position = vec4(p, 0.5, 1.0); id = uint(gl_VertexIndex) / 3u; gl_PointSize = 1.0; }");
  state.fragment = compile_glsl(VK_SHADER_STAGE_FRAGMENT_BIT,
                                "layout(location = 0) flat in uint id; layout(location = 0) out uvec4 colour;\n"
                                "void main() { colour = uvec4(1u); }");
  state.input.bindings = {{0, sizeof(Vertex), VK_VERTEX_INPUT_RATE_VERTEX}};
  state.input.attributes = {{0, 0, VK_FORMAT_R32G32_SFLOAT, 0}};
  state.input.buffers = {&vertices};
  state.vertices = count;
  // Overlaps are counted: each pixel of a cell must be hit exactly as often as the rule says.
  VkPipelineColorBlendAttachmentState blend{};
  blend.colorWriteMask = 0xF;
  state.blend = {blend};
  return state;
}

struct TriangleKind {
  const char* name;
  int spread;     // of the second and third vertex around the first, in units
  int alignment;  // coordinates are multiples of this
};
constexpr TriangleKind kKinds[] = {{"tiny", 12, 1},
                                   {"pixel_sized", 32, 1},
                                   {"cell_sized", 250, 1},
                                   {"on_pixel_centres", 250, 8},
                                   {"on_pixel_corners", 250, 16},
                                   {"huge", 40000, 1}};

void run_triangles(Device& device, const TriangleKind& kind, uint32_t seed, bool reversed) {
  Random random(fmt::format("{}{}", kind.name, seed));
  std::vector<Vertex> vertices;
  std::vector<std::array<Point, 3>> triangles;
  const auto snap = [&](int v) { return v / kind.alignment * kind.alignment; };
  for (int cell = 0; cell < kCells * kCells; ++cell) {
    const int left = cell % kCells * kCellSize * kUnits, top = cell / kCells * kCellSize * kUnits;
    const bool huge = kind.spread > 1000;
    std::array<Point, 3> t;
    const auto inside = [&](int v, int low) { return huge ? v : std::clamp(v, low, low + kCellSize * kUnits); };
    const Point first{left + snap(static_cast<int>(random.below(kCellSize * kUnits))),
                      top + snap(static_cast<int>(random.below(kCellSize * kUnits)))};
    for (int v = 0; v < 3; ++v) {
      const auto jitter = [&] {
        return v == 0 ? 0 : static_cast<int>(random.below(static_cast<uint32_t>(2 * kind.spread + 1))) - kind.spread;
      };
      t[static_cast<size_t>(v)] = {inside(snap(first.x + jitter()), left), inside(snap(first.y + jitter()), top)};
    }
    if (reversed) std::swap(t[1], t[2]);
    triangles.push_back(t);
    for (const Point& p : t) vertices.push_back(to_clip(p));
    if (huge) break;  // one, over the whole target
  }
  const Buffer buffer = create_buffer(device, vertices);
  const DrawState state = make_state(buffer, static_cast<uint32_t>(vertices.size()));
  const auto pixels = draw_once(device, state, {kSize, kSize}, VK_FORMAT_R8_UINT);
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      const Point centre{x * kUnits + kUnits / 2, y * kUnits + kUnits / 2};
      bool want = false;
      for (const auto& t : triangles) want |= covers(t[0], t[1], t[2], centre);
      const bool got = pixels[static_cast<size_t>(y * kSize + x)] != std::byte{0};
      expect(want == got, fmt::format("pixel {}, {} is {}", x, y, got ? "covered" : "not covered"));
    }
  }
}

// A fan around a point, of slivers that share every edge, drawn with additive colours: each pixel exactly once.
void run_shared_edges(Device& device, uint32_t seed) {
  Random random(fmt::format("fan{}", seed));
  std::vector<Vertex> vertices;
  const int centre_x = kSize * kUnits / 2 + static_cast<int>(random.below(200)) - 100;
  const int centre_y = kSize * kUnits / 2 + static_cast<int>(random.below(200)) - 100;
  const int count = 97, border = kSize * kUnits;
  std::vector<Point> rim;
  for (int i = 0; i < count; ++i) {  // around the square, corners included
    const int along = static_cast<int>(int64_t{i} * 4 * border / count);
    const int side = along / border, at = along % border;
    if (!rim.empty() && side > 0 && (int64_t{i - 1} * 4 * border / count) / border < side) {
      static constexpr int kCorners[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
      rim.push_back({kCorners[side][0] * border, kCorners[side][1] * border});
    }
    rim.push_back(side == 0   ? Point{at, 0}
                  : side == 1 ? Point{border, at}
                  : side == 2 ? Point{border - at, border}
                              : Point{0, border - at});
  }
  for (size_t i = 0; i < rim.size(); ++i) {
    for (const Point& p : {Point{centre_x, centre_y}, rim[i], rim[(i + 1) % rim.size()]}) vertices.push_back(to_clip(p));
  }
  const Buffer buffer = create_buffer(device, vertices);
  DrawState state = make_state(buffer, static_cast<uint32_t>(vertices.size()));
  state.fragment =
      compile_glsl(VK_SHADER_STAGE_FRAGMENT_BIT, "layout(location = 0) out vec4 c; void main() { c = vec4(1.0 / 255.0); }");
  state.blend[0].blendEnable = VK_TRUE;
  state.blend[0].srcColorBlendFactor = state.blend[0].dstColorBlendFactor = VK_BLEND_FACTOR_ONE;
  state.blend[0].srcAlphaBlendFactor = state.blend[0].dstAlphaBlendFactor = VK_BLEND_FACTOR_ONE;
  const auto pixels = draw_once(device, state, {kSize, kSize}, VK_FORMAT_R8_UNORM);
  for (size_t i = 0; i < pixels.size(); ++i) {
    expect(pixels[i] == std::byte{1},
           fmt::format("pixel {}, {} was hit {} times", i % kSize, i / kSize, std::to_integer<int>(pixels[i])));
  }
}

// A point of size s covers the square of that size around it, by the same rule as a rectangle's edges.
void run_points(Device& device, float size) {
  require(size == 1 || device.caps().features.largePoints, "largePoints");
  require(size <= device.limits().pointSizeRange[1], "points of this size");
  Random random(fmt::format("points{}", size));
  const int half = static_cast<int>(size * kUnits / 2);
  std::vector<Vertex> vertices;
  std::vector<Point> points;
  for (int n = 0; n < 8; ++n) {  // an odd sixteenth off the grid: no sample lies on an edge
    points.push_back({static_cast<int>(random.below(kSize)) * kUnits + 3, static_cast<int>(random.below(kSize)) * kUnits + 5});
    vertices.push_back(to_clip(points.back()));
  }
  const Buffer buffer = create_buffer(device, vertices);
  DrawState state = make_state(buffer, static_cast<uint32_t>(vertices.size()));
  state.vertex = compile_glsl(VK_SHADER_STAGE_VERTEX_BIT,
                              fmt::format("layout(location = 0) in vec2 p; layout(location = 0) flat out uint id;\n"
                                          "void main() {{ gl_Position = vec4(p, 0.5, 1.0); id = 0u; gl_PointSize = {:.4f}; }}",
                                          size));
  state.topology = VK_PRIMITIVE_TOPOLOGY_POINT_LIST;
  const auto pixels = draw_once(device, state, {kSize, kSize}, VK_FORMAT_R8_UINT);
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      bool want = false;
      for (const Point& p : points) {
        want |= std::abs(x * kUnits + kUnits / 2 - p.x) < half && std::abs(y * kUnits + kUnits / 2 - p.y) < half;
      }
      const bool got = pixels[static_cast<size_t>(y * kSize + x)] != std::byte{0};
      expect(want == got, fmt::format("pixel {}, {} is {}", x, y, got ? "covered" : "not covered"));
    }
  }
}

struct Culling {
  const char* name;
  VkCullModeFlags mode;
  VkFrontFace front;
  bool draws_clockwise, draws_counter_clockwise;
};
constexpr Culling kCullings[] = {
    {"none", VK_CULL_MODE_NONE, VK_FRONT_FACE_CLOCKWISE, true, true},
    {"front_of_clockwise", VK_CULL_MODE_FRONT_BIT, VK_FRONT_FACE_CLOCKWISE, false, true},
    {"back_of_clockwise", VK_CULL_MODE_BACK_BIT, VK_FRONT_FACE_CLOCKWISE, true, false},
    {"front_of_counter_clockwise", VK_CULL_MODE_FRONT_BIT, VK_FRONT_FACE_COUNTER_CLOCKWISE, true, false},
    {"back_of_counter_clockwise", VK_CULL_MODE_BACK_BIT, VK_FRONT_FACE_COUNTER_CLOCKWISE, false, true},
    {"both", VK_CULL_MODE_FRONT_AND_BACK, VK_FRONT_FACE_CLOCKWISE, false, false},
};

void run_culling(Device& device, const Culling& culling, VkPrimitiveTopology topology) {
  for (const bool clockwise : {true, false}) {
    DrawState state;
    // On the screen, with y pointing down: (0,0), (2,0), (0,2) goes clockwise.
    const std::string order = topology == VK_PRIMITIVE_TOPOLOGY_TRIANGLE_FAN ? "int[](0, 1, 3, 2)" : "int[](0, 1, 2, 3)";
    state.vertex = compile_glsl(VK_SHADER_STAGE_VERTEX_BIT,
                                fmt::format("void main() {{ int i = {}[gl_VertexIndex]; vec2 p = vec2(i & 1, i >> 1) * 2.0 - 1.0;"
                                            "gl_Position = vec4({}p.x, p.y, 0.5, 1.0); }}",
                                            order, clockwise ? "" : "-"));
    state.fragment = compile_glsl(VK_SHADER_STAGE_FRAGMENT_BIT,
                                  "layout(location = 0) out uvec4 c; void main() { c = uvec4(gl_FrontFacing ? 1u : 2u); }");
    state.topology = topology;
    state.vertices = topology == VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST ? 3 : 4;
    state.rasterization.cullMode = culling.mode;
    state.rasterization.frontFace = culling.front;
    const auto pixels = draw_once(device, state, {kSize, kSize}, VK_FORMAT_R8_UINT);
    const bool drawn = clockwise ? culling.draws_clockwise : culling.draws_counter_clockwise;
    const bool front = clockwise == (culling.front == VK_FRONT_FACE_CLOCKWISE);
    const std::byte want = !drawn ? std::byte{0} : front ? std::byte{1} : std::byte{2};
    // One pixel well inside the first triangle, one inside the second (strips and fans).
    const size_t first = clockwise ? size_t{20} * kSize + 20 : size_t{20} * kSize + kSize - 20;
    const size_t second = clockwise ? size_t{kSize - 20} * kSize + kSize - 20 : size_t{kSize - 20} * kSize + 20;
    expect(pixels[first] == want, fmt::format("{} triangle: pixel holds {}", clockwise ? "clockwise" : "counter-clockwise",
                                              std::to_integer<int>(pixels[first])));
    if (state.vertices == 4) expect(pixels[second] == want, "the strip's or fan's second triangle faces the other way");
  }
}

}  // namespace

void register_rasterization() {
  for (const TriangleKind& kind : kKinds) {
    for (uint32_t seed = 0; seed < 12; ++seed) {
      for (const bool reversed : {false, true}) {
        add_case("rasterization", fmt::format("triangles.{}_{}{}", kind.name, seed, reversed ? "_reversed" : ""),
                 "27.6.1 Basic Polygon Rasterization, 27.1 Discarding; top-left rule",
                 [&kind, seed, reversed](Device& device) { run_triangles(device, kind, seed, reversed); });
      }
    }
  }
  for (uint32_t seed = 0; seed < 16; ++seed) {
    add_case("rasterization", fmt::format("shared_edges.fan_{}", seed), "27.6 Polygons: no double hits on a shared edge",
             [seed](Device& device) { run_shared_edges(device, seed); });
  }
  for (const float size : {1.0f, 2.0f, 3.0f, 4.5f, 7.0f, 16.0f, 31.0f, 63.0f}) {
    add_case("rasterization", fmt::format("points.size_{}", static_cast<int>(size * 10)), "27.4.1 Basic Point Rasterization",
             [size](Device& device) { run_points(device, size); });
  }
  static constexpr std::pair<VkPrimitiveTopology, const char*> kTopologies[] = {{VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST, "list"},
                                                                                {VK_PRIMITIVE_TOPOLOGY_TRIANGLE_STRIP, "strip"},
                                                                                {VK_PRIMITIVE_TOPOLOGY_TRIANGLE_FAN, "fan"}};
  for (const Culling& culling : kCullings) {
    for (const auto& [topology, name] : kTopologies) {
      add_case("rasterization", fmt::format("culling.{}.{}", culling.name, name), "27.6.1 facingness and culling",
               [&culling, topology = topology](Device& device) { run_culling(device, culling, topology); });
    }
  }
}

}  // namespace pineda::cts
