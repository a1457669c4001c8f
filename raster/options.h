// What tests vary and users set by environment: none of it may change a bit of any result.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace pineda::raster {

// The instruction set that coverage uses.
enum class Isa { kSse42, kAvx2, kAvx512 };
Isa best_isa();                              // of this processor
Isa isa_from_name(const std::string& name);  // "sse42", "avx2", "avx512"; anything else: the best; never above best_isa()

// One of the copies of a function.
template <class T>
T for_isa(Isa isa, T sse42, T avx2, T avx512) {
  return isa == Isa::kAvx512 ? avx512 : isa == Isa::kAvx2 ? avx2 : sse42;
}

struct Options {
  uint32_t tile_px = 0;                        // 16, 32 or 64; 0: chosen from the attachments
  bool hi_z = true;                            // reject blocks by a conservative depth range
  bool fast_clear = true;                      // fill untouched tiles straight in memory
  bool equal_samples = true;                   // keep the colours of a block once while its samples are equal
  bool opaque = true;                          // opaque full-tile covers drop what lies under them
  bool outside_batches = true;                 // triangles of a batch that cannot be seen leave after their positions
  bool missed_triangles = true;                // small triangles that no sample sees are not set up
  bool lazy_memory = true;                     // loads and stores that the pass does not want are left out
  bool overlap = true;                         // short passes wait, to run beside others
  size_t bin_budget_bytes = size_t{96} << 20;  // geometry kept between flushes
  uint32_t chunk_prims = 4096;                 // primitives that one geometry job takes
  size_t max_chunk_entries = 1 << 20;          // bin entries after which a chunk is cut: 4 MiB
  bool timing = false;                         // fill PassStatistics' times
  bool per_draw = false;                       // gather DrawStatistics
  bool heat_map = false;                       // gather bin entries by tile
  Isa isa = Isa::kSse42;
};

// From base/config.h.
Options default_options();

}  // namespace pineda::raster
