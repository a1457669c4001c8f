#include "tools/readme.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tools/error.h"
#include "tools/html.h"

namespace pineda::tools {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* kPlots[] = {"edges.sampling", "marble.arithmetic"};

std::string read_file(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) fail("{}: cannot be read", path.string());
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

std::string time_text(double ms) {
  if (ms < 0.1) return fmt::format("{:.3g} µs", 1000 * ms);
  return ms < 10 ? fmt::format("{:.2f} ms", ms) : fmt::format("{:.1f} ms", ms);
}

std::string machine_text(const json& report) {  // the rows of machine_info.cpp that explain times
  const json& machine = report.at("machine");
  return fmt::format("{}, {} cores, {}", machine.value("Processor", "?"), machine.value("Cores", "?"),
                     machine.value("Instruction sets", "?"));
}

}  // namespace

std::string replace_section(const std::string& text, const std::string& name, const std::string& content) {
  const std::string begin = fmt::format("<!-- {} -->\n", name), end = fmt::format("<!-- /{} -->", name);
  const size_t from = text.find(begin), to = text.find(end);
  if (from == std::string::npos || to == std::string::npos || to < from) fail("no section between {} and {}", begin, end);
  return text.substr(0, from + begin.size()) + content + text.substr(to);
}

std::string bench_section(const json& report) {
  std::string table =
      fmt::format("`./run bench` on {}; medians of {} turns.\n\n| work | Pineda | lavapipe | times faster |\n|---|---|---|---|\n",
                  machine_text(report), report.at("rounds").get<int>());
  double logs = 0;
  int count = 0;
  std::string slower;
  for (const json& row : report.at("rows")) {
    const json& ratios = row.at("ratios");
    if (ratios.empty()) continue;
    const std::string own = ratios.begin().key();
    const double ratio = ratios.begin().value().at("ratio");
    double times[2] = {};
    for (const auto& [label, result] : row.at("results").items()) times[label == own ? 0 : 1] = result.at("median_ms");
    table += fmt::format("| {} | {} | {} | {:.{}f} |\n", row.at("description").get<std::string>(), time_text(times[0]),
                         time_text(times[1]), ratio, ratio < 1 ? 2 : 1);
    const std::string name = row.at("row");
    if (name == "empty-submit" || name.starts_with("host-")) continue;  // as in bench.cpp: one has no work, the others no driver
    if (ratio < 1) slower += (slower.empty() ? "" : ", ") + row.at("description").get<std::string>();
    logs += std::log(ratio);
    ++count;
  }
  if (count)
    table +=
        fmt::format("\nGeometric mean of {} rows, without the empty submit and memcpy: {:.1f} times. Slower than lavapipe: {}.\n",
                    count, std::exp(logs / count), slower.empty() ? "none" : slower);
  return table;
}

std::string accuracy_section(const json& report, const std::string& images) {
  std::string text = fmt::format("`./run report`, {} scenes at {}x{}. ", report.at("scenes").size(),
                                 report.at("width").get<int>(), report.at("height").get<int>());
  for (const json& lesson : report.at("lessons")) text += lesson.get<std::string>() + " ";
  text.back() = '\n';
  text += "\n|";
  for (const char* plot : kPlots) text += fmt::format(" ![]({}/{}.svg) |", images, plot);
  text += "\n|";
  for ([[maybe_unused]] const char* plot : kPlots) text += "---|";
  return text + "\n";
}

std::string extreme_section(const json& report) {
  std::map<std::string, std::map<std::string, int>> counts;  // by driver and verdict
  std::map<std::string, std::string> wrong;
  for (const json& which : report.at("cases")) {
    for (const auto& [driver, result] : which.at("drivers").items()) {
      const std::string verdict = result.at("verdict");
      ++counts[driver][verdict];
      if (verdict == "wrong") wrong[driver] += (wrong[driver].empty() ? "" : ", ") + which.at("name").get<std::string>();
    }
  }
  std::string text = fmt::format(
      "`./run report --extreme`: {} stiff and extreme cases, each with what the specification, exact arithmetic or a published "
      "value "
      "demands.\n\n| driver | exact | within its bound | wrong |\n|---|---|---|---|\n",
      report.at("cases").size());
  for (auto driver = counts.rbegin(); driver != counts.rend(); ++driver) {
    auto& [name, verdicts] = *driver;
    text += fmt::format("| {} | {} | {} | {} |\n", name, verdicts["exact"], verdicts["within the bound"], verdicts["wrong"]);
  }
  for (const auto& [driver, names] : wrong) text += fmt::format("\nWrong in {}: {}.\n", driver, names);
  return text;
}

void update_readme(const std::string& path, const std::string& reports) {
  const fs::path folder = reports, images = fs::absolute(path).parent_path() / "docs/images";
  std::string text = read_file(path);
  const auto report_of = [&](const char* name) { return json::parse(read_file(folder / name)); };
  if (fs::exists(folder / "bench.json")) text = replace_section(text, "bench", bench_section(report_of("bench.json")));
  if (fs::exists(folder / "extreme.json")) text = replace_section(text, "extreme", extreme_section(report_of("extreme.json")));
  if (fs::exists(folder / "accuracy.json")) {
    text = replace_section(text, "accuracy", accuracy_section(report_of("accuracy.json"), "docs/images"));
    fs::create_directories(images);
    for (const char* plot : kPlots) {
      const std::string name = fmt::format("{}.svg", plot);
      fs::copy_file(folder / name, images / name, fs::copy_options::overwrite_existing);
    }
  }
  write_file(path, text);
}

}  // namespace pineda::tools
