// `pineda report`: error against run time, for Pineda at each precision, for lavapipe, at each sample count.
#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "tools/accuracy/measures.h"
#include "tools/accuracy/suite.h"
#include "tools/driver_registry.h"

namespace pineda::tools {

struct AccuracySeries {
  std::string name;
  DriverSpec driver;
};

struct AccuracyOptions {
  std::vector<const SuiteScene*> scenes;
  std::vector<AccuracySeries> series;
  std::vector<uint32_t> sample_counts;
  uint32_t width = 400, height = 300;
  uint32_t frames = 60;
  double budget_ms = 400;  // of each configuration
  bool evaluator = true;   // PINEDA_MODE=f64 too, at one sample: how near the driver's own double precision comes
  std::string out_dir = "report";
  std::chrono::seconds timeout{120}, evaluator_timeout{600};
};

struct AccuracyRun {
  std::string series;
  uint32_t samples = 1;
  double median_ms = 0;
  PictureError sampling;    // from the mean over each pixel's area: what a viewer sees
  PictureError arithmetic;  // from the same samples in binary64, where coverage and order are decided: what rounding did
  bool sampling_dominated = false, arithmetic_dominated = false;
};

struct SceneAccuracy {
  const SuiteScene* scene = nullptr;
  std::vector<AccuracyRun> runs;       // series by series, in the order of the sample counts
  std::vector<AccuracyRun> evaluator;  // at most one, and not timed against the others
  std::vector<std::string> problems;   // of drivers
};

struct Accuracy {
  AccuracyOptions options;
  std::vector<SceneAccuracy> scenes;
  bool passed() const;
};

std::vector<AccuracySeries> default_series();  // Pineda fast, default, exact, and lavapipe

// Measures, prints tables, writes accuracy.html, accuracy.json and one SVG for each plot to the options' folder.
Accuracy measure_accuracy(const AccuracyOptions& options);

// What the figures teach, a sentence each; derived from them alone.
std::vector<std::string> lessons(const Accuracy& accuracy);

std::string accuracy_json(const Accuracy& accuracy);
std::string accuracy_html(const Accuracy& accuracy);
std::string sampling_plot(const SceneAccuracy& scene);    // SVG
std::string arithmetic_plot(const SceneAccuracy& scene);  // SVG

}  // namespace pineda::tools
