// A thread of the driver must not receive the application's signals: whoever starts one stands in this scope, and the thread
// inherits a mask with all of them blocked.
#pragma once

#include <pthread.h>
#include <signal.h>

namespace pineda {

class BlockedSignals {
 public:
  BlockedSignals() {
    sigset_t all;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &saved_);
  }
  ~BlockedSignals() { pthread_sigmask(SIG_SETMASK, &saved_, nullptr); }
  BlockedSignals(const BlockedSignals&) = delete;
  BlockedSignals& operator=(const BlockedSignals&) = delete;

 private:
  sigset_t saved_;
};

}  // namespace pineda
