#include "icd/notifier.h"

#include <linux/futex.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#include <cerrno>
#include <climits>

namespace pineda::icd {
namespace {

constexpr uint64_t kNanosecondsPerSecond = 1'000'000'000;
static_assert(sizeof(std::atomic<uint32_t>) == sizeof(uint32_t), "the kernel sees the plain word");

}  // namespace

void Notifier::notify() {
  epoch_.fetch_add(1);
  if (sleepers_.load() == 0) return;
  syscall(SYS_futex, &epoch_, FUTEX_WAKE_PRIVATE, INT_MAX, nullptr, nullptr, 0);
}

bool Notifier::sleep(uint32_t seen, uint64_t deadline_ns) {
  timespec deadline{};
  if (deadline_ns != kForever) {
    deadline.tv_sec = time_t(deadline_ns / kNanosecondsPerSecond);
    deadline.tv_nsec = long(deadline_ns % kNanosecondsPerSecond);
  }
  // WAIT_BITSET takes an absolute deadline on CLOCK_MONOTONIC; FUTEX_WAIT a relative one.
  const long result = syscall(SYS_futex, &epoch_, FUTEX_WAIT_BITSET_PRIVATE, seen, deadline_ns == kForever ? nullptr : &deadline,
                              nullptr, FUTEX_BITSET_MATCH_ANY);
  return !(result == -1 && errno == ETIMEDOUT);
}

uint64_t monotonic_ns() {
  timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return uint64_t(now.tv_sec) * kNanosecondsPerSecond + uint64_t(now.tv_nsec);
}

uint64_t deadline_after(uint64_t timeout_ns) {
  // Anything beyond a century is forever: the sum must fit timespec.
  constexpr uint64_t kCentury = 100ull * 365 * 86400 * kNanosecondsPerSecond;
  return timeout_ns >= kCentury ? Notifier::kForever : monotonic_ns() + timeout_ns;
}

}  // namespace pineda::icd
