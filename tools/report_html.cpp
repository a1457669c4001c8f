#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <set>

#include "tools/html.h"
#include "tools/machine_info.h"
#include "tools/report.h"
#include "tools/report_style.h"

namespace pineda::tools {
namespace {

std::string escape(const std::string& text) { return escape_html(text); }

std::string milliseconds(double value) { return value < 10 ? fmt::format("{:.3f}", value) : fmt::format("{:.1f}", value); }

std::string psnr(double value_db) { return std::isinf(value_db) ? "∞ (equal)" : fmt::format("{:.1f} dB", value_db); }

const char* verdict(bool good) {
  return good ? "<span class='verdict good'>pass</span>" : "<span class='verdict bad'>fail</span>";
}

class Page {
 public:
  explicit Page(const Comparison& comparison) : comparison_(comparison) {}

  std::string build() {
    add("<!doctype html>\n<html lang='en'><head><meta charset='utf-8'><meta name='viewport' content='width=device-width, "
        "initial-scale=1'>\n<title>Pineda comparison</title><style>{}</style></head><body><main>\n",
        kReportStyle);
    add_header();
    add_summary();
    for (size_t i = 0; i < comparison_.scenes.size(); ++i) add_scene(comparison_.scenes[i], i);
    add_machine();
    add("</main><dialog><p></p><div><img alt=''></div></dialog><script>{}</script></body></html>\n", kReportScript);
    return std::move(html_);
  }

 private:
  template <typename... Args>
  void add(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(html_), format, std::forward<Args>(args)...);
  }

  const std::string& reference() const { return comparison_.options.drivers.back().label; }

  void add_header() {
    const CompareOptions& options = comparison_.options;
    const std::string date = date_text();
    std::string names;
    for (size_t i = 0; i + 1 < options.drivers.size(); ++i) {
      names += (i == 0 ? "" : ", ") + escape(options.drivers[i].label);
    }
    if (!names.empty()) names += " compared with ";
    add("<header><div><h1>{}{}</h1><p>{} scenes at {}&times;{}, {}</p></div>{}</header>\n", names, escape(reference()),
        comparison_.scenes.size(), options.width, options.height, date,
        comparison_.passed() ? "<span class='verdict good'>All thresholds held</span>"
                             : "<span class='verdict bad'>Thresholds missed</span>");
  }

  // Rows of scenes; for each driver a time, for each pair the difference and the ratio of times.
  void add_summary() {
    const size_t driver_count = comparison_.options.drivers.size();
    add("<section><div class='title'><h2>Summary</h2></div><p>Wanted: at least {} of the pixels within 1/255 of {}",
        fmt::format("{:g} %", 100 * comparison_.options.threshold_share), escape(reference()));
    if (const auto largest = comparison_.options.largest_difference) add(", none further than {}/255", *largest);
    add(". Times are medians of a whole frame, submit to fence.</p><div class='scroll'><table><tr><th>Scene</th>");
    for (const DriverSpec& driver : comparison_.options.drivers) add("<th>{}<br>ms</th>", escape(driver.label));
    for (size_t i = 0; i + 1 < driver_count; ++i) {
      const std::string label = escape(comparison_.options.drivers[i].label);
      add("<th>{}<br>times faster</th><th>within<br>1/255</th><th>largest<br>difference</th><th>PSNR</th>", label);
    }
    add("<th></th></tr>\n");
    for (size_t i = 0; i < comparison_.scenes.size(); ++i) add_summary_row(comparison_.scenes[i], i);
    add("</table></div></section>\n");
  }

  void add_summary_row(const SceneComparison& scene, size_t number) {
    const size_t driver_count = comparison_.options.drivers.size();
    add("<tr><td><a href='#scene{}'>{}</a></td>", number, escape(scene.title));
    for (size_t i = 0; i < driver_count; ++i) {
      add("<td>{}</td>", scene.runs[i].error.empty() ? milliseconds(scene.runs[i].median_ms) : "failed");
    }
    const DriverRun& base = scene.runs[driver_count - 1];
    for (size_t i = 0; i + 1 < driver_count; ++i) {
      const Difference* const difference = find(scene.differences, scene.runs[i].driver);
      if (!difference) {
        add("<td class='soft'>&ndash;</td><td class='soft'>&ndash;</td><td class='soft'>&ndash;</td><td "
            "class='soft'>&ndash;</td>");
        continue;
      }
      const ImageMetrics& metrics = difference->metrics;
      add("<td>{:.2f}</td><td>{}</td><td>{}</td><td>{}</td>", base.median_ms / scene.runs[i].median_ms,
          percent_text(metrics.within_one_share), metrics.largest_difference, psnr(metrics.psnr_db));
    }
    add("<td>{}</td></tr>\n", verdict(scene.problems.empty()));
  }

  static const Difference* find(const std::vector<Difference>& differences, const std::string& driver) {
    for (const Difference& difference : differences) {
      if (difference.driver == driver) return &difference;
    }
    return nullptr;
  }

  void add_scene(const SceneComparison& scene, size_t number) {
    add("<section id='scene{}'><div class='title'><h2>{}</h2>{}</div><p>{}", number, escape(scene.title),
        verdict(scene.problems.empty()), escape(scene.description));
    std::set<std::string> notes;
    for (const DriverRun& run : scene.runs) notes.insert(run.notes.begin(), run.notes.end());
    for (const std::string& note : notes) add(" &middot; {}", escape(note));
    add("</p>\n");
    for (const std::string& problem : scene.problems) add("<div class='problem'>{}</div>\n", escape(problem));
    add_pictures(scene);
    add_differences(scene);
    add_times(scene);
    add("</section>\n");
  }

  void add_picture(const std::string& file, const std::string& alt, const std::string& caption) {
    add("<figure><img src='{}' alt='{}' loading='lazy'><figcaption>{}</figcaption></figure>\n", escape(file), escape(alt),
        caption);
  }

  void add_pictures(const SceneComparison& scene) {
    add("<div class='pictures'>\n");
    for (const DriverRun& run : scene.runs) {
      if (!run.error.empty()) continue;
      add_picture(run.png, run.driver, fmt::format("<b>{}</b> &middot; {}", escape(run.driver), escape(run.device)));
    }
    for (const auto* differences : {&scene.differences, &scene.truth_errors}) {
      for (const Difference& difference : *differences) {
        const std::string text = fmt::format("{} against {}", difference.driver, difference.reference);
        add_picture(difference.png, "difference of " + text,
                    fmt::format("<b>Difference</b>, amplified &middot; {}", escape(text)));
      }
    }
    add("</div>\n");
    if (scene.differences.empty() && scene.truth_errors.empty()) return;
    add("<div class='legend'><span>Difference in steps of 1/255:</span>");
    constexpr std::pair<const char*, const char*> kSteps[] = {{"#0c0e14", "0"},          {"#2d5cd6", "1"},
                                                              {"#20b28a", "2"},          {"#ecc834", "3&ndash;8"},
                                                              {"#f06030", "9&ndash;32"}, {"#ffeee8", "more"}};
    for (const auto& [colour, text] : kSteps) add("<span><i style='background:{}'></i>{}</span>", colour, text);
    add("</div>\n");
  }

  void add_differences(const SceneComparison& scene) {
    if (scene.differences.empty() && scene.truth_errors.empty()) return;
    add("<div class='scroll'><table><tr><th>Difference</th><th>largest</th><th>RMSE</th><th>PSNR</th><th>pixels that differ</th>"
        "<th>pixels within 1/255</th><th>pixels beyond</th></tr>\n");
    for (const auto* differences : {&scene.differences, &scene.truth_errors}) {
      for (const Difference& difference : *differences) {
        const ImageMetrics& metrics = difference.metrics;
        add("<tr><td>{} against {}</td><td>{}/255</td><td>{:.4f}/255</td><td>{}</td><td>{:.4f} %</td><td>{}</td><td>{} of "
            "{}</td></tr>\n",
            escape(difference.driver), escape(difference.reference), metrics.largest_difference, metrics.rmse,
            psnr(metrics.psnr_db), 100 * metrics.differing_share, percent_text(metrics.within_one_share),
            metrics.beyond_one_count, metrics.pixel_count);
      }
    }
    add("</table></div>\n");
  }

  void add_times(const SceneComparison& scene) {
    const DriverRun& base = scene.runs[comparison_.options.drivers.size() - 1];
    add("<div class='scroll'><table><tr><th>Time</th><th>median frame, ms</th><th>{} takes<br>times as long</th><th>frames</th>"
        "<th>first frame, ms</th><th>preparation, ms</th><th>hash of the pixels</th></tr>\n",
        escape(base.driver));
    for (const DriverRun& run : scene.runs) {
      if (!run.error.empty()) continue;
      const std::string ratio = base.error.empty() ? fmt::format("{:.2f}", base.median_ms / run.median_ms) : "&ndash;";
      add("<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td class='soft'>{}</td></tr>\n",
          escape(run.driver), milliseconds(run.median_ms), ratio, run.frame_count, milliseconds(run.first_frame_ms),
          milliseconds(run.prepare_ms), run.hash);
    }
    add("</table></div>\n");
  }

  void add_machine() {
    add("<section><div class='title'><h2>Machine and drivers</h2></div><div class='scroll'><table>\n");
    for (const auto& [name, value] : machine_info())
      add("<tr><td>{}</td><td class='wrap'>{}</td></tr>\n", escape(name), escape(value));
    std::vector<DriverSpec> drivers = comparison_.options.drivers;
    if (comparison_.options.truth) drivers.push_back(*comparison_.options.truth);
    for (size_t i = 0; i < drivers.size(); ++i) {
      std::string device = "no answer";
      for (const SceneComparison& scene : comparison_.scenes) {
        const DriverRun& run = scene.runs[i];
        if (!run.device.empty()) device = fmt::format("{}, Vulkan {}", run.device, run.api_version);
      }
      add("<tr><td>{}</td><td class='wrap'>{} <span class='soft'>{}</span></td></tr>\n", escape(drivers[i].label), escape(device),
          escape(drivers[i].manifest_path));
    }
    add("</table></div></section>\n");
  }

  const Comparison& comparison_;
  std::string html_;
};

}  // namespace

std::string report_html(const Comparison& comparison) { return Page(comparison).build(); }

}  // namespace pineda::tools
