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
    {"nooutside", "vertices outside of the picture are shaded and set up"},
    {"nomissed", "small triangles that no sample sees go to the tiles"},
    {"nolazy", "every tile is loaded and stored, wanted or not"},
    {"nounread", "vertex outputs that no fragment shader reads are computed"},
    {"general", "texture state is looked up at run time, not compiled in"},
};

constexpr uint32_t kWarmUpFrames = 3;

std::string all_flags() {
  std::string all;
  for (const Omission& omission : kOmissions) {
    if (*omission.flags) all += (all.empty() ? "" : ",") + std::string(omission.flags);
  }
  return all;
}

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

  // All variants in turn, round after round, each round from another place on, so that what else the machine does meets all
  // alike. A variant's time is compared with the one of the same round in which nothing is off; the median of these ratios
  // counts.
  int table() {
    std::vector<Variant> variants;
    for (const Omission& omission : kOmissions) add_variant(variants, omission.flags, omission.text);
    add_variant(variants, all_flags(), "all of these");
    variants.front().name = "nothing";
    variants.back().name = "all";
    for (Variant& variant : variants) render(*variant.process, kWarmUpFrames);  // specialised kernels come from the third use on
    for (uint32_t round = 0; round < options_.rounds; ++round) {
      for (size_t i = 0; i < variants.size(); ++i) run_turn(variants[(i + round) % variants.size()]);
    }
    fmt::print(
        "\nWhat each omission saves: the scene with it switched off, median of {} turns; least and most of a turn in "
        "brackets\n{:<12}{:>10}{:>9}{:>17}  {:<10} {}\n",
        options_.rounds, "off", "ms", "times", "", "bits", "what is done instead");
    bool differs = false;
    for (const Variant& variant : variants) differs |= print(variant, variants.front());
    return differs ? 1 : 0;
  }

 private:
  struct Variant {
    std::string name, text;
    std::unique_ptr<DriverProcess> process;
    std::vector<double> turns_ms;  // the median frame of each
    std::string hash;
  };

  void add_variant(std::vector<Variant>& variants, const std::string& flags, const char* text) {
    const std::string driver = flags.empty() ? "pineda" : "pineda@PINEDA_DEBUG=" + flags;
    variants.push_back({flags, text, open(parse_driver(driver)), {}, {}});
  }

  void run_turn(Variant& variant) {
    const json drawn = render(*variant.process, 1000);
    std::vector<double> frames_ms = drawn.at("frames_ms");
    const size_t warm_up = std::min<size_t>(frames_ms.size() - 1, kWarmUpFrames);
    frames_ms.erase(frames_ms.begin(), frames_ms.begin() + static_cast<ptrdiff_t>(warm_up));
    variant.turns_ms.push_back(median(frames_ms));
    variant.hash = drawn.at("hash");
  }

  // Whether its bits differ.
  static bool print(const Variant& variant, const Variant& base) {
    std::vector<double> ratios;
    for (size_t i = 0; i < variant.turns_ms.size(); ++i) ratios.push_back(variant.turns_ms[i] / base.turns_ms[i]);
    const bool same = variant.hash == base.hash;
    fmt::print("{:<12}{:>10.3f}{:>9.2f}{:>17}  {:<10} {}\n", variant.name, median(variant.turns_ms), median(ratios),
               fmt::format("({:.2f} - {:.2f})", quantile(ratios, 0), quantile(ratios, 1)), same ? "the same" : "DIFFERENT",
               variant.text);
    return !same;
  }

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
