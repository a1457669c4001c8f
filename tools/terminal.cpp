#include "tools/terminal.h"

#include <unistd.h>

#include <cstdio>

namespace pineda::tools {
namespace {
constexpr const char* kClearLine = "\r\033[2K";
}

Terminal::Terminal() : is_terminal_(isatty(STDERR_FILENO) != 0) {}

Terminal::~Terminal() {
  if (status_shown_) std::fputs(kClearLine, stderr);
}

void Terminal::status(const std::string& text) {
  if (!is_terminal_) return;
  std::fprintf(stderr, "%s%s", kClearLine, text.c_str());
  std::fflush(stderr);
  status_shown_ = true;
}

void Terminal::line(const std::string& text) {
  std::fprintf(stderr, "%s%s\n", status_shown_ ? kClearLine : "", text.c_str());
  status_shown_ = false;
}

}  // namespace pineda::tools
