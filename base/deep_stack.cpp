#include "base/deep_stack.h"

#include <pthread.h>

#include <cstddef>
#include <cstdint>
#include <exception>

#include "base/blocked_signals.h"

namespace pineda {
namespace {

// The deepest shader that is accepted takes about 4 MiB (pineda_fuzz scale, under `ulimit -s`); the default stack has 8.
constexpr size_t kEnoughBytes = size_t{5} << 20;
constexpr size_t kDeepBytes = size_t{16} << 20;

// The lowest address of this thread's stack; 0 when it is not known.
uintptr_t stack_end() {
  static thread_local const uintptr_t end = [] {
    pthread_attr_t attributes;
    if (pthread_getattr_np(pthread_self(), &attributes) != 0) return uintptr_t{0};
    void* lowest = nullptr;
    size_t size_bytes = 0;
    pthread_attr_getstack(&attributes, &lowest, &size_bytes);
    pthread_attr_destroy(&attributes);
    return reinterpret_cast<uintptr_t>(lowest);
  }();
  return end;
}

struct Call {
  const std::function<void()>* fn;
  std::exception_ptr failure;
};

void* run(void* argument) {
  Call& call = *static_cast<Call*>(argument);
  try {
    (*call.fn)();
  } catch (...) {
    call.failure = std::current_exception();
  }
  return nullptr;
}

}  // namespace

void with_deep_stack(const std::function<void()>& fn) {
  const auto here = reinterpret_cast<uintptr_t>(__builtin_frame_address(0));
  if (here - stack_end() >= kEnoughBytes) return fn();
  pthread_attr_t attributes;
  pthread_t thread;
  Call call{&fn, nullptr};
  pthread_attr_init(&attributes);
  pthread_attr_setstacksize(&attributes, kDeepBytes);
  const int failed = [&] {
    const BlockedSignals blocked;
    return pthread_create(&thread, &attributes, run, &call);
  }();
  pthread_attr_destroy(&attributes);
  if (failed) return fn();  // no thread to be had: most shaders are not deep
  pthread_join(thread, nullptr);
  if (call.failure) std::rethrow_exception(call.failure);
}

}  // namespace pineda
