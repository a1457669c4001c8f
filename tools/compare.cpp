#include "tools/compare.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "tools/driver_process.h"
#include "tools/error.h"
#include "tools/report.h"
#include "tools/scene_registry.h"
#include "tools/statistics.h"
#include "tools/terminal.h"

namespace pineda::tools {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr double kFrameBudgetMs = 3000;  // a slow driver draws fewer frames

class Comparer {
 public:
  explicit Comparer(const CompareOptions& options) : options_(options) {}

  Comparison run() {
    for (const std::string& scene : options_.scenes) require_scene(scene);
    std::error_code error;
    fs::create_directories(options_.out_dir, error);
    if (error) fail("{}: cannot be made: {}", options_.out_dir, error.message());
    Comparison comparison{.options = options_, .scenes = {}};
    for (size_t i = 0; i < options_.scenes.size(); ++i) {
      prefix_ = fmt::format("[{}/{}] {}", i + 1, options_.scenes.size(), options_.scenes[i]);
      comparison.scenes.push_back(compare_scene(options_.scenes[i]));
      print(comparison.scenes.back());
    }
    write_report(comparison);
    return comparison;
  }

 private:
  SceneComparison compare_scene(const std::string& name) {
    SceneComparison scene{.name = name, .title = name};
    if (const SceneInfo* info = find_scene(name)) {
      scene.title = info->title;
      scene.description = info->description;
    } else {
      scene.title = fs::path(name).filename().string();
      scene.description = name;
    }
    const std::string stem = unique_stem(name);
    for (const DriverSpec& driver : options_.drivers)
      scene.runs.push_back(draw(name, stem, driver, options_.frames, options_.timeout));
    if (options_.truth) scene.runs.push_back(draw(name, stem, *options_.truth, 1, options_.truth_timeout));
    for (const DriverRun& run : scene.runs) note_problems(run, scene.problems);
    measure_differences(stem, scene);
    return scene;
  }

  // A file name for the scene's pictures: two models of the same name in different folders must not share it.
  std::string unique_stem(const std::string& scene) {
    std::string stem = find_scene(scene) ? scene : fs::path(scene).stem().string();
    for (char& c : stem) {
      if (!std::isalnum(static_cast<unsigned char>(c)) && c != '-') c = '_';
    }
    const int count = ++stem_counts_[stem];
    return count == 1 ? stem : fmt::format("{}-{}", stem, count);
  }

  DriverRun draw(const std::string& scene, const std::string& stem, const DriverSpec& driver, uint32_t frames,
                 std::chrono::milliseconds timeout) {
    DriverRun run{.driver = driver.label};
    run.png = fmt::format("{}.{}.png", stem, driver.file_stem());
    const std::string png_path = (fs::path(options_.out_dir) / run.png).string();
    const Progress progress = [&](const std::string& text) {
      terminal_.status(fmt::format("{}: {}: {}", prefix_, driver.label, text));
    };
    try {
      progress("starting");
      DriverProcess process(driver);
      const json opened = process.request({{"command", "open"}, {"validate", options_.validate}}, timeout);
      run.device = opened.at("device");
      run.api_version = opened.at("api_version");
      const json drawn = process.request({{"command", "render"},
                                          {"scene", scene},
                                          {"width", options_.width},
                                          {"height", options_.height},
                                          {"frames", frames},
                                          {"budget_ms", kFrameBudgetMs},
                                          {"png", png_path}},
                                         timeout, progress);
      run.hash = drawn.at("hash");
      run.prepare_ms = drawn.at("prepare_ms");
      run.first_frame_ms = drawn.at("first_frame_ms");
      std::vector<double> frames_ms = drawn.at("frames_ms");
      run.frame_count = frames_ms.size();
      if (frames_ms.size() > 1) frames_ms.erase(frames_ms.begin());  // the first one warms up
      run.median_ms = median(frames_ms);
      run.notes = drawn.at("notes");
      run.validation = process.request({{"command", "close"}}, timeout).at("validation");
      process.finish();
      run.picture = load_image(png_path);
    } catch (const ToolError& error) {
      run.error = error.what();
    }
    return run;
  }

  static void note_problems(const DriverRun& run, std::vector<std::string>& problems) {
    if (!run.error.empty()) problems.push_back(run.error);
    if (!run.validation.empty()) {
      problems.push_back(
          fmt::format("{}: {} validation messages, the first: {}", run.driver, run.validation.size(), run.validation[0]));
    }
  }

  void measure_differences(const std::string& stem, SceneComparison& scene) {
    const DriverRun& reference = scene.runs[options_.drivers.size() - 1];
    for (size_t i = 0; i + 1 < options_.drivers.size(); ++i) {
      if (const auto difference = difference_of(stem, scene.runs[i], reference)) {
        scene.differences.push_back(*difference);
        check_thresholds(*difference, scene);
      }
    }
    if (!options_.truth) return;
    for (size_t i = 0; i < options_.drivers.size(); ++i) {
      if (const auto error = difference_of(stem, scene.runs[i], scene.runs.back())) scene.truth_errors.push_back(*error);
    }
  }

  std::optional<Difference> difference_of(const std::string& stem, const DriverRun& run, const DriverRun& reference) const {
    if (!run.error.empty() || !reference.error.empty()) return std::nullopt;
    const fs::path run_stem = fs::path(run.png).stem().extension(), reference_stem = fs::path(reference.png).stem().extension();
    Difference difference{
        .driver = run.driver, .reference = reference.driver, .metrics = measure(run.picture, reference.picture)};
    difference.png = fmt::format("{}.difference{}{}.png", stem, run_stem.string(), reference_stem.string());
    save_png((fs::path(options_.out_dir) / difference.png).string(), difference_map(run.picture, reference.picture));
    return difference;
  }

  void check_thresholds(const Difference& difference, SceneComparison& scene) const {
    std::vector<std::string>& problems = scene.problems;
    const ImageMetrics& metrics = difference.metrics;
    const SceneInfo* known = find_scene(scene.name);
    const double wanted_share = known ? std::min(options_.threshold_share, known->explained_share) : options_.threshold_share;
    if (metrics.within_one_share < wanted_share) {
      problems.push_back(fmt::format("{}: {} of the pixels are within 1/255 of {}, {:g} % are wanted", difference.driver,
                                     percent_text(metrics.within_one_share), difference.reference, 100 * wanted_share));
    }
    if (options_.largest_difference && metrics.largest_difference > *options_.largest_difference) {
      problems.push_back(fmt::format("{}: the largest difference from {} is {}/255, at most {}/255 is wanted", difference.driver,
                                     difference.reference, metrics.largest_difference, *options_.largest_difference));
    }
  }

  void print(const SceneComparison& scene) {
    std::string text = fmt::format("{:<24}", prefix_);
    for (const DriverRun& run : scene.runs) {
      if (run.error.empty()) text += fmt::format("  {} {:.2f} ms", run.driver, run.median_ms);
    }
    for (const Difference& difference : scene.differences) {
      text += fmt::format("  {} within 1/255, largest {}", percent_text(difference.metrics.within_one_share),
                          difference.metrics.largest_difference);
    }
    terminal_.line(text + (scene.problems.empty() ? "  ok" : "  FAILED"));
    for (const std::string& problem : scene.problems) terminal_.line("    " + problem);
  }

  CompareOptions options_;
  Terminal terminal_;
  std::string prefix_;
  std::map<std::string, int> stem_counts_;
};

}  // namespace

bool Comparison::passed() const {
  return std::ranges::all_of(scenes, [](const SceneComparison& scene) { return scene.problems.empty(); });
}

Comparison compare(const CompareOptions& options) { return Comparer(options).run(); }

}  // namespace pineda::tools
