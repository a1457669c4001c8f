// The word at which kernels look in every turn of a loop: when it is not 0, loops end. For shaders that never end
// (icd/watchdog.h). One for the process, because machine code and evaluator know nothing of devices. Machine code finds it
// through KernelHandle::self.
#pragma once

#include <atomic>
#include <cstdint>

namespace pineda {

inline std::atomic<uint32_t>& stop_word() {
  static constinit std::atomic<uint32_t> word{0};
  return word;
}
inline bool kernels_stopped() { return stop_word().load(std::memory_order_relaxed) != 0; }

}  // namespace pineda
