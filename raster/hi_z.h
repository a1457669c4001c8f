// Hi-Z of one tile: for every 4x4 block a bound of the depths stored in it, so that blocks whose every fragment must fail the
// depth test are left out before shading.
//
// Why no bit can change: a block's bound is formed from the depth buffer itself, and again whenever waves that may write the
// block have run. Waves that are still queued belong to the same draw, and while it uses the bounds its test lets it move depths
// only away from them (LESS only lowers them). The triangle's side of the comparison has a margin for the rounding of the
// kernel's own
//     z = z0 + l1 * dz1 + l2 * dz2
// With S_i = |l_i_dx| * |x - x0| + |l_i_dy| * |y - y0|, all its roundings together stay below
//     8 * 2^-24 * (|z0| + (1 + S_1) |dz1| + (1 + S_2) |dz2|)
// and the plane below has as many again. With several samples a pixel a block's bound is that of all its samples, whose depths
// have two roundings more, and the plane is bounded over whole pixels.
#pragma once

#include <cstdint>

#include "raster/coverage.h"
#include "raster/geometry_types.h"
#include "raster/small_group.h"
#include "raster/tile_buffer.h"

namespace pineda::raster {

bool hi_z_supports(VkFormat depth_format);

// A triangle's depth over a tile: every fragment of block (bx, by) has at least min(ceiling, max(least, at_origin + bx * dx + by
// * dy)). Depths are negated when the test asks for greater ones.
struct TriangleDepth {
  float least;
  float at_origin, dx_block, dy_block;
  float ceiling;  // clamping may lower a depth to this
};
TriangleDepth triangle_depth(const FragmentPrim& prim, const Draw& draw, const TilePosition& tile);

// The bound without the plane: all that a small triangle is worth.
float least_depth(const FragmentPrim& prim, const Draw& draw, const TilePosition& tile);

// No fragment of the draw is farther than this where depths are clamped; where they are not, a bound that is too near only
// rejects less.
float depth_ceiling(const Draw& draw, uint32_t viewport);

// Twice the bound at the top of this file, and its own rounding.
inline constexpr float kHiZMargin = 0x1p-19f;

class HiZ {
 public:
  // `uniform`: every depth of the buffer is the same (a cleared tile).
  void begin_tile(VkFormat format, const uint8_t* depth_buffer, int32_t size_px, uint32_t samples, bool uniform);
  // Before the first triangle of a draw; no wave may be queued.
  void begin_draw(const Draw& draw);
  // After the depth buffer was changed by something else than a wave.
  void forget();
  // Waves that may write the depth of these blocks of a macro block were queued; all queued waves have run.
  void queued(uint32_t macro, uint32_t blocks) { queued_[macro] |= static_cast<uint16_t>(blocks); }
  void flushed();

  // Of the blocks `wanted` of macro block `macro`, those that may have a fragment that passes.
  uint32_t survivors(uint32_t macro, uint32_t wanted, const TriangleDepth& depth);
  // No fragment of the block with at least this depth can pass.
  bool hides(uint32_t block, float least);

  // The bounds as far as they are known without a look into the depth buffer, for draws that they hold for.
  bool bounded(const Draw& draw) const { return draw.hi_z != HiZMode::kNone && draw.hi_z == direction_; }
  SmallHiZ bounds(float ceiling) const { return {direction_ == HiZMode::kGreater ? -1.0f : 1.0f, ceiling, farthest_}; }

 private:
  static constexpr uint32_t kMacros = kMaxTileBlocks / kLanes;
  void refresh(uint32_t block);

  // Every bound holds while a draw of its direction is at work, also where it is stale: only waves of a draw without bounds can
  // break one, and their blocks are unbounded once they have run.
  VkFormat format_ = VK_FORMAT_UNDEFINED;
  const uint8_t* depth_ = nullptr;
  uint32_t macros_ = 0;
  uint32_t samples_ = 1;
  bool uniform_ = false;
  bool breaks_bounds_ = false;          // the draw whose waves are queued
  HiZMode direction_ = HiZMode::kNone;  // which way farthest_ bounds
  uint16_t queued_[kMacros] = {}, stale_[kMacros] = {};
  alignas(
      64) float farthest_[kMaxTileBlocks];  // kLess: at least every depth of the block; kGreater: at least every negated depth
};

}  // namespace pineda::raster
