#include "base/config.h"

#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <string_view>

namespace pineda {
namespace {

struct FlagRow {
  const char* name;
  DebugFlag flag;
  const char* help;
};

// The one table of PINEDA_DEBUG flags: parsing and help derive from it.
constexpr FlagRow kFlags[] = {
    {"ir", kDebugIr, "print each kernel's IR after all passes"},
    {"llvm", kDebugLlvm, "print each kernel's LLVM IR"},
    {"asm", kDebugAsm, "print each kernel's machine code"},
    {"time", kDebugTime, "print how long each kernel took to compile"},
    {"perf", kDebugPerf, "name kernels for perf, in /tmp/perf-PID.map"},
    {"general", kDebugGeneral, "never specialise pipelines for the textures that are bound (same bits)"},
    {"specialize", kDebugSpecialize, "specialise pipelines for their textures before the first draw (same bits)"},
    {"api", kDebugApi, "print messages of level info too"},
    {"stats", kDebugStats, "print statistics of each render pass"},
    {"explain", kDebugExplain, "tell what was left out of each pipeline, pass and dispatch; in explain.txt in PINEDA_DEBUG_DIR"},
    {"heatmap", kDebugHeatMap, "a picture of each pass's bins, a pixel a tile: bins-N.pgm in PINEDA_DEBUG_DIR or here"},
    {"nohiz", kDebugNoHiZ, "no hierarchical depth rejection (same bits)"},
    {"nofastclear", kDebugNoFastClear, "no clears as tile state (same bits)"},
    {"noopaque", kDebugNoOpaque, "opaque covers drop nothing (same bits)"},
    {"noequal", kDebugNoEqualSamples, "every sample has its own colour, even where all are equal (same bits)"},
    {"nooutside", kDebugNoOutside, "batches of triangles that cannot be seen do not leave after their positions (same bits)"},
    {"nomissed", kDebugNoMissed, "small triangles that no sample sees are set up and binned (same bits)"},
    {"nolazy", kDebugNoLazy, "loads and stores of tiles that the pass does not want are done (same bits)"},
    {"nooverlap", kDebugNoOverlap, "no render pass runs beside another (same bits)"},
    {"nounread", kDebugNoUnread, "vertex outputs that no fragment shader reads are kept (same bits)"},
};

std::string text(const char* name) {
  const char* value = std::getenv(name);
  return value ? value : "";
}

void bad_value(const char* name, std::string_view value, const char* expected) {
  std::fprintf(stderr, "pineda: %s=%.*s is ignored: expected %s\n", name, static_cast<int>(value.size()), value.data(), expected);
}

uint32_t number(const char* name, uint32_t max) {
  std::string value = text(name);
  if (value.empty()) return 0;
  uint32_t n = 0;
  auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), n);
  if (error == std::errc() && end == value.data() + value.size() && n >= 1 && n <= max) return n;
  bad_value(name, value, ("a number from 1 to " + std::to_string(max)).c_str());
  return 0;
}

// Index of the variable's value in `names`; 0, the default, when it is unset or wrong.
template <size_t N>
size_t choice(const char* name, const char* const (&names)[N], const char* expected) {
  std::string value = text(name);
  if (value.empty()) return 0;
  for (size_t i = 0; i < N; ++i) {
    if (value == names[i]) return i;
  }
  bad_value(name, value, expected);
  return 0;
}

void print_help() {
  std::fprintf(
      stderr,
      "Pineda's environment:\n"
      "  PINEDA_THREADS=N                        threads, the caller's included (default: one per core)\n"
      "  PINEDA_ISA=sse42|avx2|avx512            instruction set (default: the best that the CPU has; same bits)\n"
      "  PINEDA_MODE=jit|f32|f64|check           machine code; evaluator; evaluator in double precision; both, compared\n"
      "  PINEDA_PRECISION=fast|default|exact     transcendental functions: within Vulkan's demands; within a few ULP; correctly\n"
      "                                          rounded but for ties (docs/errors.md has the measured error of each)\n"
      "  PINEDA_TILE=16|32|64                    tile size in pixels (default: from the attachments' footprint; same bits)\n"
      "  PINEDA_TIMEOUT=N|off                    seconds that a submission may run before the device is lost (default: 120)\n"
      "  PINEDA_CACHE=off|DIR                    where compiled kernels are kept (default: $XDG_CACHE_HOME/pineda, "
      "~/.cache/pineda)\n"
      "  PINEDA_STATS=FILE                       append statistics of each render pass and its draws, a line of JSON each\n"
      "  PINEDA_TRACE=FILE                       write what threads do when, for chrome://tracing and Perfetto\n"
      "  PINEDA_DEBUG_DIR=DIR                    dumps go to files in DIR\n"
      "  PINEDA_DEBUG=flag,flag...\n");
  for (const FlagRow& row : kFlags) std::fprintf(stderr, "      %-12s %s\n", row.name, row.help);
}

uint32_t parse_debug(std::string_view list) {
  uint32_t flags = 0;
  while (!list.empty()) {
    size_t comma = list.find(',');
    std::string_view word = list.substr(0, comma);
    list = comma == std::string_view::npos ? "" : list.substr(comma + 1);
    if (word.empty()) continue;
    bool known = false;
    for (const FlagRow& row : kFlags) {
      if (word == row.name) flags |= row.flag, known = true;
    }
    if (word == "help") {
      print_help();
    } else if (!known) {
      bad_value("PINEDA_DEBUG", word, "a flag from PINEDA_DEBUG=help");
    }
  }
  return flags;
}

Config read_environment() {
  Config c;
  c.threads = number("PINEDA_THREADS", 256);
  c.isa = text("PINEDA_ISA");
  c.mode = static_cast<Mode>(choice("PINEDA_MODE", {"jit", "f32", "f64", "check"}, "jit, f32, f64 or check"));
  c.precision = static_cast<Precision>(choice("PINEDA_PRECISION", {"default", "fast", "exact"}, "fast, default or exact"));
  constexpr uint32_t kTiles[] = {0, 16, 32, 64};
  c.tile_px = kTiles[choice("PINEDA_TILE", {"", "16", "32", "64"}, "16, 32 or 64")];
  // The evaluator takes a thousand times as long, so it has no limit that nobody asked for.
  constexpr uint32_t kDefaultTimeout_s = 120;
  const bool unlimited = text("PINEDA_TIMEOUT") == "off";
  c.timeout_s = unlimited ? 0 : number("PINEDA_TIMEOUT", 86400);
  if (text("PINEDA_TIMEOUT").empty() && c.mode == Mode::kJit) c.timeout_s = kDefaultTimeout_s;
  c.cache = text("PINEDA_CACHE");
  c.debug = parse_debug(text("PINEDA_DEBUG"));
  c.stats_file = text("PINEDA_STATS");
  c.trace_file = text("PINEDA_TRACE");
  c.debug_dir = text("PINEDA_DEBUG_DIR");
  return c;
}

}  // namespace

const Config& config() {
  static const Config kConfig = read_environment();
  return kConfig;
}

}  // namespace pineda
