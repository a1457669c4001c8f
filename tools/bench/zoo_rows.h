// Rows that create many different pipelines and use each once: cold, and warm from the two caches.
#pragma once

#include "tools/bench/rows.h"

namespace pineda::tools {

enum class ZooStage { kGraphics, kCompute };
enum class ZooCache { kNone, kPipelineCache };

// Milliseconds of all the pipelines of tools/bench/zoo, created one by one and then used by one submit. A cache on disk is a
// matter of the process's environment (BenchRowInfo::disk_cache).
std::unique_ptr<BenchRow> make_zoo_row(VkContext& context, ZooStage stage, ZooCache cache);

}  // namespace pineda::tools
