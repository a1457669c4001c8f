// The report of a comparison: index.html (opens from disk, no network) and report.json beside the pictures.
#pragma once

#include <string>

#include "tools/compare.h"

namespace pineda::tools {

void write_report(const Comparison& comparison);  // throws ToolError when a file cannot be written
std::string report_html(const Comparison& comparison);
std::string report_json(const Comparison& comparison);

}  // namespace pineda::tools
