// The bit contract needs round to nearest even with denormals kept, but Vulkan calls arrive on threads of the application, which
// may have set FTZ and DAZ (engines do). Whoever computes numbers on such a thread stands in this scope.
#pragma once

#include <xmmintrin.h>

namespace pineda {

class ScopedFloatEnvironment {
 public:
  ScopedFloatEnvironment() : saved_(_mm_getcsr()) { _mm_setcsr(kDefaultMxcsr); }
  ~ScopedFloatEnvironment() { _mm_setcsr(saved_); }
  ScopedFloatEnvironment(const ScopedFloatEnvironment&) = delete;
  ScopedFloatEnvironment& operator=(const ScopedFloatEnvironment&) = delete;

 private:
  static constexpr unsigned kDefaultMxcsr = 0x1F80;  // all exceptions masked, nearest even, no FTZ, no DAZ
  unsigned saved_;
};

}  // namespace pineda
