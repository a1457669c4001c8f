// Rows about latency: submission, and pipelines that no cache has seen.
#pragma once

#include <memory>

#include "tools/bench/rows.h"

namespace pineda::tools {

std::unique_ptr<BenchRow> make_empty_submit_row(VkContext& context, VkExtent2D);
// From vkCreateShaderModule to the first result, with a specialization constant that was never used before.
std::unique_ptr<BenchRow> make_cold_compute_row(VkContext& context, VkExtent2D);
std::unique_ptr<BenchRow> make_cold_graphics_row(VkContext& context, VkExtent2D extent);

}  // namespace pineda::tools
