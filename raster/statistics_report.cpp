#include "raster/statistics_report.h"

#include <algorithm>

namespace pineda::raster {
namespace {

struct Row {
  const char* name;
  uint64_t PassStatistics::*value;
};

constexpr Row kRows[] = {
#define PINEDA_STATISTIC(name, text) {#name, &PassStatistics::name},
#include "raster/statistics.inc"
};

void append(std::string& json, const char* name, uint64_t value) {
  if (json.back() != '{') json += ',';
  json += '"';
  json += name;
  json += "\":" + std::to_string(value);
}

}  // namespace

std::string statistics_text(const PassStatistics& statistics, std::span<const ThreadTimes> threads) {
  std::string text;
  for (const Row& row : kRows) {
    if (statistics.*row.value == 0) continue;
    if (!text.empty()) text += ", ";
    text += row.name;
    text += ' ' + std::to_string(statistics.*row.value);
  }
  for (size_t t = 0; t < threads.size(); ++t) {
    text += "; thread " + std::to_string(t) + ": geometry_ns " + std::to_string(threads[t].geometry_ns) + ", tiles_ns " +
            std::to_string(threads[t].tiles_ns);
  }
  return text;
}

std::string statistics_json(const PassStatistics& statistics, std::span<const DrawStatistics> draws,
                            std::span<const ThreadTimes> threads) {
  std::string json = "{";
  for (const Row& row : kRows) append(json, row.name, statistics.*row.value);
  json += ",\"per_draw\":[";
  for (const DrawStatistics& draw : draws) {
    if (json.back() != '[') json += ',';
    json += '{';
    append(json, "vertices_shaded", draw.vertices_shaded);
    append(json, "primitives_in", draw.primitives_in);
    append(json, "triangles_clipped", draw.triangles_clipped);
    append(json, "triangles_culled", draw.triangles_culled);
    append(json, "triangles_binned", draw.triangles_binned);
    append(json, "blocks_shaded", draw.blocks_shaded);
    json += '}';
  }
  json += "],\"per_thread\":[";
  for (const ThreadTimes& thread : threads) {
    if (json.back() != '[') json += ',';
    json += '{';
    append(json, "geometry_ns", thread.geometry_ns);
    append(json, "tiles_ns", thread.tiles_ns);
    json += '}';
  }
  return json + "]}";
}

std::string heat_map_pgm(uint32_t columns, uint32_t rows, std::span<const uint64_t> entries) {
  std::string picture = "P5 " + std::to_string(columns) + ' ' + std::to_string(rows) + " 255\n";
  const uint64_t most = std::max<uint64_t>(1, entries.empty() ? 1 : *std::ranges::max_element(entries));
  for (size_t i = 0; i < size_t{columns} * rows; ++i) {
    picture += static_cast<char>(i < entries.size() ? entries[i] * 255 / most : 0);
  }
  return picture;
}

}  // namespace pineda::raster
