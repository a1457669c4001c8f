// A child process that is spoken to in lines: it reads them from descriptor 3 and writes them to descriptor 4. What it prints is
// kept, to be shown when it dies.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace pineda::tools {

inline constexpr int kCommandFd = 3, kReplyFd = 4;

using Environment = std::vector<std::pair<std::string, std::string>>;  // added to the own environment, replacing equal names

class ChildProcess {
 public:
  ChildProcess(const std::vector<std::string>& arguments, const Environment& environment);  // throws ToolError
  ~ChildProcess();  // closes the pipes; ends the child if it does not end by itself
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  enum class Status { kLine, kTimeout, kClosed };
  bool write_line(const std::string& line);  // false when the child is gone
  Status read_line(std::string& line, std::chrono::milliseconds timeout);

  // Closes the child's input and waits for its end, by force when it takes too long. Nothing for a good end, else a description.
  std::optional<std::string> finish();
  void kill();
  std::string wait_and_describe();  // e.g. "was killed by signal 11 (Segmentation fault)"
  std::string last_output() const;  // the end of what it printed to stdout and stderr

 private:
  pid_t pid_ = -1;
  int command_fd_ = -1, reply_fd_ = -1, output_fd_ = -1;
  std::optional<int> status_;
  std::string pending_;  // read, but not a whole line yet
};

}  // namespace pineda::tools
