// What lines add to a tile: stipples, and coverage by area.
#include "raster/line_area.h"
#include "raster/tile.h"
#include "raster/wave_lanes.h"

namespace pineda::raster {

// "Line Stipple": pixel number s of the line, counted from its first vertex, is drawn if bit s / factor (modulo 16) is set.
template <class Wave>
uint32_t TileWorker::cut_by_stipple(const Triangle& line, uint32_t count) {
  constexpr uint32_t kColumn[4] = {0x0505, 0x0A0A, 0x5050, 0xA0A0}, kRow[4] = {0x0033, 0x00CC, 0x3300, 0xCC00};  // their lanes
  Wave* const waves = queue<Wave>();
  const LineState& state = draw_->packet.line;
  const bool is_x = line.shape() == Shape::kPixelLineX;
  const int32_t first = line.x_fx8[2], end = line.y_fx8[2];  // pixels of the longer axis
  const bool forwards = is_x ? line.x_fx8[0] <= line.x_fx8[1] : line.y_fx8[0] <= line.y_fx8[1];
  uint32_t kept = 0;
  for (uint32_t i = 0; i < count; ++i) {
    Wave wave = waves[i];
    const int32_t origin = is_x ? header(wave).x_px : header(wave).y_px;
    uint32_t lanes = 0;
    for (int32_t k = 0; k < int32_t{kBlockDim}; ++k) {
      const auto number = static_cast<uint32_t>(forwards ? origin + k - first : end - 1 - origin - k);
      const bool draws = (state.stipple_pattern >> (line.stipple_start() + number) / state.stipple_factor % 16 & 1u) != 0;
      if (draws) lanes |= is_x ? kColumn[k] : kRow[k];
    }
    keep_lanes(wave, lanes);
    waves[kept] = wave;
    kept += header(wave).coverage != 0;
  }
  return kept;
}
template uint32_t TileWorker::cut_by_stipple<FragmentWave>(const Triangle&, uint32_t);
template uint32_t TileWorker::cut_by_stipple<FragmentSampleWave>(const Triangle&, uint32_t);

uint32_t TileWorker::cut_by_stipple_length(const Triangle& line, uint32_t count, FragmentWave* waves) {
  const LineStipple stipple(line, draw_->packet.line);
  uint32_t kept = 0;
  for (uint32_t i = 0; i < count; ++i) {
    FragmentWave wave = waves[i];
    for (uint32_t left = wave.coverage; left != 0; left &= left - 1) {
      const auto lane = static_cast<uint32_t>(__builtin_ctz(left));
      const auto x = static_cast<int32_t>(wave.x_px + morton_x(lane)), y = static_cast<int32_t>(wave.y_px + morton_y(lane));
      if (!stipple.draws(x * kSubpixels + kSubpixels / 2, y * kSubpixels + kSubpixels / 2)) wave.coverage &= ~(1u << lane);
    }
    waves[kept] = wave;
    kept += wave.coverage != 0;
  }
  return kept;
}

// Each sample where it lies.
uint32_t TileWorker::cut_by_stipple_length(const Triangle& line, uint32_t count, FragmentSampleWave* waves) {
  const LineStipple stipple(line, draw_->packet.line);
  const SampleLocation* const locations = sample_locations(scene_->samples());
  uint32_t kept = 0;
  for (uint32_t i = 0; i < count; ++i) {
    FragmentSampleWave wave = waves[i];
    for (uint32_t left = wave.wave.coverage; left != 0; left &= left - 1) {
      const auto lane = static_cast<uint32_t>(__builtin_ctz(left));
      const auto x = static_cast<int32_t>(wave.wave.x_px + morton_x(lane)),
                 y = static_cast<int32_t>(wave.wave.y_px + morton_y(lane));
      for (uint32_t s = 0; s < scene_->samples(); ++s) {
        constexpr int32_t kPerSixteenth = kSubpixels / 16;
        const bool draws =
            stipple.draws(x * kSubpixels + locations[s].x * kPerSixteenth, y * kSubpixels + locations[s].y * kPerSixteenth);
        if (!draws) wave.samples[lane] &= static_cast<uint16_t>(~(1u << s));
      }
      if (wave.samples[lane] == 0) wave.wave.coverage &= ~(1u << lane);
    }
    waves[kept] = wave;
    kept += wave.wave.coverage != 0;
  }
  return kept;
}

// Of a smooth line every pixel that it touches, with the area in place of a mask of samples.
uint32_t TileWorker::cover_smooth(const Triangle& line, const Rect& box_px, FragmentSampleWave* out) {
  constexpr int32_t kMacroPx = 16;
  const LineArea area(line, draw_->packet.line, draw_->stipples, scene_->options.isa);
  const auto macros = static_cast<uint32_t>(position_.size_px * position_.size_px) / (kMacroPx * kMacroPx);
  uint32_t count = 0;
  for (uint32_t macro = 0; macro < macros; ++macro) {
    const auto macro_x = static_cast<int32_t>(morton_x(macro)) * kMacroPx,
               macro_y = static_cast<int32_t>(morton_y(macro)) * kMacroPx;
    if (intersect(box_px, {macro_x, macro_y, macro_x + kMacroPx, macro_y + kMacroPx}).empty()) continue;
    if (area.misses(position_.x_px + macro_x, position_.y_px + macro_y, kMacroPx)) continue;
    for (uint32_t i = 0; i < kLanes; ++i) {
      const auto x = macro_x + static_cast<int32_t>(morton_x(i) * kBlockDim),
                 y = macro_y + static_cast<int32_t>(morton_y(i) * kBlockDim);
      const uint32_t lanes =
          box_px.contains({x, y, x + int32_t{kBlockDim}, y + int32_t{kBlockDim}}) ? 0xFFFF : rect_lanes(box_px, x, y);
      const int32_t x_px = position_.x_px + x, y_px = position_.y_px + y;
      if (lanes == 0 || area.misses(x_px, y_px, kBlockDim)) continue;
      FragmentSampleWave& wave = out[count];
      wave.wave = {0xFFFF, 0, static_cast<uint16_t>(x_px), static_cast<uint16_t>(y_px), macro * kLanes + i};
      area.block(x_px, y_px, wave.samples);
      for (uint32_t lane = 0; lane < kLanes; ++lane) wave.wave.coverage |= static_cast<uint32_t>(wave.samples[lane] != 0) << lane;
      keep_lanes(wave, lanes);
      count += wave.wave.coverage != 0;
    }
  }
  return count;
}

// The same for smooth lines, which cover all samples of the pixels that they touch.
void TileWorker::flush_smooth_samples() {
  const uint32_t samples = scene_->samples();
  expanded_smooth_.clear();
  for (uint32_t p = 0; p < prim_count_; ++p) {
    PrimRecord& record = records_[p];
    const auto first = static_cast<uint32_t>(expanded_smooth_.size());
    for (uint32_t w = record.first_wave; w < record.first_wave + record.wave_count; ++w) {
      FragmentSampleWave wave = sample_waves_[w];
      const uint32_t block = wave.wave.block_index;
      attachments_.separate_samples(*scene_, block);
      for (uint32_t s = 0; s < samples; ++s) {
        wave.wave.block_index = block * samples + s;
        expanded_smooth_.push_back(wave);
        count_lanes(wave.wave.coverage);
      }
    }
    record.first_wave = first;
    record.wave_count = static_cast<uint32_t>(expanded_smooth_.size()) - first;
  }
  draw_->packet.fragment(draw_->packet.context, &attachments_.context(), records_, prim_count_, expanded_smooth_.data());
}

}  // namespace pineda::raster
