// docs/errors.md and the data it is made from, which keep the rows of earlier runs.
#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string>

#include "tools/errors/measure.h"

namespace pineda::tools {

struct ErrorColumn {
  const char* name;
  const char* driver;  // for parse_driver
};
std::span<const ErrorColumn> error_columns();

class ErrorTable {
 public:
  explicit ErrorTable(const std::string& markdown_path);  // empty: write() does nothing
  void set(const MeasuredFunction& function, const std::string& column, const std::string& device, bool exhaustive,
           const Measurement& m);
  void write() const;

 private:
  std::string markdown() const;
  std::string row(const MeasuredFunction& function) const;

  std::string path_, data_path_;
  nlohmann::json data_;  // function -> column -> cell
};

}  // namespace pineda::tools
