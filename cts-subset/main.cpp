// pineda_cts: conformance-style tests of any Vulkan driver, through the loader (VK_DRIVER_FILES chooses it).
//
//   pineda_cts --gtest_filter='pipeline.blend.*'    in this process
//   pineda_cts --isolate --junit=out.xml            in child processes, so that a crash costs one case
//   pineda_cts --driver a=a.json --driver b=b.json  on several drivers, one column for each
//
// GoogleTest's own flags and environment (filter, sharding, repetition) work in both. Exit status 0: no case failed.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>

#include "cts-subset/groups/groups.h"
#include "cts-subset/harness/case.h"
#include "cts-subset/harness/device.h"
#include "cts-subset/harness/isolate.h"

namespace pineda::cts {
namespace {

// In a child: tells the parent each verdict as it falls, on the pipe that it was given.
class PipeReporter : public testing::EmptyTestEventListener {
 public:
  explicit PipeReporter(int fd) : fd_(fd) {}

  void OnTestEnd(const testing::TestInfo& info) override {
    const testing::TestResult& result = *info.result();
    std::string line = result.Skipped() ? "N" : result.Failed() ? "F" : "P";
    line += std::string(info.test_suite_name()) + "." + info.name();
    for (int i = 0; i < result.total_part_count(); ++i) {
      if (!result.GetTestPartResult(i).passed()) line += std::string("\t") + result.GetTestPartResult(i).message();
    }
    std::ranges::replace(line, '\n', ' ');
    line += "\n";
    if (write(fd_, line.data(), line.size()) != static_cast<ssize_t>(line.size())) _exit(3);
  }

 private:
  int fd_;
};

// The names that GoogleTest's filter and sharding leave, in order. Its listing knows the filter only; which of them are in this
// shard is decided as GoogleTest does it: every n-th, by number.
std::vector<std::string> selected_cases() {
  testing::internal::CaptureStdout();
  GTEST_FLAG_SET(list_tests, true);
  if (RUN_ALL_TESTS() != 0) return {};
  std::istringstream listing(testing::internal::GetCapturedStdout());
  const auto number = [](const char* variable, uint32_t otherwise) {
    const char* const text = getenv(variable);
    return text ? static_cast<uint32_t>(std::stoul(text)) : otherwise;
  };
  const uint32_t shards = std::max(1u, number("GTEST_TOTAL_SHARDS", 1)), shard = number("GTEST_SHARD_INDEX", 0);
  std::vector<std::string> cases;
  uint32_t count = 0;
  std::string line, group;
  while (std::getline(listing, line)) {
    if (line.starts_with("  ")) {
      if (count++ % shards == shard) cases.push_back(group + line.substr(2));
    } else {
      group = line;  // ends with a dot
    }
  }
  return cases;
}

struct Driver {
  std::string name, manifest, junit_path;
};

// Runs the cases on each driver and prints a row for each group, a column for each driver.
int run_in_children(const std::vector<Driver>& drivers, IsolationOptions options) {
  const std::vector<std::string> cases = selected_cases();
  std::vector<Outcome> outcomes;
  std::string heading = fmt::format("{:<28}", "Pass / Fail / NotSupported"), all = fmt::format("{:<28}", "all");
  bool failed = cases.empty();
  const auto column = [](const Totals& t) { return fmt::format("{:>7} /{:>5} /{:>5}", t.pass, t.fail, t.not_supported); };
  for (const Driver& driver : drivers) {
    if (drivers.size() > 1) fmt::print("{}:\n", driver.name);
    options.manifest = driver.manifest;
    options.junit_path = driver.junit_path;
    outcomes.push_back(run_isolated(cases, options));
    heading += fmt::format("{:>21}", driver.name);
    all += column(outcomes.back().all);
    failed |= &driver == drivers.data() && outcomes.back().all.fail != 0;
  }
  fmt::print("{}\n", heading);
  for (const auto& [group, totals] : outcomes[0].groups) {
    std::string line = fmt::format("{:<28}", group);
    for (const Outcome& outcome : outcomes) line += column(outcome.groups.contains(group) ? outcome.groups.at(group) : Totals{});
    fmt::print("{}\n", line);
  }
  fmt::print("{}\n", all);
  return failed ? 1 : 0;
}

int run_as_child(const std::string& list_path, int report_fd) {
  std::ifstream list(list_path);
  std::string filter, name;
  while (std::getline(list, name)) filter += (filter.empty() ? "" : ":") + name;
  GTEST_FLAG_SET(filter, filter);
  for (const char* applied : {"GTEST_TOTAL_SHARDS", "GTEST_SHARD_INDEX"}) unsetenv(applied);  // by the parent
  auto& listeners = testing::UnitTest::GetInstance()->listeners();
  delete listeners.Release(listeners.default_result_printer());
  listeners.Append(new PipeReporter(report_fd));
  return RUN_ALL_TESTS();
}

}  // namespace
}  // namespace pineda::cts

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  CLI::App app("Conformance-style tests of the Vulkan driver that the loader finds");
  bool isolate = false, self_test = false;
  uint32_t case_timeout_s = 60;
  std::string junit_path, child_list;
  std::vector<std::string> named_drivers;
  int child_report = -1;
  app.add_flag("--isolate", isolate, "run the cases in child processes: a crash or a hang costs one case");
  app.add_option("--junit", junit_path, "with --isolate: write a JUnit file");
  app.add_option("--driver", named_drivers,
                 "NAME=MANIFEST, repeated: isolate, on each of these; NAME.xml is written, exit status of the first");
  app.add_option("--case-timeout", case_timeout_s, "seconds after which a case of a child process has failed")
      ->capture_default_str();
  app.add_flag("--self-test", self_test, "cases that pass, fail, crash and hang on purpose, in place of all others");
  app.add_option("--child-list", child_list)->group("");
  app.add_option("--child-report", child_report)->group("");
  CLI11_PARSE(app, argc, argv);
  if (self_test) {
    pineda::cts::register_self_test();
  } else {
    pineda::cts::register_all_groups();
  }
  int status;
  if (!child_list.empty()) {
    status = pineda::cts::run_as_child(child_list, child_report);
  } else if (isolate || !named_drivers.empty()) {
    std::vector<pineda::cts::Driver> drivers;
    for (const std::string& named : named_drivers) {
      const size_t equals = named.find('=');
      const std::string name = named.substr(0, equals), manifest = equals == std::string::npos ? "" : named.substr(equals + 1);
      drivers.push_back({name, manifest, name + ".xml"});
    }
    if (drivers.empty()) drivers.push_back({"driver", "", junit_path});
    pineda::cts::IsolationOptions options;
    options.program = "/proc/self/exe";
    options.case_timeout = std::chrono::seconds(case_timeout_s);
    if (self_test) options.arguments.push_back("--self-test");
    status = pineda::cts::run_in_children(drivers, options);
  } else {
    status = RUN_ALL_TESTS();
  }
  pineda::cts::discard_shared_device();
  return status;
}
