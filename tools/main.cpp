// The `pineda` command: draws scenes with Vulkan drivers, compares and times them. See `pineda --help`.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "tools/accuracy/accuracy.h"
#include "tools/bench/bench.h"
#include "tools/capture.h"
#include "tools/compare.h"
#include "tools/driver_process.h"
#include "tools/error.h"
#include "tools/errors/errors.h"
#include "tools/explain.h"
#include "tools/extreme/extreme.h"
#include "tools/golden.h"
#include "tools/readme.h"
#include "tools/scene_registry.h"
#include "tools/size.h"
#include "tools/worker.h"

namespace pineda::tools {
namespace {

constexpr int kFailed = 1, kUsageError = 2;

struct Arguments {
  std::vector<std::string> scenes;
  std::string drivers = "pineda,lavapipe", driver = "pineda";
  std::string size = "800x600", compare_size = "1600x1200", report_size = "400x300";
  std::string out, json, filter, golden_file, capture, readme;
  uint32_t frames = 30, rounds = 5;
  double threshold_share = 0.999, budget_ms = 200;
  int largest_difference = -1;  // no limit
  uint32_t timeout_s = 120;
  std::string functions, columns = "fast,default,exact,lavapipe", errors_file = "docs/errors.md";
  bool quick = false;
  bool extreme = false, truth = false, validate = false, hash = false, update = false, list = false, scaling = false;
};

int run_compare_capture(const Arguments& arguments) {
  const CaptureComparison result = compare_capture({.file = arguments.capture,
                                                    .drivers = parse_drivers(arguments.drivers),
                                                    .out_dir = arguments.out.empty() ? "report" : arguments.out,
                                                    .threshold_share = arguments.threshold_share});
  for (const FrameDifference& frame : result.frames) {
    fmt::print("{} {}: {} within 1/255, largest difference {}\n", frame.driver, frame.frame,
               percent_text(frame.metrics.within_one_share), frame.metrics.largest_difference);
  }
  for (const std::string& problem : result.problems) fmt::print(stderr, "{}\n", problem);
  fmt::print("{} frames compared\n", result.frames.size());
  return result.problems.empty() ? 0 : kFailed;
}

int run_compare(const Arguments& arguments) {
  if (!arguments.capture.empty()) return run_compare_capture(arguments);
  const Size size = parse_size(arguments.compare_size);
  CompareOptions options{.scenes = arguments.scenes,
                         .drivers = parse_drivers(arguments.drivers),
                         .width = size.width,
                         .height = size.height,
                         .frames = arguments.frames,
                         .validate = arguments.validate,
                         .out_dir = arguments.out.empty() ? "report" : arguments.out,
                         .threshold_share = arguments.threshold_share,
                         .timeout = std::chrono::seconds(arguments.timeout_s)};
  if (options.scenes.empty()) {
    for (const SceneInfo& scene : known_scenes()) options.scenes.emplace_back(scene.name);
  }
  if (arguments.largest_difference >= 0) options.largest_difference = static_cast<uint32_t>(arguments.largest_difference);
  if (arguments.truth) {
    options.truth = parse_driver("pineda@PINEDA_MODE=f64");
    options.truth->label = "truth (f64)";
  }
  const Comparison comparison = compare(options);
  fmt::print("report: {}/index.html\n{}\n", options.out_dir,
             comparison.passed() ? "all thresholds held" : "FAILED: see the messages above or the report");
  return comparison.passed() ? 0 : kFailed;
}

int run_report_extreme(const Arguments& arguments) {
  return report_extreme(
      {.drivers = parse_drivers(arguments.drivers),
       .variants = arguments.quick ? std::vector<DriverSpec>{} : parse_drivers("pineda@PINEDA_ISA=sse42,pineda@PINEDA_ISA=avx2"),
       .filter = arguments.filter,
       .out_dir = arguments.out.empty() ? "report" : arguments.out,
       .timeout = std::chrono::seconds(arguments.timeout_s)});
}

int run_report(const Arguments& arguments) {
  if (!arguments.readme.empty()) {
    update_readme(arguments.readme, arguments.out.empty() ? "report" : arguments.out);
    return 0;
  }
  if (arguments.extreme) return run_report_extreme(arguments);
  const Size size = parse_size(arguments.report_size);
  AccuracyOptions options{.scenes = {},
                          .series = default_series(),
                          .sample_counts = {1, 2, 4, 8, 16},
                          .width = size.width,
                          .height = size.height,
                          .budget_ms = arguments.budget_ms,
                          .evaluator = !arguments.quick,
                          .out_dir = arguments.out.empty() ? "report" : arguments.out,
                          .timeout = std::chrono::seconds(arguments.timeout_s)};
  for (const std::string& name : arguments.scenes) options.scenes.push_back(&require_suite_scene(name));
  if (options.scenes.empty()) {
    for (const SuiteScene& scene : suite_scenes()) options.scenes.push_back(&scene);
  }
  const Accuracy accuracy = measure_accuracy(options);
  fmt::print("\n");
  for (const std::string& lesson : lessons(accuracy)) fmt::print("{}\n", lesson);
  fmt::print("report: {}/accuracy.html\n", options.out_dir);
  return accuracy.passed() ? 0 : kFailed;
}

int run_bench(const Arguments& arguments) {
  if (arguments.list) {
    list_bench_rows();
    return 0;
  }
  // How work grows from one thread to two, with triangles and with pixels.
  const std::string drivers = arguments.scaling ? "pineda@PINEDA_THREADS=2,pineda@PINEDA_THREADS=1" : arguments.drivers;
  const std::string filter =
      arguments.scaling && arguments.filter.empty() ? "grow-,layers,lit-mesh,depth-only" : arguments.filter;
  return bench({.drivers = parse_drivers(drivers),
                .filter = filter,
                .rounds = arguments.rounds,
                .budget_ms = arguments.budget_ms,
                .json_path = arguments.json});
}

int run_render(const Arguments& arguments) {
  using nlohmann::json;
  require_scene(arguments.scenes[0]);
  const Size size = parse_size(arguments.size);
  const std::chrono::seconds timeout(arguments.timeout_s);
  DriverProcess process(parse_driver(arguments.driver));
  process.request({{"command", "open"}, {"validate", arguments.validate}}, timeout);
  json command{{"command", "render"}, {"scene", arguments.scenes[0]}, {"width", size.width}, {"height", size.height}};
  if (!arguments.out.empty()) command["png"] = arguments.out;
  const json result = process.request(command, timeout);
  for (const json& note : result.at("notes")) fmt::print(stderr, "{}\n", note.get<std::string>());
  if (arguments.hash)
    fmt::print("{} {}x{} {}\n", arguments.scenes[0], size.width, size.height, result.at("hash").get<std::string>());
  const json messages = process.request({{"command", "close"}}, timeout).at("validation");
  if (const std::string output = process.finish(); !output.empty()) fmt::print(stderr, "{}\n", output);
  for (const json& message : messages) fmt::print(stderr, "validation: {}\n", message.get<std::string>());
  return messages.empty() ? 0 : kFailed;
}

int list_scenes() {
  for (const SceneInfo& scene : known_scenes()) fmt::print("{:<12}{}\n", scene.name, scene.description);
  fmt::print("Any other name is the path of a model file (glTF, OBJ, Collada, 3DS, PLY, ...).\n");
  return 0;
}

void add_driver_set(CLI::App& verb, Arguments& arguments) {
  verb.add_option(
          "--drivers", arguments.drivers,
          "comma-separated: pineda, lavapipe, NAME=path.json; each with @VARIABLE=value for its environment. The last one is "
          "what the others are compared with")
      ->capture_default_str();
}

void add_verbs(CLI::App& app, Arguments& arguments, int& status) {
  CLI::App* const compare =
      app.add_subcommand("compare", "draw scenes or model files with several drivers and compare the pictures");
  compare->add_option("scenes", arguments.scenes, "scene names or model files (default: all scenes)");
  add_driver_set(*compare, arguments);
  compare->add_option("--size", arguments.compare_size, "of the picture")->capture_default_str();
  compare->add_option("--frames", arguments.frames, "to time, for each scene and driver")
      ->capture_default_str()
      ->check(CLI::Range(1, 100000));
  compare->add_flag("--truth", arguments.truth, "draw with Pineda in f64 too, and measure each driver's error against that");
  compare->add_flag("--validate", arguments.validate, "run under the Khronos validation layer; any message fails the scene");
  compare->add_option("--out", arguments.out, "folder of the report (default: report)");
  compare->add_option("--threshold-share", arguments.threshold_share, "share of pixels that must be within 1/255")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 1.0));
  compare->add_option("--max-diff", arguments.largest_difference, "largest difference allowed, in units of 1/255")
      ->check(CLI::Range(0, 255));
  compare->add_option("--capture", arguments.capture,
                      "replay this capture of GFXReconstruct instead (needs gfxrecon-replay and a display), frame by frame");
  compare->add_option("--timeout", arguments.timeout_s, "seconds a driver may be silent")->capture_default_str();
  compare->callback([&] { status = run_compare(arguments); });

  CLI::App* const bench = app.add_subcommand("bench", "time fixed work on several drivers in turn");
  add_driver_set(*bench, arguments);
  bench->add_option("--filter", arguments.filter, "only rows whose name contains one of these (comma-separated)");
  bench->add_option("--json", arguments.json, "write all results to this file");
  bench->add_option("--rounds", arguments.rounds, "turns of each driver")->capture_default_str()->check(CLI::Range(1, 1000));
  bench->add_option("--budget", arguments.budget_ms, "milliseconds of each turn")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  bench->add_flag("--list", arguments.list, "list the rows");
  bench->add_flag("--scaling", arguments.scaling, "two threads beside one, and rows that grow with triangles and pixels");
  bench->callback([&] { status = run_bench(arguments); });

  CLI::App* const report = app.add_subcommand("report", "error against run time, at each precision and sample count");
  report->add_option("scenes", arguments.scenes, "of the accuracy suite (default: all)");
  report->add_option("--size", arguments.report_size, "of the picture")->capture_default_str();
  report->add_option("--budget", arguments.budget_ms, "milliseconds to time each configuration")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  report->add_flag("--extreme", arguments.extreme, "stiff and extreme cases instead: what drivers give beside what is right");
  report->add_option("--readme", arguments.readme,
                     "measure nothing: rewrite this file's sections from the reports in --out (tools/readme.h)");
  report->add_option("--filter", arguments.filter, "only extreme cases whose 'group: name' contains this");
  add_driver_set(*report, arguments);
  report->add_flag("--quick", arguments.quick, "without PINEDA_MODE=f64, or the other ISA paths of the extreme cases");
  report->add_option("--out", arguments.out, "folder of the report (default: report)");
  report->add_option("--timeout", arguments.timeout_s, "seconds a driver may be silent")->capture_default_str();
  report->callback([&] { status = run_report(arguments); });

  CLI::App* const render = app.add_subcommand("render", "draw one scene with one driver");
  render->add_option("scene", arguments.scenes, "scene name or model file")->required()->expected(1);
  render->add_option("--driver", arguments.driver, "pineda, lavapipe or NAME=path.json")->capture_default_str();
  render->add_option("--size", arguments.size, "of the picture")->capture_default_str();
  render->add_option("--out", arguments.out, "PNG file to write");
  render->add_flag("--hash", arguments.hash, "print the hash of the pixels (XXH64)");
  render->add_flag("--validate", arguments.validate, "run under the Khronos validation layer; any message fails");
  render->add_option("--timeout", arguments.timeout_s, "seconds the driver may be silent")->capture_default_str();
  render->callback([&] { status = run_render(arguments); });

  CLI::App* const explained = app.add_subcommand("explain", "what Pineda leaves out of a scene, why, and what it saves");
  explained->add_option("scene", arguments.scenes, "scene name or model file")->required()->expected(1);
  explained->add_option("--size", arguments.size, "of the picture")->capture_default_str();
  explained->add_option("--rounds", arguments.rounds, "turns of each variant")->capture_default_str()->check(CLI::Range(1, 1000));
  explained->add_option("--budget", arguments.budget_ms, "milliseconds of each turn")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  explained->add_option("--timeout", arguments.timeout_s, "seconds the driver may be silent")->capture_default_str();
  explained->callback([&] {
    status = explain({.scene = arguments.scenes[0],
                      .size = parse_size(arguments.size),
                      .rounds = arguments.rounds,
                      .budget_ms = arguments.budget_ms,
                      .timeout = std::chrono::seconds(arguments.timeout_s)});
  });

  CLI::App* const golden = app.add_subcommand("golden", "draw the scenes of a golden file and compare their hashes");
  golden->add_option("file", arguments.golden_file, "lines of: scene WIDTHxHEIGHT hash")->required();
  golden->add_option("--driver", arguments.driver, "pineda, lavapipe or NAME=path.json")->capture_default_str();
  golden->add_flag("--update", arguments.update, "write the hashes instead of comparing them");
  golden->add_flag("--validate", arguments.validate, "run under the Khronos validation layer; any message fails");
  golden->callback([&] {
    status = check_golden(arguments.golden_file, parse_driver(arguments.driver), arguments.update, arguments.validate);
  });

  CLI::App* const errors = app.add_subcommand("errors", "measure the largest error of each function, beside what Vulkan allows");
  errors->add_option("--functions", arguments.functions, "only these (comma-separated; `pineda errors --list`)");
  errors->add_option("--columns", arguments.columns, "of fast, default, exact, lavapipe")->capture_default_str();
  errors->add_flag("--quick", arguments.quick,
                   "a structured sample instead of all 2^32 operands; writes nothing unless --out is given");
  errors
      ->add_option("--out", arguments.errors_file,
                   "Markdown file to write, with its data beside it (.json): rows measured before stay")
      ->capture_default_str();
  errors->add_flag("--list", arguments.list, "list the functions");
  errors->callback([&, errors] {
    status = measure_errors({.functions = arguments.functions,
                             .columns = arguments.columns,
                             .quick = arguments.quick,
                             .list = arguments.list,
                             .out = arguments.quick && errors->count("--out") == 0 ? "" : arguments.errors_file});
  });

  app.add_subcommand("scenes", "list the scenes")->callback([&] { status = list_scenes(); });
  app.add_subcommand("worker", "")->group("")->callback([&] { status = run_worker(); });  // started by the verbs above
}

int run(int argument_count, char** arguments_begin) {
  CLI::App app("Draws scenes with Vulkan drivers, compares their pictures and times them.", "pineda");
  app.require_subcommand(1);
  Arguments arguments;
  int status = 0;
  add_verbs(app, arguments, status);
  const auto is_given = [&](const CLI::App* verb) { return verb->check_name(arguments_begin[1]); };
  if (argument_count > 1 && arguments_begin[1][0] != '-' && app.get_subcommands(is_given).empty()) {
    fmt::print(stderr, "pineda: unknown verb '{}'; see pineda --help\n", arguments_begin[1]);
    return kUsageError;
  }
  try {
    app.parse(argument_count, arguments_begin);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kUsageError;
  } catch (const std::exception& error) {
    fmt::print(stderr, "pineda: {}\n", error.what());
    return kFailed;
  }
  return status;
}

}  // namespace
}  // namespace pineda::tools

int main(int argument_count, char** arguments) { return pineda::tools::run(argument_count, arguments); }
