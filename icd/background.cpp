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
  for (std::thread& thread : threads_) thread.join();
}

bool Background::start_thread() {
  try {
    const BlockedSignals blocked;
    threads_.emplace_back([this] { run(); });
    return true;
  } catch (const std::system_error&) {
    return false;
  }
}

void Background::submit(const void* owner, std::function<void()> work) {
  const std::scoped_lock lock(mutex_);
  const bool wants_thread = jobs_.size() >= idle_ && threads_.size() < max_threads_;
  if (wants_thread && !start_thread() && threads_.empty()) return;
  jobs_.push_back({owner, std::move(work)});
  changed_.notify_all();
}

void Background::cancel(const void* owner) {
  std::unique_lock lock(mutex_);
  std::erase_if(jobs_, [&](const Job& job) { return job.owner == owner; });
  changed_.wait(lock, [&] { return std::ranges::find(running_, owner) == running_.end(); });
}

void Background::run() {
  std::unique_lock lock(mutex_);
  while (true) {
    ++idle_;
    changed_.wait(lock, [&] { return stop_ || !jobs_.empty(); });
    --idle_;
    if (stop_) return;
    {
      const Job job = std::move(jobs_.front());
      jobs_.pop_front();
      running_.push_back(job.owner);
      lock.unlock();
      job.work();
      lock.lock();
      running_.erase(std::ranges::find(running_, job.owner));
    }
    changed_.notify_all();
  }
}

}  // namespace pineda::icd
