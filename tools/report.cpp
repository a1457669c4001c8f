#include "tools/report.h"

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "tools/html.h"
#include "tools/machine_info.h"

namespace pineda::tools {
namespace {

using nlohmann::json;

json as_json(const SceneComparison& scene);

json as_json(const DriverRun& run) {
  return {{"driver", run.driver},
          {"device", run.device},
          {"api_version", run.api_version},
          {"error", run.error.empty() ? json() : json(run.error)},
          {"png", run.png},
          {"hash", run.hash},
          {"prepare_ms", run.prepare_ms},
          {"first_frame_ms", run.first_frame_ms},
          {"median_ms", run.median_ms},
          {"frame_count", run.frame_count},
          {"notes", run.notes},
          {"validation", run.validation}};
}

json as_json(const Difference& difference) {
  const ImageMetrics& metrics = difference.metrics;
  return {{"driver", difference.driver},
          {"reference", difference.reference},
          {"png", difference.png},
          {"largest_difference", metrics.largest_difference},
          {"rmse", metrics.rmse},
          {"psnr_db", std::isfinite(metrics.psnr_db) ? json(metrics.psnr_db) : json()},  // null: the pictures are equal
          {"differing_share", metrics.differing_share},
          {"within_one_share", metrics.within_one_share}};
}

template <typename T>
json as_json(const std::vector<T>& items) {
  json result = json::array();
  for (const T& item : items) result.push_back(as_json(item));
  return result;
}

json as_json(const SceneComparison& scene) {
  return {
      {"scene", scene.name},         {"passed", scene.problems.empty()},          {"problems", scene.problems},
      {"runs", as_json(scene.runs)}, {"differences", as_json(scene.differences)}, {"truth_errors", as_json(scene.truth_errors)}};
}

}  // namespace

std::string report_json(const Comparison& comparison) {
  json machine;
  for (const auto& [name, value] : machine_info()) machine[name] = value;
  const json report{{"passed", comparison.passed()},
                    {"threshold_share", comparison.options.threshold_share},
                    {"width", comparison.options.width},
                    {"height", comparison.options.height},
                    {"machine", machine},
                    {"scenes", as_json(comparison.scenes)}};
  return report.dump(2, ' ', false, json::error_handler_t::replace) + "\n";
}

void write_report(const Comparison& comparison) {
  const std::filesystem::path folder = comparison.options.out_dir;
  write_file((folder / "report.json").string(), report_json(comparison));
  write_file((folder / "index.html").string(), report_html(comparison));
}

}  // namespace pineda::tools
