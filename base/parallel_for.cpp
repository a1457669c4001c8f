#include "base/parallel_for.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

#include "base/blocked_signals.h"
#include "base/config.h"
#include "base/float_environment.h"

namespace pineda {
namespace {

std::atomic<uint32_t> helpers{0};  // of all calls, now

uint32_t max_helpers() {
  static const uint32_t max = [] {
    const uint32_t threads = config().threads != 0 ? config().threads : std::max(1u, std::thread::hardware_concurrency());
    return threads - 1;
  }();
  return max;
}

bool take_helper() {
  uint32_t now = helpers.load();
  while (now < max_helpers()) {
    if (helpers.compare_exchange_weak(now, now + 1)) return true;
  }
  return false;
}

}  // namespace

void parallel_for(uint32_t count, const std::function<void(uint32_t index)>& body) {
  std::atomic<uint32_t> next{0};
  std::mutex mutex;
  std::exception_ptr failure;
  const auto work = [&] {
    for (uint32_t i = next++; i < count; i = next++) {
      try {
        body(i);
      } catch (...) {
        const std::lock_guard lock(mutex);
        if (!failure) failure = std::current_exception();
      }
    }
  };
  std::vector<std::thread> threads;
  while (threads.size() + 1 < count && take_helper()) {
    try {
      const BlockedSignals blocked;
      threads.emplace_back([&work] {
        const ScopedFloatEnvironment environment;
        work();
        --helpers;
      });
    } catch (const std::exception&) {  // no thread to be had: fewer do it
      --helpers;
      break;
    }
  }
  work();
  for (std::thread& thread : threads) thread.join();
  if (failure) std::rethrow_exception(failure);
}

}  // namespace pineda
