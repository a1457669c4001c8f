// Statistics add up, per draw too, and come out as text, JSON and a picture.
#include "raster/statistics_report.h"

#include <gtest/gtest.h>

#include "raster/test_scene.h"

namespace pineda::raster {
namespace {

using namespace testing;

TEST(Statistics, CountsReasonsAndDrawsAddUp) {
  ThreadPool pool(2);
  Target target(64, 64);
  Options options = test_options();
  options.tile_px = 16;
  options.per_draw = options.heat_map = options.timing = true;
  Pass pass(pool, target.desc(), options);
  // A triangle over the upper left half; one that faces away; one without a pixel's centre; one outside.
  TestDraw draw(4, count_kernel);
  const float corners[4][6] = {
      {0, 0, 64, 0, 0, 64}, {8, 8, 8, 24, 24, 8}, {8.1f, 8.1f, 8.9f, 8.1f, 8.1f, 8.7f}, {100, 100, 120, 100, 100, 120}};
  for (const auto& c : corners) {
    for (int k = 0; k < 3; ++k) add_window_vertex(draw, 64, 64, c[2 * k], c[2 * k + 1]);
  }
  draw.packet_base.front_face = VK_FRONT_FACE_CLOCKWISE;
  draw.packet_base.cull = VK_CULL_MODE_BACK_BIT;
  pass.draw(draw.packet(64, 64));
  TestDraw second(4, count_kernel);
  for (int k = 0; k < 3; ++k) add_window_vertex(second, 64, 64, corners[0][2 * k], corners[0][2 * k + 1]);
  pass.draw(second.packet(64, 64));
  const PassStatistics s = pass.end();
  EXPECT_EQ(s.draws, 2u);
  EXPECT_EQ(s.vertices_shaded, 15u);
  EXPECT_EQ(s.triangles_in, 5u);
  EXPECT_EQ(s.triangles_culled, 3u);
  EXPECT_EQ(s.culled_facing, 1u);
  EXPECT_EQ(s.culled_no_sample, 1u);
  EXPECT_EQ(s.triangles_binned, 2u);
  EXPECT_EQ(s.bin_entries, 20u) << "10 of 16 tiles each";
  EXPECT_EQ(s.fragments_shaded, 2 * 64u * 63 / 2) << "the hypotenuse's centres are on a right edge";
  EXPECT_EQ(s.bytes_loaded, 10 * 256 * 4u);
  EXPECT_EQ(s.bytes_stored, 10 * 256 * 4u);
  EXPECT_GT(s.geometry_ns, 0u);
  EXPECT_GT(s.tiles_ns, 0u);
  const std::vector<DrawStatistics> draws = pass.draw_statistics();
  ASSERT_EQ(draws.size(), 2u);
  EXPECT_EQ(draws[0].primitives_in, 4u);
  EXPECT_EQ(draws[0].triangles_culled, 3u);
  EXPECT_EQ(draws[1].triangles_binned, 1u);
  EXPECT_EQ(draws[0].blocks_shaded + draws[1].blocks_shaded, s.blocks_shaded);
  const Pass::HeatMap map = pass.heat_map();
  ASSERT_EQ(map.entries.size(), 16u);
  EXPECT_EQ(map.entries[0], 2u);
  EXPECT_EQ(map.entries[15], 0u);
  const std::vector<ThreadTimes> threads = pass.thread_times();
  ASSERT_EQ(threads.size(), 2u);
  EXPECT_EQ(threads[0].geometry_ns + threads[1].geometry_ns, s.geometry_ns);
  EXPECT_EQ(threads[0].tiles_ns + threads[1].tiles_ns, s.tiles_ns);
  EXPECT_EQ(s.blocks_accepted, 2 * 120u) << "4x4 blocks under the diagonal: 15 + 14 + ...";
  const std::string json = statistics_json(s, draws, threads);
  EXPECT_NE(json.find("\"per_thread\":[{\"geometry_ns\":"), std::string::npos);
  EXPECT_EQ(json.find("{\"draws\":2,"), 0u);
  EXPECT_NE(json.find("\"per_draw\":[{\"vertices_shaded\":12,\"primitives_in\":4,"), std::string::npos);
  EXPECT_NE(statistics_text(s, threads).find("culled_facing 1, culled_no_sample 1"), std::string::npos);
  EXPECT_EQ(heat_map_pgm(map.columns, map.rows, map.entries).substr(0, 12), std::string("P5 4 4 255\n\xFF"));
}

}  // namespace
}  // namespace pineda::raster
