// Whole passes with hand-written kernels.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>

#include "raster/test_scene.h"

namespace pineda::raster {
namespace {

using namespace testing;

// Draws of random overlapping triangles: all depth modes, some clipped, some huge, several draws each.
struct RandomScene {
  static constexpr uint32_t kWidth = 203, kHeight = 149;  // no multiple of anything
  std::vector<std::unique_ptr<TestDraw>> draws;

  explicit RandomScene(uint32_t seed, uint32_t draw_count, uint32_t triangles, VkCompareOp compare) {
    std::mt19937 rng(seed);
    std::uniform_real_distribution<float> unit(0, 1), around(-1.4f, 1.4f);
    for (uint32_t d = 0; d < draw_count; ++d) {
      auto draw = std::make_unique<TestDraw>(6, mix_kernel);
      draw->constants.color = d;
      // Most draws test as the scene does; some write against its direction, some do not test.
      draw->constants.depth_test = d % 4 != 3;
      draw->constants.depth_write = d % 3 != 1;
      draw->constants.compare = d % 7 == 5 ? VK_COMPARE_OP_ALWAYS : d % 11 == 6 ? VK_COMPARE_OP_GREATER : compare;
      const float size = d % 5 == 0 ? 2.5f : d % 2 ? 0.15f : 0.02f;
      for (uint32_t t = 0; t < triangles; ++t) {
        const float cx = around(rng), cy = around(rng), cz = unit(rng);
        for (int k = 0; k < 3; ++k) {
          const float w = d % 6 == 4 ? around(rng) + 1.0f : 0.5f + unit(rng);  // some behind the eye
          draw->add({(cx + size * (unit(rng) - 0.5f)) * w, (cy + size * (unit(rng) - 0.5f)) * w, (cz + 0.2f * unit(rng)) * w, w,
                     unit(rng), unit(rng)});
        }
      }
      draws.push_back(std::move(draw));
    }
  }

  PassStatistics render(Target& target, const Options& options, uint32_t threads, bool with_clear) {
    ThreadPool pool(threads);
    PassDesc desc = target.desc(true);
    desc.depth.load = VK_ATTACHMENT_LOAD_OP_CLEAR;
    desc.depth.clear.depthStencil.depth = 0.6f;
    Pass pass(pool, desc, options);
    for (size_t i = 0; i < draws.size(); ++i) {
      pass.draw(draws[i]->packet(kWidth, kHeight));
      if (with_clear && i == draws.size() / 2) {
        VkClearValue value{};
        value.depthStencil.depth = 0.9f;
        const VkRect2D rects[] = {{{10, 20}, {90, 55}}, {{150, 100}, {400, 400}}};
        pass.clear(Pass::kDepth, value, rects);
        value = {};
        value.color.float32[0] = 1;
        pass.clear(0, value, rects);
      }
    }
    return pass.end();
  }
};

// One thread, 16 px tiles, no shortcut, everything kept: the plainest way through the code.
Options plain_options() {
  Options options = test_options();
  options.tile_px = 16;
  options.hi_z = options.fast_clear = options.opaque = false;
  options.bin_budget_bytes = size_t{1} << 30;
  options.isa = Isa::kSse42;
  return options;
}

TEST(Pass, NothingButTheSceneDecidesTheBits) {
  const uint32_t draw_counts[] = {3, 14}, triangle_counts[] = {700, 150};
  for (const VkCompareOp compare : {VK_COMPARE_OP_LESS, VK_COMPARE_OP_LESS_OR_EQUAL, VK_COMPARE_OP_GREATER}) {
    for (int variant = 0; variant < 2; ++variant) {
      RandomScene scene(100 + static_cast<uint32_t>(variant), draw_counts[variant], triangle_counts[variant], compare);
      Target expected(RandomScene::kWidth, RandomScene::kHeight);
      scene.render(expected, plain_options(), 1, true);
      EXPECT_GT(std::count_if(expected.color.begin(), expected.color.end(), [](uint32_t v) { return v != 0; }), 10000);
      for (const uint32_t threads : {1u, 2u, 5u}) {
        for (const uint32_t tile : {16u, 32u, 64u}) {
          for (const bool shortcuts : {false, true}) {
            for (const size_t budget : {size_t{1}, size_t{64} << 20}) {
              if (budget == 1 && (threads == 5 || tile == 32)) continue;  // covered by the others; keeps the test short
              Options options = test_options();
              options.tile_px = tile;
              options.hi_z = options.opaque = options.fast_clear = shortcuts;
              options.bin_budget_bytes = budget;
              options.chunk_prims = budget == 1 ? 37 : 4096;
              if (threads == 5) options.max_chunk_entries = 700;  // chunks are cut
              Target got(RandomScene::kWidth, RandomScene::kHeight);
              scene.render(got, options, threads, true);
              ASSERT_TRUE(got.color == expected.color) << "threads " << threads << " tile " << tile << " shortcuts " << shortcuts;
              ASSERT_TRUE(got.depth == expected.depth) << "threads " << threads << " tile " << tile << " shortcuts " << shortcuts;
            }
          }
        }
      }
    }
  }
}

// Passes that run beside each other, each on one thread, against each on its own: pictures and statistics.
TEST(Pass, TogetherTheyDrawWhatTheyDrawAlone) {
  constexpr uint32_t kPasses = 9, kSize = 120;
  for (const uint32_t threads : {1u, 2u, 5u}) {
    std::vector<RandomScene> scenes;
    std::vector<Target> alone, together;
    for (uint32_t i = 0; i < kPasses; ++i) {
      scenes.emplace_back(40 + i, 1 + i % 3, 100 + 70 * i, VK_COMPARE_OP_LESS);
      alone.emplace_back(kSize, kSize);
      together.emplace_back(kSize, kSize);
    }
    ThreadPool pool(threads);
    std::vector<PassStatistics> expected;
    std::vector<Pass> passes;
    for (uint32_t i = 0; i < kPasses; ++i) {
      Pass one(pool, alone[i].desc(true), test_options());
      passes.emplace_back(pool, together[i].desc(true), test_options());
      for (const auto& draw : scenes[i].draws) {
        one.draw(draw->packet(kSize, kSize));
        passes[i].draw(draw->packet(kSize, kSize));
      }
      EXPECT_EQ(passes[i].may_wait(), threads > 1);
      EXPECT_FALSE(passes[i].shares_memory(one));
      expected.push_back(one.end());
    }
    std::vector<Pass*> pointers;
    for (Pass& pass : passes) pointers.push_back(&pass);
    Pass::end_together(pointers);
    for (uint32_t i = 0; i < kPasses; ++i) {
      ASSERT_TRUE(together[i].color == alone[i].color) << i << " of " << threads << " threads";
      ASSERT_TRUE(together[i].depth == alone[i].depth) << i << " of " << threads << " threads";
      const PassStatistics& s = passes[i].statistics();
      EXPECT_EQ(s.overlapped, 1u);
      EXPECT_EQ(s.vertices_shaded, expected[i].vertices_shaded);
      EXPECT_EQ(s.triangles_culled, expected[i].triangles_culled);
      EXPECT_EQ(s.bytes_stored, expected[i].bytes_stored);
    }
  }
}

TEST(Pass, WaitsOnlyWhenItIsShortAndChangesNothingElse) {
  ThreadPool pool(2);
  Target small(64, 64), large(300, 300);
  TestDraw draw(4, count_kernel);
  draw.add({-1, -1, 0, 1});
  draw.add({3, -1, 0, 1});
  draw.add({-1, 3, 0, 1});
  const auto may_wait = [&](const PassDesc& desc, const DrawPacket& packet, bool overlap = true) {
    Options options = test_options();
    options.overlap = overlap;
    Pass pass(pool, desc, options);
    pass.draw(packet);
    return pass.may_wait();
  };
  DrawPacket packet = draw.packet(64, 64);
  EXPECT_TRUE(may_wait(small.desc(), packet));
  EXPECT_FALSE(may_wait(small.desc(), packet, false));
  EXPECT_FALSE(may_wait(large.desc(), packet));
  packet.has_side_effects = true;
  EXPECT_FALSE(may_wait(small.desc(), packet));
  packet.has_side_effects = false;
  std::atomic<uint64_t> counter = 0;
  packet.samples_passed = &counter;
  EXPECT_FALSE(may_wait(small.desc(), packet));

  // One attachment's last row is the other's first.
  Pass upper(pool, small.desc(), test_options());
  PassDesc shifted = small.desc();
  shifted.color[0].address += size_t{63} * shifted.color[0].row_pitch_bytes;
  EXPECT_TRUE(Pass(pool, shifted, test_options()).shares_memory(upper));
  shifted.color[0].address += shifted.color[0].row_pitch_bytes;
  EXPECT_FALSE(Pass(pool, shifted, test_options()).shares_memory(upper));
}

// Each omission alone, and nothing left out at all.
TEST(Pass, EachOmissionAloneChangesNoBit) {
  RandomScene scene(7, 5, 400, VK_COMPARE_OP_LESS);
  Target expected(RandomScene::kWidth, RandomScene::kHeight);
  scene.render(expected, plain_options(), 1, true);
  constexpr bool Options::*kOmissions[] = {&Options::hi_z,          &Options::fast_clear,      &Options::opaque,
                                           &Options::equal_samples, &Options::outside_batches, &Options::missed_triangles,
                                           &Options::lazy_memory};
  for (size_t off = 0; off <= std::size(kOmissions); ++off) {
    Options options = test_options();
    for (size_t i = 0; i < std::size(kOmissions); ++i) options.*kOmissions[i] = off < std::size(kOmissions) && i != off;
    Target got(RandomScene::kWidth, RandomScene::kHeight);
    scene.render(got, options, 2, true);
    EXPECT_TRUE(got.color == expected.color && got.depth == expected.depth) << "omission " << off;
  }
}

// Meshes beside the target, before the near plane and behind the viewer leave batch by batch; a batch of which one triangle
// reaches into the target stays.
TEST(Pass, BatchesOutsideLeaveAfterTheirPositions) {
  for (const bool leave : {true, false}) {
    Options options = test_options();
    options.outside_batches = leave;
    ThreadPool pool(1);
    Target target(64, 64);
    Pass pass(pool, target.desc(), options);
    std::vector<std::unique_ptr<TestDraw>> draws;
    const auto mesh = [&](float x, float y, float z, float w, bool reaches) {
      draws.push_back(std::make_unique<TestDraw>(4, count_kernel));
      for (int i = 0; i < 600; ++i) {
        const float dx = 0.01f * static_cast<float>(i % 20), dy = 0.01f * static_cast<float>(i / 20);
        draws.back()->add({x + dx, y + dy, z, w});
        draws.back()->add({x + dx + 0.02f, y + dy, z, w});
        draws.back()->add({reaches && i == 599 ? 0 : x + dx, y + dy + 0.02f, z, w});
      }
      pass.draw(draws.back()->packet(64, 64));
    };
    mesh(1.05f, 0, 0.5f, 1, false);
    mesh(-2, 0, 0.5f, 1, false);
    mesh(0, 1.1f, 0.5f, 1, false);
    mesh(0, -2, 0.5f, 1, false);
    mesh(0, 0, -0.5f, 1, false);
    mesh(0, 0, 0.5f, -1, false);
    mesh(1.05f, 0, 0.5f, 1, true);
    const PassStatistics s = pass.end();
    // All but the last one's last; where batches begin follows from the sizes of geometry jobs.
    if (leave) {
      EXPECT_GE(s.batches_outside, 7 * 600u / 512 + 1);
    } else {
      EXPECT_EQ(s.batches_outside, 0u);
    }
    EXPECT_EQ(s.triangles_in, 7 * 600u);
    EXPECT_EQ(s.triangles_culled, 7 * 600u - 1);
    EXPECT_GT(s.fragments_shaded, 0u);
  }
}

// Hi-Z must find something to do in a scene that hides most of itself, and still change nothing.
TEST(Pass, HiZRejectsHiddenLayers) {
  for (const bool reverse : {false, true}) {
    PassStatistics statistics[2];
    std::unique_ptr<Target> targets[2];
    for (int on = 0; on < 2; ++on) {
      TestDraw draw(4, mix_kernel);
      draw.constants.depth_test = draw.constants.depth_write = 1;
      draw.constants.compare = reverse ? VK_COMPARE_OP_GREATER_OR_EQUAL : VK_COMPARE_OP_LESS;
      for (int layer = 0; layer < 10; ++layer) {  // front to back, slightly tilted
        const float z = 0.1f + 0.05f * static_cast<float>(layer);
        const auto depth = [&](float v) { return reverse ? 1 - v : v; };
        draw.add({-1, -1, depth(z), 1});
        draw.add({3, -1, depth(z + 0.02f), 1});
        draw.add({-1, 3, depth(z + 0.03f), 1});
      }
      targets[on] = std::make_unique<Target>(256, 256);
      std::fill(targets[on]->depth.begin(), targets[on]->depth.end(), reverse ? 0.0f : 1.0f);
      ThreadPool pool(1);
      Options options = test_options();
      options.hi_z = on == 1;
      Pass pass(pool, targets[on]->desc(true), options);
      pass.draw(draw.packet(256, 256));
      statistics[on] = pass.end();
    }
    EXPECT_TRUE(targets[0]->color == targets[1]->color);
    EXPECT_TRUE(targets[0]->depth == targets[1]->depth);
    EXPECT_EQ(statistics[0].blocks_hi_z_rejected, 0u);
    EXPECT_EQ(statistics[0].blocks_shaded, 10u * 64 * 64);
    EXPECT_EQ(statistics[1].blocks_shaded, 64u * 64) << "only the front layer";
    EXPECT_EQ(statistics[1].blocks_hi_z_rejected, 9u * 64 * 64);
  }
}

// Clamping lowers depths that lie behind the viewport's range: Hi-Z must expect that.
TEST(Pass, HiZKnowsDepthClamp) {
  Target target(64, 64);
  std::fill(target.depth.begin(), target.depth.end(), 0.5f);
  TestDraw draw(4, mix_kernel);
  draw.constants.depth_test = draw.constants.depth_write = 1;
  draw.constants.compare = VK_COMPARE_OP_LESS_OR_EQUAL;
  draw.constants.depth_max = 0.5f;
  draw.add({-1, -1, 4, 1});
  draw.add({3, -1, 4, 1});
  draw.add({-1, 3, 4, 1});
  draw.packet_base.depth_clip = false;
  draw.packet_base.viewport = {0, 0, 64, 64, 0, 0.5f};
  ThreadPool pool(1);
  Pass pass(pool, target.desc(true), test_options());
  pass.draw(draw.packet(64, 64));
  pass.end();
  for (const uint32_t v : target.color) ASSERT_NE(v, 0u);
}

TEST(Pass, DrawsComeInApiOrder) {
  // Every draw overwrites the target where it covers it: the last one wins.
  constexpr uint32_t kSize = 100;
  std::vector<std::unique_ptr<TestDraw>> draws;
  std::mt19937 rng(5);
  std::uniform_real_distribution<float> d(-1, 1);
  std::vector<uint32_t> expected(kSize * kSize, 0);
  for (uint32_t i = 0; i < 300; ++i) {
    draws.push_back(std::make_unique<TestDraw>(4, color_kernel));
    draws.back()->constants.color = i + 1;
    for (int k = 0; k < 3; ++k) draws.back()->add({d(rng), d(rng), 0.5f, 1});
  }
  const auto render = [&](size_t first, size_t end, Target& target, uint32_t threads) {
    ThreadPool pool(threads);
    Options options = test_options();
    options.chunk_prims = 8;
    options.tile_px = 16;
    Pass pass(pool, target.desc(), options);
    for (size_t i = first; i < end; ++i) pass.draw(draws[i]->packet(kSize, kSize));
    pass.end();
  };
  Target all(kSize, kSize), one_by_one(kSize, kSize);
  render(0, draws.size(), all, 3);
  for (size_t i = 0; i < draws.size(); ++i) render(i, i + 1, one_by_one, 1);
  EXPECT_TRUE(all.color == one_by_one.color);
}

TEST(Pass, OpaqueCoverDropsWhatLiesUnderIt) {
  for (const bool side_effects : {false, true}) {
    Target target(256, 256);
    TestDraw below(4, count_kernel), cover(4, color_kernel), above(4, count_kernel);
    for (TestDraw* draw : {&below, &cover, &above}) {
      draw->add({-1, -1, 0.5f, 1});
      draw->add({3, -1, 0.5f, 1});
      draw->add({-1, 3, 0.5f, 1});
    }
    cover.constants.color = 41;
    ThreadPool pool(1);
    Pass pass(pool, target.desc(), test_options());
    DrawPacket packet = below.packet(256, 256);
    packet.has_side_effects = side_effects;
    pass.draw(packet);
    packet = cover.packet(256, 256);
    packet.opaque = true;
    pass.draw(packet);
    pass.draw(above.packet(256, 256));
    const PassStatistics statistics = pass.end();
    for (const uint32_t v : target.color) ASSERT_EQ(v, 42u);
    EXPECT_EQ(statistics.blocks_shaded, (side_effects ? 3u : 2u) * 64 * 64);
  }
}

// A cover hides colours, not what happened to depth.
TEST(Pass, OpaqueCoverKeepsDepthClears) {
  Target target(128, 128);
  TestDraw cover(4, color_kernel);
  cover.add({-1, -1, 0.5f, 1});
  cover.add({3, -1, 0.5f, 1});
  cover.add({-1, 3, 0.5f, 1});
  ThreadPool pool(1);
  Pass pass(pool, target.desc(true), test_options());
  VkClearValue value{};
  value.depthStencil.depth = 0.25f;
  const VkRect2D all{{0, 0}, {128, 128}};
  pass.clear(Pass::kDepth, value, {&all, 1});
  DrawPacket packet = cover.packet(128, 128);
  packet.opaque = true;
  pass.draw(packet);
  pass.end();
  for (const float z : target.depth) ASSERT_EQ(z, 0.25f);
}

TEST(Pass, ScissorAndRenderArea) {
  Target target(90, 70);
  TestDraw draw(4, count_kernel);
  draw.add({-1, -1, 0.5f, 1});
  draw.add({3, -1, 0.5f, 1});
  draw.add({-1, 3, 0.5f, 1});
  draw.packet_base.scissor = {{7, 9}, {50, 1000}};
  ThreadPool pool(2);
  PassDesc desc = target.desc();
  desc.render_area = {{3, 13}, {40, 41}};
  Pass pass(pool, desc, test_options());
  pass.draw(draw.packet(90, 70));
  pass.end();
  for (uint32_t y = 0; y < 70; ++y) {
    for (uint32_t x = 0; x < 90; ++x) {
      const bool inside = x >= 7 && x < 43 && y >= 13 && y < 54;
      ASSERT_EQ(target.at(x, y), inside ? 1u : 0u) << x << ' ' << y;
    }
  }
}

TEST(Pass, LoadClearAndStoreOperations) {
  for (const bool fast_clear : {false, true}) {
    for (const VkAttachmentLoadOp load :
         {VK_ATTACHMENT_LOAD_OP_LOAD, VK_ATTACHMENT_LOAD_OP_CLEAR, VK_ATTACHMENT_LOAD_OP_DONT_CARE}) {
      for (const VkAttachmentStoreOp store : {VK_ATTACHMENT_STORE_OP_STORE, VK_ATTACHMENT_STORE_OP_DONT_CARE}) {
        for (const bool draws : {false, true}) {
          Target target(150, 150);
          std::fill(target.color.begin(), target.color.end(), 0x10u);
          TestDraw draw(4, count_kernel);
          for (const auto& p : {std::pair{0.f, 0.f}, {8.f, 0.f}, {0.f, 8.f}})
            add_window_vertex(draw, 150, 150, p.first, p.second);
          ThreadPool pool(2);
          PassDesc desc = target.desc();
          desc.render_area = {{0, 0}, {149, 150}};
          desc.color[0].load = load;
          desc.color[0].store = store;
          desc.color[0].clear.color.float32[0] = 1;  // 0x000000FF
          Options options = test_options();
          options.tile_px = 32;
          options.fast_clear = fast_clear;
          Pass pass(pool, desc, options);
          if (draws) pass.draw(draw.packet(150, 150));
          const PassStatistics statistics = pass.end();
          const bool stored = store == VK_ATTACHMENT_STORE_OP_STORE;
          const uint32_t background = !stored || load == VK_ATTACHMENT_LOAD_OP_LOAD ? 0x10u
                                      : load == VK_ATTACHMENT_LOAD_OP_CLEAR         ? 0xFFu
                                                                                    : 0u;
          EXPECT_EQ(target.at(100, 100), background);
          EXPECT_EQ(target.at(20, 20), background);
          EXPECT_EQ(target.at(149, 100), 0x10u) << "outside of the render area";
          EXPECT_EQ(target.at(1, 1), stored && draws ? background + 1 : background);
          EXPECT_EQ(statistics.tiles_touched, draws ? 1u : 0u);
          const bool fills = stored && load != VK_ATTACHMENT_LOAD_OP_LOAD;
          EXPECT_EQ(statistics.tiles_filled, fills ? (draws ? 24u : 25u) : 0u);
          EXPECT_EQ(statistics.tiles_untouched, fills ? 0u : (draws ? 24u : 25u));
        }
      }
    }
  }
}

TEST(Pass, RefusesOtherTopologies) {
  Target target(32, 32);
  TestDraw draw(4, count_kernel);
  for (int i = 0; i < 3; ++i) draw.add({0, 0, 0.5f, 1});
  draw.packet_base.topology = VK_PRIMITIVE_TOPOLOGY_PATCH_LIST;
  ThreadPool pool(1);
  Pass pass(pool, target.desc(), test_options());
  pass.draw(draw.packet(32, 32));
  EXPECT_EQ(pass.end().triangles_in, 0u);
}

TEST(Pass, EmptyPassesAndTargets) {
  ThreadPool pool(2);
  Target target(8, 8);
  PassDesc desc = target.desc();
  desc.render_area = {{100, 100}, {5, 5}};
  TestDraw draw(4, count_kernel);
  for (int i = 0; i < 3; ++i) draw.add({0, 0, 0.5f, 1});
  Pass outside(pool, desc, test_options());
  outside.draw(draw.packet(8, 8));
  outside.end();
  PassDesc nothing;
  nothing.extent = {16, 16};
  nothing.render_area = {{0, 0}, {16, 16}};
  Pass no_attachments(pool, nothing, test_options());
  EXPECT_EQ(no_attachments.end().tiles_touched, 0u);
  for (const uint32_t v : target.color) EXPECT_EQ(v, 0u);
}

}  // namespace
}  // namespace pineda::raster
