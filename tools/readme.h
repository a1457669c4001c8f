// Sections of a Markdown file that come from reports: what stands between <!-- NAME --> and <!-- /NAME -->.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace pineda::tools {

// The text with the section's content replaced; throws ToolError when the two marks are not there in this order.
std::string replace_section(const std::string& text, const std::string& name, const std::string& content);

std::string bench_section(const nlohmann::json& report);                                // of `pineda bench --json`
std::string accuracy_section(const nlohmann::json& report, const std::string& images);  // of accuracy.json
std::string extreme_section(const nlohmann::json& report);                              // of extreme.json
std::string scenes_section(const nlohmann::json& report);                               // of report.json, with a truth
std::string cts_section(const std::string& pineda, const std::string& lavapipe);        // of the two JUnit files of pineda_cts

// Rewrites the sections `bench`, `accuracy`, `extreme`, `scenes` and `cts` of the file from bench.json, accuracy.json,
// extreme.json, report.json, and pineda.xml with lavapipe.xml in the folder, as many of them as there are, and copies the plots
// to docs/images beside the file. Tells which sections it has left as they were.
void update_readme(const std::string& path, const std::string& reports);

}  // namespace pineda::tools
