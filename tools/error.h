// Failure inside the `pineda` command. The command is an application: a Vulkan call or a file that fails unwinds to the one place
// that reports it (main, or the worker's command loop). Exceptions never cross a process or a library boundary.
#pragma once

#include <fmt/format.h>

#include <stdexcept>
#include <string>
#include <utility>

namespace pineda::tools {

class ToolError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

template <typename... Args>
[[noreturn]] void fail(fmt::format_string<Args...> format, Args&&... args) {
  throw ToolError(fmt::format(format, std::forward<Args>(args)...));
}

}  // namespace pineda::tools
