// What a pass counted, for people (text) and programs (JSON, a picture of the bins).
#pragma once

#include <span>
#include <string>

#include "raster/binner.h"
#include "raster/raster.h"

namespace pineda::raster {

// Only what is not 0; one line.
std::string statistics_text(const PassStatistics& statistics, std::span<const ThreadTimes> threads);

// One object: every count by name, "per_draw", an array in API order, and "per_thread", the times of each.
std::string statistics_json(const PassStatistics& statistics, std::span<const DrawStatistics> draws,
                            std::span<const ThreadTimes> threads);

// A binary PGM picture, one pixel a tile: 255 for the tile with the most bin entries.
std::string heat_map_pgm(uint32_t columns, uint32_t rows, std::span<const uint64_t> entries);

}  // namespace pineda::raster
