// Memory that passes reuse: per-thread workers, chunks, the list of draws. Fresh pages cost more than the work of a small pass.
#pragma once

#include <array>
#include <memory>
#include <mutex>
#include <vector>

#include "raster/geometry.h"
#include "raster/tile.h"

namespace pineda::raster {

// Draws at fixed addresses.
class DrawList {
 public:
  Draw& append() {
    if (size_ == blocks_.size() * kBlock) blocks_.push_back(std::make_unique<std::array<Draw, kBlock>>());
    Draw& draw = (*this)[size_++];
    draw = {};
    return draw;
  }
  Draw& operator[](size_t i) { return (*blocks_[i / kBlock])[i % kBlock]; }
  size_t size() const { return size_; }
  void clear() { size_ = 0; }

 private:
  static constexpr size_t kBlock = 64;
  std::vector<std::unique_ptr<std::array<Draw, kBlock>>> blocks_;
  size_t size_ = 0;
};

struct Workspace {
  std::vector<std::unique_ptr<GeometryWorker>> geometry;  // by thread; made on first use
  std::vector<std::unique_ptr<TileWorker>> tile;
  std::vector<std::unique_ptr<Chunk>> free_chunks;
  DrawList draws;
  std::vector<TileState> tiles;

  std::unique_ptr<Chunk> take_chunk();
  void give_back(std::unique_ptr<Chunk> chunk);
};

// What a thread pool's passes leave for the next one; thread-safe. Lives as long as the pool, so the memory goes with the device.
class WorkspaceStore {
 public:
  std::unique_ptr<Workspace> acquire(uint32_t threads);
  void release(std::unique_ptr<Workspace> workspace);

 private:
  std::mutex mutex_;
  std::vector<std::unique_ptr<Workspace>> kept_;
};

}  // namespace pineda::raster
