// Input assembly, culling, clipping and the planes of interpolation.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cfloat>
#include <limits>

#include "raster/assemble.h"
#include "raster/clip.h"
#include "raster/index_reader.h"
#include "raster/test_scene.h"
#include "raster/vertex_batch.h"

namespace pineda::raster {
namespace {

using namespace testing;

Target draw_once(TestDraw& draw, uint32_t size, PassStatistics* statistics = nullptr, uint32_t tile = 32) {
  Target target(size, size);
  ThreadPool pool(2);
  Options options = test_options();
  options.tile_px = tile;
  Pass pass(pool, target.desc(), options);
  pass.draw(draw.packet(size, size));
  const PassStatistics s = pass.end();
  if (statistics) *statistics = s;
  return target;
}

uint64_t total(const Target& target) {
  uint64_t sum = 0;
  for (const uint32_t v : target.color) sum += v;
  return sum;
}

// ---- input assembly -------------------------------------------------------------------------------------------------------

std::vector<uint32_t> vertices_of_primitive(VkPrimitiveTopology topology, bool last, uint32_t i) {
  const std::array<uint32_t, 3> v = primitive_vertices(topology, last, i);
  return {v.begin(), v.begin() + vertices_of(find_topology(topology)->kind)};
}

// "Primitive Topologies": the vertices of primitive i and, for VK_EXT_provoking_vertex, which of them comes first here.
TEST(Assemble, TopologiesMatchTheSpecification) {
  using V = std::vector<uint32_t>;
  const struct {
    VkPrimitiveTopology topology;
    uint32_t i;
    V first, last;
  } kCases[] = {
      {VK_PRIMITIVE_TOPOLOGY_POINT_LIST, 5, {5}, {5}},
      {VK_PRIMITIVE_TOPOLOGY_LINE_LIST, 2, {4, 5}, {4, 5}},
      {VK_PRIMITIVE_TOPOLOGY_LINE_STRIP, 2, {2, 3}, {2, 3}},
      {VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST, 2, {6, 7, 8}, {8, 6, 7}},
      {VK_PRIMITIVE_TOPOLOGY_TRIANGLE_STRIP, 0, {0, 1, 2}, {2, 0, 1}},
      {VK_PRIMITIVE_TOPOLOGY_TRIANGLE_STRIP, 1, {1, 3, 2}, {3, 2, 1}},
      {VK_PRIMITIVE_TOPOLOGY_TRIANGLE_FAN, 3, {4, 5, 0}, {5, 0, 4}},
      {VK_PRIMITIVE_TOPOLOGY_LINE_LIST_WITH_ADJACENCY, 1, {5, 6}, {5, 6}},
      {VK_PRIMITIVE_TOPOLOGY_LINE_STRIP_WITH_ADJACENCY, 1, {2, 3}, {2, 3}},
      {VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST_WITH_ADJACENCY, 1, {6, 8, 10}, {10, 6, 8}},
      {VK_PRIMITIVE_TOPOLOGY_TRIANGLE_STRIP_WITH_ADJACENCY, 0, {0, 2, 4}, {4, 0, 2}},
      {VK_PRIMITIVE_TOPOLOGY_TRIANGLE_STRIP_WITH_ADJACENCY, 1, {2, 6, 4}, {6, 4, 2}},
  };
  for (const auto& c : kCases) {
    EXPECT_EQ(vertices_of_primitive(c.topology, false, c.i), c.first) << c.topology;
    EXPECT_EQ(vertices_of_primitive(c.topology, true, c.i), c.last) << c.topology;
  }
  const auto count = [](VkPrimitiveTopology topology, uint64_t vertices) {
    return primitive_count(*find_topology(topology), vertices);
  };
  EXPECT_EQ(count(VK_PRIMITIVE_TOPOLOGY_POINT_LIST, 8), 8u);
  EXPECT_EQ(count(VK_PRIMITIVE_TOPOLOGY_LINE_LIST, 7), 3u);
  EXPECT_EQ(count(VK_PRIMITIVE_TOPOLOGY_LINE_STRIP, 7), 6u);
  EXPECT_EQ(count(VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST, 8), 2u);
  EXPECT_EQ(count(VK_PRIMITIVE_TOPOLOGY_TRIANGLE_STRIP, 2), 0u);
  EXPECT_EQ(count(VK_PRIMITIVE_TOPOLOGY_TRIANGLE_FAN, 5), 3u);
  EXPECT_EQ(count(VK_PRIMITIVE_TOPOLOGY_LINE_LIST_WITH_ADJACENCY, 9), 2u);
  EXPECT_EQ(count(VK_PRIMITIVE_TOPOLOGY_LINE_STRIP_WITH_ADJACENCY, 5), 2u);
  EXPECT_EQ(count(VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST_WITH_ADJACENCY, 13), 2u);
  EXPECT_EQ(count(VK_PRIMITIVE_TOPOLOGY_TRIANGLE_STRIP_WITH_ADJACENCY, 9), 2u);
}

TEST(Assemble, RestartBeginsANewStrip) {
  const uint8_t indices[] = {0, 1, 2, 3, 255, 4, 5, 255, 6, 7, 8, 255};
  DrawPacket packet;
  packet.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_STRIP;
  packet.index = {indices, sizeof(indices), VK_INDEX_TYPE_UINT8_EXT};
  packet.count = sizeof(indices);
  const std::vector<RestartPrimitive> primitives = restart_primitives(packet);
  ASSERT_EQ(primitives.size(), 3u);
  const std::array<uint32_t, 3> expected[3] = {{0, 1, 2}, {1, 3, 2}, {8, 9, 10}};
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(primitives[i].vertex, expected[i]);
    EXPECT_EQ(primitives[i].begins, i != 1);
  }
}

TEST(Assemble, IndicesOfEveryTypeAndPastTheEnd) {
  const uint8_t bytes[] = {1, 2, 3, 4, 5, 6, 7, 8, 9};
  const IndexReader r8({bytes, 9, VK_INDEX_TYPE_UINT8_EXT}), r16({bytes, 9, VK_INDEX_TYPE_UINT16}),
      r32({bytes, 9, VK_INDEX_TYPE_UINT32});
  EXPECT_EQ(r8.read(8), 9u);
  EXPECT_EQ(r8.read(9), 0u);
  EXPECT_EQ(r16.read(3), 0x0807u);
  EXPECT_EQ(r16.read(4), 0u) << "half an index";
  EXPECT_EQ(r32.read(1), 0x08070605u);
  EXPECT_EQ(r32.read(uint64_t{1} << 40), 0u);
  EXPECT_EQ(r8.restart_value(), 0xFFu);
  EXPECT_EQ(r16.restart_value(), 0xFFFFu);
  EXPECT_EQ(r32.restart_value(), 0xFFFFFFFFu);
  uint32_t out[4];
  r16.read(2, 4, out);
  EXPECT_EQ(out[0], 0x0605u);
  EXPECT_EQ(out[1], 0x0807u);
  EXPECT_EQ(out[2], 0u);
  EXPECT_EQ(out[3], 0u);
}

// A grid of quads drawn as list, strip, fan pieces, with every index type: the same picture, each pixel once.
template <class T>
void draw_indexed_quad(VkIndexType type, VkPrimitiveTopology topology, std::vector<T> indices, bool restart) {
  TestDraw draw(4, count_kernel);
  for (int y = 0; y < 3; ++y) {
    for (int x = 0; x < 3; ++x) add_window_vertex(draw, 64, 64, 32.0f * static_cast<float>(x), 32.0f * static_cast<float>(y));
  }
  draw.packet_base.topology = topology;
  draw.packet_base.primitive_restart = restart;
  draw.packet_base.index = {reinterpret_cast<const uint8_t*>(indices.data()), indices.size() * sizeof(T), type};
  draw.packet_base.count = static_cast<uint32_t>(indices.size());
  PassStatistics s;
  const Target target = draw_once(draw, 64, &s);
  for (const uint32_t v : target.color) ASSERT_EQ(v, 1u);
  EXPECT_EQ(s.triangles_in, 8u);
  EXPECT_EQ(s.vertices_shaded, 9u) << "every vertex is shaded once";
}

template <class T>
void draw_all_topologies(VkIndexType type) {
  const T r = static_cast<T>(~T{0});
  draw_indexed_quad<T>(type, VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST,
                       {0, 1, 3, 3, 1, 4, 1, 2, 4, 4, 2, 5, 3, 4, 6, 6, 4, 7, 4, 5, 7, 7, 5, 8}, false);
  draw_indexed_quad<T>(type, VK_PRIMITIVE_TOPOLOGY_TRIANGLE_STRIP, {0, 3, 1, 4, 2, 5, r, 3, 6, 4, 7, 5, 8}, true);
  draw_indexed_quad<T>(type, VK_PRIMITIVE_TOPOLOGY_TRIANGLE_FAN, {4, 0, 1, 2, 5, 8, 7, 6, 3, 0}, false);
}

TEST(Assemble, EveryTopologyAndIndexTypeDraws) {
  draw_all_topologies<uint8_t>(VK_INDEX_TYPE_UINT8_EXT);
  draw_all_topologies<uint16_t>(VK_INDEX_TYPE_UINT16);
  draw_all_topologies<uint32_t>(VK_INDEX_TYPE_UINT32);
}

TEST(Assemble, HostileIndicesAndCountsAreHarmless) {
  std::mt19937 rng(3);
  std::vector<uint32_t> indices(500);
  for (uint32_t& i : indices) i = rng();
  for (const VkPrimitiveTopology topology :
       {VK_PRIMITIVE_TOPOLOGY_LINE_LIST, VK_PRIMITIVE_TOPOLOGY_LINE_STRIP, VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST,
        VK_PRIMITIVE_TOPOLOGY_TRIANGLE_STRIP, VK_PRIMITIVE_TOPOLOGY_TRIANGLE_FAN, VK_PRIMITIVE_TOPOLOGY_LINE_STRIP_WITH_ADJACENCY,
        VK_PRIMITIVE_TOPOLOGY_TRIANGLE_STRIP_WITH_ADJACENCY}) {
    for (const bool restart : {false, true}) {
      TestDraw draw(4, count_kernel);
      draw.add({0, 0, 0.5f, 1});
      draw.packet_base.topology = topology;
      draw.packet_base.primitive_restart = restart;
      draw.packet_base.index = {reinterpret_cast<const uint8_t*>(indices.data()), indices.size() * 4, VK_INDEX_TYPE_UINT32};
      draw.packet_base.count = 0xFFFFFFF0u;  // far past the buffer
      draw.packet_base.first = 20;
      draw.packet_base.vertex_offset = -17;
      EXPECT_EQ(total(draw_once(draw, 32)), 0u);
    }
  }
}

TEST(Assemble, InstancesAndPrimitiveIds) {
  TestDraw draw(
      4, [](const KernelHandle*, const void*, void* thread, const PrimRecord* prims, uint32_t count, const void* waves) {
        for_fragments(thread, prims, count, waves, [](const FragmentPrim& p, uint32_t* color, float*, uint32_t, uint32_t) {
          *color += 1 + 16 * p.primitive_id;
        });
      });
  // Two triangles, 4 px wide at the top, side by side; instance i is moved by i / 8 in clip space: 8 px.
  for (const float x : {0.0f, 4.0f}) {
    add_window_vertex(draw, 128, 128, x, 0);
    add_window_vertex(draw, 128, 128, x + 4, 0);
    add_window_vertex(draw, 128, 128, x, 128);
  }
  draw.packet_base.first_instance = 2;
  draw.packet_base.instance_count = 5;
  PassStatistics s;
  const Target target = draw_once(draw, 128, &s);
  EXPECT_EQ(s.triangles_in, 10u);
  EXPECT_EQ(s.vertices_shaded, 30u);
  for (uint32_t x = 0; x < 128; ++x) {  // instances 2 to 6 begin at 16, 24, ...; each has ids 0 and 1
    const bool drawn = x >= 16 && x < 56;
    EXPECT_EQ(target.at(x, 0), !drawn ? 0u : x % 8 < 4 ? 1u : 17u) << x;
  }
}

// ---- culling --------------------------------------------------------------------------------------------------------------

TEST(Setup, CullModesAndFacing) {
  for (const bool clockwise : {false, true}) {
    for (const VkFrontFace front_face : {VK_FRONT_FACE_COUNTER_CLOCKWISE, VK_FRONT_FACE_CLOCKWISE}) {
      for (const VkCullModeFlags cull :
           {VK_CULL_MODE_NONE, VK_CULL_MODE_FRONT_BIT, VK_CULL_MODE_BACK_BIT, VK_CULL_MODE_FRONT_AND_BACK}) {
        TestDraw draw(
            4, [](const KernelHandle*, const void*, void* thread, const PrimRecord* prims, uint32_t count, const void* waves) {
              for_fragments(thread, prims, count, waves, [](const FragmentPrim& p, uint32_t* color, float*, uint32_t, uint32_t) {
                *color = 1 + p.front_facing;
              });
            });
        // On the screen, y down: right then down is clockwise.
        add_window_vertex(draw, 64, 64, 10, 10);
        add_window_vertex(draw, 64, 64, clockwise ? 50 : 10, clockwise ? 10 : 50);
        add_window_vertex(draw, 64, 64, clockwise ? 10 : 50, clockwise ? 50 : 10);
        draw.packet_base.front_face = front_face;
        draw.packet_base.cull = static_cast<VkCullModeFlags>(cull);
        const bool front = clockwise == (front_face == VK_FRONT_FACE_CLOCKWISE);
        const bool culled = (cull & (front ? VK_CULL_MODE_FRONT_BIT : VK_CULL_MODE_BACK_BIT)) != 0;
        EXPECT_EQ(draw_once(draw, 64).at(20, 20), culled ? 0u : front ? 2u : 1u);
      }
    }
  }
}

TEST(Setup, NegativeViewportHeightFlips) {
  TestDraw draw(4, count_kernel);
  for (const auto& p : {std::pair{0.f, 0.f}, {64.f, 0.f}, {0.f, 64.f}}) add_window_vertex(draw, 64, 64, p.first, p.second);
  draw.packet_base.viewport = {0, 64, 64, -64, 0, 1};
  const Target target = draw_once(draw, 64);
  EXPECT_EQ(target.at(1, 1), 0u);
  EXPECT_EQ(target.at(1, 62), 1u);
}

TEST(Setup, DepthBiasMovesDepth) {
  // A plane with dz/dx = 1/64 per px: slope factor 2 moves it by 2/64. r for z in [0.5, 1] is 2^-24.
  const auto depth_at_center = [](float constant, float slope, float clamp) {
    TestDraw draw(4, mix_kernel);
    draw.constants.depth_test = draw.constants.depth_write = 1;
    for (const auto& p : {std::array{0.f, 0.f, 0.0f}, {64.f, 0.f, 0.75f}, {0.f, 64.f, 0.0f}})
      add_window_vertex(draw, 64, 64, p[0], p[1], p[2]);
    draw.packet_base.depth_bias = true;
    draw.packet_base.depth_bias_constant = constant;
    draw.packet_base.depth_bias_slope = slope;
    draw.packet_base.depth_bias_clamp = clamp;
    Target target(64, 64);
    ThreadPool pool(1);
    Pass pass(pool, target.desc(true), test_options());
    pass.draw(draw.packet(64, 64));
    pass.end();
    return target.depth[16 * 64 + 16];
  };
  const float base = 0.75f / 64 * 16.5f;
  EXPECT_NEAR(depth_at_center(0, 0, 0), base, 1e-7);  // f32 rounding of three terms below 1
  EXPECT_NEAR(depth_at_center(0, 2, 0), base + 2 * 0.75f / 64, 1e-7);
  EXPECT_NEAR(depth_at_center(0, 2, 0.01f), base + 0.01f, 1e-7);
  EXPECT_NEAR(depth_at_center(0, -2, -0.01f), base - 0.01f, 1e-7);
  EXPECT_NEAR(depth_at_center(0x1p20f, 0, 0), base + 0x1p-4f, 1e-7);
}

// Each primitive goes to the viewport that its provoking vertex names, under that viewport's scissor; indices that there are not
// mean the first. Depth ranges, Hi-Z and clipping are the viewport's own.
TEST(Setup, PrimitivesChooseTheirViewport) {
  TestDraw draw(
      5, [](const KernelHandle*, const void*, void* thread, const PrimRecord* prims, uint32_t count, const void* waves) {
        for_fragments(thread, prims, count, waves,
                      [](const FragmentPrim& p, uint32_t* color, float*, uint32_t, uint32_t) { *color += 1 + p.viewport_index; });
      });
  ViewportArray viewports{.count = 3};
  viewports.viewport = {VkViewport{0, 0, 64, 64, 0, 1}, VkViewport{0, 0, 32, 32, 0, 1}, VkViewport{32, 32, 32, 32, 1, 0}};
  viewports.scissor = {VkRect2D{{0, 0}, {64, 8}}, VkRect2D{{0, 0}, {64, 64}}, VkRect2D{{40, 0}, {64, 64}}};
  draw.packet_base.viewports = &viewports;
  draw.packet_base.viewport = viewports.viewport[0];
  draw.packet_base.scissor = viewports.scissor[0];
  draw.packet_base.outputs.viewport_index = 4;
  for (const uint32_t index : {0u, 1u, 2u, 77u}) {  // a triangle over the whole viewport and beyond
    for (const auto& [x, y] : {std::pair{-1.0f, -1.0f}, {3.0f, -1.0f}, {-1.0f, 3.0f}}) {
      draw.add({x, y, 0.5f, 1, std::bit_cast<float>(index)});
    }
  }
  const Target target = draw_once(draw, 64, nullptr, 16);
  for (uint32_t y = 0; y < 64; ++y) {
    for (uint32_t x = 0; x < 64; ++x) {
      const uint32_t expected = (y < 8 ? 2 : 0) + (x < 32 && y < 32 ? 2 : 0) + (x >= 40 && y >= 32 ? 3 : 0);
      ASSERT_EQ(target.at(x, y), expected) << x << ' ' << y;
    }
  }
}

// ---- clipping -------------------------------------------------------------------------------------------------------------

TEST(Clip, VerticesStayInsideAndSharedEdgesAgree) {
  std::mt19937 rng(9);
  std::uniform_real_distribution<float> d(-3, 3);
  const ViewportTransform t = make_viewport_transform({0, 0, 640, 480, 0, 1}, true);
  Draw draw;
  draw.packet.vertex_slots = 5;
  constexpr uint32_t kAllPlanes = kClipDrop - 1;
  int crossing = 0;
  for (int i = 0; i < 3000; ++i) {
    float storage[4][5 * kLanes];
    for (auto& v : storage) {
      for (int s = 0; s < 5; ++s) v[s * static_cast<int>(kLanes)] = d(rng) * (i % 3 == 0 && s < 2 ? 1e5f : 1.0f);
    }
    // Two triangles on both sides of the edge 1-2, which they run through in opposite directions.
    const float* left[3] = {storage[0], storage[1], storage[2]};
    const float* right[3] = {storage[3], storage[2], storage[1]};
    Clipper a, b;
    const uint32_t na = a.clip_triangle(draw, t, kAllPlanes, left), nb = b.clip_triangle(draw, t, kAllPlanes, right);
    for (uint32_t k = 0; k < na; ++k) {
      const float* v = a.vertex(k);
      // Every plane holds up to the rounding of the cut by a later plane: relative to w a few ulp.
      const float slack = 1e-5f * (std::fabs(v[3]) + std::fabs(v[2])) + 1e-6f;
      EXPECT_GE(v[2], -slack);
      EXPECT_LE(v[2], v[3] + slack);
      EXPECT_GT(v[3], 0);
    }
    // Cuts of the shared edge are on both polygons, bit for bit: their attribute (slot 4) runs between those of 1 and 2.
    const auto on_shared_edge = [&](const Clipper& c, uint32_t n) {
      std::vector<std::array<float, 5>> cuts;
      const float *p = storage[1], *q = storage[2];
      for (uint32_t k = 0; k < n; ++k) {
        const float* v = c.vertex(k);
        const double at = (double{v[4]} - p[4 * kLanes]) / (double{q[4 * kLanes]} - p[4 * kLanes]);
        double off = 0;
        for (uint32_t s = 0; s < 4; ++s) {
          const double on_line = p[s * kLanes] + at * (double{q[s * kLanes]} - p[s * kLanes]);
          off = std::max(off, std::fabs(on_line - v[s]) / (1 + std::fabs(on_line)));
        }
        if (off < 1e-6 && at > -1e-6 && at < 1 + 1e-6) cuts.push_back({v[0], v[1], v[2], v[3], v[4]});
      }
      std::sort(cuts.begin(), cuts.end());
      return cuts;
    };
    if (na < 3 || nb < 3 || std::fabs(storage[1][4 * kLanes] - storage[2][4 * kLanes]) < 0.5f) continue;
    const auto cuts_a = on_shared_edge(a, na), cuts_b = on_shared_edge(b, nb);
    if (cuts_a.size() == 2 && cuts_b.size() == 2) {
      ++crossing;
      EXPECT_EQ(cuts_a, cuts_b) << i;
    }
  }
  EXPECT_GT(crossing, 100);
}

// The picture of a clipped triangle against the definition: a pixel is covered when its homogeneous barycentrics are all positive
// (Olano and Greer, 1997), and depth is inside [0, 1]. Pixels closer to an edge than the snapping can move it are not judged.
TEST(Clip, PicturesMatchHomogeneousRasterization) {
  constexpr uint32_t kSeed = 4242;
  constexpr int kSize = 64;
  std::mt19937 rng(kSeed);
  std::uniform_real_distribution<float> d(-1.5f, 1.5f);
  int judged = 0, covered = 0, clipped = 0;
  for (int i = 0; i < 400; ++i) {
    TestDraw draw(
        5, [](const KernelHandle*, const void*, void* thread, const PrimRecord* prims, uint32_t count, const void* waves) {
          for_fragments(thread, prims, count, waves, [](const FragmentPrim& p, uint32_t* color, float*, uint32_t, uint32_t) {
            *color += static_cast<uint32_t>(flat_attribute(p, 4));
          });
        });
    double m[3][4];
    for (auto& v : m) {
      for (double& c : v) c = d(rng) * (i % 4 == 0 ? 100 : 1);
      if (i % 4 == 0) v[3] *= 0.01, v[2] *= 0.01;
      v[3] += 0.3;
      v[2] = v[2] * 0.5 + 0.3;
      for (double& c : v) c = static_cast<float>(c);
      draw.add({static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2]), static_cast<float>(v[3]),
                &v == &m[0] ? 1.0f : 1000.0f});
    }
    PassStatistics s;
    const Target target = draw_once(draw, kSize, &s);
    clipped += s.triangles_clipped != 0;
    const auto cross = [](const double* a, const double* b, double* out) {  // of (x, y, w)
      out[0] = a[1] * b[3] - a[3] * b[1];
      out[1] = a[3] * b[0] - a[0] * b[3];
      out[2] = a[0] * b[1] - a[1] * b[0];
    };
    double e[3][3];
    for (int k = 0; k < 3; ++k) cross(m[(k + 1) % 3], m[(k + 2) % 3], e[k]);
    const double det = m[0][0] * e[0][0] + m[0][1] * e[0][1] + m[0][3] * e[0][2];
    if (std::fabs(det) < 1e-3) continue;
    for (int y = 0; y < kSize; ++y) {
      for (int x = 0; x < kSize; ++x) {
        const auto inside = [&](double px, double py) {
          const double xn = px * 2 / kSize - 1, yn = py * 2 / kSize - 1;
          double b[3], one_over_w = 0, z = 0;
          for (int k = 0; k < 3; ++k) {
            b[k] = (e[k][0] * xn + e[k][1] * yn + e[k][2]) / det;  // barycentric / w
            one_over_w += b[k];
          }
          for (int k = 0; k < 3; ++k) z += b[k] * m[k][2];
          return b[0] > 0 && b[1] > 0 && b[2] > 0 && one_over_w > 0 && z > 0 && z < 1;
        };
        // Judged only where the neighbourhood agrees: 1/16 px is far more than snapping and the f32 of the cuts can move an edge.
        const double r = 1.0 / 16, cx = x + 0.5, cy = y + 0.5;
        const bool in = inside(cx, cy);
        if (inside(cx - r, cy - r) != in || inside(cx + r, cy - r) != in || inside(cx - r, cy + r) != in ||
            inside(cx + r, cy + r) != in)
          continue;
        ++judged;
        covered += in;
        ASSERT_EQ(target.at(static_cast<uint32_t>(x), static_cast<uint32_t>(y)), in ? 1u : 0u)
            << "triangle " << i << " at " << x << ' ' << y;
      }
    }
  }
  EXPECT_GT(judged, 1000000);
  EXPECT_GT(covered, 50000);
  EXPECT_GT(clipped, 200);
}

TEST(Clip, NotFiniteAndDegenerateInputDrawsNothing) {
  const float inf = std::numeric_limits<float>::infinity(), nan = std::numeric_limits<float>::quiet_NaN();
  for (const float bad : {inf, -inf, nan}) {
    for (int component = 0; component < 4; ++component) {
      TestDraw draw(4, count_kernel);
      draw.vertices = {-1, -1, 0.5f, 1, 3, -1, 0.5f, 1, -1, 3, 0.5f, 1};
      draw.vertices[static_cast<size_t>(4 + component)] = bad;
      EXPECT_EQ(total(draw_once(draw, 32)), 0u);
    }
  }
  for (const float w : {0.0f, -1.0f, FLT_MIN, 1e-45f, FLT_MAX}) {  // must not crash; behind the eye nothing shows
    TestDraw draw(4, count_kernel);
    draw.vertices = {-1, -1, 0.5f * w, w, 3, -1, 0.5f * w, w, -1, 3, 0.5f * w, w};
    const uint64_t n = total(draw_once(draw, 32));
    if (w <= 0) {
      EXPECT_EQ(n, 0u);
    }
  }
}

TEST(Clip, HostileFloatsNeverCrash) {
  std::mt19937 rng(11);
  const float specials[] = {0.0f, -0.0f, 1.0f, -1.0f, FLT_MAX, -FLT_MAX, FLT_MIN, 1e-45f, 1e30f, -1e30f, 1e-30f, 16384.0f, 0.5f};
  for (int i = 0; i < 3000; ++i) {
    TestDraw draw(5, count_kernel);
    for (int v = 0; v < 15; ++v) {
      uint32_t bits = rng();
      float f;
      std::memcpy(&f, &bits, 4);
      draw.vertices.push_back(rng() % 3 ? specials[rng() % 13] : f);
    }
    draw.packet_base.depth_clip = i % 2 != 0;
    draw.packet_base.depth_bias = i % 3 == 0;
    draw.packet_base.depth_bias_slope = 1e30f;
    if (i % 4 == 0)
      draw.packet_base.viewport = {
          specials[rng() % 13], specials[rng() % 13], specials[rng() % 13] + 1, specials[rng() % 13], 0, 1};
    draw_once(draw, 16, nullptr, 16);
  }
}

TEST(Clip, DepthClampKeepsWhatDepthClippingCuts) {
  for (const bool clamp : {false, true}) {
    TestDraw draw(4, count_kernel);
    draw.vertices = {-1, -1, -0.5f, 1, 3, -1, -0.5f, 1, -1, 3, 3.5f, 1};
    draw.packet_base.depth_clip = !clamp;
    const uint64_t n = total(draw_once(draw, 32));
    if (clamp) {
      EXPECT_EQ(n, 32u * 32);
    } else {
      EXPECT_GT(n, 0u);
      EXPECT_LT(n, 32u * 32);
    }
  }
}

// ---- interpolation --------------------------------------------------------------------------------------------------------

// Planes against double precision from the snapped vertices.
struct Worst {
  double l = 0, z = 0, attribute = 0;
  uint64_t fragments = 0;
};

void interpolation_kernel(const KernelHandle*, const void* draw, void* thread, const PrimRecord* prims, uint32_t count,
                          const void* waves) {
  Worst& worst = *static_cast<Worst*>(const_cast<void*>(static_cast<const DrawContext*>(draw)->sets[0]));
  for_fragments(thread, prims, count, waves, [&](const FragmentPrim& p, uint32_t*, float*, uint32_t x, uint32_t y) {
    const Barycentrics b = barycentrics(p, x, y);
    // Vertex positions again, from the clip coordinates, in double.
    double sx[3], sy[3], iw[3], a[3], z[3];
    for (int k = 0; k < 3; ++k) {
      const float* v = p.vertex[k];
      const double w = v[3 * kLanes];
      sx[k] = std::nearbyint((v[0] / w * 64 + 64) * 256) / 256;
      sy[k] = std::nearbyint((v[kLanes] / w * 64 + 64) * 256) / 256;
      z[k] = v[2 * kLanes] / w;
      iw[k] = 1 / w;
      a[k] = v[4 * kLanes];
    }
    const double x1 = sx[1] - sx[0], y1 = sy[1] - sy[0], x2 = sx[2] - sx[0], y2 = sy[2] - sy[0], px = x + 0.5 - sx[0],
                 py = y + 0.5 - sy[0];
    const double area = x1 * y2 - y1 * x2;
    if (std::fabs(area) < 20) return;  // the bound below is for well-shaped triangles
    const double l1 = (px * y2 - py * x2) / area, l2 = (py * x1 - px * y1) / area, l0 = 1 - l1 - l2;
    const double one_over_w = l0 * iw[0] + l1 * iw[1] + l2 * iw[2];
    const double value = (l0 * iw[0] * a[0] + l1 * iw[1] * a[1] + l2 * iw[2] * a[2]) / one_over_w;
    worst.l = std::max({worst.l, std::fabs(b.l1 - l1), std::fabs(b.l2 - l2)});
    worst.z = std::max(worst.z, std::fabs(b.z - (l0 * z[0] + l1 * z[1] + l2 * z[2])));
    worst.attribute = std::max(worst.attribute, std::fabs(attribute(p, b, 4) - value));
    ++worst.fragments;
  });
}

TEST(Interpolation, PlanesAgreeWithDouble) {
  std::mt19937 rng(21);
  std::uniform_real_distribution<float> d(-1.2f, 1.2f), unit(0.05f, 0.95f);
  Worst worst;
  TestDraw draw(5, interpolation_kernel);
  for (int i = 0; i < 900; ++i) {
    const float w = 0.5f + 2 * unit(rng);
    draw.add({d(rng) * w, d(rng) * w, unit(rng) * w, w, unit(rng)});
  }
  draw.context.sets[0] = &worst;
  Target target(128, 128);
  ThreadPool pool(1);
  Pass pass(pool, target.desc(), test_options());
  pass.draw(draw.packet(128, 128));
  pass.end();
  EXPECT_GT(worst.fragments, 100000u);
  // Area >= 20 px^2 with edges below 310 px: |l_d| <= 310 / 20, so terms of l reach 310 * 15.5 = 4805 in the worst shape; 3
  // roundings of 2^-24 each give 9e-4. What typical shapes give is far below; this bound is for the sliver that the seed
  // contains.
  EXPECT_LT(worst.l, 9e-4);
  EXPECT_LT(worst.z, 2 * 9e-4);
  EXPECT_LT(worst.attribute, 6 * 9e-4);  // w varies by a factor 5 at most
}

// A plane that recedes from w = 1 to w = 10^6, each of its vertices first in turn. The attribute is w, so that its error can be
// told in pixels: in how far from the pixel it would be right.
struct Receding {
  double worst_px = 0;
  uint64_t fragments = 0, other_flat = 0;
  float provoking = 0;
};

void receding_kernel(const KernelHandle*, const void* draw, void* thread, const PrimRecord* prims, uint32_t count,
                     const void* waves) {
  Receding& receding = *static_cast<Receding*>(const_cast<void*>(static_cast<const DrawContext*>(draw)->sets[0]));
  for_fragments(thread, prims, count, waves, [&](const FragmentPrim& p, uint32_t*, float*, uint32_t x, uint32_t y) {
    const double slope = (1 - 1e-6) / 64, one_over_w = 1 - (y + 0.5 - 32) * slope;  // 1 at row 32, 10^-6 at row 96
    const double error = std::fabs(attribute(p, barycentrics(p, x, y), 4) - 1 / one_over_w);
    receding.worst_px = std::max(receding.worst_px, error * one_over_w * one_over_w / slope);
    receding.other_flat += flat_attribute(p, 5) != receding.provoking;
    ++receding.fragments;
  });
}

TEST(Interpolation, FarVerticesDoNotBlurNearPixels) {
  for (size_t first = 0; first < 3; ++first) {
    Receding receding{.provoking = static_cast<float>(first)};
    TestDraw draw(6, receding_kernel);
    const auto vertex = [](size_t i) {
      const float x[] = {-0.75f, 0.5f, 0.625f}, y[] = {-0.5f, 0.5f, 0.5f}, w[] = {1, 1e6f, 1e6f};
      return std::array{x[i] * w[i], y[i] * w[i], 0.0f, w[i], w[i], static_cast<float>(i)};
    };
    for (size_t i = first; i < first + 3; ++i) {
      for (const float value : vertex(i % 3)) draw.vertices.push_back(value);
    }
    draw.context.sets[0] = &receding;
    draw_once(draw, 128);
    EXPECT_GT(receding.fragments, 200u);
    EXPECT_EQ(receding.other_flat, 0u) << "flat attributes are those of the provoking vertex, " << first;
    // l1, l2, 1/w and b0, b2 have about 16 roundings, of at most 2^-24 of the largest 1/w. That is as much of 1/w as it changes
    // in 64 px.
    EXPECT_LT(receding.worst_px, 64 * 16 * 0x1p-24) << "vertex " << first << " first";
  }
}

}  // namespace
}  // namespace pineda::raster
