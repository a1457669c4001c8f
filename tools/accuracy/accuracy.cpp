#include "tools/accuracy/accuracy.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>

#include "tools/driver_process.h"
#include "tools/error.h"
#include "tools/html.h"
#include "tools/statistics.h"
#include "tools/terminal.h"

namespace pineda::tools {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr uint32_t kAreaSamples = 256;
constexpr uint32_t kRounds = 3;

class Measurer {
 public:
  explicit Measurer(const AccuracyOptions& options) : options_(options) {}

  Accuracy run() {
    fs::create_directories(options_.out_dir);
    for (const AccuracySeries& series : options_.series) processes_.push_back(open(series.driver));
    Accuracy accuracy{.options = options_, .scenes = {}};
    for (const SuiteScene* scene : options_.scenes) {
      accuracy.scenes.push_back(measure_scene(*scene));
      mark_dominated(accuracy.scenes.back().runs);
      print(accuracy.scenes.back());
    }
    for (const auto& process : processes_) process->request({{"command", "close"}}, options_.timeout);
    return accuracy;
  }

 private:
  std::unique_ptr<DriverProcess> open(const DriverSpec& driver) {
    auto process = std::make_unique<DriverProcess>(driver);
    process->request({{"command", "open"}}, options_.timeout);
    return process;
  }

  SceneAccuracy measure_scene(const SuiteScene& scene) {
    terminal_.status(fmt::format("{}: the truth", scene.name));
    std::vector<glm::dvec4> area =
        render_reference(scene, options_.width, options_.height, area_samples(kAreaSamples), Shading::kSample).colours;
    if (scene.exact_area) {
      const std::vector<double> coverage = exact_coverage(scene, options_.width, options_.height);
      for (size_t i = 0; i < area.size(); ++i) area[i] = glm::dvec4(coverage[i], coverage[i], coverage[i], 1);
    }
    SceneAccuracy result{.scene = &scene, .runs = {}, .evaluator = {}, .problems = {}};
    for (const uint32_t samples : options_.sample_counts) {
      const ReferencePicture truth =
          render_reference(scene, options_.width, options_.height, standard_samples(samples), Shading::kPixelCentre);
      measure_series(scene, samples, area, truth, result);
      if (samples == 1 && options_.evaluator) measure_evaluator(scene, area, truth, result);
    }
    std::ranges::stable_sort(result.runs, {}, [&](const AccuracyRun& run) {
      return std::ranges::find(options_.series, run.series, &AccuracySeries::name) - options_.series.begin();
    });
    return result;
  }

  // All series in turn, kRounds times: the frames of all rounds count for the time.
  void measure_series(const SuiteScene& scene, uint32_t samples, const std::vector<glm::dvec4>& area,
                      const ReferencePicture& truth, SceneAccuracy& result) {
    std::vector<std::vector<double>> frames_ms(processes_.size());
    for (uint32_t round = 0; round < kRounds; ++round) {
      for (size_t i = 0; i < processes_.size(); ++i) {
        const std::string& name = options_.series[i].name;
        terminal_.status(fmt::format("{}: {}, {} samples", scene.name, name, samples));
        try {
          std::vector<AccuracyRun> run;
          draw(*processes_[i], scene, name, samples, options_.frames, options_.timeout, area, truth, run, frames_ms[i]);
          if (round + 1 == kRounds) result.runs.insert(result.runs.end(), run.begin(), run.end());
        } catch (const ToolError& error) {
          result.problems.push_back(error.what());
        }
      }
    }
  }

  void measure_evaluator(const SuiteScene& scene, const std::vector<glm::dvec4>& area, const ReferencePicture& truth,
                         SceneAccuracy& result) {
    terminal_.status(fmt::format("{}: PINEDA_MODE=f64", scene.name));
    try {
      const auto process = open(parse_driver("pineda@PINEDA_MODE=f64"));
      std::vector<double> frames_ms;
      draw(*process, scene, "PINEDA_MODE=f64", 1, 1, options_.evaluator_timeout, area, truth, result.evaluator, frames_ms);
    } catch (const ToolError& error) {
      result.problems.push_back(error.what());
    }
  }

  void draw(DriverProcess& process, const SuiteScene& scene, const std::string& name, uint32_t samples, uint32_t frames,
            std::chrono::seconds timeout, const std::vector<glm::dvec4>& area, const ReferencePicture& truth,
            std::vector<AccuracyRun>& runs, std::vector<double>& all_frames_ms) {
    const std::string path = (fs::path(options_.out_dir) / "suite.floats").string();
    const json reply = process.request({{"command", "suite_render"},
                                        {"scene", scene.name},
                                        {"samples", samples},
                                        {"width", options_.width},
                                        {"height", options_.height},
                                        {"frames", frames},
                                        {"budget_ms", options_.budget_ms / kRounds},
                                        {"floats", path}},
                                       timeout);
    if (!reply.at("supported").get<bool>()) return;
    const std::vector<double> frames_ms = reply.at("frames_ms");
    const size_t first = frames_ms.size() > 1 ? 1 : 0;  // the first one warms up
    all_frames_ms.insert(all_frames_ms.end(), frames_ms.begin() + static_cast<ptrdiff_t>(first), frames_ms.end());
    std::vector<float> floats(size_t{4} * options_.width * options_.height);
    std::ifstream file(path, std::ios::binary);
    if (!file.read(reinterpret_cast<char*>(floats.data()), static_cast<std::streamsize>(floats.size() * sizeof(float)))) {
      fail("{}: too short", path);
    }
    file.close();
    fs::remove(path);
    runs.push_back({.series = name,
                    .samples = samples,
                    .median_ms = median(all_frames_ms),
                    .sampling = measure_error(floats, area, {}),
                    .arithmetic = measure_error(floats, truth.colours, truth.undecided)});
  }

  static void mark_dominated(std::vector<AccuracyRun>& runs) {
    std::vector<CostPoint> sampling, arithmetic;
    for (const AccuracyRun& run : runs) {
      sampling.push_back({run.median_ms, run.sampling.rmse});
      arithmetic.push_back({run.median_ms, run.arithmetic.rmse});
    }
    const std::vector<bool> by_sampling = dominated(sampling), by_arithmetic = dominated(arithmetic);
    for (size_t i = 0; i < runs.size(); ++i) {
      runs[i].sampling_dominated = by_sampling[i];
      runs[i].arithmetic_dominated = by_arithmetic[i];
    }
  }

  void print(const SceneAccuracy& scene) {
    terminal_.line(fmt::format("{} ({}): {}", scene.scene->title, scene.scene->name, scene.scene->description));
    terminal_.line(fmt::format("  {:<16}{:>8}{:>10}  {:>12}{:>10}{:>3}  {:>12}{:>12}{:>10}{:>3}  {:>9}", "", "samples", "ms",
                               "area: RMSE", "largest", "", "f64: RMSE", "largest", "ULP", "", "undecided"));
    for (const auto* runs : {&scene.runs, &scene.evaluator}) {
      for (const AccuracyRun& run : *runs) {
        terminal_.line(
            fmt::format("  {:<16}{:>8}{:>10.3f}  {:>12.3e}{:>10.2e}{:>3}  {:>12.3e}{:>12.2e}{:>10.4g}{:>3}  {:>7.3f} %",
                        run.series, run.samples, run.median_ms, run.sampling.rmse, run.sampling.largest,
                        run.sampling_dominated ? "d" : "", run.arithmetic.rmse, run.arithmetic.largest,
                        run.arithmetic.largest_ulp, run.arithmetic_dominated ? "d" : "", 100 * run.arithmetic.skipped_share));
      }
    }
    for (const std::string& problem : scene.problems) terminal_.line("    " + problem);
  }

  const AccuracyOptions& options_;
  Terminal terminal_;
  std::vector<std::unique_ptr<DriverProcess>> processes_;  // of the series
};

const AccuracyRun* find_run(const SceneAccuracy& scene, const std::string& series, uint32_t samples) {
  for (const AccuracyRun& run : scene.runs) {
    if (run.series == series && run.samples == samples) return &run;
  }
  return nullptr;
}

bool is_lavapipe(const AccuracyRun& run) { return run.series == "lavapipe"; }

void add_sampling_lesson(const Accuracy& accuracy, std::vector<std::string>& out) {
  for (const SceneAccuracy& scene : accuracy.scenes) {
    if (!scene.scene->exact_area) continue;
    const AccuracyRun *one = find_run(scene, "Pineda default", 1), *most = nullptr;
    for (const AccuracyRun& run : scene.runs) {
      if (run.series == "Pineda default") most = &run;
    }
    if (!one || !most || most->samples == 1 || most->sampling.rmse == 0) continue;
    const double doublings = std::log2(most->samples);
    out.push_back(
        fmt::format("What samples buy: on {}, {} samples take {:.1f} times as long as one and bring the coverage error from "
                    "{:.3f} to {:.4f}; "
                    "each doubling multiplies the error by {:.2f} and the time by {:.2f}.",
                    scene.scene->title, most->samples, most->median_ms / one->median_ms, one->sampling.rmse, most->sampling.rmse,
                    std::pow(most->sampling.rmse / one->sampling.rmse, 1 / doublings),
                    std::pow(most->median_ms / one->median_ms, 1 / doublings)));
  }
}

void add_precision_lesson(const Accuracy& accuracy, std::vector<std::string>& out) {
  for (const SceneAccuracy& scene : accuracy.scenes) {
    const AccuracyRun *fast = find_run(scene, "Pineda fast", 1), *middle = find_run(scene, "Pineda default", 1),
                      *exact = find_run(scene, "Pineda exact", 1);
    if (!fast || !middle || !exact || std::string_view(scene.scene->name) != "marble") continue;
    out.push_back(
        fmt::format("What precision buys: on {}, where every function of the shader has three algorithms, the arithmetic error "
                    "is {:.1e} (fast), "
                    "{:.1e} (default), {:.1e} (exact) in {:.2f}, {:.2f} and {:.2f} ms; beside the sampling error of {:.1e} at "
                    "one sample all three are "
                    "invisible.",
                    scene.scene->title, fast->arithmetic.rmse, middle->arithmetic.rmse, exact->arithmetic.rmse, fast->median_ms,
                    middle->median_ms, exact->median_ms, middle->sampling.rmse));
  }
}

void add_comparison_lesson(const Accuracy& accuracy, std::vector<std::string>& out) {
  size_t lavapipe_count = 0, lavapipe_dominated = 0, pineda_beaten = 0, pineda_count = 0;
  for (const SceneAccuracy& scene : accuracy.scenes) {
    for (const AccuracyRun& run : scene.runs) {
      (is_lavapipe(run) ? lavapipe_count : pineda_count) += 1;
      for (const AccuracyRun& other : scene.runs) {
        if (is_lavapipe(run) == is_lavapipe(other)) continue;
        const CostPoint pair[] = {{run.median_ms, run.sampling.rmse}, {other.median_ms, other.sampling.rmse}};
        if (!dominated(pair)[0]) continue;
        (is_lavapipe(run) ? lavapipe_dominated : pineda_beaten) += 1;
        break;
      }
    }
  }
  if (!lavapipe_count) return;
  out.push_back(
      fmt::format("Against lavapipe: a point of Pineda is faster and at least as near to the area's mean for {} of lavapipe's {} "
                  "points, and one of lavapipe for {} of Pineda's {}.",
                  lavapipe_dominated, lavapipe_count, pineda_beaten, pineda_count));
}

// Which driver's numbers are nearer to binary64 where nothing but rounding is left.
void add_arithmetic_lesson(const Accuracy& accuracy, std::vector<std::string>& out) {
  double undecided = 0;
  std::string pineda_nearer, lavapipe_nearer, of_the_grid;
  for (const SceneAccuracy& scene : accuracy.scenes) {
    const AccuracyRun *pineda = find_run(scene, "Pineda default", 1), *lavapipe = find_run(scene, "lavapipe", 1);
    if (!pineda || !lavapipe) continue;
    undecided = std::max(undecided, pineda->arithmetic.skipped_share);
    const double ours = pineda->arithmetic.rmse, theirs = lavapipe->arithmetic.rmse;
    if (ours == theirs) continue;
    std::string& list = ours < theirs ? pineda_nearer : lavapipe_nearer;
    list += fmt::format("{}{} ({:.1e} beside {:.1e})", list.empty() ? "" : ", ", scene.scene->title, std::min(ours, theirs),
                        std::max(ours, theirs));
    // More precise arithmetic on the same snapped vertices that is no nearer.
    if (theirs < ours && !scene.evaluator.empty() && scene.evaluator[0].arithmetic.rmse > ours / 2) {
      of_the_grid += fmt::format("{}{}", of_the_grid.empty() ? "" : ", ", scene.scene->title);
    }
  }
  out.push_back(
      fmt::format("What rounding does: at one sample at most {:.2f} % of the pixels hang on the 1/256 px to which vertices are "
                  "rounded; in the others "
                  "Pineda is nearer to binary64 on {}, lavapipe on {}.",
                  100 * undecided, pineda_nearer.empty() ? "no scene" : pineda_nearer,
                  lavapipe_nearer.empty() ? "no scene" : lavapipe_nearer));
  if (!of_the_grid.empty()) {
    out.push_back(
        fmt::format("On {} PINEDA_MODE=f64 is no nearer than binary32: the error is not of the arithmetic but of interpolating "
                    "between vertices where the 1/256 px grid has put them.",
                    of_the_grid));
  }
}

}  // namespace

bool Accuracy::passed() const {
  return std::ranges::all_of(scenes, [](const SceneAccuracy& scene) { return scene.problems.empty(); });
}

std::vector<AccuracySeries> default_series() {
  return {{"Pineda fast", parse_driver("pineda@PINEDA_PRECISION=fast")},
          {"Pineda default", parse_driver("pineda")},
          {"Pineda exact", parse_driver("pineda@PINEDA_PRECISION=exact")},
          {"lavapipe", parse_driver("lavapipe")}};
}

std::vector<std::string> lessons(const Accuracy& accuracy) {
  std::vector<std::string> out;
  add_sampling_lesson(accuracy, out);
  add_precision_lesson(accuracy, out);
  add_arithmetic_lesson(accuracy, out);
  add_comparison_lesson(accuracy, out);
  return out;
}

Accuracy measure_accuracy(const AccuracyOptions& options) {
  const Accuracy accuracy = Measurer(options).run();
  const fs::path folder = options.out_dir;
  for (const SceneAccuracy& scene : accuracy.scenes) {
    write_file((folder / fmt::format("{}.sampling.svg", scene.scene->name)).string(), sampling_plot(scene));
    write_file((folder / fmt::format("{}.arithmetic.svg", scene.scene->name)).string(), arithmetic_plot(scene));
  }
  write_file((folder / "accuracy.json").string(), accuracy_json(accuracy));
  write_file((folder / "accuracy.html").string(), accuracy_html(accuracy));
  return accuracy;
}

}  // namespace pineda::tools
