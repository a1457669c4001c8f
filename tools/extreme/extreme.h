// `pineda report --extreme`: what drivers do where numbers are stiff, huge, tiny or undefined. Each case knows what a correct
// implementation gives, and from where: the specification, exact arithmetic, or a published value.
#pragma once

#include <chrono>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "tools/driver_registry.h"
#include "tools/image.h"

namespace pineda::tools {

class ExtremeRig;
class VkContext;

enum class Verdict { kExact, kWithin, kWrong, kNotSupported };
const char* verdict_name(Verdict verdict);

struct Outcome {
  Verdict verdict = Verdict::kNotSupported;
  std::string measured, truth;  // side by side, in few words
  std::string bound;            // what makes the verdict "within"
  std::string bytes;            // everything the driver computed: must be the same on every ISA path of Pineda
  std::vector<std::pair<std::string, Image>> pictures;  // with their captions
};

struct ExtremeCase {
  const char *group, *name;
  const char* statement;  // what is done, and what a correct implementation gives
  const char* source;     // where that is from
  Outcome (*run)(ExtremeRig& rig);
};

std::span<const ExtremeCase> geometry_cases();
std::span<const ExtremeCase> depth_cases();
std::span<const ExtremeCase> interpolation_cases();
std::span<const ExtremeCase> blending_cases();
std::span<const ExtremeCase> stiff_cases();
std::span<const ExtremeCase> integer_cases();
std::vector<ExtremeCase> extreme_cases();  // all of them

// The worker's command {"command": "extreme_run", "case": index, "pictures": folder and file name's beginning, or ""}
// -> verdict, measured, truth, bound, hash, pictures[{caption, file}]
nlohmann::json run_extreme_case(VkContext& context, const nlohmann::json& command);

struct ExtremeOptions {
  std::vector<DriverSpec> drivers;   // columns; the first is Pineda
  std::vector<DriverSpec> variants;  // Pineda on other ISA paths, whose bits must be those of the first driver
  std::string filter;                // only cases whose group or name contains it
  std::string out_dir;               // for extreme.html, extreme.json and pictures; empty: the table only
  std::chrono::seconds timeout{120};
};

int report_extreme(const ExtremeOptions& options);  // exit status: 1 when the first driver is wrong somewhere or its bits vary

}  // namespace pineda::tools
