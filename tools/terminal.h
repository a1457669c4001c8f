// Progress on stderr: a status line that rewrites itself on a terminal, plain lines elsewhere.
#pragma once

#include <string>

namespace pineda::tools {

class Terminal {
 public:
  Terminal();
  ~Terminal();
  void status(const std::string& text);  // transient; shown on a terminal only
  void line(const std::string& text);    // stays
 private:
  bool is_terminal_;
  bool status_shown_ = false;
};

}  // namespace pineda::tools
