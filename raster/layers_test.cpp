// Layers and viewports that primitives choose: a pass over all layers at once, against one pass for each layer that is given the
// layer's primitives only.
#include <gtest/gtest.h>

#include <bit>
#include <random>

#include "raster/test_scene.h"

namespace pineda::raster {
namespace {

using namespace testing;

constexpr uint32_t kSize = 80, kLayers = 5, kPixels = kSize * kSize;
constexpr uint32_t kSlots = 7;  // position, colour, layer, viewport

// color = color * 3 + the primitive's, so that order shows; with a depth test.
void ordered_kernel(const KernelHandle*, const void* draw, void* thread, const PrimRecord* prims, uint32_t count,
                    const void* waves) {
  const Constants c = constants(draw);
  for_fragments(thread, prims, count, waves, [&](const FragmentPrim& p, uint32_t* color, float* depth, uint32_t x, uint32_t y) {
    const float z = barycentrics(p, x, y).z;
    if (depth && !passes(c.compare, z, *depth)) return;
    if (depth) *depth = z;
    *color = *color * 3 + std::bit_cast<uint32_t>(flat_attribute(p, 4)) + p.viewport_index;
  });
}

struct Primitive {
  std::array<std::array<float, 3>, 3> corner;
  float w[3];
  uint32_t color, layer, viewport;
};

std::vector<Primitive> random_primitives(uint32_t seed, uint32_t count, uint32_t layers, uint32_t viewports) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> unit(0, 1);
  std::vector<Primitive> out(count);
  for (Primitive& p : out) {
    const float size = random() % 4 == 0 ? 3.0f : 0.4f, x = unit(random) * 2 - 1, y = unit(random) * 2 - 1;
    for (uint32_t k = 0; k < 3; ++k) {
      // Some reach behind the viewer and some before the near plane, so that clipping takes part.
      p.w[k] = random() % 16 == 0 ? -0.5f : 1;
      p.corner[k] = {x + (unit(random) - 0.5f) * size, y + (unit(random) - 0.5f) * size, unit(random) * 1.2f - 0.1f};
    }
    p.color = random() % 1000;
    p.layer = random() % layers;
    p.viewport = random() % viewports;
  }
  return out;
}

struct Layered {
  std::vector<uint32_t> color = std::vector<uint32_t>(kPixels * kLayers, 7);
  std::vector<float> depth = std::vector<float>(kPixels * kLayers, 1.0f);
  bool operator==(const Layered&) const = default;
};

PassDesc layered_desc(Layered& target, uint32_t first_layer, uint32_t layers) {
  PassDesc d;
  d.extent = {kSize, kSize};
  d.render_area = {{0, 0}, {kSize, kSize}};
  d.color_count = 1;
  d.color[0] = {reinterpret_cast<uint8_t*>(target.color.data() + first_layer * kPixels), kSize * 4, VK_FORMAT_R8G8B8A8_UNORM};
  d.depth = {reinterpret_cast<uint8_t*>(target.depth.data() + first_layer * kPixels), kSize * 4, VK_FORMAT_D32_SFLOAT};
  d.color[0].layer_pitch_bytes = d.depth.layer_pitch_bytes = kPixels * 4;
  d.depth.load = VK_ATTACHMENT_LOAD_OP_CLEAR;
  d.depth.clear.depthStencil.depth = 0.875f;
  d.layers = layers;
  return d;
}

ViewportArray three_viewports() {
  ViewportArray v{.count = 3};
  v.viewport = {VkViewport{0, 0, kSize, kSize, 0, 1}, VkViewport{20, 10, 50, 60, 0.25f, 0.75f},
                VkViewport{70, 70, -60, -60, 1, 0}};
  v.scissor = {VkRect2D{{0, 0}, {kSize, 40}}, VkRect2D{{0, 0}, {kSize, kSize}}, VkRect2D{{15, 0}, {50, 77}}};
  return v;
}

// The primitives of layer `only`, or all of them with their layers when it is ~0.
void add_primitives(TestDraw& draw, const std::vector<Primitive>& list, uint32_t only) {
  for (const Primitive& p : list) {
    if (only != ~0u && p.layer != only) continue;
    for (uint32_t k = 0; k < 3; ++k) {
      draw.add({p.corner[k][0], p.corner[k][1], p.corner[k][2], p.w[k], std::bit_cast<float>(p.color),
                std::bit_cast<float>(only == ~0u ? p.layer : 0u), std::bit_cast<float>(p.viewport)});
    }
  }
}

TestDraw make_draw(VkPrimitiveTopology topology, const ViewportArray& viewports) {
  TestDraw draw(kSlots, ordered_kernel);
  draw.constants.compare = VK_COMPARE_OP_LESS_OR_EQUAL;
  draw.packet_base.topology = topology;
  draw.packet_base.outputs.layer = 5;
  draw.packet_base.outputs.viewport_index = 6;
  draw.packet_base.viewports = &viewports;
  draw.packet_base.viewport = viewports.viewport[0];
  draw.packet_base.scissor = viewports.scissor[0];
  draw.packet_base.early_depth = draw.packet_base.depth_test = draw.packet_base.depth_write = true;
  draw.packet_base.depth_compare = VK_COMPARE_OP_LESS_OR_EQUAL;
  return draw;
}

// Two draws with a clear of layers 1 and 2 between them.
void draw_pass(ThreadPool& pool, const Options& options, Layered& target, const std::array<std::vector<Primitive>, 2>& lists,
               VkPrimitiveTopology topology, uint32_t only) {
  const ViewportArray viewports = three_viewports();
  const VkRect2D hole{{10, 20}, {33, 17}};
  Pass pass(pool, only == ~0u ? layered_desc(target, 0, kLayers) : layered_desc(target, only, 1), options);
  TestDraw first = make_draw(topology, viewports), second = make_draw(topology, viewports);
  add_primitives(first, lists[0], only);
  add_primitives(second, lists[1], only);
  VkClearValue value{};
  value.color.float32[0] = 1;
  if (first.vertex_count() != 0) pass.draw(first.packet(kSize, kSize));
  if (only == ~0u) {
    pass.clear(0, value, {&hole, 1}, 1, 2);
  } else if (only == 1 || only == 2) {
    pass.clear(0, value, {&hole, 1});
  }
  if (second.vertex_count() != 0) pass.draw(second.packet(kSize, kSize));
  pass.end();
}

TEST(Layers, AllAtOnceIsEachForItself) {
  ThreadPool one(1), three(3);
  for (const VkPrimitiveTopology topology : {VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST, VK_PRIMITIVE_TOPOLOGY_LINE_LIST}) {
    const std::array<std::vector<Primitive>, 2> lists{random_primitives(91, 700, kLayers, 3),
                                                      random_primitives(92, 300, kLayers, 3)};
    std::array<std::vector<Primitive>, 2> drawn = lists;
    if (topology == VK_PRIMITIVE_TOPOLOGY_LINE_LIST) {  // whose vertices go two by two: those of a layer would fall apart
      for (auto& list : drawn)
        for (Primitive& p : list) p.layer = 3;
    }
    Layered expected;
    for (uint32_t layer = 0; layer < kLayers; ++layer) draw_pass(one, {}, expected, drawn, topology, layer);
    for (const uint32_t variant : {0u, 1u, 2u, 3u}) {
      Options options;
      options.tile_px = variant == 0 ? 0 : 16u << (variant % 3);
      options.hi_z = variant != 1;
      options.chunk_prims = variant == 2 ? 64 : 4096;
      options.bin_budget_bytes = variant == 2 ? 1 : options.bin_budget_bytes;
      Layered target;
      draw_pass(variant % 2 == 0 ? one : three, options, target, drawn, topology, ~0u);
      EXPECT_TRUE(target == expected) << "variant " << variant << " topology " << topology;
    }
  }
}

// A layer that the framebuffer does not have is the first (the specification leaves it undefined); nothing is written outside.
TEST(Layers, ThoseThatAreNotThere) {
  ThreadPool pool(1);
  std::array<std::vector<Primitive>, 2> lists{random_primitives(5, 50, 1, 1), {}};
  Layered expected, target;
  draw_pass(pool, {}, expected, lists, VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST, ~0u);
  for (Primitive& p : lists[0]) {
    p.layer = 0xFFFFFF00u + p.color;
    p.viewport = 77;
  }
  draw_pass(pool, {}, target, lists, VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST, ~0u);
  EXPECT_TRUE(target == expected);
}

// Without attachments the layers share their tiles, and fragments still know theirs.
TEST(Layers, WithoutAttachments) {
  ThreadPool pool(2);
  static std::array<std::atomic<uint32_t>, kLayers> seen;
  for (auto& count : seen) count = 0;
  TestDraw draw(kSlots,
                [](const KernelHandle*, const void*, void* thread, const PrimRecord* prims, uint32_t count, const void* waves) {
                  for_fragments(thread, prims, count, waves,
                                [](const FragmentPrim& p, uint32_t*, float*, uint32_t, uint32_t) { ++seen[p.layer]; });
                });
  draw.packet_base.outputs.layer = 5;
  draw.packet_base.has_side_effects = true;
  for (uint32_t layer = 0; layer < kLayers; ++layer) {
    for (const auto& [x, y] : {std::pair{-1.0f, -1.0f}, {3.0f, -1.0f}, {-1.0f, 3.0f}})
      draw.add({x, y, 0.5f, 1, 0, std::bit_cast<float>(layer), 0});
  }
  PassDesc d;
  d.extent = {kSize, kSize};
  d.render_area = {{0, 0}, {kSize, kSize}};
  d.layers = kLayers;
  Pass pass(pool, d);
  pass.draw(draw.packet(kSize, kSize));
  pass.end();
  for (uint32_t layer = 0; layer < kLayers; ++layer) EXPECT_EQ(seen[layer], kPixels) << layer;
}

// Attachments whose loads and stores nobody wants never touch their memory, whatever is drawn, in every layer.
TEST(Layers, TransientAttachmentsStayInTiles) {
  ThreadPool pool(2);
  const std::array<std::vector<Primitive>, 2> lists{random_primitives(17, 200, kLayers, 3), {}};
  const ViewportArray viewports = three_viewports();
  Layered target;
  TestDraw draw = make_draw(VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST, viewports);
  add_primitives(draw, lists[0], ~0u);
  PassDesc d = layered_desc(target, 0, kLayers);
  d.color[0].load = VK_ATTACHMENT_LOAD_OP_DONT_CARE;
  d.color[0].store = d.depth.store = VK_ATTACHMENT_STORE_OP_DONT_CARE;
  Pass pass(pool, d);
  pass.draw(draw.packet(kSize, kSize));
  const PassStatistics statistics = pass.end();
  EXPECT_GT(statistics.fragments_shaded, 0u);
  EXPECT_EQ(statistics.bytes_loaded, 0u);
  EXPECT_EQ(statistics.bytes_stored, 0u);
  EXPECT_TRUE(target == Layered{});
}

}  // namespace
}  // namespace pineda::raster
