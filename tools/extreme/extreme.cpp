#include "tools/extreme/extreme.h"

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "tools/driver_process.h"
#include "tools/error.h"
#include "tools/extreme/rig.h"
#include "tools/html.h"
#include "tools/machine_info.h"
#include "tools/report_style.h"
#include "tools/terminal.h"

namespace pineda::tools {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// FNV-1a, 64 bits: tells the bits of two ISA paths apart.
uint64_t hash_of_bytes(const std::string& bytes) {
  uint64_t hash = 0xCBF29CE484222325;
  for (const char byte : bytes) hash = (hash ^ static_cast<uint8_t>(byte)) * 0x100000001B3;
  return hash;
}

struct Result {  // of one case on one driver
  std::string verdict, measured, truth, bound, hash;
  std::vector<std::pair<std::string, std::string>> pictures;  // caption, file name
};

class Runner {  // one driver, restarted after a crash
 public:
  Runner(DriverSpec driver, std::chrono::seconds timeout) : driver_(std::move(driver)), timeout_(timeout) {}

  Result run(size_t index, const std::string& pictures) {
    try {
      if (!process_) {
        process_ = std::make_unique<DriverProcess>(driver_);
        process_->request({{"command", "open"}}, timeout_);
      }
      const json reply = process_->request({{"command", "extreme_run"}, {"case", index}, {"pictures", pictures}}, timeout_);
      Result result{reply.at("verdict"), reply.at("measured"), reply.at("truth"), reply.at("bound"), reply.at("hash"), {}};
      for (const json& picture : reply.at("pictures")) result.pictures.emplace_back(picture.at("caption"), picture.at("file"));
      return result;
    } catch (const ToolError& error) {
      process_.reset();
      return {verdict_name(Verdict::kWrong), error.what(), {}, {}, {}, {}};
    }
  }

  const DriverSpec& driver() const { return driver_; }

 private:
  DriverSpec driver_;
  std::chrono::seconds timeout_;
  std::unique_ptr<DriverProcess> process_;
};

struct Row {
  const ExtremeCase* which;
  std::vector<Result> results;  // of the drivers
  std::string varying;          // variants whose bits differ
};

struct Counts {
  size_t exact = 0, within = 0, wrong = 0, missing = 0;
};

Counts count(const std::vector<Row>& rows, size_t driver) {
  Counts counts;
  for (const Row& row : rows) {
    const std::string& verdict = row.results[driver].verdict;
    counts.exact += verdict == verdict_name(Verdict::kExact);
    counts.within += verdict == verdict_name(Verdict::kWithin);
    counts.wrong += verdict == verdict_name(Verdict::kWrong);
    counts.missing += verdict == verdict_name(Verdict::kNotSupported);
  }
  return counts;
}

std::string summary(const Counts& counts) {
  return fmt::format("{} exact, {} within their bounds, {} wrong, {} not supported", counts.exact, counts.within, counts.wrong,
                     counts.missing);
}

class Page {
 public:
  Page(const ExtremeOptions& options, const std::vector<Row>& rows) : options_(options), rows_(rows) {}

  std::string build() {
    add("<!doctype html>\n<html lang='en'><head><meta charset='utf-8'><meta name='viewport' content='width=device-width, "
        "initial-scale=1'>\n<title>Stiff and extreme cases</title><style>{}{}</style></head><body><main>\n",
        kReportStyle, kStyle);
    const bool good = count(rows_, 0).wrong == 0;
    add("<header><div><h1>Stiff and extreme cases</h1><p>{} cases, {}</p></div><span class='verdict {}'>{}</span></header>\n",
        rows_.size(), date_text(), good ? "good" : "bad",
        good ? "Nothing of Pineda&rsquo;s is wrong" : "Pineda is wrong somewhere");
    add("<section><div class='title'><h2>Summary</h2></div><table><tr><th>Driver</th><th>exact</th><th>within the "
        "bound</th><th>wrong</th><th>not "
        "supported</th></tr>\n");
    for (size_t i = 0; i < options_.drivers.size(); ++i) {
      const Counts counts = count(rows_, i);
      add("<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n", escape_html(options_.drivers[i].label),
          counts.exact, counts.within, counts.wrong, counts.missing);
    }
    size_t varying = 0;
    for (const Row& row : rows_) varying += !row.varying.empty();
    add("</table><p>On {} other ISA paths of Pineda {} cases give other bits.</p></section>\n", options_.variants.size(),
        varying ? std::to_string(varying) : "no");
    for (size_t begin = 0; begin < rows_.size();) {
      size_t end = begin;
      while (end < rows_.size() && std::string_view(rows_[end].which->group) == rows_[begin].which->group) ++end;
      add_group(begin, end);
      begin = end;
    }
    add("</main><dialog><p></p><div><img alt=''></div></dialog><script>{}</script></body></html>\n", kReportScript);
    return std::move(html_);
  }

 private:
  static constexpr const char* kStyle = R"css(
td.wrap { vertical-align: top; min-width: 190px; } td.wrap .soft { font-size: 13px; display: block; }
.verdict.within { color: #8a6100; background: #fff0cf; } .verdict.missing { color: var(--soft); background: var(--line); }
.pictures { grid-template-columns: repeat(auto-fill, minmax(190px, 1fr)); }
.pictures img { image-rendering: pixelated; }
)css";

  template <typename... Args>
  void add(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(html_), format, std::forward<Args>(args)...);
  }

  void add_group(size_t begin, size_t end) {
    add("<section><div class='title'><h2>{}</h2></div><div class='scroll'><table><tr><th>Case</th><th "
        "style='text-align:left'>Truth</th>",
        escape_html(rows_[begin].which->group));
    for (const DriverSpec& driver : options_.drivers) add("<th style='text-align:left'>{}</th>", escape_html(driver.label));
    add("</tr>\n");
    for (size_t i = begin; i < end; ++i) add_row(rows_[i]);
    add("</table></div><div class='pictures'>\n");
    for (size_t i = begin; i < end; ++i) add_pictures(rows_[i]);
    add("</div></section>\n");
  }

  void add_row(const Row& row) {
    std::string truth, bound;
    for (const Result& result : row.results) {
      if (truth.empty()) truth = result.truth, bound = result.bound;
    }
    add("<tr><td class='wrap'><b>{}</b><span class='soft'>{}</span></td><td class='wrap'>{}<span class='soft'>{}{}</span><span "
        "class='soft'>{}</span></td>",
        escape_html(row.which->name), escape_html(row.which->statement), escape_html(truth),
        bound.empty() ? "" : "Bound: ", escape_html(bound), escape_html(row.which->source));
    for (const Result& result : row.results) {
      add("<td class='wrap'><span class='verdict {}'>{}</span> {}</td>", style_of(result.verdict), escape_html(result.verdict),
          escape_html(result.measured));
    }
    add("</tr>\n");
    if (!row.varying.empty())
      add("<tr><td colspan='4' class='wrap'><div class='problem'>{}</div></td></tr>\n", escape_html(row.varying));
  }

  static const char* style_of(const std::string& verdict) {
    if (verdict == verdict_name(Verdict::kExact)) return "good";
    if (verdict == verdict_name(Verdict::kWithin)) return "within";
    return verdict == verdict_name(Verdict::kWrong) ? "bad" : "missing";
  }

  void add_pictures(const Row& row) {
    for (size_t i = 0; i < row.results.size(); ++i) {
      for (const auto& [caption, file] : row.results[i].pictures) {
        const std::string text = fmt::format("{}, {}: {}", options_.drivers[i].label, row.which->name, caption);
        add("<figure><img src='{}' alt='{}' loading='lazy'><figcaption>{}</figcaption></figure>\n", escape_html(file),
            escape_html(text), escape_html(text));
      }
    }
  }

  const ExtremeOptions& options_;
  const std::vector<Row>& rows_;
  std::string html_;
};

json as_json(const ExtremeOptions& options, const std::vector<Row>& rows) {
  json cases = json::array();
  for (const Row& row : rows) {
    json drivers = json::object();
    for (size_t i = 0; i < row.results.size(); ++i) {
      const Result& result = row.results[i];
      drivers[options.drivers[i].label] = {{"verdict", result.verdict},
                                           {"measured", result.measured},
                                           {"truth", result.truth},
                                           {"bound", result.bound},
                                           {"hash", result.hash}};
    }
    cases.push_back({{"group", row.which->group},
                     {"name", row.which->name},
                     {"statement", row.which->statement},
                     {"source", row.which->source},
                     {"drivers", drivers},
                     {"varying", row.varying}});
  }
  json machine;
  for (const auto& [name, value] : machine_info()) machine[name] = value;
  return {{"machine", machine}, {"cases", cases}};
}

std::string pictures_prefix(const ExtremeOptions& options, const DriverSpec& driver, size_t index) {
  if (options.out_dir.empty()) return {};
  return (fs::path(options.out_dir) / fmt::format("extreme-{}-{}", index, driver.file_stem())).string();
}

}  // namespace

const char* verdict_name(Verdict verdict) {
  constexpr const char* kNames[] = {"exact", "within the bound", "wrong", "not supported"};
  return kNames[static_cast<size_t>(verdict)];
}

std::vector<ExtremeCase> extreme_cases() {
  std::vector<ExtremeCase> cases;
  for (const auto group :
       {geometry_cases(), depth_cases(), interpolation_cases(), blending_cases(), stiff_cases(), integer_cases()}) {
    cases.insert(cases.end(), group.begin(), group.end());
  }
  return cases;
}

json run_extreme_case(VkContext& context, const json& command) {
  const ExtremeCase which = extreme_cases().at(command.at("case").get<size_t>());
  const std::string prefix = command.at("pictures");
  ExtremeRig rig(context);
  const Outcome outcome = which.run(rig);
  json pictures = json::array();
  for (size_t i = 0; i < outcome.pictures.size() && !prefix.empty(); ++i) {
    const std::string path = fmt::format("{}{}.png", prefix, i ? fmt::format("-{}", i) : "");
    save_png(path, outcome.pictures[i].second);
    pictures.push_back({{"caption", outcome.pictures[i].first}, {"file", fs::path(path).filename().string()}});
  }
  return {{"verdict", verdict_name(outcome.verdict)},
          {"measured", outcome.measured},
          {"truth", outcome.truth},
          {"bound", outcome.bound},
          {"hash", fmt::format("{:016x}", hash_of_bytes(outcome.bytes))},
          {"pictures", pictures}};
}

int report_extreme(const ExtremeOptions& options) {
  if (!options.out_dir.empty()) fs::create_directories(options.out_dir);
  Terminal terminal;
  std::vector<Runner> columns, variants;
  for (const DriverSpec& driver : options.drivers) columns.emplace_back(driver, options.timeout);
  for (const DriverSpec& driver : options.variants) variants.emplace_back(driver, options.timeout);
  const std::vector<ExtremeCase> cases = extreme_cases();
  std::vector<Row> rows;
  bool varying = false;
  for (size_t index = 0; index < cases.size(); ++index) {
    const ExtremeCase& which = cases[index];
    const std::string name = fmt::format("{}: {}", which.group, which.name);
    if (name.find(options.filter) == std::string::npos) continue;
    terminal.status(name);
    Row row{.which = &which, .results = {}, .varying = {}};
    for (Runner& column : columns) row.results.push_back(column.run(index, pictures_prefix(options, column.driver(), index)));
    for (Runner& variant : variants) {
      const Result result = variant.run(index, "");
      if (result.hash == row.results[0].hash) continue;
      row.varying +=
          fmt::format("{}other bits on {}: {}", row.varying.empty() ? "" : "; ", variant.driver().label, result.measured);
    }
    varying |= !row.varying.empty();
    terminal.line(fmt::format("{:<52} {}", name, row.results[0].truth));
    for (size_t i = 0; i < row.results.size(); ++i) {
      terminal.line(fmt::format("    {:<12}{:<17}{}", options.drivers[i].name, row.results[i].verdict, row.results[i].measured));
    }
    if (!row.varying.empty()) terminal.line("    " + row.varying);
    rows.push_back(std::move(row));
  }
  if (rows.empty()) fail("no extreme case has '{}' in its name", options.filter);
  for (size_t i = 0; i < columns.size(); ++i)
    terminal.line(fmt::format("{}: {}", options.drivers[i].label, summary(count(rows, i))));
  if (!options.out_dir.empty()) {
    write_file((fs::path(options.out_dir) / "extreme.html").string(), Page(options, rows).build());
    write_file((fs::path(options.out_dir) / "extreme.json").string(),
               as_json(options, rows).dump(2, ' ', false, json::error_handler_t::replace) + "\n");
    terminal.line(fmt::format("report: {}/extreme.html", options.out_dir));
  }
  return count(rows, 0).wrong || varying ? 1 : 0;
}

}  // namespace pineda::tools
