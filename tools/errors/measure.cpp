#include "tools/errors/measure.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace pineda::tools {
namespace {

// The bulk reference is good to 2^-20 ULP of a binary32 with a wide margin; what is nearer to a tie is for MPFR to decide.
constexpr double kUndecided = 0x1p-20;

bool is_denormal(double v) { return v != 0 && std::fabs(v) < 0x1p-126; }

struct Part {
  double worst_ulp, worst_denormal_ulp;
  uint64_t normal, misrounded, special, near_ties;
};

// The common case, written for the vectoriser: no branches, no calls; the largest error as an integer, which orders non-negative
// binary64 values the same and is what a vector maximum may be made of without -ffast-math. Elements with an infinity or NaN that
// are not plainly equal count as special and are left to the slow path.
__attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default"))) Part scan(const float* __restrict x,
                                                                                        const double* __restrict exact,
                                                                                        const float* __restrict got,
                                                                                        uint32_t count) {
  int64_t worst = 0, worst_denormal = 0, normal_count = 0, misrounded = 0, special = 0, near_ties = 0;
  for (uint32_t i = 0; i < count; ++i) {
    const double e = exact[i], g = got[i], nearest = static_cast<float>(e), operand = x[i];
    const double magnitude = e < 0 ? -e : e, operand_magnitude = operand < 0 ? -operand : operand;
    // 2^(23 - exponent of e), the exponent being at least -126
    const double at_least = magnitude > 0x1p-126 ? magnitude : 0x1p-126;
    const int64_t exponent_bits = std::bit_cast<int64_t>(at_least) & 0x7ff0000000000000;
    const double scale = std::bit_cast<double>((int64_t{2 * 1023 + 23} << 52) - exponent_bits);
    const double difference = g - e;
    const double error = (difference < 0 ? -difference : difference) * scale;
    const int64_t finite = magnitude <= 0x1.fffffep127 && error < 0x1p200 ? -1 : 0;
    const int64_t same = g == nearest || (g != g && e != e) ? -1 : 0;
    const int64_t result_normal = magnitude >= 0x1p-126 || e == 0 ? -1 : 0;
    const int64_t operand_normal = operand_magnitude >= 0x1p-126 || operand == 0 ? -1 : 0;
    const int64_t normal = finite & result_normal & operand_normal;
    const int64_t bits = std::bit_cast<int64_t>(error) & finite;
    const int64_t normal_bits = bits & normal, other_bits = bits & ~normal;
    worst = normal_bits > worst ? normal_bits : worst;
    worst_denormal = other_bits > worst_denormal ? other_bits : worst_denormal;
    const double from_nearest = (nearest > e ? nearest - e : e - nearest) * scale;
    const int64_t near_tie = from_nearest > 0.5 - kUndecided ? -1 : 0;
    normal_count -= normal;
    near_ties -= normal & near_tie;
    misrounded -= normal & ~same & ~near_tie;
    special -= ~finite & ~same;
  }
  return {std::bit_cast<double>(worst),      std::bit_cast<double>(worst_denormal), static_cast<uint64_t>(normal_count),
          static_cast<uint64_t>(misrounded), static_cast<uint64_t>(special),        static_cast<uint64_t>(near_ties)};
}

class Looker {
 public:
  Looker(const MeasuredFunction& function, const Block& block, const float* results)
      : function_(function), block_(block), results_(results) {}

  void look_at(uint32_t i, Measurement& m) const {
    const Operands in{block_.x[i], block_.y ? block_.y[i] : 0.0, block_.z ? block_.z[i] : 0.0};
    const double exact = block_.exact[i], got = results_[i];
    if (std::isnan(exact) && std::isnan(got)) return;
    if (results_[i] == static_cast<float>(exact) && (std::isinf(got) || std::isinf(exact))) return;
    if (!std::isfinite(exact) || !std::isfinite(got) || std::fabs(exact) > 0x1.fffffep127) {
      // Rounding up to infinity, or down from it, within the last place of the largest number is an error like others.
      const bool at_the_end = std::fabs(exact) > 0x1.fffffcp127 && std::fabs(got) > 0x1.fffffcp127;
      if (!at_the_end) ++m.other_specials;
      if (!at_the_end && std::isfinite(exact) && std::fabs(exact) <= 0x1.fffffep127) violate(in, exact, got, m);
      return;
    }
    const double error = std::fabs(got - exact), ulp = error / ulp_of(exact);
    if (is_denormal(in.x) || is_denormal(in.y) || is_denormal(in.z) || is_denormal(exact)) return;
    if (ulp >= m.worst_ulp) m.worst_ulp = ulp, m.worst_at = in;
    violate(in, exact, got, m);
  }

 private:
  void violate(const Operands& in, double exact, double got, Measurement& m) const {
    for (const double v : {in.x, in.y, in.z, exact}) {
      if (is_denormal(v) || !std::isfinite(v)) return;
    }
    const double allowed = function_.allowed(in, exact);
    if (std::isinf(allowed)) return;
    const double error = std::isfinite(got) ? std::fabs(got - exact) : INFINITY;
    const double share = error == 0 ? 0 : error / (allowed + 0x1p-19 * ulp_of(exact));
    if (share > m.worst_share) m.worst_share = share, m.worst_share_at = in;
    m.beyond += share > 1;
  }

  const MeasuredFunction& function_;
  const Block& block_;
  const float* results_;
};

// Without a precise reference the bulk's word stands.
void keep_near_ties(const MeasuredFunction& function, const Block& block, const float* results, Measurement& m) {
  for (uint32_t i = 0; i < block.count; ++i) {
    const double exact = block.exact[i];
    const float nearest = static_cast<float>(exact);
    if (!std::isfinite(exact) || is_denormal(exact) || is_denormal(block.x[i]) || !std::isfinite(results[i])) continue;
    if (std::fabs(nearest - exact) / ulp_of(exact) <= 0.5 - kUndecided) continue;
    if (!function.precise || m.near_ties.size() >= kMaxNearTies) {
      m.misrounded += results[i] != nearest;
    } else {
      m.near_ties.push_back({block.x[i], results[i]});
    }
  }
}

}  // namespace

void measure(const MeasuredFunction& function, const Block& block, const float* results, Measurement& m) {
  const Part part = scan(block.x, block.exact, results, block.count);
  m.count += block.count;
  m.normal += part.normal;
  m.misrounded += part.misrounded;
  m.worst_denormal_ulp = std::max(m.worst_denormal_ulp, part.worst_denormal_ulp);
  // Functions of several operands are few: each element is looked at.
  const Looker looker(function, block, results);
  const bool look = function.operands > 1 || part.special > 0 || part.worst_ulp > std::min(m.worst_ulp, function.surely_ulp);
  for (uint32_t i = 0; look && i < block.count; ++i) looker.look_at(i, m);
  if (part.near_ties > 0) keep_near_ties(function, block, results, m);
}

}  // namespace pineda::tools
