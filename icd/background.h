// Threads that work while the application and the queue go on: they compile. A thread starts when work comes and no thread is
// idle, as long as there are fewer than the most that are allowed, and stays.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace pineda::icd {

class Background {
 public:
  explicit Background(uint32_t max_threads) : max_threads_(max_threads) {}
  ~Background();  // what has not begun is dropped
  Background(const Background&) = delete;
  Background& operator=(const Background&) = delete;

  // `work` may use `owner` until cancel(owner) returns. It must not throw. It stays undone when there is no thread to be had.
  void submit(const void* owner, std::function<void()> work);
  // Drops what the owner has submitted and waits for what is running of it. Only for owners that are not null.
  void cancel(const void* owner);

 private:
  struct Job {
    const void* owner;
    std::function<void()> work;
  };
  void run();
  bool start_thread();

  const uint32_t max_threads_;
  std::mutex mutex_;  // guards all of these
  std::condition_variable changed_;
  std::deque<Job> jobs_;
  std::vector<const void*> running_;  // owners of the jobs that run
  uint32_t idle_ = 0;                 // threads that wait for a job
  bool stop_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace pineda::icd
