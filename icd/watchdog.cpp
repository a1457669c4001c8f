#include "icd/watchdog.h"

#include <algorithm>
#include <chrono>
#include <system_error>
#include <vector>

#include "base/blocked_signals.h"
#include "base/config.h"
#include "base/stop_word.h"
#include "icd/device.h"
#include "icd/notifier.h"

namespace pineda::icd {
namespace {

constexpr uint64_t kSecond_ns = 1'000'000'000;
constexpr uint64_t kMaxLook_ns = kSecond_ns / 2;

// All watchdogs of the process, and the one whose submission is being stopped.
struct Pack {
  std::mutex mutex;
  std::condition_variable changed;
  std::vector<Watchdog*> all;
  const Watchdog* stopping = nullptr;
};
Pack& pack() {
  static Pack instance;
  return instance;
}

}  // namespace

Watchdog::Watchdog(Device& device) : device_(device), timeout_ns_(config().timeout_s * kSecond_ns) {
  const std::scoped_lock lock(pack().mutex);
  pack().all.push_back(this);
}

Watchdog::~Watchdog() {
  {
    const std::scoped_lock lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
  const std::scoped_lock pack_lock(pack().mutex);
  std::erase(pack().all, this);
}

void Watchdog::begin() noexcept {
  running_.store(++serial_);
  while (kernels_stopped()) {  // until another device's shader has come to its end
    running_.store(0);
    std::unique_lock lock(pack().mutex);
    pack().changed.wait(lock, [] { return !pack().stopping; });
    running_.store(serial_);
  }
  if (timeout_ns_ != 0 && !watching_.load()) start_thread();
}

void Watchdog::end() noexcept {
  running_.store(0);
  if (!kernels_stopped()) return;
  {
    const std::scoped_lock lock(pack().mutex);
    if (pack().stopping != this) return;
    pack().stopping = nullptr;
    stop_word().store(0);
  }
  pack().changed.notify_all();
}

void Watchdog::stop_kernels() {
  const std::scoped_lock lock(pack().mutex);
  if (running_.load() == 0) return;  // it has just come to its end by itself
  pack().stopping = this;
  stop_word().store(1);
  for (Watchdog* other : pack().all) {
    if (other != this && other->running_.load() != 0) {
      other->device_.lose("a shader of another device in this process was stopped while this one executed");
    }
  }
}

void Watchdog::start_thread() noexcept {
  const std::scoped_lock lock(mutex_);
  watching_ = true;
  if (thread_.joinable()) {
    changed_.notify_all();
    return;
  }
  try {
    const BlockedSignals blocked;
    thread_ = std::thread([this] { main(); });
  } catch (const std::system_error&) {
    report(Severity::kWarning, "no thread for the watchdog: PINEDA_TIMEOUT has no effect");
  }
}

void Watchdog::main() {
  pthread_setname_np(pthread_self(), "pineda-watchdog");
  const std::chrono::nanoseconds look(std::min(timeout_ns_ / 4, kMaxLook_ns));
  std::unique_lock lock(mutex_);
  uint64_t seen = 0, seen_ns = 0;  // what ran at the last look, and since when it does
  while (!stopping_) {
    if (!watching_) {
      changed_.wait(lock);
      seen = 0;
      continue;
    }
    changed_.wait_for(lock, look);
    const uint64_t running = running_.load();
    if (running == 0) {
      watching_ = false;
      if (running_.load() != 0) watching_ = true;  // a submission that began just now saw it up
      continue;
    }
    if (running != seen) {
      seen = running;
      seen_ns = monotonic_ns();
      continue;
    }
    if (monotonic_ns() - seen_ns < timeout_ns_) continue;
    device_.lose("a submission ran for " + std::to_string(timeout_ns_ / kSecond_ns) +
                 " s (PINEDA_TIMEOUT), so its shaders were stopped");
    lock.unlock();
    stop_kernels();
    return;
  }
}

}  // namespace pineda::icd
