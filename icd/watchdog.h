// Ends shaders that never end. While submissions execute, a thread of its own looks now and then whether it sees the same one as
// before, so that executing costs no look at the clock; past PINEDA_TIMEOUT the device is lost, and the stop word
// (base/stop_word.h), at which kernels look in every turn of a loop, makes what runs come to its end. The word is the process's:
// other devices that execute at that moment lose their results, and are lost too.
//
// The thread starts with the first submission that executes commands, and sleeps for good while nothing does.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <thread>

namespace pineda::icd {

class Device;

class Watchdog {
 public:
  explicit Watchdog(Device& device);
  ~Watchdog();

  // Around the execution of commands; by the holder of the scheduler's baton. Does not throw: without a thread nobody watches.
  void begin() noexcept;
  void end() noexcept;

 private:
  void main();
  void stop_kernels();
  void start_thread() noexcept;

  Device& device_;
  const uint64_t timeout_ns_;          // 0: no limit
  uint64_t serial_ = 0;                // of the last submission; of who holds the baton
  std::atomic<uint64_t> running_{0};   // the serial of what executes; 0: nothing does
  std::atomic<bool> watching_{false};  // the thread looks at running_ by itself
  std::mutex mutex_;                   // guards all below
  std::condition_variable changed_;
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace pineda::icd
