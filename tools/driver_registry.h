// Which Vulkan drivers can be compared, and what environment makes the loader take exactly one of them.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace pineda::tools {

struct DriverSpec {
  std::string label;                                             // as the user wrote it, e.g. "pineda@PINEDA_ISA=sse42"
  std::string name;                                              // "pineda", "lavapipe", or the NAME of NAME=path.json
  std::string manifest_path;                                     // the driver's JSON file
  std::vector<std::pair<std::string, std::string>> environment;  // for the child process

  std::string file_stem() const;  // the label, fit for a file name
};

// Reads one driver: `pineda`, `lavapipe` or NAME=path.json, then any number of @VARIABLE=value for its environment.
// Throws ToolError when it is unknown or its manifest does not exist.
DriverSpec parse_driver(const std::string& text);
std::vector<DriverSpec> parse_drivers(const std::string& comma_separated);

}  // namespace pineda::tools
