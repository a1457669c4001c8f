// The work that `pineda bench` times. A row is prepared once in each driver's process and then sampled again and again.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "tools/vk/context.h"

namespace pineda::tools {

using MeanColour = std::array<double, 4>;  // of a picture, in units of 1/255

class BenchRow {
 public:
  virtual ~BenchRow() = default;
  // Of what the last sample drew, if it drew: no driver shall win a row by drawing something else.
  virtual std::optional<MeanColour> mean_colour() { return std::nullopt; }
  virtual double run_sample() = 0;  // milliseconds of one piece of work, submit and wait included
};

struct BenchRowInfo {
  std::string name;
  std::string description;
  VkExtent2D extent;
  std::function<std::unique_ptr<BenchRow>(VkContext&, VkExtent2D)> create;  // null: timed by the parent (start-up)
  bool disk_cache = false;  // the driver may keep its code on disk: the warm-up fills an empty directory
  bool in_mean = true;      // of the ratios: not what no driver does
};

std::span<const BenchRowInfo> bench_rows();
std::unique_ptr<BenchRow> create_bench_row(const std::string& name, VkContext& context, VkExtent2D extent);

}  // namespace pineda::tools
