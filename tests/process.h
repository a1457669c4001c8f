// Runs a command with environment variables of its own and keeps what it prints.
#pragma once

#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <string>

namespace pineda::tests {

struct ProcessResult {
  int exit_status = -1;  // 128 + signal when a signal ended it
  std::string output;    // stdout and stderr, interleaved
};

// `command` is a shell command line, assignments first: "PINEDA_ISA=avx2 build/pineda render ...".
inline ProcessResult run_process(const std::string& command) {
  ProcessResult result;
  FILE* pipe = popen((command + " 2>&1").c_str(), "r");
  if (!pipe) return result;
  std::array<char, 4096> buffer;
  while (size_t n = fread(buffer.data(), 1, buffer.size(), pipe)) result.output.append(buffer.data(), n);
  int status = pclose(pipe);
  result.exit_status = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return result;
}

// The path of this program, to run it once more with another environment.
inline std::string own_program() {
  char path[4096];
  const ssize_t length = readlink("/proc/self/exe", path, sizeof(path));
  return length > 0 ? std::string(path, size_t(length)) : std::string();
}

}  // namespace pineda::tests
