// Rows that move texels: copies, blits, mip levels, clears; and what memcpy and memset take for as many bytes.
#pragma once

#include <vector>

#include "tools/bench/rows.h"

namespace pineda::tools {

void add_transfer_rows(std::vector<BenchRowInfo>& rows);

}  // namespace pineda::tools
