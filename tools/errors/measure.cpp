#include "tools/errors/measure.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "tools/errors/shared_block.h"

// The dynamic linker chooses among clones before ThreadSanitizer's runtime is there, which the choosing function would call.
#ifdef __SANITIZE_THREAD__
#define PINEDA_CLONES
#else
#define PINEDA_CLONES __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#endif

namespace pineda::tools {
namespace {

// The bulk reference is good to 2^-20 ULP of a binary32 with a wide margin; what is nearer to a tie is for MPFR to decide.
constexpr double kUndecided = 0x1p-20;

bool is_denormal(double v, Width width = Width::k32) { return v != 0 && std::fabs(v) < smallest_normal(width); }

struct Part {
  double worst_ulp, worst_denormal_ulp;
  uint64_t normal, misrounded, special, near_ties;
};

// The common case, written for the vectoriser: no branches, no calls; the largest error as an integer, which orders non-negative
// binary64 values the same and is what a vector maximum may be made of without -ffast-math. Elements with an infinity or NaN that
// are not plainly equal count as special and are left to the slow path.
PINEDA_CLONES Part scan(const float* __restrict x, const double* __restrict exact, const float* __restrict got, uint32_t count) {
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
    if (!(std::isfinite(in.x) && std::isfinite(in.y) && std::isfinite(in.z))) {
      m.other_specials += got != exact;
      return;
    }
    const double largest = largest_finite(width_), last_place = ulp_of(largest, width_);
    if (std::isinf(got) && (got < 0) == (exact < 0) && std::fabs(exact) >= largest + last_place / 2) return;
    if (!std::isfinite(exact) || !std::isfinite(got) || std::fabs(exact) > largest) {
      // Rounding up to infinity, or down from it, within the last place of the largest number is an error like others.
      const bool at_the_end = std::fabs(exact) > largest - last_place && std::fabs(got) > largest - last_place;
      if (!at_the_end) ++m.other_specials;
      if (!at_the_end && std::isfinite(exact) && std::fabs(exact) <= largest) violate(in, exact, got, m);
      return;
    }
    const double error = std::fabs(got - exact), ulp = error / ulp_of(exact, width_);
    if (any_denormal(in, exact)) {
      if (width_ != Width::k32) m.worst_denormal_ulp = std::max(m.worst_denormal_ulp, ulp);
      return;
    }
    if (width_ != Width::k32) {  // scan() has counted these of binary32
      ++m.normal;
      m.misrounded += ulp > 0.5;
    }
    if (ulp >= m.worst_ulp) m.worst_ulp = ulp, m.worst_at = in;
    violate(in, exact, got, m);
  }

 private:
  bool any_denormal(const Operands& in, double exact) const {
    return is_denormal(in.x, width_) || is_denormal(in.y, width_) || is_denormal(in.z, width_) || is_denormal(exact, width_);
  }
  void violate(const Operands& in, double exact, double got, Measurement& m) const {
    for (const double v : {in.x, in.y, in.z, exact}) {
      if (is_denormal(v, width_) || !std::isfinite(v)) return;
    }
    const double allowed = function_.allowed(in, exact);
    if (std::isinf(allowed)) return;
    const double error = std::isfinite(got) ? std::fabs(got - exact) : INFINITY;
    const double share = error == 0 ? 0 : error / (allowed + 0x1p-19 * ulp_of(exact, width_));
    if (share > m.worst_share) m.worst_share = share, m.worst_share_at = in;
    m.beyond += share > 1;
  }

  const MeasuredFunction& function_;
  const Block& block_;
  const float* results_;
  const Width width_ = function_.width;
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
  if (function.width != Width::k32) {
    const Looker looker(function, block, results);
    m.count += block.count;
    for (uint32_t i = 0; i < block.count; ++i) looker.look_at(i, m);
    return;
  }
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

void measure_doubles(const MeasuredFunction& function, const float* const (&operands)[3], const float* results, Measurement& m) {
  constexpr uint32_t kCount = SharedBlock::kElements / 2;
  const auto value = [](const float* array, uint32_t i) {
    return std::bit_cast<double>(uint64_t{std::bit_cast<uint32_t>(array[i + kCount])} << 32 | std::bit_cast<uint32_t>(array[i]));
  };
  for (uint32_t i = 0; i < kCount; ++i) {
    const Operands in{value(operands[0], i), value(operands[1], i), value(operands[2], i)};
    const double got = value(results, i);
    const __float128 precise = function.wide(in);
    const auto exact = static_cast<double>(precise);
    ++m.count;
    const bool special = !std::isfinite(exact) || !std::isfinite(got);
    if (special) {
      m.other_specials += !(got == exact || (std::isnan(got) && std::isnan(exact)));
      continue;
    }
    const auto difference = static_cast<double>(got - precise);
    const double ulp = std::fabs(difference) / ulp_of(exact, Width::k64);
    const bool denormal = is_denormal(in.x, Width::k64) || is_denormal(in.y, Width::k64) || is_denormal(in.z, Width::k64) ||
                          is_denormal(exact, Width::k64);
    if (denormal) {
      m.worst_denormal_ulp = std::max(m.worst_denormal_ulp, ulp);
      continue;
    }
    ++m.normal;
    m.misrounded += ulp > 0.5;
    if (ulp >= m.worst_ulp) m.worst_ulp = ulp, m.worst_at = in;
    const double share = std::fabs(difference) / function.allowed(in, exact);
    if (difference != 0 && share > m.worst_share) m.worst_share = share, m.worst_share_at = in;
    m.beyond += difference != 0 && share > 1;
  }
}

}  // namespace pineda::tools
