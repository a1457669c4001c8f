// Rows about compute throughput.
#pragma once

#include <memory>

#include "tools/bench/rows.h"

namespace pineda::tools {

std::unique_ptr<BenchRow> make_saxpy_row(VkContext& context, VkExtent2D);

}  // namespace pineda::tools
