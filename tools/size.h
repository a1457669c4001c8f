#pragma once

#include <cstdint>
#include <string>

namespace pineda::tools {

struct Size {
  uint32_t width = 800, height = 600;
};

Size parse_size(const std::string& text);  // "WIDTHxHEIGHT", each 1 to 16384; throws ToolError

}  // namespace pineda::tools
