#include "raster/workspace.h"

namespace pineda::raster {
namespace {

constexpr size_t kKeptWorkspaces = 2;
constexpr size_t kKeptChunkBytes = size_t{112} << 20;  // somewhat more than a pass keeps between flushes

}  // namespace

std::unique_ptr<Chunk> Workspace::take_chunk() {
  if (free_chunks.empty()) return std::make_unique<Chunk>();
  std::unique_ptr<Chunk> chunk = std::move(free_chunks.back());
  free_chunks.pop_back();
  return chunk;
}

void Workspace::give_back(std::unique_ptr<Chunk> chunk) {
  chunk->reset();
  free_chunks.push_back(std::move(chunk));
}

std::unique_ptr<Workspace> WorkspaceStore::acquire(uint32_t threads) {
  std::unique_ptr<Workspace> workspace;
  {
    const std::lock_guard lock(mutex_);
    if (!kept_.empty()) {
      workspace = std::move(kept_.back());
      kept_.pop_back();
    }
  }
  if (!workspace) workspace = std::make_unique<Workspace>();
  if (workspace->geometry.size() < threads) workspace->geometry.resize(threads);
  if (workspace->tile.size() < threads) workspace->tile.resize(threads);
  return workspace;
}

void WorkspaceStore::release(std::unique_ptr<Workspace> workspace) {
  workspace->draws.clear();
  size_t kept_bytes = 0;
  std::erase_if(workspace->free_chunks, [&](const std::unique_ptr<Chunk>& chunk) {
    kept_bytes += chunk->capacity_bytes();
    return kept_bytes > kKeptChunkBytes;
  });
  const std::lock_guard lock(mutex_);
  if (kept_.size() < kKeptWorkspaces) kept_.push_back(std::move(workspace));
}

}  // namespace pineda::raster
