// `pineda errors`: the largest error of each function, for each precision of Pineda and for lavapipe on the same SPIR-V, beside
// what Vulkan allows.
#pragma once

#include <string>

namespace pineda::tools {

struct ErrorsOptions {
  std::string functions;  // comma-separated names; empty: all
  std::string columns;    // comma-separated
  bool quick = false, list = false;
  std::string out;  // Markdown file; empty: none
};

// 0 when every row of Pineda is within what Vulkan allows. Throws ToolError.
int measure_errors(const ErrorsOptions& options);

}  // namespace pineda::tools
