// What the environment asks for, read once per process. The one table of debug flags is in config.cpp; PINEDA_DEBUG=help prints
// it.
#pragma once

#include <cstdint>
#include <string>

namespace pineda {

enum class Mode : uint8_t { kJit, kF32, kF64, kCheck };

// Which algorithms passes/lower_math chooses; docs/errors.md has the error of each.
enum class Precision : uint8_t { kDefault, kFast, kExact };

enum DebugFlag : uint32_t {
  kDebugIr = 1u << 0,     // final IR of each kernel
  kDebugLlvm = 1u << 1,   // LLVM IR
  kDebugAsm = 1u << 2,    // machine code
  kDebugApi = 1u << 3,    // messages of level info
  kDebugStats = 1u << 4,  // statistics of each render pass
  kDebugNoHiZ = 1u << 5,  // switch one omission off (same bits)
  kDebugNoFastClear = 1u << 6,
  kDebugNoOpaque = 1u << 7,         // opaque covers drop nothing
  kDebugTime = 1u << 8,             // compile times
  kDebugPerf = 1u << 9,             // names of kernels for perf
  kDebugGeneral = 1u << 10,         // pipelines are never specialised for what is bound (same bits)
  kDebugSpecialize = 1u << 11,      // pipelines are specialised before their first draw
  kDebugNoEqualSamples = 1u << 12,  // every sample has its own colour
  kDebugExplain = 1u << 13,         // what was left out, in words
  kDebugNoOutside = 1u << 17,       // batches that cannot be seen go on after their positions
  kDebugNoMissed = 1u << 14,        // small triangles that no sample sees are set up and binned
  kDebugNoLazy = 1u << 15,          // loads and stores that the pass does not want are done
  kDebugNoUnread = 1u << 16,        // vertex outputs that no fragment shader reads are computed and stored
  kDebugNoOverlap = 1u << 18,       // no pass runs beside another
  kDebugHeatMap = 1u << 20,         // a picture of each pass's bins
};

struct Config {
  uint32_t threads = 0;                       // PINEDA_THREADS; 0 = one per core
  std::string isa;                            // PINEDA_ISA; empty = best
  Mode mode = Mode::kJit;                     // PINEDA_MODE=jit|f32|f64|check
  Precision precision = Precision::kDefault;  // PINEDA_PRECISION=fast|default|exact
  uint32_t tile_px = 0;                       // PINEDA_TILE=16|32|64; 0 = chosen from the footprint of the attachments
  uint32_t timeout_s = 0;                     // PINEDA_TIMEOUT: seconds that a submission may run; 0 = no limit
  std::string cache;                          // PINEDA_CACHE=off|DIR; empty = the user's cache directory
  uint32_t debug = 0;                         // DebugFlag bits
  std::string stats_file;                     // PINEDA_STATS: statistics of each pass, a line of JSON each; empty = none
  std::string trace_file;  // PINEDA_TRACE: what threads do when, for chrome://tracing and Perfetto; empty = none
  std::string debug_dir;   // PINEDA_DEBUG_DIR: dumps go to files there, otherwise to stderr
};

const Config& config();
inline bool debug(DebugFlag flag) { return (config().debug & flag) != 0; }

}  // namespace pineda
