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

// Rewrites the sections `bench`, `accuracy` and `extreme` of the file from bench.json, accuracy.json and extreme.json in the
// folder, as many of them as there are, and copies the plots to docs/images beside the file.
void update_readme(const std::string& path, const std::string& reports);

}  // namespace pineda::tools
