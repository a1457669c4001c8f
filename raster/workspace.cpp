#include "raster/workspace.h"

#include <mutex>

namespace pineda::raster {
namespace {

constexpr size_t kKeptWorkspaces = 2;
constexpr size_t kKeptChunkBytes = size_t{112} << 20;  // somewhat more than a pass keeps between flushes

struct Store {
  std::mutex mutex;
  std::vector<std::unique_ptr<Workspace>> workspaces;
};

Store& store() {
  static Store* const instance = new Store;  // never destroyed: a driver may be used while static objects die
  return *instance;
}

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

std::unique_ptr<Workspace> acquire_workspace(uint32_t threads) {
  std::unique_ptr<Workspace> workspace;
  {
    Store& s = store();
    const std::lock_guard lock(s.mutex);
    if (!s.workspaces.empty()) {
      workspace = std::move(s.workspaces.back());
      s.workspaces.pop_back();
    }
  }
  if (!workspace) workspace = std::make_unique<Workspace>();
  if (workspace->geometry.size() < threads) workspace->geometry.resize(threads);
  if (workspace->tile.size() < threads) workspace->tile.resize(threads);
  return workspace;
}

void release_workspace(std::unique_ptr<Workspace> workspace) {
  workspace->draws.clear();
  size_t kept_bytes = 0;
  std::erase_if(workspace->free_chunks, [&](const std::unique_ptr<Chunk>& chunk) {
    kept_bytes += chunk->capacity_bytes();
    return kept_bytes > kKeptChunkBytes;
  });
  Store& s = store();
  const std::lock_guard lock(s.mutex);
  if (s.workspaces.size() < kKeptWorkspaces) s.workspaces.push_back(std::move(workspace));
}

}  // namespace pineda::raster
