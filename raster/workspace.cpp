#include "raster/workspace.h"

namespace pineda::raster {
namespace {

constexpr size_t kKeptWorkspaces = 64;                 // as many passes as are likely to wait for each other
constexpr size_t kKeptChunkBytes = size_t{112} << 20;  // somewhat more than a pass keeps between flushes

template <class Worker>
Worker& made(std::unique_ptr<Worker>& worker) {
  if (!worker) worker = std::make_unique<Worker>();
  return *worker;
}

// The last of `kept`, or a new one.
template <class T>
std::unique_ptr<T> take(std::mutex& mutex, std::vector<std::unique_ptr<T>>& kept) {
  {
    const std::lock_guard lock(mutex);
    if (!kept.empty()) {
      std::unique_ptr<T> last = std::move(kept.back());
      kept.pop_back();
      return last;
    }
  }
  return std::make_unique<T>();
}

}  // namespace

GeometryWorker& WorkspaceStore::geometry(uint32_t thread) { return made(geometry_[thread]); }
TileWorker& WorkspaceStore::tile(uint32_t thread) { return made(tile_[thread]); }

std::unique_ptr<Workspace> WorkspaceStore::acquire() { return take(mutex_, kept_); }

void WorkspaceStore::release(std::unique_ptr<Workspace> workspace) {
  workspace->draws.clear();
  const std::lock_guard lock(mutex_);
  if (kept_.size() < kKeptWorkspaces) kept_.push_back(std::move(workspace));
}

std::unique_ptr<Chunk> WorkspaceStore::take_chunk() { return take(mutex_, free_chunks_); }

void WorkspaceStore::give_back(std::unique_ptr<Chunk> chunk) {
  chunk->reset();
  const std::lock_guard lock(mutex_);
  free_chunks_.push_back(std::move(chunk));
}

void WorkspaceStore::trim() {
  const std::lock_guard lock(mutex_);
  size_t kept_bytes = 0;
  std::erase_if(free_chunks_, [&](const std::unique_ptr<Chunk>& chunk) {
    kept_bytes += chunk->capacity_bytes();
    return kept_bytes > kKeptChunkBytes;
  });
}

}  // namespace pineda::raster
