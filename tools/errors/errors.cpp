#include "tools/errors/errors.h"

#include <mpfr.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <nlohmann/json.hpp>
#include <numeric>
#include <sstream>
#include <vector>

#include "tools/driver_process.h"
#include "tools/error.h"
#include "tools/errors/error_table.h"
#include "tools/errors/measure.h"
#include "tools/errors/operands.h"
#include "tools/stopwatch.h"

namespace pineda::tools {
namespace {

using nlohmann::json;

constexpr std::chrono::minutes kTimeout{10};

std::vector<std::string> split(const std::string& list, char separator) {
  std::vector<std::string> parts;
  std::istringstream stream(list);
  for (std::string part; std::getline(stream, part, separator);) parts.push_back(part);
  return parts;
}

DriverSpec driver_of(const std::string& column) {
  for (const ErrorColumn& known : error_columns()) {
    if (column == known.name) return parse_driver(known.driver);
  }
  fail("no column '{}'", column);
}

struct Driver {
  std::string column;
  std::unique_ptr<DriverProcess> process;
  std::string device;
};

std::vector<Driver> start_drivers(const std::string& columns, const SharedBlock& shared, uint32_t count) {
  std::vector<Driver> drivers;
  for (const std::string& column : split(columns, ',')) {
    Driver driver{column, std::make_unique<DriverProcess>(driver_of(column)), {}};
    driver.device = driver.process->request({{"command", "open"}}, kTimeout).at("device");
    driver.process->request({{"command", "errors_open"}, {"path", shared.path()}, {"drivers", count}, {"driver", drivers.size()}},
                            kTimeout);
    drivers.push_back(std::move(driver));
  }
  return drivers;
}

// Elements that are computed and compared together: they stay in the cache.
constexpr uint32_t kPart = 8192;

// The exact results of a part.
void fill_exact(const MeasuredFunction& function, const Block& part, double* exact) {
  if (function.vector) {
    double wide[kPart];
    std::copy(part.x, part.x + part.count, wide);
    return function.vector(wide, exact, part.count);
  }
  for (uint32_t i = 0; i < part.count; ++i) {
    exact[i] = function.reference({part.x[i], part.y ? part.y[i] : 0.0, part.z ? part.z[i] : 0.0});
  }
}

// f(x) rounded to binary32 by MPFR, and the error in ULP of `got` if it is given.
struct Precise {
  explicit Precise(int bits = 200) { mpfr_inits2(bits, x, value, static_cast<mpfr_ptr>(nullptr)); }
  ~Precise() { mpfr_clears(x, value, static_cast<mpfr_ptr>(nullptr)); }
  void compute(const MeasuredFunction& function, double operand) {
    mpfr_set_d(x, operand, MPFR_RNDN);
    function.precise(value, x, MPFR_RNDN);
  }
  float nearest() const { return mpfr_get_flt(value, MPFR_RNDN); }
  mpfr_t x, value;
};

// Near a tie the bulk reference cannot decide which binary32 is the nearest: MPFR does. Not when there are too many to keep.
void settle_ties(const MeasuredFunction& function, Measurement& m) {
  if (!function.precise) return;
  Precise precise;
  for (const NearTie& tie : m.near_ties) {
    precise.compute(function, tie.x);
    m.misrounded += precise.nearest() != tie.got;
  }
}

// One function on all drivers: while they compute one block, the results of the one before are compared.
class FunctionRun {
 public:
  FunctionRun(const MeasuredFunction& function, std::vector<Driver>& drivers, SharedBlock& shared, bool quick)
      : function_(function),
        drivers_(drivers),
        shared_(shared),
        exhaustive_(!quick && function.operands == 1 && function.width == Width::k32) {
    blocks_ = exhaustive_ ? kExhaustiveBlocks : quick || function.operands == 1 ? 1 : kSampledBlocks;
    for (Driver& driver : drivers_) {
      driver.process->send({{"command", "errors_select"},
                            {"function", function.number},
                            {"operands", function.width == Width::k32 ? function.operands : 3}});
    }
    for (Driver& driver : drivers_) {
      driver.process->receive(kTimeout);
      runs_.push_back(&driver);
    }
    result_of_.resize(drivers_.size());
    std::iota(result_of_.begin(), result_of_.end(), 0);
    if (exhaustive_) share_results();
  }

  std::vector<Measurement> run() {
    std::vector<Measurement> sums(drivers_.size());
    start(0, exhaustive_);
    for (uint32_t block = 0; block < blocks_; ++block) {
      const uint32_t slot = block % SharedBlock::kSlots;
      for (Driver* driver : runs_) driver->process->receive(kTimeout);
      if (block + 1 < blocks_) start(block + 1, exhaustive_);
      if (function_.width == Width::k64) {
        compare_doubles(slot, sums);
      } else {
        for (uint32_t begin = 0; begin < SharedBlock::kElements; begin += kPart) compare(slot, begin, sums);
      }
    }
    for (Measurement& sum : sums) settle_ties(function_, sum);
    for (size_t d = 0; d < sums.size(); ++d) sums[d] = sums[result_of_[d]];
    return sums;
  }

  bool exhaustive() const { return exhaustive_; }

 private:
  // Most functions do not depend on the precision, or are the same at two of three. Of Pineda's columns that agree bit for bit on
  // the sample, one takes all operands.
  void share_results() {
    start(0, false);
    for (Driver& driver : drivers_) driver.process->receive(kTimeout);
    const auto results = [&](size_t d) { return shared_.results(0, static_cast<uint32_t>(d)); };
    runs_.clear();
    for (size_t d = 0; d < drivers_.size(); ++d) {
      for (size_t first = 0; first < d && result_of_[d] == d; ++first) {
        const bool same_driver = drivers_[d].device == drivers_[first].device;
        const bool agrees = std::memcmp(results(d), results(first), SharedBlock::kElements * sizeof(float)) == 0;
        if (same_driver && agrees) result_of_[d] = result_of_[first];
      }
      if (result_of_[d] == d) runs_.push_back(&drivers_[d]);
    }
  }

  void compare(uint32_t slot, uint32_t begin, std::vector<Measurement>& sums) {
    double exact[kPart];
    const auto operand = [&](uint32_t i) { return i < function_.operands ? shared_.operands(slot, i) + begin : nullptr; };
    const Block part{operand(0), operand(1), operand(2), exact, kPart};
    fill_exact(function_, part, exact);
    for (uint32_t d = 0; d < drivers_.size(); ++d) {
      if (result_of_[d] == d) measure(function_, part, shared_.results(slot, d) + begin, sums[d]);
    }
  }

  void compare_doubles(uint32_t slot, std::vector<Measurement>& sums) {
    const float* const operands[] = {shared_.operands(slot, 0), shared_.operands(slot, 1), shared_.operands(slot, 2)};
    for (uint32_t d = 0; d < drivers_.size(); ++d) measure_doubles(function_, operands, shared_.results(slot, d), sums[d]);
  }

  void start(uint32_t block, bool exhaustive) {
    const uint32_t slot = block % SharedBlock::kSlots;
    fill_operands(function_, exhaustive, block, shared_.operands(slot, 0), shared_.operands(slot, 1), shared_.operands(slot, 2));
    for (Driver* driver : runs_) driver->process->send({{"command", "errors_run"}, {"slot", slot}});
  }

  const MeasuredFunction& function_;
  std::vector<Driver>& drivers_;
  std::vector<Driver*> runs_;      // those that compute
  std::vector<size_t> result_of_;  // by driver: whose result is its own, too
  SharedBlock& shared_;
  const bool exhaustive_;
  uint32_t blocks_;
};

std::vector<const MeasuredFunction*> chosen_functions(const std::string& names) {
  std::vector<const MeasuredFunction*> chosen;
  for (const MeasuredFunction& function : measured_functions()) {
    const std::vector<std::string> wanted = split(names, ',');
    if (names.empty() || std::ranges::find(wanted, function.name) != wanted.end()) chosen.push_back(&function);
  }
  if (chosen.empty()) fail("no function is named '{}'; see `pineda errors --list`", names);
  return chosen;
}

// Prints and returns whether a row keeps Vulkan's demand.
bool print_cell(const MeasuredFunction& function, const Driver& driver, const Measurement& m) {
  const bool kept = m.beyond == 0;
  fmt::print("  {:<10} {:>12.6g} ULP at {:a}{}  {:6.3f} of what is allowed{}  misrounded {}/{}  specials {}\n", driver.column,
             m.worst_ulp, m.worst_at.x, function.operands > 1 ? fmt::format(", {:a}, {:a}", m.worst_at.y, m.worst_at.z) : "",
             m.worst_share,
             kept ? ""
                  : fmt::format(" (BEYOND for {} operands, e.g. {:a}, {:a}, {:a})", m.beyond, m.worst_share_at.x,
                                m.worst_share_at.y, m.worst_share_at.z),
             m.misrounded, m.normal, m.other_specials);
  std::fflush(stdout);
  return kept;
}

}  // namespace

int measure_errors(const ErrorsOptions& options) {
  if (options.list) {
    for (const MeasuredFunction& function : measured_functions()) fmt::print("{:<20} {}\n", function.name, function.demand);
    return 0;
  }
  const std::vector<const MeasuredFunction*> functions = chosen_functions(options.functions);
  const uint32_t driver_count = static_cast<uint32_t>(split(options.columns, ',').size());
  SharedBlock shared(driver_count);
  std::vector<Driver> drivers = start_drivers(options.columns, shared, driver_count);
  ErrorTable table(options.out);
  bool kept = true;
  for (const MeasuredFunction* function : functions) {
    const Stopwatch watch;
    FunctionRun run(*function, drivers, shared, options.quick);
    const std::vector<Measurement> results = run.run();
    fmt::print("{} ({:.1f} s)\n", function->name, watch.elapsed_ms() / 1000);
    for (uint32_t d = 0; d < driver_count; ++d) {
      const bool within = print_cell(*function, drivers[d], results[d]);
      if (drivers[d].column != "lavapipe") kept &= within;
      table.set(*function, drivers[d].column, drivers[d].device, run.exhaustive(), results[d]);
    }
    table.write();
  }
  fmt::print("{}\n", kept ? "every row of Pineda is within what Vulkan allows" : "FAILED: a row is beyond what Vulkan allows");
  return kept ? 0 : 1;
}

}  // namespace pineda::tools
