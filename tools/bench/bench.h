// `pineda bench`: times the rows on several drivers in turn, A B A B, and compares the medians.
#pragma once

#include <string>
#include <vector>

#include "tools/driver_registry.h"

namespace pineda::tools {

struct BenchOptions {
  std::vector<DriverSpec> drivers;  // the last one is what the others are compared with
  std::string filter;               // rows whose name contains one of these, separated by commas; empty: all
  uint32_t rounds = 5;
  double budget_ms = 200;  // of one driver in one round of one row
  std::string json_path;   // empty: none
};

int bench(const BenchOptions& options);  // the exit status: 0 when every row ran on every driver
void list_bench_rows();

}  // namespace pineda::tools
