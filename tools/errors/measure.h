// Compares a block of results with the truth, in units of the last place.
#pragma once

#include <cstdint>
#include <vector>

#include "tools/errors/functions.h"

namespace pineda::tools {

struct NearTie {  // of a function of one operand
  float x, got;
};

// One driver's results of one function. "Normal": the operands that vary and the exact result are normal or zero, which is all
// that Vulkan bounds (denormals "may be flushed to zero", infinities and NaN "may be" anything without SignedZeroInfNanPreserve).
struct Measurement {
  uint64_t count = 0, normal = 0;
  double worst_ulp = 0;  // normal
  Operands worst_at;
  double worst_share = 0;  // of what Vulkan allows; normal
  Operands worst_share_at;
  uint64_t beyond = 0;             // results beyond what Vulkan allows
  uint64_t misrounded = 0;         // normal results that are not the binary32 nearest to the exact value (by the bulk reference)
  double worst_denormal_ulp = 0;   // the others that are finite
  uint64_t other_specials = 0;     // an infinity or NaN instead of a number or of one another
  std::vector<NearTie> near_ties;  // normal results not counted above: the bulk reference cannot decide them
};

inline constexpr size_t kMaxNearTies = 1u << 16;

struct Block {
  const float *x, *y, *z;  // operands; y and z may be null
  const double* exact;
  uint32_t count;
};
// Adds a block, of at most kMaxBlock elements.
inline constexpr uint32_t kMaxBlock = 8192;
// A whole block of SharedBlock::kElements floats: operands and results of half as many binary64 values (measured_double.comp).
void measure_doubles(const MeasuredFunction& function, const float* const (&operands)[3], const float* results, Measurement& sum);
void measure(const MeasuredFunction& function, const Block& block, const float* results, Measurement& sum);

}  // namespace pineda::tools
