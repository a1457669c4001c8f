// The parent's side of a worker: one child process with one driver, asked in JSON lines (worker.h has the commands).
#pragma once

#include <chrono>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "tools/child_process.h"
#include "tools/driver_registry.h"

namespace pineda::tools {

using Progress = std::function<void(const std::string&)>;

class DriverProcess {
 public:
  explicit DriverProcess(const DriverSpec& driver);

  // Sends a command and waits for its result. Throws ToolError, with the driver's name and its last words, when the driver
  // reports an error, dies, or says nothing for `timeout` (then it is ended).
  nlohmann::json request(const nlohmann::json& command, std::chrono::milliseconds timeout, const Progress& progress = {});

  // The two halves of request(), for work that the parent does meanwhile.
  void send(const nlohmann::json& command);
  nlohmann::json receive(std::chrono::milliseconds timeout, const Progress& progress = {});

  // Lets the process end and returns what the driver printed. Throws ToolError when it does not end well.
  std::string finish();

 private:
  [[noreturn]] void fail_with(const std::string& reason);

  std::string label_;
  ChildProcess child_;
};

}  // namespace pineda::tools
