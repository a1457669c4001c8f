#include "tools/errors/error_table.h"

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "tools/error.h"
#include "tools/errors/operands.h"

namespace pineda::tools {
namespace {

using nlohmann::json;

constexpr ErrorColumn kColumns[] = {{"fast", "pineda@PINEDA_PRECISION=fast"},
                                    {"default", "pineda@PINEDA_PRECISION=default"},
                                    {"exact", "pineda@PINEDA_PRECISION=exact"},
                                    {"lavapipe", "lavapipe"}};

constexpr const char* kIntroduction =
    R"(# The error of every function

`./run errors` measures and writes this file (and `errors.json`, its data); `./run errors --quick` takes a structured sample and fails
when a row of Pineda is beyond what Vulkan allows, as the tests do.

Each cell: the largest error in units of the last place (ULP) of the exact result, over all operands and results that are normal
numbers or zero; after the semicolon the largest share of what Vulkan allows that an error takes; in brackets how many results are not
the binary32 nearest to the exact value. **Bold**: beyond what Vulkan allows ("Precision and Operation of SPIR-V Instructions"), with the number of operands. Where Vulkan's demand is "from" a formula,
it is the error that the formula inherits from its operations; where it is an absolute error or a range, the ULP beyond it are not a
fault. Where terms may cancel no ULP are told. Functions of one operand are measured on all 2^32 values, those of several on 2^23 operands: a grid of edges, neighbours and
random values from fixed seeds (`tools/errors/operands.cpp`). Of Pineda's columns that agree bit for bit on a sample of 2^20 operands
one takes all 2^32. binary16 ("f16"): all 2^16 values of the first operand, ULP of binary16. binary64 ("f64"): ULP of binary64,
against binary128. All drivers run the same SPIR-V (`tools/errors/shaders/measured.comp`).

The truth: for functions of one operand glibc's binary64 vector functions (libmvec, below 4 ULP of a binary64, which is 2^-27 ULP
here); results within 2^-20 ULP of a tie are decided by MPFR. For the others binary64 arithmetic and glibc's binary64 functions.

)";

std::string cell_text(const MeasuredFunction& function, const json& cell) {
  const double ulp = cell.at("worst_ulp");
  const double share = cell.at("normal") == 0 ? 0 : cell.at("misrounded").get<double>() / cell.at("normal").get<double>();
  const uint64_t beyond = cell.at("beyond");
  std::string text = ulp >= 1e5                 ? fmt::format("{:.3g}", ulp)
                     : ulp < 0.505 && ulp > 0.5 ? fmt::format("{:.6f}", ulp)
                                                : fmt::format("{:.3f}", ulp);
  text = fmt::format("{}; {:.2f}", function.cancels ? "" : text, cell.at("worst_share_of_allowed").get<double>());
  if (beyond > 0) text = fmt::format("**{}, {} beyond**", text, beyond);
  if (share == 0) return text + " (0)";
  return text +
         (share >= 1e-4 ? fmt::format(" ({:.2f} %)", 100 * share) : fmt::format(" ({})", cell.at("misrounded").get<uint64_t>()));
}

std::string escaped(std::string text) {  // for a Markdown table
  for (size_t at = 0; (at = text.find('|', at)) != std::string::npos; at += 2) text.insert(at, 1, '\\');
  return text;
}

json operands_json(const Operands& in) {
  return json::array({fmt::format("{:a}", in.x), fmt::format("{:a}", in.y), fmt::format("{:a}", in.z)});
}

}  // namespace

std::span<const ErrorColumn> error_columns() { return kColumns; }

ErrorTable::ErrorTable(const std::string& markdown_path) : path_(markdown_path), data_(json::object()) {
  if (path_.empty()) return;
  data_path_ = std::filesystem::path(path_).replace_extension(".json").string();
  if (std::ifstream file(data_path_); file) data_ = json::parse(file);
}

void ErrorTable::set(const MeasuredFunction& function, const std::string& column, const std::string& device, bool exhaustive,
                     const Measurement& m) {
  data_[function.name][column] = {{"device", device},
                                  {"exhaustive", exhaustive},
                                  {"count", m.count},
                                  {"normal", m.normal},
                                  {"worst_ulp", m.worst_ulp},
                                  {"worst_at", operands_json(m.worst_at)},
                                  {"worst_share_of_allowed", std::min(m.worst_share, 1e9)},  // JSON has no infinity
                                  {"beyond", m.beyond},
                                  {"misrounded", m.misrounded},
                                  {"worst_denormal_ulp", m.worst_denormal_ulp},
                                  {"other_specials", m.other_specials}};
}

std::string ErrorTable::row(const MeasuredFunction& function) const {
  std::string text = fmt::format("| {} | {} |", function.name, escaped(function.demand));
  const json& cells = data_.at(function.name);
  for (const ErrorColumn& column : kColumns) {
    const bool measured = cells.contains(column.name);
    const uint64_t all = function.width != Width::k32 ? 0
                         : function.operands == 1     ? uint64_t{1} << 32
                                                      : uint64_t{kSampledBlocks} * SharedBlock::kElements;
    const bool sampled = measured && cells[column.name].at("count").get<uint64_t>() < all;
    text += measured ? fmt::format(" {}{} |", cell_text(function, cells[column.name]), sampled ? " sampled" : "") : " |";
  }
  // Denormals and special values: of the default precision and lavapipe.
  for (const char* column : {"default", "lavapipe"}) {
    if (!cells.contains(column)) {
      text += " |";
      continue;
    }
    const json& cell = cells[column];
    const bool kept = cell.at("worst_denormal_ulp").get<double>() <= std::max(4.5, cell.at("worst_ulp").get<double>());
    const uint64_t specials = cell.at("other_specials");
    text += fmt::format(" {}{} |", kept ? "kept" : "flushed", specials == 0 ? "" : fmt::format(", {} other specials", specials));
  }
  return text + "\n";
}

std::string ErrorTable::markdown() const {
  std::string text = kIntroduction;
  text +=
      "| function | Vulkan allows | Pineda, fast | Pineda, default | Pineda, exact | lavapipe | denormals: default | denormals: "
      "lavapipe |\n";
  text += "|---|---|---|---|---|---|---|---|\n";
  for (const MeasuredFunction& function : measured_functions()) {
    if (data_.contains(function.name)) text += row(function);
  }
  text +=
      "\n\"Other specials\": an infinity or NaN where the exact result is a number or the other of the two, and the reverse; "
      "Vulkan "
      "leaves them open. \"sampled\": 2^20 operands so far, of every sign and exponent. Functions of bits (unpack..., "
      "int to float) have no denormal or special operands, so their last two columns say nothing. A 1 or 2 misrounded by an "
      "exact "
      "column of 2^32 is a result that is nearer to a tie than binary64 tells apart.\n";
  return text;
}

void ErrorTable::write() const {
  if (path_.empty()) return;
  std::ofstream(data_path_) << data_.dump(1) << '\n';
  std::ofstream(path_) << markdown();
}

}  // namespace pineda::tools
