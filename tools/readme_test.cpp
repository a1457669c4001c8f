#include "tools/readme.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tools/error.h"

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
  EXPECT_NE(text.find("| pineda | 1 | 1 | 0 |\n| lavapipe | 1 | 0 | 1 |"), std::string::npos) << text;
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

}  // namespace
}  // namespace pineda::tools
