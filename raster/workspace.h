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
  DrawList draws;
  std::vector<TileState> tiles;
};

// What a thread pool's passes leave for the next one. Lives as long as the pool, so the memory goes with the device. Thread-safe;
// a thread's workers belong to whoever runs as that thread of the pool.
class WorkspaceStore {
 public:
  explicit WorkspaceStore(uint32_t threads) : geometry_(threads), tile_(threads) {}

  GeometryWorker& geometry(uint32_t thread);  // made on first use
  TileWorker& tile(uint32_t thread);
  // Null when it never worked.
  GeometryWorker* find_geometry(uint32_t thread) { return geometry_[thread].get(); }
  TileWorker* find_tile(uint32_t thread) { return tile_[thread].get(); }

  std::unique_ptr<Workspace> acquire();
  void release(std::unique_ptr<Workspace> workspace);
  std::unique_ptr<Chunk> take_chunk();
  void give_back(std::unique_ptr<Chunk> chunk);
  void trim();  // gives memory of chunks back when it is more than the next pass is likely to want

 private:
  std::vector<std::unique_ptr<GeometryWorker>> geometry_;
  std::vector<std::unique_ptr<TileWorker>> tile_;
  std::mutex mutex_;  // guards what follows
  std::vector<std::unique_ptr<Workspace>> kept_;
  std::vector<std::unique_ptr<Chunk>> free_chunks_;
};

}  // namespace pineda::raster
