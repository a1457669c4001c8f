#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

namespace pineda::tools {

// The quantile of the samples with linear interpolation between neighbours; 0.5 is the median. No samples: NaN.
inline double quantile(std::vector<double> samples, double share) {
  if (samples.empty()) return std::nan("");
  std::sort(samples.begin(), samples.end());
  const double position = share * static_cast<double>(samples.size() - 1);
  const size_t index = static_cast<size_t>(position);
  if (index + 1 >= samples.size()) return samples.back();
  return samples[index] + (position - static_cast<double>(index)) * (samples[index + 1] - samples[index]);
}

inline double median(const std::vector<double>& samples) { return quantile(samples, 0.5); }

}  // namespace pineda::tools
