// The tile phase: one tile's triangles in API order -> coverage -> Hi-Z -> waves -> fragment kernel, between load and store of
// the attachments.
#pragma once

#include <cstdint>
#include <span>

#include "raster/coverage_samples.h"
#include "raster/hi_z.h"
#include "raster/tile_attachments.h"

namespace pineda::raster {

// One thread's tile work. Reused from tile to tile.
class TileWorker {
 public:
  // Draws a tile's list.
  void run(const Scene& scene, uint32_t tile, TileState& state);
  // `count` tiles side by side from `tile` on that no draw touched in the whole pass; several only with
  // Scene::fills_with_next().
  void run_untouched(const Scene& scene, uint32_t tile, uint32_t count, const TileState& state);

  PassStatistics statistics{};

 private:
  // Waves of one draw are queued and given to its kernel together.
  static constexpr uint32_t kMaxPrims = 128;
  static constexpr uint32_t kMaxWaves = 768;
  static constexpr uint32_t kEagerWaves = 128;  // for draws that write depth under Hi-Z: what is queued hides nothing yet
  static constexpr uint32_t kHiZPatience = 48, kHiZRetry = 16, kHiZWorthBlocks = 12, kHiZFewBlocks = 4;
  static constexpr uint32_t kMaxItems = 512;
  struct Item {
    const Triangle* triangle;
    const Batch* batches;
    bool covers;
  };

  void place(const Scene& scene, uint32_t tile);
  void count_bytes(const Scene& scene, const TileState& state);
  bool gather(const TileState& state, size_t& segment, uint32_t& entry);
  void draw_list(const TileState& state);
  void begin_draw(const Draw& draw, uint32_t viewport);
  const Batch& batch_of(const Item& item) const { return item.batches[item.triangle->batch]; }
  void change_draw(const Batch& batch);
  void draw_group(uint32_t first, uint32_t count);
  void draw_items(uint32_t first, uint32_t count);
  void draw_item(const Item& item, const Batch& batch);
  void cover_group(uint32_t first, uint32_t count);
  void set_mixed_group(std::span<const Batch* const> batches);
  void use_hi_z(float ceiling);
  void draw_small(uint32_t i);
  template <class Wave>
  void draw_near(uint32_t i);
  uint32_t cover_near(uint32_t i, FragmentWave* out) const;
  uint32_t cover_near(uint32_t i, FragmentSampleWave* out) const;
  void clear_rect(const Scene& scene, const Draw& draw, const Triangle& record);
  bool wants_hi_z(uint32_t count);
  void flush();
  void count_lanes(uint32_t lanes) {
    statistics.fragments_shaded += static_cast<uint32_t>(__builtin_popcount(lanes));
    statistics.blocks_accepted += lanes == 0xFFFF;
  }
  void flush_samples();
  void flush_smooth_samples();
  void count_hidden(uint32_t blocks);
  // Wave: FragmentWave, or FragmentSampleWave with several samples a pixel.
  template <class Wave>
  void draw_triangle(const Triangle& triangle, const Batch& batch, bool covers);
  template <class Wave>
  void queue_prim(uint32_t count);
  template <class Wave>
  Wave* queue();
  uint32_t put_small(uint32_t i);
  uint32_t cover(const Triangle& triangle, bool covers, const Rect& box_px, FragmentWave* out);
  uint32_t cover(const Triangle& triangle, bool covers, const Rect& box_px, FragmentSampleWave* out);
  template <class Wave>
  uint32_t find_blocks(const Triangle& triangle, bool covers);
  template <class Wave>
  uint32_t cut_by_stipple(const Triangle& line, uint32_t count);
  uint32_t cut_by_stipple_length(const Triangle& line, uint32_t count, FragmentWave* waves);
  uint32_t cut_by_stipple_length(const Triangle& line, uint32_t count, FragmentSampleWave* waves);
  uint32_t cover_smooth(const Triangle& line, const Rect& box_px, FragmentSampleWave* out);
  template <class Wave>
  uint32_t cut_to_rect(const Rect& rect, uint32_t count);
  template <class Wave>
  uint32_t reject_hidden(uint32_t count, const FragmentPrim& prim);
  template <class Wave, class Each>
  void for_macros(uint32_t count, const Each& each);

  const CoverageFunctions* coverage_ = nullptr;
  CoverSamplesFn cover_samples_ = nullptr;
  SmallGroupFn small_group_ = nullptr;
  const Scene* scene_ = nullptr;
  TilePosition position_{};
  TileAttachments attachments_;
  bool hi_z_on_ = false;
  HiZ hi_z_;
  uint32_t hi_z_patience_ = 0;  // triangles to test until one must have been rejected
  uint32_t hi_z_skipped_ = 0;
  // the draw whose waves are queued
  const Draw* draw_ = nullptr;
  uint32_t viewport_ = 0;
  Rect draw_rect_;              // in tile coordinates
  bool draw_rect_full_ = true;  // it contains the whole tile
  uint32_t wave_limit_ = kMaxWaves;
  uint32_t prim_count_ = 0, wave_count_ = 0;
  FragmentPrim prims_[kMaxPrims];
  PrimRecord records_[kMaxPrims];
  // Coverage writes one past what it keeps.
  FragmentWave waves_[kMaxWaves + kMaxTileBlocks + 1];
  PodBuffer<FragmentSampleWave> sample_waves_;  // instead of them with several samples a pixel
  PodBuffer<FragmentWave> expanded_;            // for kernels that run for each sample
  PodBuffer<FragmentSampleWave> expanded_smooth_;
  uint32_t item_count_ = 0;
  Item items_[kMaxItems];
  SmallGroup group_;  // of the 16 items at hand
  SmallHiZ small_hi_z_{};
  const Batch* group_batch_ = nullptr;  // that all of group_.batches are set to; null: several
};

// Where the next wave goes.
template <>
inline FragmentWave* TileWorker::queue() {
  return waves_ + wave_count_;
}
template <>
inline FragmentSampleWave* TileWorker::queue() {
  return sample_waves_.data() + wave_count_;
}

}  // namespace pineda::raster
