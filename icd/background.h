// One thread that works while the queue goes on: it compiles kernels that are better than those in use, with the same bits.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>

namespace pineda::icd {

class Background {
 public:
  Background() = default;
  ~Background();  // what has not begun is dropped
  Background(const Background&) = delete;
  Background& operator=(const Background&) = delete;

  // `work` may use `owner` until cancel(owner) returns. It must not throw. The thread starts with the first submission.
  void submit(const void* owner, std::function<void()> work);
  // Drops what the owner has submitted and waits for what is running.
  void cancel(const void* owner);

 private:
  struct Job {
    const void* owner;
    std::function<void()> work;
  };
  void run();

  std::mutex mutex_;  // guards all of these
  std::condition_variable changed_;
  std::deque<Job> jobs_;
  const void* running_ = nullptr;  // owner of the job that runs
  bool stop_ = false;
  std::thread thread_;
};

}  // namespace pineda::icd
