// What both kinds of waves have: a header, and lanes that can be dropped.
#pragma once

#include "base/abi.h"
#include "raster/coverage.h"

namespace pineda::raster {

inline FragmentWave& header(FragmentWave& wave) { return wave; }
inline FragmentWave& header(FragmentSampleWave& wave) { return wave.wave; }

inline void keep_lanes(FragmentWave& wave, uint32_t lanes) { wave.coverage &= lanes; }
inline void keep_lanes(FragmentSampleWave& wave, uint32_t lanes) {
  wave.wave.coverage &= lanes;
  if (lanes == 0xFFFF) return;
  for (uint32_t lane = 0; lane < kLanes; ++lane) wave.samples[lane] &= static_cast<uint16_t>(-(lanes >> lane & 1));
}

// Blocks that a rectangle of pixels touches.
inline BlockRange block_range(const Rect& r) {
  const auto block = [](int32_t px) { return static_cast<uint32_t>(px) / kBlockDim; };
  return {block(r.x0), block(r.y0), block(r.x1 + 3), block(r.y1 + 3)};
}

}  // namespace pineda::raster
