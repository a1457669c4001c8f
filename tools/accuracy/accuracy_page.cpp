#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>

#include "tools/accuracy/accuracy.h"
#include "tools/accuracy/plot.h"
#include "tools/html.h"
#include "tools/machine_info.h"
#include "tools/report_style.h"

namespace pineda::tools {
namespace {

using nlohmann::json;

constexpr double kArithmeticFloor = 1e-9;  // below half a unit in the last place of any colour: plotted as this

struct SeriesLook {
  const char *name, *colour;
  Mark mark;
};
constexpr SeriesLook kLooks[] = {{"Pineda fast", "#e08a00", Mark::kTriangle},
                                 {"Pineda default", "#2f6fed", Mark::kCircle},
                                 {"Pineda exact", "#18915a", Mark::kSquare},
                                 {"lavapipe", "#c2314b", Mark::kDiamond}};
constexpr SeriesLook kOtherLook{"", "#7a5cc7", Mark::kDiamond};

const SeriesLook& look_of(const std::string& name) {
  const auto found = std::ranges::find_if(kLooks, [&](const SeriesLook& look) { return name == look.name; });
  return found == std::end(kLooks) ? kOtherLook : *found;
}

Plot plot_of(const SceneAccuracy& scene, const std::string& title, const std::string& y_label, PictureError AccuracyRun::*error,
             bool AccuracyRun::*dominated) {
  Plot plot{.title = title, .x_label = "median time of a frame, ms", .y_label = y_label};
  for (const AccuracyRun& run : scene.runs) {
    if (plot.series.empty() || plot.series.back().name != run.series) {
      const SeriesLook& look = look_of(run.series);
      plot.series.push_back({run.series, look.colour, look.mark, {}});
    }
    plot.series.back().points.push_back(
        {run.median_ms, (run.*error).rmse, std::to_string(run.samples),
         fmt::format("{}, {} samples: {:.3f} ms, RMSE {:.3e}", run.series, run.samples, run.median_ms, (run.*error).rmse),
         run.*dominated});
  }
  return plot;
}

std::string scientific(double value) { return value == 0 ? "0" : fmt::format("{:.2e}", value); }

class Page {
 public:
  explicit Page(const Accuracy& accuracy) : accuracy_(accuracy) {}

  std::string build() {
    add("<!doctype html>\n<html lang='en'><head><meta charset='utf-8'><meta name='viewport' content='width=device-width, "
        "initial-scale=1'>\n<title>Error against run time</title><style>{}{}</style></head><body><main>\n",
        kReportStyle, kPlotStyle);
    add("<header><div><h1>Error against run time</h1><p>{} scenes at {}&times;{}, {}</p></div></header>\n",
        accuracy_.scenes.size(), accuracy_.options.width, accuracy_.options.height, date_text());
    add_lessons();
    add_truth();
    for (const SceneAccuracy& scene : accuracy_.scenes) add_scene(scene);
    add_machine();
    add("</main></body></html>\n");
    return std::move(html_);
  }

 private:
  static constexpr const char* kPlotStyle = R"css(
.plots { display: grid; grid-template-columns: repeat(auto-fit, minmax(460px, 1fr)); gap: 16px; margin-top: 14px; }
.plots svg { width: 100%; height: auto; }
.bars { display: flex; align-items: flex-end; gap: 2px; height: 40px; }
.bars i { display: block; width: 9px; background: var(--accent); border-radius: 2px 2px 0 0; }
.hollow { color: var(--soft); }
ul { margin: 10px 0 0; padding-left: 20px; } li { margin: 4px 0; }
)css";

  template <typename... Args>
  void add(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(html_), format, std::forward<Args>(args)...);
  }

  void add_lessons() {
    add("<section><div class='title'><h2>What the plots teach</h2></div><p style='color:var(--text)'>");
    for (const std::string& lesson : lessons(accuracy_)) add("{} ", escape_html(lesson));
    add("</p></section>\n");
  }

  void add_truth() {
    add("<section><div class='title'><h2>What is measured</h2></div><ul>"
        "<li><b>The truth</b> is the whole pipeline in binary64, drawn by a renderer that shares no code with a driver: the "
        "shaders are the "
        "same text, compiled as C++ with <code>double</code>; vertices are not snapped to a grid, attachments are not "
        "rounded.</li>"
        "<li><b>Sampling error</b>: against the mean of the true scene over each pixel&rsquo;s area (256 points of "
        "Hammersley&rsquo;s set; for Edges "
        "the exact area of the triangles in the pixel). More samples make it smaller.</li>"
        "<li><b>Arithmetic error</b>: against the truth at the same standard sample locations, where coverage and order are "
        "beyond doubt: not "
        "within 1/256 px of an edge, nor within 10<sup>&minus;6</sup> in depth of another surface. More precision makes it "
        "smaller.</li>"
        "<li>Attachments are R32G32B32A32_SFLOAT, so nothing hides behind 8 bits. Times are medians of a frame, submit to fence, "
        "all series in turn, three rounds.</li><li><b>Dominated</b> (hollow, grey): another point is at least as good in both "
        "and "
        "better by more "
        "than 5 % in one.</li></ul></section>\n");
  }

  void add_scene(const SceneAccuracy& scene) {
    add("<section id='{}'><div class='title'><h2>{}</h2></div><p>{}</p>\n", scene.scene->name, escape_html(scene.scene->title),
        escape_html(scene.scene->description));
    for (const std::string& problem : scene.problems) add("<div class='problem'>{}</div>\n", escape_html(problem));
    add("<div class='plots'><div>{}</div><div>{}</div></div>\n", sampling_plot(scene), arithmetic_plot(scene));
    add_dominated(scene);
    add_table(scene);
    add("</section>\n");
  }

  void add_dominated(const SceneAccuracy& scene) {
    const auto list = [&](bool AccuracyRun::*flag) {
      std::map<std::string, std::string> by_series;
      for (const AccuracyRun& run : scene.runs) {
        if (run.*flag) by_series[run.series] += fmt::format("{}{}", by_series[run.series].empty() ? "" : ", ", run.samples);
      }
      std::string text;
      for (const auto& [series, samples] : by_series)
        text += fmt::format("{}{} at {}", text.empty() ? "" : "; ", series, samples);
      return text.empty() ? std::string("none") : text;
    };
    add("<p><b>Dominated</b> &middot; by sampling error: {} &middot; by arithmetic error: {}</p>\n",
        escape_html(list(&AccuracyRun::sampling_dominated)), escape_html(list(&AccuracyRun::arithmetic_dominated)));
  }

  void add_table(const SceneAccuracy& scene) {
    add("<div "
        "class='scroll'><table><tr><th></th><th>samples</th><th>ms</th><th>sampling<br>RMSE</th><th>largest</"
        "th><th>arithmetic<br>RMSE</th>"
        "<th>largest</th><th>largest,<br>ULP</th><th>pixels left out</th><th>components by ULP: 0, &le; 1, 2, 4 "
        "&hellip;</th></tr>\n");
    for (const auto* runs : {&scene.runs, &scene.evaluator}) {
      for (const AccuracyRun& run : *runs) add_row(run, runs == &scene.evaluator);
    }
    add("</table></div>\n");
  }

  void add_row(const AccuracyRun& run, bool evaluator) {
    const char* const sampling = run.sampling_dominated ? " class='hollow'" : "";
    const char* const arithmetic = run.arithmetic_dominated ? " class='hollow'" : "";
    add("<tr><td>{}</td><td>{}</td><td>{}</td><td{}>{:.5f}</td><td{}>{:.4f}</td><td{}>{}</td><td{}>{}</td><td{}>{:.4g}</"
        "td><td>{:.3f} "
        "%</td><td>",
        escape_html(run.series), run.samples, evaluator ? "&ndash;" : fmt::format("{:.3f}", run.median_ms), sampling,
        run.sampling.rmse, sampling, run.sampling.largest, arithmetic, scientific(run.arithmetic.rmse), arithmetic,
        scientific(run.arithmetic.largest), arithmetic, run.arithmetic.largest_ulp, 100 * run.arithmetic.skipped_share);
    uint64_t total = 0;
    for (const uint64_t count : run.arithmetic.ulp_histogram) total += count;
    add("<div class='bars'>");
    for (size_t bin = 0; bin < kUlpBins; ++bin) {
      const double share = total ? static_cast<double>(run.arithmetic.ulp_histogram[bin]) / static_cast<double>(total) : 0;
      add("<i title='{}: {:.3f} %' style='height:{:.1f}%'></i>", ulp_bin_text(bin), 100 * share,
          share > 0 ? 4 + 96 * share : 0.0);
    }
    add("</div></td></tr>\n");
  }

  void add_machine() {
    add("<section><div class='title'><h2>Machine</h2></div><div class='scroll'><table>\n");
    for (const auto& [name, value] : machine_info())
      add("<tr><td>{}</td><td class='wrap'>{}</td></tr>\n", escape_html(name), escape_html(value));
    add("</table></div></section>\n");
  }

  const Accuracy& accuracy_;
  std::string html_;
};

json as_json(const PictureError& error) {
  return {{"rmse", error.rmse},
          {"largest", error.largest},
          {"largest_ulp", error.largest_ulp},
          {"ulp_histogram", error.ulp_histogram},
          {"skipped_share", error.skipped_share}};
}

json as_json(const AccuracyRun& run) {
  return {{"series", run.series},
          {"samples", run.samples},
          {"median_ms", run.median_ms},
          {"sampling", as_json(run.sampling)},
          {"arithmetic", as_json(run.arithmetic)},
          {"sampling_dominated", run.sampling_dominated},
          {"arithmetic_dominated", run.arithmetic_dominated}};
}

}  // namespace

std::string sampling_plot(const SceneAccuracy& scene) {
  return svg(plot_of(scene, fmt::format("{}: sampling error", scene.scene->title),
                     scene.scene->exact_area ? "RMSE against the exact area" : "RMSE against the mean over the pixel",
                     &AccuracyRun::sampling, &AccuracyRun::sampling_dominated));
}

std::string arithmetic_plot(const SceneAccuracy& scene) {
  Plot plot = plot_of(scene, fmt::format("{}: arithmetic error", scene.scene->title), "RMSE against binary64 at the same samples",
                      &AccuracyRun::arithmetic, &AccuracyRun::arithmetic_dominated);
  plot.y_floor = kArithmeticFloor;
  return svg(plot);
}

std::string accuracy_html(const Accuracy& accuracy) { return Page(accuracy).build(); }

std::string accuracy_json(const Accuracy& accuracy) {
  json machine, scenes = json::array();
  for (const auto& [name, value] : machine_info()) machine[name] = value;
  for (const SceneAccuracy& scene : accuracy.scenes) {
    json runs = json::array();
    for (const AccuracyRun& run : scene.runs) runs.push_back(as_json(run));
    for (const AccuracyRun& run : scene.evaluator) runs.push_back(as_json(run));
    scenes.push_back({{"scene", scene.scene->name}, {"runs", runs}, {"problems", scene.problems}});
  }
  const json report{{"width", accuracy.options.width},
                    {"height", accuracy.options.height},
                    {"machine", machine},
                    {"lessons", lessons(accuracy)},
                    {"scenes", scenes}};
  return report.dump(2, ' ', false, json::error_handler_t::replace) + "\n";
}

}  // namespace pineda::tools
