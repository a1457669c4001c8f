#include "tools/readme.h"

#include <algorithm>
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

constexpr double kAlikeShare = 0.999;
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

// Whose root mean square error against the truth is the smaller one, scene by scene.
class Nearer {
 public:
  void add(const std::string& scene, double pineda, double lavapipe) {
    constexpr double kEqual = 1.01;
    ++count_;
    if (std::max(pineda, lavapipe) <= kEqual * std::min(pineda, lavapipe)) {
      append(equal_, scene);
    } else if (pineda < lavapipe) {
      ++pineda_;
    } else {
      append(lavapipe_, fmt::format("{} ({:.2g}/255 beside {:.2g}/255)", scene, pineda, lavapipe));
    }
  }

  std::string text() const {
    return fmt::format(
        "Pineda's root mean square error against the f64 truth is the smaller one in {} of the {}; equal to 1 %: {}; larger: "
        "{}.\n",
        pineda_, count_, equal_.empty() ? "none" : equal_, lavapipe_.empty() ? "none" : lavapipe_);
  }

 private:
  static void append(std::string& list, const std::string& what) { list += (list.empty() ? "" : ", ") + what; }

  int count_ = 0, pineda_ = 0;
  std::string equal_, lavapipe_;
};

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
      "demands.\n\n| driver | exact | within its bound | wrong | not supported |\n|---|---|---|---|---|\n",
      report.at("cases").size());
  for (auto driver = counts.rbegin(); driver != counts.rend(); ++driver) {
    auto& [name, verdicts] = *driver;
    text += fmt::format("| {} | {} | {} | {} | {} |\n", name, verdicts["exact"], verdicts["within the bound"], verdicts["wrong"],
                        verdicts["not supported"]);
  }
  for (const auto& [driver, names] : wrong) text += fmt::format("\nWrong in {}: {}.\n", driver, names);
  return text;
}

std::string scenes_section(const json& report) {
  Nearer nearer;
  std::string others;
  size_t alike = 0;
  for (const json& scene : report.at("scenes")) {
    const std::string name = scene.at("scene");
    if (scene.at("differences").empty()) fail("report.json: {} was not drawn by two drivers", name);
    if (scene.at("truth_errors").size() != 2) fail("report.json has no truth (pineda compare --truth)");
    const double share = scene.at("differences")[0].at("within_one_share");
    if (share >= kAlikeShare) {
      ++alike;
    } else {
      others += fmt::format("{}{} ({:.1f} %)", others.empty() ? "" : ", ", name, 100 * share);
    }
    nearer.add(name, scene.at("truth_errors")[0].at("rmse"), scene.at("truth_errors")[1].at("rmse"));
  }
  std::string text = fmt::format(
      "`./run compare --truth` on the {} scenes at {}x{}: in {} at least {:g} % of the pixels are within 1/255 of lavapipe's",
      report.at("scenes").size(), report.at("width").get<int>(), report.at("height").get<int>(), alike, 100 * kAlikeShare);
  if (!others.empty()) text += "; in the others, " + others + ", [docs/differences.md](docs/differences.md) says why not";
  return text + ".\n" + nearer.text();
}

std::string cts_section(const std::string& pineda, const std::string& lavapipe) {
  const auto counts = [](const std::string& junit) {
    const auto number = [&](const std::string& attribute) {
      const std::string key = " " + attribute + "=\"";
      const size_t at = junit.find(key);
      if (at == std::string::npos) fail("a JUnit file without {}", attribute);
      return std::stoi(junit.substr(at + key.size()));
    };
    struct {
      int all, failed, unsupported;
    } result{number("tests"), number("failures"), number("skipped")};
    return result;
  };
  const auto [all, failed, unsupported] = counts(pineda);
  const auto [other_all, other_failed, other_unsupported] = counts(lavapipe);
  if (all != other_all) fail("pineda.xml and lavapipe.xml are of different cases");
  return fmt::format(
      "| `./run cts`, {} cases | pass | fail | not supported |\n|---|---|---|---|\n| Pineda | {} | {} | {} |\n| lavapipe | {} | "
      "{} | {} "
      "|\n",
      all, all - failed - unsupported, failed, unsupported, other_all - other_failed - other_unsupported, other_failed,
      other_unsupported);
}

void update_readme(const std::string& path, const std::string& reports) {
  const fs::path folder = reports, images = fs::absolute(path).parent_path() / "docs/images";
  std::string text = read_file(path);
  const auto report_of = [&](const char* name) { return json::parse(read_file(folder / name)); };
  const auto is_there = [&](const char* name) {
    if (fs::exists(folder / name)) return true;
    fmt::print("{} is not there: its section stays as it was\n", (folder / name).string());
    return false;
  };
  if (is_there("bench.json")) text = replace_section(text, "bench", bench_section(report_of("bench.json")));
  if (is_there("extreme.json")) text = replace_section(text, "extreme", extreme_section(report_of("extreme.json")));
  if (is_there("report.json")) text = replace_section(text, "scenes", scenes_section(report_of("report.json")));
  if (is_there("pineda.xml") && is_there("lavapipe.xml")) {
    text = replace_section(text, "cts", cts_section(read_file(folder / "pineda.xml"), read_file(folder / "lavapipe.xml")));
  }
  if (is_there("accuracy.json")) {
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
