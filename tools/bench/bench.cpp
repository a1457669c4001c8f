#include "tools/bench/bench.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>

#include "tools/bench/bench_scenes.h"
#include "tools/bench/rows.h"
#include "tools/driver_process.h"
#include "tools/error.h"
#include "tools/machine_info.h"
#include "tools/statistics.h"
#include "tools/terminal.h"

namespace pineda::tools {
namespace {

// A submission without work takes Pineda 70 ns and a driver with a queue thread a thousand times as long: one such ratio would
// raise the mean of twenty rows by a third and say nothing of them.
constexpr std::string_view kNotInMean = "empty-submit";

using nlohmann::json;

constexpr std::chrono::seconds kTimeout{120};
constexpr size_t kMaxSamplesPerRound = 2000;
constexpr double kWarmUpMs = 60;
constexpr int kStartupsPerRound = 4;

struct Samples {
  std::vector<double> all_ms;
  std::vector<double> round_medians_ms;
  std::optional<MeanColour> mean_colour;  // of what the driver drew
  std::string error;                      // why the driver did not finish the row

  void add_round(const std::vector<double>& samples_ms) {
    all_ms.insert(all_ms.end(), samples_ms.begin(), samples_ms.end());
    round_medians_ms.push_back(median(samples_ms));
  }
  bool valid() const { return error.empty() && !all_ms.empty(); }
};

// A driver under test: its process lives through all rows and is started anew only when it died.
class BenchDriver {
 public:
  explicit BenchDriver(const DriverSpec& driver) : spec_(driver) {}
  ~BenchDriver() {
    std::error_code ignored;
    std::filesystem::remove_all(cache_directory(), ignored);
  }

  const std::string& label() const { return spec_.label; }
  const std::string& device() const { return device_; }

  double start_up_ms() const {
    DriverProcess fresh(with_caches(false));
    return fresh.request({{"command", "open"}}, kTimeout).at("startup_ms");
  }
  std::optional<MeanColour> begin(const BenchRowInfo& row) {
    if (process_ && disk_cache_ != row.disk_cache) process_.reset();
    disk_cache_ = row.disk_cache;
    if (!process_) start();
    const json begun = process_->request(
        {{"command", "row_begin"}, {"row", row.name}, {"width", row.extent.width}, {"height", row.extent.height}}, kTimeout);
    run(kWarmUpMs);
    const json& mean_colour = begun.at("mean_colour");
    return mean_colour.is_null() ? std::nullopt : std::optional(mean_colour.get<MeanColour>());
  }
  std::vector<double> run(double budget_ms) {
    return process_->request({{"command", "row_run"}, {"budget_ms", budget_ms}, {"max_samples", kMaxSamplesPerRound}}, kTimeout)
        .at("samples_ms");
  }
  void end() {
    if (process_) process_->request({{"command", "row_end"}}, kTimeout);
  }
  void abandon() { process_.reset(); }

 private:
  std::string cache_directory() const {
    const auto name = fmt::format("pineda-bench-{}-{}", getpid(), spec_.file_stem());
    return (std::filesystem::temp_directory_path() / name).string();
  }

  // Cold rows must be cold: no driver may find its shaders on disk, but in rows that ask for it.
  DriverSpec with_caches(bool disk_cache) const {
    DriverSpec spec = spec_;
    const auto set = [&](const char* name, const std::string& value) {
      spec.environment.emplace(spec.environment.begin(), name, value);
    };
    set("MESA_SHADER_CACHE_DISABLE", disk_cache ? "false" : "true");
    set("MESA_GLSL_CACHE_DISABLE", disk_cache ? "false" : "true");
    set("MESA_SHADER_CACHE_DIR", cache_directory());
    set("PINEDA_CACHE", disk_cache ? cache_directory() : "off");
    return spec;
  }

  void start() {
    process_ = std::make_unique<DriverProcess>(with_caches(disk_cache_));
    device_ = process_->request({{"command", "open"}}, kTimeout).at("device");
  }

  const DriverSpec spec_;
  bool disk_cache_ = false;
  std::string device_;
  std::unique_ptr<DriverProcess> process_;
};

bool is_selected(const BenchRowInfo& row, const std::string& filter) {
  if (filter.empty()) return !row.name.starts_with(kGrowthPrefix);
  for (size_t begin = 0; begin <= filter.size();) {
    const size_t end = std::min(filter.find(',', begin), filter.size());
    if (end > begin && row.name.find(filter.substr(begin, end - begin)) != std::string::npos) return true;
    begin = end + 1;
  }
  return false;
}

std::string time_text(double ms) {  // four digits, in a unit that suits
  if (ms < 1e-3) return fmt::format("{:.4g} ns", ms * 1e6);
  if (ms < 1) return fmt::format("{:.4g} us", ms * 1e3);
  return fmt::format("{:.4g} ms", ms);
}

class Bench {
 public:
  explicit Bench(const BenchOptions& options) : options_(options) {
    for (const DriverSpec& driver : options.drivers) drivers_.push_back(std::make_unique<BenchDriver>(driver));
  }

  int run() {
    std::vector<const BenchRowInfo*> rows;
    for (const BenchRowInfo& row : bench_rows()) {
      if (is_selected(row, options_.filter)) rows.push_back(&row);
    }
    if (rows.empty()) fail("no row matches '{}' (see `pineda bench --list`)", options_.filter);
    print_heading();
    for (size_t i = 0; i < rows.size(); ++i) {
      prefix_ = fmt::format("[{}/{}] {}", i + 1, rows.size(), rows[i]->name);
      const std::vector<Samples> samples = measure(*rows[i]);
      print_row(*rows[i], samples);
      record(*rows[i], samples);
    }
    print_mean();
    if (!options_.json_path.empty()) write_json();
    return failed_ ? 1 : 0;
  }

 private:
  std::vector<Samples> measure(const BenchRowInfo& row) {
    std::vector<Samples> samples(drivers_.size());
    const auto each = [&](const char* what, auto&& action) {
      for (size_t i = 0; i < drivers_.size(); ++i) {
        if (!samples[i].error.empty()) continue;
        terminal_.status(fmt::format("{}: {}: {}", prefix_, drivers_[i]->label(), what));
        try {
          action(*drivers_[i], samples[i]);
        } catch (const ToolError& error) {
          samples[i].error = error.what();
          drivers_[i]->abandon();
        }
      }
    };
    if (!row.create) {
      each("warming up", [](BenchDriver& driver, Samples&) { driver.start_up_ms(); });
      for (uint32_t round = 0; round < options_.rounds; ++round) each("starting", add_startups);
      return samples;
    }
    each("preparing", [&](BenchDriver& driver, Samples& own) { own.mean_colour = driver.begin(row); });
    require_equal_pictures(samples);
    for (uint32_t round = 0; round < options_.rounds; ++round) {
      each("running", [&](BenchDriver& driver, Samples& own) { own.add_round(driver.run(options_.budget_ms)); });
    }
    each("ending", [](BenchDriver& driver, Samples&) { driver.end(); });
    return samples;
  }

  // A driver that drew something else has not done the row's work. (How close pictures are is the business of `compare`.)
  void require_equal_pictures(std::vector<Samples>& samples) const {
    constexpr double kTolerance = 1;  // of the mean, in units of 1/255: rounding cannot move it further
    const Samples& reference = samples.back();
    for (size_t i = 0; i + 1 < samples.size(); ++i) {
      if (!samples[i].mean_colour || !reference.mean_colour) continue;
      for (size_t channel = 0; channel < 4; ++channel) {
        const double own = (*samples[i].mean_colour)[channel], wanted = (*reference.mean_colour)[channel];
        if (std::abs(own - wanted) <= kTolerance) continue;
        samples[i].error = fmt::format("{}: drew another picture than {} (channel {}: mean {:.2f} instead of {:.2f})",
                                       drivers_[i]->label(), drivers_.back()->label(), channel, own, wanted);
        drivers_[i]->abandon();
        break;
      }
    }
  }

  static void add_startups(const BenchDriver& driver, Samples& samples) {
    std::vector<double> round_ms;
    for (int i = 0; i < kStartupsPerRound; ++i) round_ms.push_back(driver.start_up_ms());
    samples.add_round(round_ms);
  }

  // How many times longer the reference takes: of the medians, and the range over the rounds.
  struct Ratio {
    double value = std::nan(""), low = 0, high = 0;
  };
  static Ratio ratio_of(const Samples& own, const Samples& reference) {
    if (!own.valid() || !reference.valid()) return {};
    Ratio ratio{.value = median(reference.all_ms) / median(own.all_ms), .low = INFINITY, .high = 0};
    for (size_t i = 0; i < std::min(own.round_medians_ms.size(), reference.round_medians_ms.size()); ++i) {
      const double of_round = reference.round_medians_ms[i] / own.round_medians_ms[i];
      ratio.low = std::min(ratio.low, of_round);
      ratio.high = std::max(ratio.high, of_round);
    }
    return ratio;
  }

  void print_heading() const {
    std::string line = fmt::format("{:<18}", "row");
    for (const auto& driver : drivers_) line += fmt::format("{:>38}", driver->label() + " (quartiles)");
    for (size_t i = 0; i + 1 < drivers_.size(); ++i) line += fmt::format("{:>30}", drivers_[i]->label() + " x faster (rounds)");
    fmt::print("{}\n", line);
    std::fflush(stdout);
  }

  void print_row(const BenchRowInfo& row, const std::vector<Samples>& samples) {
    terminal_.status("");
    std::string line = fmt::format("{:<18}", row.name);
    for (const Samples& own : samples) {
      const std::string text = own.valid()
                                   ? fmt::format("{} ({} - {})", time_text(median(own.all_ms)),
                                                 time_text(quantile(own.all_ms, 0.25)), time_text(quantile(own.all_ms, 0.75)))
                                   : std::string("failed");
      line += fmt::format("{:>38}", text);
    }
    for (size_t i = 0; i + 1 < samples.size(); ++i) {
      const Ratio ratio = ratio_of(samples[i], samples.back());
      line += fmt::format("{:>30}", std::isnan(ratio.value)
                                        ? std::string("-")
                                        : fmt::format("{:.2f} ({:.2f}-{:.2f})", ratio.value, ratio.low, ratio.high));
    }
    fmt::print("{}\n", line);
    std::fflush(stdout);
    for (const Samples& own : samples) {
      if (!own.error.empty()) terminal_.line("    " + own.error);
    }
  }

  void record(const BenchRowInfo& row, const std::vector<Samples>& samples) {
    json results = json::object(), ratios = json::object();
    for (size_t i = 0; i < samples.size(); ++i) {
      const Samples& own = samples[i];
      failed_ |= !own.valid();
      if (!own.valid()) {
        results[drivers_[i]->label()] = {{"error", own.error}};
        continue;
      }
      results[drivers_[i]->label()] = {{"median_ms", median(own.all_ms)},         {"q1_ms", quantile(own.all_ms, 0.25)},
                                       {"q3_ms", quantile(own.all_ms, 0.75)},     {"min_ms", quantile(own.all_ms, 0)},
                                       {"max_ms", quantile(own.all_ms, 1)},       {"samples", own.all_ms.size()},
                                       {"round_medians_ms", own.round_medians_ms}};
      if (i + 1 == samples.size()) continue;
      const Ratio ratio = ratio_of(own, samples.back());
      if (std::isnan(ratio.value)) continue;
      ratios[drivers_[i]->label()] = {{"ratio", ratio.value}, {"low", ratio.low}, {"high", ratio.high}};
      if (row.in_mean && row.name != kNotInMean) log_ratios_[drivers_[i]->label()].push_back(std::log(ratio.value));
    }
    rows_.push_back({{"row", row.name},
                     {"description", row.description},
                     {"width", row.extent.width},
                     {"height", row.extent.height},
                     {"results", results},
                     {"ratios", ratios}});
  }

  void print_mean() {
    for (const auto& [label, logs] : log_ratios_) {
      double sum = 0;
      for (const double log : logs) sum += log;
      fmt::print("\n{} is {:.2f} times faster than {} in the geometric mean of {} rows (all but {} and host-*)\n", label,
                 std::exp(sum / static_cast<double>(logs.size())), drivers_.back()->label(), logs.size(), kNotInMean);
    }
  }

  void write_json() const {
    json machine, drivers = json::array();
    for (const auto& [name, value] : machine_info()) machine[name] = value;
    for (const auto& driver : drivers_) drivers.push_back({{"driver", driver->label()}, {"device", driver->device()}});
    const json result{{"machine", machine},
                      {"drivers", drivers},
                      {"rounds", options_.rounds},
                      {"budget_ms", options_.budget_ms},
                      {"rows", rows_}};
    std::ofstream file(options_.json_path);
    file << result.dump(2) << "\n";
    file.close();
    if (!file) fail("{}: cannot be written", options_.json_path);
  }

  BenchOptions options_;
  Terminal terminal_;
  std::string prefix_;
  std::vector<std::unique_ptr<BenchDriver>> drivers_;
  std::map<std::string, std::vector<double>> log_ratios_;
  json rows_ = json::array();
  bool failed_ = false;
};

}  // namespace

int bench(const BenchOptions& options) { return Bench(options).run(); }

void list_bench_rows() {
  for (const BenchRowInfo& row : bench_rows()) {
    const std::string size = row.extent.width ? fmt::format("{}x{}", row.extent.width, row.extent.height) : "";
    fmt::print("{:<18}{:<48}{}\n", row.name, row.description, size);
  }
}

}  // namespace pineda::tools
