// Runs a pass: geometry in windows of chunks, their ordered commit, and the tiles whenever the bins are full and at the end.
//
// Where chunks, windows and flushes begin depends on sizes only to bound memory and balance threads; no result depends on it.
#include <algorithm>
#include <utility>

#include "base/trace.h"
#include "raster/fill_pattern.h"
#include "raster/pass_state.h"

namespace pineda::raster {
namespace {

constexpr uint32_t kMinChunkPrims = 512;
constexpr size_t kWorstChunkBytes = size_t{2} << 20;  // vertices of a chunk when nothing is shared
constexpr uint32_t kWindowChunks = 16;                // at least, before memory is looked at
constexpr uint32_t kDrawCostPrims = 8;                // what starting a draw costs, in primitives
constexpr uint64_t kSerialPrims = 768;                // less geometry than this is done before a helper wakes up
constexpr uint64_t kSerialPixels = 64 * 64;           // likewise shading
constexpr uint64_t kSerialEntries = 512;
constexpr uint32_t kFillTilesPerJob = 8;  // side by side they are rows of 2 KiB and more

void add_statistics(PassStatistics& sum, const PassStatistics& s) {
#define PINEDA_STATISTIC(name, text) sum.name += s.name;
#include "raster/statistics.inc"
}

// Runs body(); when it is asked for, its time goes to `sum_ns` and to the trace.
template <class Body>
void timed(const Options& options, const char* name, uint64_t& sum_ns, const Body& body) {
  if (!options.timing && !tracing()) return body();
  const uint64_t begin = now_ns();
  body();
  const uint64_t end = now_ns();
  sum_ns += end - begin;
  if (tracing()) trace_event(name, begin, end);
}

uint64_t total_prims(const Draw& draw) { return draw.prims_per_instance * draw.packet.instance_count; }

}  // namespace

Pass::State::~State() {
  scene.clear_lists();
  scene.tiles.swap(workspace->tiles);
  for (std::unique_ptr<Chunk>& chunk : committed) store.give_back(std::move(chunk));
  store.release(std::move(workspace));
  store.trim();
}

void Pass::State::for_each(uint32_t count, const std::function<void(uint32_t, uint32_t)>& body, bool helpers) {
  if (!crew.alone) return pool.parallel_for(count, body, helpers);
  for (uint32_t i = 0; i < count; ++i) body(i, crew.first);
}

// Primitives of a geometry job: enough jobs for all threads, few enough for long bin segments.
uint32_t Pass::State::chunk_prims() const {
  const uint64_t share = recorded_prims / (uint64_t{pool.threads()} * 4);
  const uint32_t most = std::max(1u, scene.options.chunk_prims);
  return static_cast<uint32_t>(std::clamp<uint64_t>(share, std::min(kMinChunkPrims, most), most));
}

// The next jobs from `cursor` on.
void Pass::State::plan_window(Cursor& cursor, std::vector<Job>& jobs) {
  const uint32_t chunk = chunk_prims();
  const size_t most = std::max(kWindowChunks, 4 * pool.threads());
  while (jobs.size() < most && cursor.draw < workspace->draws.size()) {
    Job job;
    uint64_t cost = 0;
    while (cost < chunk && cursor.draw < workspace->draws.size()) {
      const Draw& draw = workspace->draws[cursor.draw];
      const uint64_t prim_bytes = sizeof(Triangle) + 3 * sizeof(float) * uint64_t{draw.packet.vertex_slots};
      const uint64_t room = std::min<uint64_t>(chunk - cost, kWorstChunkBytes / prim_bytes + 1);
      const uint64_t left = total_prims(draw) - cursor.prim;
      const uint64_t count = draw.in_order ? std::min<uint64_t>(left, ~0u) : std::min(room, left);
      if (count != 0) job.ranges.push_back({&draw, cursor.prim, static_cast<uint32_t>(count)});
      job.prims += count;
      cost += kDrawCostPrims + count;
      if (prim_bytes * count >= kWorstChunkBytes) cost = chunk;
      cursor.prim += count;
      if (cursor.prim == total_prims(draw)) {
        ++cursor.draw;
        cursor.prim = 0;
      }
    }
    if (job.prims != 0) jobs.push_back(std::move(job));
  }
}

void Pass::State::run_window(std::vector<Job>& jobs) {
  uint64_t prims = 0;
  for (Job& job : jobs) {
    job.chunk = store.take_chunk();
    prims += job.prims;
  }
  for_each(
      static_cast<uint32_t>(jobs.size()),
      [&](uint32_t i, uint32_t thread) {
        GeometryWorker& worker = store.geometry(thread);
        timed(scene.options, "geometry", worker.statistics.geometry_ns,
              [&] { jobs[i].done = worker.run(scene.grid, jobs[i].ranges, scene.options, *jobs[i].chunk); });
      },
      prims >= kSerialPrims);
  for (Job& job : jobs) finish_job(job);
}

// Commits a job's chunk. One that was cut is drawn at once and its rest is done here: rare, so not in parallel.
void Pass::State::finish_job(Job& job) {
  commit(std::move(job.chunk));
  while (job.done < job.prims) {
    flush(false);
    std::vector<PrimRange> rest;
    uint64_t skip = job.done;
    for (const PrimRange& range : job.ranges) {
      const uint64_t drop = std::min<uint64_t>(skip, range.count);
      skip -= drop;
      if (drop < range.count) rest.push_back({range.draw, range.first + drop, static_cast<uint32_t>(range.count - drop)});
    }
    std::unique_ptr<Chunk> chunk = store.take_chunk();
    for_each(
        1, [&](uint32_t, uint32_t thread) { job.done += store.geometry(thread).run(scene.grid, rest, scene.options, *chunk); },
        false);
    commit(std::move(chunk));
  }
}

void Pass::State::commit(std::unique_ptr<Chunk> chunk) {
  statistics.triangles_binned += chunk->triangles.size();
  statistics.bin_entries += chunk->entries.size();
  scene.commit(*chunk);
  if (scene.options.heat_map) {
    bin_entries.resize(scene.grid.count());
    for (size_t i = 0; i < chunk->segments.size(); ++i) bin_entries[chunk->segments[i].tile] += chunk->segments[i].count;
  }
  committed_bytes += chunk->used_bytes();
  committed.push_back(std::move(chunk));
}

void Pass::State::flush(bool last) {
  std::vector<uint32_t> touched, untouched;
  uint64_t entries = 0;
  for (const std::unique_ptr<Chunk>& chunk : committed) entries += chunk->entries.size();
  for (uint32_t i = 0; i < scene.grid.count(); ++i) {
    if (!scene.tiles[i].segments.empty()) {
      touched.push_back(i);
    } else if (last) {
      untouched.push_back(i);
    }
  }
  scene.last_flush = last;
  scene.streams_fills = untouched.size() * scene.fill_bytes_per_tile() >= kStreamBytes;
  const auto draw_jobs = static_cast<uint32_t>(touched.size());
  const auto fill_jobs = static_cast<uint32_t>((untouched.size() + kFillTilesPerJob - 1) / kFillTilesPerJob);
  const uint64_t tile_pixels = uint64_t{scene.grid.tile_px * 1u} * static_cast<uint32_t>(scene.grid.tile_px);
  const bool helpers =
      (draw_jobs + fill_jobs) > 1 && (touched.size() * tile_pixels > kSerialPixels || entries > kSerialEntries || fill_jobs > 4);
  for_each(
      draw_jobs + fill_jobs,
      [&](uint32_t i, uint32_t thread) {
        TileWorker& worker = store.tile(thread);
        if (i < draw_jobs) {
          timed(scene.options, "tile", worker.statistics.tiles_ns,
                [&] { worker.run(scene, touched[i], scene.tiles[touched[i]]); });
          return;
        }
        const size_t first = size_t{i - draw_jobs} * kFillTilesPerJob, end = std::min(untouched.size(), first + kFillTilesPerJob);
        for (size_t t = first, next; t < end; t = next) {
          for (next = t + 1;
               next < end && untouched[next] == untouched[next - 1] + 1 && scene.fills_with_next(untouched[next - 1]);)
            ++next;
          worker.run_untouched(scene, untouched[t], static_cast<uint32_t>(next - t), scene.tiles[untouched[t]]);
        }
      },
      helpers);
  if (!touched.empty()) ++statistics.flushes;
  scene.clear_lists();
  for (std::unique_ptr<Chunk>& chunk : committed) store.give_back(std::move(chunk));
  committed.clear();
  committed_bytes = 0;
}

void Pass::State::run_recorded(bool last, Crew by) {
  crew = by;
  Cursor cursor;
  std::vector<Job> jobs;
  while (cursor.draw < workspace->draws.size()) {
    jobs.clear();
    plan_window(cursor, jobs);
    if (!jobs.empty()) run_window(jobs);
    if (committed_bytes > scene.options.bin_budget_bytes && cursor.draw < workspace->draws.size()) flush(false);
  }
  flush(last);
  workspace->draws.clear();
  recorded_prims = 0;
  thread_times.resize(pool.threads());
  for (uint32_t t = crew.first; t < crew.end; ++t) take_statistics(t);
}

// What a thread has counted since it was asked last is this pass's.
void Pass::State::take_statistics(uint32_t thread) {
  if (GeometryWorker* worker = store.find_geometry(thread)) {
    thread_times[thread].geometry_ns += worker->statistics.geometry_ns;
    add_statistics(statistics, std::exchange(worker->statistics, {}));
  }
  if (TileWorker* worker = store.find_tile(thread)) {
    thread_times[thread].tiles_ns += worker->statistics.tiles_ns;
    add_statistics(statistics, std::exchange(worker->statistics, {}));
  }
}

// ---- passes beside each other -------------------------------------------------------------------------------------------------

bool Pass::may_wait() const {
  constexpr uint64_t kMostPixels = 256 * 256, kMostPrims = 16384;
  const State& s = *state_;
  if (!s.scene.options.overlap || s.pool.threads() == 1 || s.has_effects || s.statistics.flushes != 0) return false;
  const TileGrid& grid = s.scene.grid;
  const uint64_t pixels = uint64_t(grid.area.x1 - grid.area.x0) * uint64_t(grid.area.y1 - grid.area.y0) * grid.layers;
  return pixels * s.scene.samples() <= kMostPixels && s.recorded_prims <= kMostPrims;
}

bool Pass::shares_memory(const Pass& other) const {
  for (const State::Range& a : state_->attachment_ranges) {
    for (const State::Range& b : other.state_->attachment_ranges) {
      if (a.begin < b.end && b.begin < a.end) return true;
    }
  }
  return false;
}

void Pass::end_together(std::span<Pass* const> passes) {
  if (passes.size() == 1) passes[0]->end();
  if (passes.size() < 2) return;
  passes[0]->state_->pool.parallel_for(static_cast<uint32_t>(passes.size()), [&](uint32_t i, uint32_t thread) {
    State& s = *passes[i]->state_;
    s.choose_tiles(1);
    s.run_recorded(true, {thread, thread + 1, true});
    s.statistics.overlapped = 1;
  });
}

}  // namespace pineda::raster
