// The one thread pool: geometry, tiles, compute, copies and clears.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>

namespace pineda::raster {

class WorkspaceStore;

class ThreadPool {
 public:
  // `threads` counts the caller of parallel_for: 1 starts no thread. Workers start on the first parallel_for that wants them.
  explicit ThreadPool(uint32_t threads);
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;

  uint32_t threads() const;
  WorkspaceStore& workspaces();  // memory that the passes of this pool reuse

  // Calls body(index, thread) for every index in [0, count), each once, and returns when all are done. thread < threads() names
  // the running thread's scratch memory; the caller takes part as thread 0. When a body throws, indices not yet handed out are
  // dropped and the first exception is thrown again here. Indices are handed out in ascending order. One job at a time: called
  // from one thread (the queue's); not reentrant. `helpers` = false runs everything on the caller: for work that is shorter than
  // a wake-up (some 10 us).
  void parallel_for(uint32_t count, const std::function<void(uint32_t index, uint32_t thread)>& body, bool helpers = true);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace pineda::raster
