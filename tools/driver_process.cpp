#include "tools/driver_process.h"

#include <filesystem>
#include <nlohmann/json.hpp>

#include "tools/error.h"

namespace pineda::tools {
namespace {

using nlohmann::json;

std::string own_path() { return std::filesystem::read_symlink("/proc/self/exe").string(); }

}  // namespace

DriverProcess::DriverProcess(const DriverSpec& driver)
    : label_(driver.label), child_({own_path(), "worker"}, driver.environment) {}

json DriverProcess::request(const json& command, std::chrono::milliseconds timeout, const Progress& progress) {
  send(command);
  return receive(timeout, progress);
}

void DriverProcess::send(const json& command) {
  if (!child_.write_line(command.dump())) fail_with("the driver's process " + child_.wait_and_describe());
}

json DriverProcess::receive(std::chrono::milliseconds timeout, const Progress& progress) {
  std::string line;
  for (;;) {
    switch (child_.read_line(line, timeout)) {
      case ChildProcess::Status::kTimeout:
        child_.kill();
        child_.wait_and_describe();
        fail_with(fmt::format("said nothing for {:.0f} s and was ended", std::chrono::duration<double>(timeout).count()));
      case ChildProcess::Status::kClosed:
        fail_with("the driver's process " + child_.wait_and_describe());
      case ChildProcess::Status::kLine:
        break;
    }
    const json reply = json::parse(line, nullptr, false);
    if (reply.is_discarded() || !reply.is_object()) fail_with("sent a reply that is no JSON object");
    const std::string type = reply.value("type", "");
    if (type == "result") return reply;
    if (type == "error") fail_with(reply.value("message", "unknown error"));
    if (type == "progress" && progress) progress(reply.value("text", ""));
  }
}

std::string DriverProcess::finish() {
  if (const auto failure = child_.finish()) fail_with("at its end, the driver's process " + *failure);
  return child_.last_output();
}

void DriverProcess::fail_with(const std::string& reason) {
  const std::string output = child_.last_output();
  fail("{}: {}{}{}", label_, reason, output.empty() ? "" : "\n  its last output: ", output);
}

}  // namespace pineda::tools
