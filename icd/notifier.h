// Sleeping until something about fences, events or queries has changed: one counter for a device, a futex underneath. Waiting
// burns no core, and notify() without a sleeper costs two atomic operations.
#pragma once

#include <atomic>
#include <cstdint>

namespace pineda::icd {

class Notifier {
 public:
  static constexpr uint64_t kForever = ~uint64_t{0};

  // Call after the state that others wait for has been stored.
  void notify();

  // Sleeps until ready() holds or the deadline (CLOCK_MONOTONIC) has passed; false then. ready() is called without locks.
  template <typename Ready>
  bool wait(uint64_t deadline_ns, Ready&& ready) {
    if (ready()) return true;
    sleepers_.fetch_add(1);
    bool done = false;
    bool in_time = true;
    while (!done && in_time) {
      const uint32_t seen = epoch_.load();  // before ready(): a change after it makes sleep() return at once
      done = ready();
      if (!done) in_time = sleep(seen, deadline_ns);
    }
    sleepers_.fetch_sub(1);
    return done || ready();
  }

 private:
  bool sleep(uint32_t seen, uint64_t deadline_ns);  // false: deadline passed

  std::atomic<uint32_t> epoch_{0};
  std::atomic<uint32_t> sleepers_{0};
};

uint64_t monotonic_ns();
// now + timeout, saturating at kForever.
uint64_t deadline_after(uint64_t timeout_ns);

}  // namespace pineda::icd
