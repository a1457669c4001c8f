// The state of a pass: what is recorded (pass.cpp) and how it runs (schedule.cpp).
#pragma once

#include <deque>
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

  State(ThreadPool& thread_pool, const PassDesc& desc, const Options& options);
  ~State();

  // pass.cpp
  void record(const DrawPacket& packet);

  // schedule.cpp
  void run_recorded(bool last);  // geometry and tiles of all that is recorded
  void plan_window(Cursor& cursor, std::vector<Job>& jobs);
  void run_window(std::vector<Job>& jobs);
  void finish_job(Job& job);
  void commit(std::unique_ptr<Chunk> chunk);
  void flush(bool last);  // tiles of all that is committed
  uint32_t chunk_prims() const;
  GeometryWorker& geometry_worker(uint32_t thread);
  TileWorker& tile_worker(uint32_t thread);

  ThreadPool& pool;
  Scene scene;
  std::unique_ptr<Workspace> workspace;
  uint64_t recorded_prims = 0;
  std::vector<std::unique_ptr<Chunk>> committed;
  size_t committed_bytes = 0;
  PassStatistics statistics{};
  std::deque<DrawCounters> counters;  // with Options::per_draw
  std::vector<ThreadTimes> thread_times;
  std::vector<uint64_t> bin_entries;  // of each tile, with Options::heat_map
};

}  // namespace pineda::raster
