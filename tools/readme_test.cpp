#include "tools/readme.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tools/error.h"
#include "tools/html.h"

namespace pineda::tools {
namespace {

using nlohmann::json;

TEST(Readme, ReplacesWhatStandsBetweenTheMarks) {
  const std::string text = "a\n<!-- bench -->\nold\n<!-- /bench -->\nb\n";
  EXPECT_EQ(replace_section(text, "bench", "new\n"), "a\n<!-- bench -->\nnew\n<!-- /bench -->\nb\n");
  EXPECT_EQ(replace_section(replace_section(text, "bench", "x\n"), "bench", "old\n"), text);
  EXPECT_THROW(replace_section(text, "extreme", ""), ToolError);
  EXPECT_THROW(replace_section("<!-- /bench -->\n<!-- bench -->\n", "bench", ""), ToolError);
}

TEST(Readme, CountsVerdicts) {
  const auto result = [](const char* verdict) { return json{{"verdict", verdict}}; };
  const json report{{"cases",
                     {{{"name", "w of 0"}, {"drivers", {{"pineda", result("exact")}, {"lavapipe", result("wrong")}}}},
                      {{"name", "sum"}, {"drivers", {{"pineda", result("within the bound")}, {"lavapipe", result("exact")}}}}}}};
  const std::string text = extreme_section(report);
  EXPECT_NE(text.find("| pineda | 1 | 1 | 0 | 0 |\n| lavapipe | 1 | 0 | 1 | 0 |"), std::string::npos) << text;
  EXPECT_NE(text.find("Wrong in lavapipe: w of 0."), std::string::npos);
}

TEST(Readme, WritesBenchRows) {
  const json row{{"row", "cubes"},
                 {"description", "Cubes"},
                 {"results", {{"pineda", {{"median_ms", 2.0}}}, {"lavapipe", {{"median_ms", 13.0}}}}},
                 {"ratios", {{"pineda", {{"ratio", 6.5}}}}}};
  const json report{{"machine", json::object()}, {"rounds", 3}, {"rows", {row}}};
  EXPECT_NE(bench_section(report).find("| Cubes | 2.00 ms | 13.0 ms | 6.5 |"), std::string::npos);
  EXPECT_NE(bench_section(report).find(
                "Geometric mean of 1 rows, without the empty submit and memcpy: 6.5 times. Slower than lavapipe: none."),
            std::string::npos);
}

json scene_of(const char* name, double within, double pineda_rmse, double lavapipe_rmse) {
  return {{"scene", name},
          {"differences", {{{"within_one_share", within}}}},
          {"truth_errors", {{{"rmse", pineda_rmse}}, {{"rmse", lavapipe_rmse}}}}};
}

TEST(Readme, TellsSceneBySceneWhoIsNearerToTheTruth) {
  const json report{
      {"width", 64},
      {"height", 48},
      {"scenes", {scene_of("cubes", 1, 0.1, 0.2), scene_of("blits", 0.79, 0.3, 0.302), scene_of("gathers", 0.999, 0.21, 0.17)}}};
  EXPECT_EQ(
      scenes_section(report),
      "`./run compare --truth` on the 3 scenes at 64x48: in 2 at least 99.9 % of the pixels are within 1/255 of lavapipe's; in "
      "the others, blits (79.0 %), [docs/differences.md](docs/differences.md) says why not.\n"
      "Pineda's root mean square error against the f64 truth is the smaller one in 1 of the 3; equal to 1 %: blits; larger: "
      "gathers (0.21/255 beside 0.17/255).\n");
  json without = report;
  without["scenes"][0]["truth_errors"] = json::array();
  EXPECT_THROW(scenes_section(without), ToolError);
}

const char* const kPineda = "<testsuite name=\"a\" tests=\"9\" failures=\"0\" skipped=\"2\">";
const char* const kLavapipe = "<testsuite name=\"a\" tests=\"9\" failures=\"1\" skipped=\"3\">";

TEST(Readme, CountsConformanceCases) {
  const std::string text = cts_section(kPineda, kLavapipe);
  EXPECT_NE(text.find("| Pineda | 7 | 0 | 2 |\n| lavapipe | 5 | 1 | 3 |\n"), std::string::npos) << text;
  EXPECT_THROW(cts_section(kPineda, "<testsuite tests=\"8\" failures=\"1\" skipped=\"3\">"), ToolError);
}

// A second time nothing changes, and what has no report stays.
TEST(Readme, UpdatesTheSectionsThatHaveReports) {
  const std::filesystem::path folder = testing::TempDir() + std::to_string(getpid()) + "readme";
  std::filesystem::create_directories(folder);
  const std::string path = (folder / "README.md").string();
  write_file(path, "<!-- bench -->\nold\n<!-- /bench -->\n<!-- cts -->\n<!-- /cts -->\nend\n");
  write_file((folder / "pineda.xml").string(), kPineda);
  write_file((folder / "lavapipe.xml").string(), kLavapipe);
  const auto text = [&] {
    std::ostringstream out;
    out << std::ifstream(path).rdbuf();
    return out.str();
  };
  update_readme(path, folder.string());
  const std::string once = text();
  EXPECT_EQ(once,
            "<!-- bench -->\nold\n<!-- /bench -->\n<!-- cts -->\n" + cts_section(kPineda, kLavapipe) + "<!-- /cts -->\nend\n");
  update_readme(path, folder.string());
  EXPECT_EQ(text(), once);
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace pineda::tools
