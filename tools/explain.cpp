#include "tools/explain.h"

#include <fmt/format.h>
#include <stdlib.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>
#include <vector>

#include "tools/driver_process.h"
#include "tools/driver_registry.h"
#include "tools/error.h"
#include "tools/scene_registry.h"
#include "tools/statistics.h"

namespace pineda::tools {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

struct Omission {
  const char *flags, *text;
};
constexpr Omission kOmissions[] = {
    {"", "as it is"},
    {"nohiz", "blocks behind others are shaded and tested one by one"},
    {"nofastclear", "every tile is opened, cleared and stored"},
    {"noopaque", "what lies under opaque covers is drawn"},
    {"noequal", "every sample has a colour of its own"},
    {"general", "texture state is looked up at run time, not compiled in"},
    {"nohiz,nofastclear,noopaque,noequal,general", "all of these"},
};

class ScratchFolder {
 public:
  ScratchFolder() {
    std::string name = (fs::temp_directory_path() / "pineda-explain-XXXXXX").string();
    if (!mkdtemp(name.data())) fail("{}: cannot be made", name);
    path_ = name;
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  ~ScratchFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

class Explainer {
 public:
  explicit Explainer(const ExplainOptions& options) : options_(options) {}

  std::string words() {
    const ScratchFolder folder;
    DriverSpec driver = parse_driver("pineda@PINEDA_DEBUG=explain");
    driver.environment.emplace_back("PINEDA_DEBUG_DIR", folder.path().string());
    const std::unique_ptr<DriverProcess> process = open(driver);
    render(*process, 1);
    process->request({{"command", "close"}}, options_.timeout);
    process->finish();
    std::ifstream file(folder.path() / "explain.txt");
    if (!file) fail("the driver explained nothing");
    std::ostringstream text;
    text << file.rdbuf();
    return text.str();
  }

  int table() {
    struct Variant {
      std::unique_ptr<DriverProcess> process;
      std::vector<double> frames_ms;
      std::string hash;
    };
    std::vector<Variant> variants;
    for (const Omission& omission : kOmissions) {
      const std::string flags = omission.flags;
      variants.push_back({open(parse_driver(flags.empty() ? "pineda" : "pineda@PINEDA_DEBUG=" + flags)), {}, {}});
    }
    for (uint32_t round = 0; round < options_.rounds; ++round) {
      for (Variant& variant : variants) {
        const json drawn = render(*variant.process, 1000);
        std::vector<double> frames_ms = drawn.at("frames_ms");
        const size_t warm_up = std::min<size_t>(frames_ms.size() - 1, 3);  // specialised kernels come from the third use on
        variant.frames_ms.insert(variant.frames_ms.end(), frames_ms.begin() + static_cast<ptrdiff_t>(warm_up), frames_ms.end());
        variant.hash = drawn.at("hash");
      }
    }
    bool differs = false;
    const double base_ms = median(variants[0].frames_ms);
    fmt::print("\n{:<12}{:>10}{:>9}  {:<10} {}\n", "off", "ms", "times", "bits", "what is done instead");
    for (size_t i = 0; i < variants.size(); ++i) {
      const double ms = median(variants[i].frames_ms);
      const bool same = variants[i].hash == variants[0].hash;
      differs |= !same;
      const bool all = i + 1 == variants.size();
      fmt::print("{:<12}{:>10.3f}{:>9.2f}  {:<10} {}\n",
                 i == 0 ? "nothing"
                 : all  ? "all"
                        : kOmissions[i].flags,
                 ms, ms / base_ms, same ? "the same" : "DIFFERENT", kOmissions[i].text);
    }
    return differs ? 1 : 0;
  }

 private:
  std::unique_ptr<DriverProcess> open(const DriverSpec& driver) {
    auto process = std::make_unique<DriverProcess>(driver);
    process->request({{"command", "open"}}, options_.timeout);
    return process;
  }

  json render(DriverProcess& process, uint32_t frames) {
    return process.request({{"command", "render"},
                            {"scene", options_.scene},
                            {"width", options_.size.width},
                            {"height", options_.size.height},
                            {"frames", frames},
                            {"budget_ms", options_.budget_ms}},
                           options_.timeout);
  }

  const ExplainOptions& options_;
};

}  // namespace

int explain(const ExplainOptions& options) {
  require_scene(options.scene);
  Explainer explainer(options);
  fmt::print("{}", explainer.words());
  return explainer.table();
}

}  // namespace pineda::tools
