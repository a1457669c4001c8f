// The attachments of a pass inside one tile: their buffers, and what happens to them before and after the tile's draws. With
// several samples a pixel the colours of a block whose samples are all equal are kept once (ThreadContext::equal_samples): such
// blocks are cleared, shaded, stored and resolved at the cost of one sample.
#pragma once

#include <array>
#include <cstdint>

#include "raster/scene.h"

namespace pineda::raster {

class TileAttachments {
 public:
  // Moves to a tile and makes room for its attachments.
  void place(const Scene& scene, const TilePosition& position);
  // Load operations, or what an earlier flush of the pass has left in memory.
  void load(const Scene& scene, const TileState& state);
  // Resolves and store operations.
  void store(const Scene& scene);
  // The last flush, for a tile that has nothing to draw in it; of tiles side by side
  // (Scene::fills_with_next()) `rect` covers all. False when nothing had to be written.
  bool finish_untouched(const Scene& scene, const Rect& rect, const TileState& state);

  // Texels of `rect` (tile coordinates) of an attachment become `texel`.
  void fill_rect(const Scene& scene, uint32_t slot, const uint8_t* texel, const Rect& rect);
  // Gives each sample of the block's colours a place of its own.
  void separate_samples(const Scene& scene, uint32_t block);

  ThreadContext& context() { return context_; }
  const uint8_t* depth() const { return context_.depth; }

 private:
  uint8_t* buffer(uint32_t slot);
  uint8_t* memory(const PassAttachment& a, uint32_t sample) const;
  uint8_t* resolve_memory(const PassAttachment& a) const;
  uint32_t block_count() const { return static_cast<uint32_t>(position_.size_px * position_.size_px) / kLanes; }
  void load_slot(const Scene& scene, const TileState& state, uint32_t slot, bool once);
  void store_slot(const Scene& scene, uint32_t slot);
  void resolve_slot(const Scene& scene, uint32_t slot);

  TilePosition position_{};
  ThreadContext context_{};
  PodBuffer<uint8_t> buffers_, resolved_, equal_;
  PodBuffer<FragmentWave> waves_;
};

}  // namespace pineda::raster
