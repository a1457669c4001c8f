// `pineda compare`: the same scenes on several drivers, and how far their pictures are apart.
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "tools/driver_registry.h"
#include "tools/image_metrics.h"

namespace pineda::tools {

struct CompareOptions {
  std::vector<std::string> scenes;  // names or paths of model files
  std::vector<DriverSpec> drivers;  // the last one is what the others are compared with
  std::optional<DriverSpec> truth;  // a driver that computes in f64
  uint32_t width = 800, height = 600;
  uint32_t frames = 30;
  bool validate = false;
  std::string out_dir = "report";
  double threshold_share = 0.999;              // of the pixels must be within 1/255
  std::optional<uint32_t> largest_difference;  // and no pixel further apart than this, in units of 1/255
  std::chrono::seconds timeout{120}, truth_timeout{3600};
};

struct DriverRun {  // one scene on one driver
  std::string driver, device, api_version;
  std::string error;  // empty when it drew
  Image picture;
  std::string png;  // file name in the report's folder
  std::string hash;
  double prepare_ms = 0, first_frame_ms = 0, median_ms = 0;
  size_t frame_count = 0;
  std::vector<std::string> notes, validation;
};

struct Difference {  // of one driver from another
  std::string driver, reference;
  ImageMetrics metrics;
  std::string png;  // the difference map
};

struct SceneComparison {
  std::string name, title, description;
  std::vector<DriverRun> runs;           // in the order of the drivers; the truth, if any, comes last
  std::vector<Difference> differences;   // each driver from the reference
  std::vector<Difference> truth_errors;  // each driver from the truth
  std::vector<std::string> problems;     // why it did not pass; empty when it did
};

struct Comparison {
  CompareOptions options;
  std::vector<SceneComparison> scenes;
  bool passed() const;
};

// Draws, compares, and writes pictures, index.html and report.json to the options' folder. Throws ToolError when it cannot start
// at all; what goes wrong with one scene or driver is in the result.
Comparison compare(const CompareOptions& options);

}  // namespace pineda::tools
