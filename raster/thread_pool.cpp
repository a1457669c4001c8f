#include "raster/thread_pool.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <exception>
#include <string>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "base/blocked_signals.h"
#include "base/float_environment.h"
#include "base/log.h"
#include "raster/workspace.h"

namespace pineda::raster {
namespace {

// How long a thread spins before it sleeps. A wake-up costs some 10 us; on small machines spinning takes the core from the
// application.
constexpr auto kSpin = std::chrono::microseconds(15);

inline void relax() {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#endif
}

// True as soon as done() is; false when kSpin has passed.
template <class Done>
bool spin_until(Done done) {
  if (done()) return true;
  const auto deadline = std::chrono::steady_clock::now() + kSpin;
  do {
    for (int i = 0; i < 32; ++i) {
      relax();
      if (done()) return true;
    }
  } while (std::chrono::steady_clock::now() < deadline);
  return false;
}

}  // namespace

// A job is open while `gate` has kOpen. A worker enters by raising the count in `gate` only while it is open, so the caller,
// which closes the gate and then waits for the count to reach zero, never takes the job away from under a worker that came late.
struct ThreadPool::State {
  static constexpr uint32_t kOpen = 1u << 31;
  static constexpr size_t kLine = 64;

  const uint32_t threads;
  WorkspaceStore workspaces;
  std::vector<std::thread> workers;

  // The job; written only while the gate is closed and nobody is inside.
  const std::function<void(uint32_t, uint32_t)>* body = nullptr;
  uint32_t count = 0;
  std::exception_ptr failure;  // valid once `failed` is set and the gate is closed
  std::atomic<bool> failed{false};

  alignas(kLine) std::atomic<uint32_t> next{0};
  alignas(kLine) std::atomic<uint32_t> gate{0};
  alignas(kLine) std::atomic<uint32_t> epoch{0};  // a new value announces a job
  std::atomic<uint32_t> sleepers{0};
  std::atomic<bool> stop{false};

  explicit State(uint32_t thread_count) : threads(std::max(1u, thread_count)), workspaces(threads) {}

  void start_workers() {
    if (!workers.empty() || threads == 1) return;
    workers.reserve(threads - 1);
    const BlockedSignals blocked;
    try {
      for (uint32_t i = 1; i < threads; ++i) workers.emplace_back([this, i] { work(i); });
    } catch (const std::system_error&) {
      report(Severity::kWarning, "the system gives no more threads: going on with " + std::to_string(workers.size() + 1));
    }
  }

  void announce() {
    epoch.fetch_add(1);  // sequentially consistent with `sleepers`: either the worker sees the epoch or we see the sleeper
    if (sleepers.load() != 0) epoch.notify_all();
  }

  // The first exception of a body (out of memory) ends the job; parallel_for throws it again on the caller.
  void run_indices(uint32_t thread) {
    try {
      for (;;) {
        const uint32_t index = next.fetch_add(1, std::memory_order_relaxed);
        if (index >= count) return;
        (*body)(index, thread);
      }
    } catch (...) {
      next.store(count, std::memory_order_relaxed);
      if (!failed.exchange(true)) failure = std::current_exception();
    }
  }

  bool enter() {
    uint32_t g = gate.load(std::memory_order_relaxed);
    while (g & kOpen) {
      if (gate.compare_exchange_weak(g, g + 1, std::memory_order_acquire, std::memory_order_relaxed)) return true;
    }
    return false;
  }

  void leave() {
    if (gate.fetch_sub(1, std::memory_order_acq_rel) == 1) gate.notify_one();  // closed and we were the last
  }

  void close_and_wait() {
    gate.fetch_and(~kOpen, std::memory_order_acq_rel);
    if (spin_until([this] { return gate.load(std::memory_order_acquire) == 0; })) return;
    for (uint32_t g; (g = gate.load(std::memory_order_acquire)) != 0;) gate.wait(g, std::memory_order_acquire);
  }

  void work(uint32_t thread) {
    ScopedFloatEnvironment float_environment;
    uint32_t seen = 0;  // before the first job
    for (;;) {
      if (!spin_until([&] { return epoch.load(std::memory_order_acquire) != seen; })) {
        sleepers.fetch_add(1);
        while (epoch.load() == seen) epoch.wait(seen);
        sleepers.fetch_sub(1);
      }
      if (stop.load(std::memory_order_acquire)) return;
      seen = epoch.load(std::memory_order_acquire);
      if (enter()) {
        run_indices(thread);
        leave();
      }
    }
  }
};

ThreadPool::ThreadPool(uint32_t threads) : state_(std::make_unique<State>(threads)) {}

ThreadPool::~ThreadPool() {
  state_->stop.store(true, std::memory_order_release);
  state_->epoch.fetch_add(1);
  state_->epoch.notify_all();
  for (std::thread& worker : state_->workers) worker.join();
}

uint32_t ThreadPool::threads() const { return state_->threads; }
WorkspaceStore& ThreadPool::workspaces() { return state_->workspaces; }

void ThreadPool::parallel_for(uint32_t count, const std::function<void(uint32_t, uint32_t)>& body, bool helpers) {
  ScopedFloatEnvironment float_environment;
  State& s = *state_;
  if (!helpers || count <= 1 || s.threads == 1) {
    for (uint32_t i = 0; i < count; ++i) body(i, 0);
    return;
  }
  s.start_workers();
  s.body = &body;
  s.count = count;
  s.next.store(0, std::memory_order_relaxed);
  s.gate.store(State::kOpen, std::memory_order_release);
  s.announce();
  s.run_indices(0);
  s.close_and_wait();
  if (s.failed.exchange(false)) std::rethrow_exception(std::exchange(s.failure, nullptr));
}

}  // namespace pineda::raster
