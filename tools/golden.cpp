#include "tools/golden.h"

#include <fmt/format.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <vector>

#include "tools/driver_process.h"
#include "tools/error.h"
#include "tools/size.h"

namespace pineda::tools {
namespace {

using nlohmann::json;

constexpr std::chrono::seconds kTimeout{600};

struct Line {
  std::string text;  // as it is in the file; comments and blank lines have no scene
  std::string scene, hash;
  Size size;
};

std::vector<Line> read_lines(const std::string& path) {
  std::ifstream file(path);
  if (!file) fail("{}: cannot be read", path);
  std::vector<Line> lines;
  for (std::string text; std::getline(file, text);) {
    Line& line = lines.emplace_back();
    line.text = text;
    if (text.empty() || text[0] == '#') continue;
    std::istringstream words(text);
    std::string size;
    if (!(words >> line.scene >> size)) fail("{}: '{}' is not 'scene WIDTHxHEIGHT hash'", path, text);
    words >> line.hash;  // may be missing before the first update
    line.size = parse_size(size);
  }
  return lines;
}

}  // namespace

int check_golden(const std::string& path, const DriverSpec& driver, bool update, bool validate) {
  std::vector<Line> lines = read_lines(path);
  int passed = 0, failed = 0;
  DriverProcess process(driver);
  process.request({{"command", "open"}, {"validate", validate}}, kTimeout);
  for (Line& line : lines) {
    if (line.scene.empty()) continue;
    const json command{{"command", "render"}, {"scene", line.scene}, {"width", line.size.width}, {"height", line.size.height}};
    const std::string hash = process.request(command, kTimeout).at("hash");
    const bool equal = hash == line.hash;
    ++(equal ? passed : failed);
    if (!equal) fmt::print("{} {}x{}: {} instead of {}\n", line.scene, line.size.width, line.size.height, hash, line.hash);
    line.text = fmt::format("{} {}x{} {}", line.scene, line.size.width, line.size.height, hash);
  }
  const json messages = process.request({{"command", "close"}}, kTimeout).at("validation");
  if (const std::string output = process.finish(); !output.empty()) fmt::print("{}\n", output);
  for (const json& message : messages) fmt::print("validation: {}\n", message.get<std::string>());
  if (update) {
    std::ofstream file(path);
    for (const Line& line : lines) file << line.text << "\n";
    if (!file.flush()) fail("{}: cannot be written", path);
    fmt::print("{} hashes written to {}, {} of them changed\n", passed + failed, path, failed);
    return messages.empty() ? 0 : 1;
  }
  fmt::print("{} of {} hashes are equal\n", passed, passed + failed);
  return failed == 0 && messages.empty() ? 0 : 1;
}

}  // namespace pineda::tools
