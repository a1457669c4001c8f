// Rows that time one compute shader over storage buffers. Each checks its result against the CPU before it is timed.
#pragma once

#include <memory>

#include "tools/bench/rows.h"

namespace pineda::tools {

std::unique_ptr<BenchRow> make_sgemm_row(VkContext& context, VkExtent2D);
std::unique_ptr<BenchRow> make_transcendentals_row(VkContext& context, VkExtent2D);
std::unique_ptr<BenchRow> make_histogram_row(VkContext& context, VkExtent2D);
std::unique_ptr<BenchRow> make_reduce_row(VkContext& context, VkExtent2D);
std::unique_ptr<BenchRow> make_scan_row(VkContext& context, VkExtent2D);

}  // namespace pineda::tools
