#include "raster/options.h"

#include <algorithm>

#include "base/config.h"

namespace pineda::raster {

Options default_options() {
  Options options;
  const uint32_t tile_px = config().tile_px;
  if (tile_px == 16 || tile_px == 32 || tile_px == 64) options.tile_px = tile_px;
  options.hi_z = !debug(kDebugNoHiZ);
  options.fast_clear = !debug(kDebugNoFastClear);
  options.equal_samples = !debug(kDebugNoEqualSamples);
  options.opaque = !debug(kDebugNoOpaque);
  options.outside_batches = !debug(kDebugNoOutside);
  options.missed_triangles = !debug(kDebugNoMissed);
  options.lazy_memory = !debug(kDebugNoLazy);
  options.overlap = !debug(kDebugNoOverlap);
  options.timing = options.per_draw = debug(kDebugStats) || !config().stats_file.empty();
  options.heat_map = debug(kDebugHeatMap);
  options.isa = isa_from_name(config().isa);
  return options;
}

Isa best_isa() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq")) return Isa::kAvx512;
  if (__builtin_cpu_supports("avx2")) return Isa::kAvx2;
#endif
  return Isa::kSse42;
}

Isa isa_from_name(const std::string& name) {
  const Isa best = best_isa();
  if (name == "sse42") return Isa::kSse42;
  if (name == "avx2") return std::min(best, Isa::kAvx2);
  return best;
}

}  // namespace pineda::raster
