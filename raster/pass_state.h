// The state of a pass: what is recorded (pass.cpp) and how it runs (schedule.cpp).
#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "raster/raster.h"
#include "raster/workspace.h"

namespace pineda::raster {

struct Pass::State {
  // One geometry job: ranges of primitives in API order, and the chunk they become.
  struct Job {
    std::vector<PrimRange> ranges;
    std::unique_ptr<Chunk> chunk;
    uint64_t prims = 0, done = 0;
  };
  // Where planning stands in the recorded draws.
  struct Cursor {
    size_t draw = 0;
    uint64_t prim = 0;
  };

  // Who runs the pass: threads [first, end) of the pool together, or, from inside of a job of the pool, its thread `first` alone.
  struct Crew {
    uint32_t first = 0, end = 1;
    bool alone = false;
  };
  // Memory that the pass may write or read as attachments.
  struct Range {
    const uint8_t *begin, *end;
  };

  State(ThreadPool& thread_pool, const PassDesc& desc, const Options& options);
  ~State();

  // pass.cpp
  void choose_tiles(uint32_t threads);  // that share the pass
  void add_ranges(const Attachment& attachment, const PassDesc& desc);
  void record(const DrawPacket& packet);

  // schedule.cpp
  void run_recorded(bool last, Crew crew);  // geometry and tiles of all that is recorded
  // As ThreadPool::parallel_for, by the crew.
  void for_each(uint32_t count, const std::function<void(uint32_t index, uint32_t thread)>& body, bool helpers);
  Crew everybody() const { return {0, pool.threads(), false}; }
  void plan_window(Cursor& cursor, std::vector<Job>& jobs);
  void run_window(std::vector<Job>& jobs);
  void finish_job(Job& job);
  void commit(std::unique_ptr<Chunk> chunk);
  void flush(bool last);  // tiles of all that is committed
  uint32_t chunk_prims() const;
  void take_statistics(uint32_t thread);

  ThreadPool& pool;
  Scene scene;
  WorkspaceStore& store;
  std::unique_ptr<Workspace> workspace;
  Crew crew;
  std::vector<Range> attachment_ranges;
  bool has_effects = false;   // beyond its attachments: stores of shaders, queries
  uint32_t bytes_per_px = 0;  // of all attachments
  uint64_t recorded_prims = 0;
  std::vector<std::unique_ptr<Chunk>> committed;
  size_t committed_bytes = 0;
  PassStatistics statistics{};
  std::deque<DrawCounters> counters;  // with Options::per_draw
  std::vector<ThreadTimes> thread_times;
  std::vector<uint64_t> bin_entries;  // of each tile, with Options::heat_map
};

}  // namespace pineda::raster
