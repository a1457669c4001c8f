// Crash isolation: the cases run in child processes; a crash or a hang costs one case, not the run.
#pragma once

#include <chrono>
#include <map>
#include <string>
#include <vector>

namespace pineda::cts {

struct IsolationOptions {
  std::string program;                 // this binary
  std::vector<std::string> arguments;  // for the children, besides the filter
  std::chrono::seconds case_timeout{60};
  std::string manifest;    // the driver that the loader is pointed at; empty: as the environment says
  std::string junit_path;  // empty: none
};

struct Totals {
  int pass = 0, fail = 0, not_supported = 0;
};

struct Outcome {
  Totals all;
  std::map<std::string, Totals> groups;  // by the part of the name before the first dot of the case
};

// Runs the given cases ("group.case") in order and prints a line for each that fails. A child that dies or does not answer fails
// the case that it was at, and another child goes on behind it.
Outcome run_isolated(const std::vector<std::string>& cases, const IsolationOptions& options);

}  // namespace pineda::cts
