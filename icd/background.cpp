#include "icd/background.h"

#include <algorithm>
#include <system_error>

#include "base/blocked_signals.h"

namespace pineda::icd {

Background::~Background() {
  {
    const std::scoped_lock lock(mutex_);
    stop_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void Background::submit(const void* owner, std::function<void()> work) {
  const std::scoped_lock lock(mutex_);
  if (!thread_.joinable()) {
    try {
      const BlockedSignals blocked;
      thread_ = std::thread([this] { run(); });
    } catch (const std::system_error&) {  // no thread to be had: the work stays undone, as it may
      return;
    }
  }
  jobs_.push_back({owner, std::move(work)});
  changed_.notify_all();
}

void Background::cancel(const void* owner) {
  std::unique_lock lock(mutex_);
  std::erase_if(jobs_, [&](const Job& job) { return job.owner == owner; });
  changed_.wait(lock, [&] { return running_ != owner; });
}

void Background::run() {
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [&] { return stop_ || !jobs_.empty(); });
    if (stop_) return;
    const Job job = std::move(jobs_.front());
    jobs_.pop_front();
    running_ = job.owner;
    lock.unlock();
    job.work();
    lock.lock();
    running_ = nullptr;
    changed_.notify_all();
  }
}

}  // namespace pineda::icd
