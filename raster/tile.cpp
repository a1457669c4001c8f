#include "raster/tile.h"

#include <limits>
#include <type_traits>
#include <utility>

#include "raster/fragment_prim.h"
#include "raster/wave_lanes.h"

namespace pineda::raster {

void TileWorker::place(const Scene& scene, uint32_t tile) {
  const TileGrid& grid = scene.grid;
  position_ = {grid.x_px(tile), grid.y_px(tile), grid.tile_px, grid.rect(tile), grid.layer(tile)};
  attachments_.place(scene, position_);
}

// What a tile's loads and stores move; all passes count it, because it is cheap.
void TileWorker::count_bytes(const Scene& scene, const TileState& state) {
  const Rect& r = position_.rect;
  const uint64_t pixels = uint64_t(r.x1 - r.x0) * uint64_t(r.y1 - r.y0);
  for (uint32_t slot = 0; slot < Scene::kSlots; ++slot) {
    const PassAttachment& a = scene.attachments[slot];
    if (!a.address) continue;
    const uint64_t bytes = pixels * a.texel_bytes;
    const bool covered = state.covered && slot < scene.color_count && scene.options.lazy_memory;
    if ((a.load || state.in_memory) && !covered) statistics.bytes_loaded += bytes * scene.samples();
    if (a.store || !scene.last_flush) statistics.bytes_stored += bytes * scene.samples();
    if (a.resolve.fn && scene.last_flush) statistics.bytes_stored += bytes;
  }
}

void TileWorker::run(const Scene& scene, uint32_t tile, TileState& state) {
  scene_ = &scene;
  place(scene, tile);
  coverage_ = &coverage_functions(scene.options.isa);
  cover_samples_ = cover_samples_function(scene.options.isa, scene.samples());
  small_group_ = small_group_function(scene.options.isa);
  if (scene.samples() > 1 && sample_waves_.empty()) sample_waves_.append(std::size(waves_));
  count_bytes(scene, state);
  attachments_.load(scene, state);
  const PassAttachment& depth = scene.depth();
  hi_z_on_ = scene.options.hi_z && depth.address && hi_z_supports(depth.format);
  hi_z_patience_ = kHiZPatience;
  hi_z_skipped_ = 0;
  if (hi_z_on_) {
    hi_z_.begin_tile(depth.format, attachments_.depth(), position_.size_px, scene.samples(), !depth.load && !state.in_memory);
  }
  draw_list(state);
  attachments_.store(scene);
  state.in_memory = true;
  ++statistics.tiles_touched;
}

void TileWorker::run_untouched(const Scene& scene, uint32_t tile, uint32_t count, const TileState& state) {
  place(scene, tile);
  position_.rect.x1 = scene.grid.rect(tile + count - 1).x1;
  const bool filled = attachments_.finish_untouched(scene, position_.rect, state);
  if (!state.in_memory) (filled ? statistics.tiles_filled : statistics.tiles_untouched) += count;
}

// Fills items_ from the list on; false at its end.
bool TileWorker::gather(const TileState& state, size_t& segment, uint32_t& entry) {
  item_count_ = 0;
  while (segment < state.segments.size() && item_count_ < kMaxItems) {
    constexpr size_t kAhead = 3;
    if (segment + kAhead < state.segments.size()) {
      const TileSegment& next = state.segments[segment + kAhead];
      const uint32_t* const line = next.chunk->entries.data() + next.first;
      for (uint32_t i = 0; i < std::min(next.count, 64u); i += 16) __builtin_prefetch(line + i);
    }
    const TileSegment& s = state.segments[segment];
    const uint32_t* entries = s.chunk->entries.data() + s.first;
    const Triangle* triangles = s.chunk->triangles.data();
    const Batch* batches = s.chunk->batches.data();
    for (; entry < s.count && item_count_ < kMaxItems; ++entry) {
      items_[item_count_++] = {triangles + (entries[entry] & ~kEntryCovers), batches, (entries[entry] & kEntryCovers) != 0};
    }
    if (entry < s.count) break;
    ++segment;
    entry = 0;
  }
  return item_count_ != 0;
}

void TileWorker::draw_list(const TileState& state) {
  draw_ = nullptr;
  group_batch_ = nullptr;
  group_.samples = scene_->samples();
  size_t segment = 0;
  uint32_t entry = 0;
  while (gather(state, segment, entry)) {
    for (uint32_t first = 0; first < item_count_; first += kLanes) draw_group(first, std::min(kLanes, item_count_ - first));
  }
  flush();
}

inline void TileWorker::change_draw(const Batch& batch) {
  if (batch.draw == draw_ && batch.viewport == viewport_) [[likely]]
    return;
  flush();
  begin_draw(*batch.draw, batch.viewport);
}

void TileWorker::draw_item(const Item& item, const Batch& batch) {
  if (draw_->is_clear) [[unlikely]] {
    clear_rect(*scene_, *draw_, *item.triangle);
  } else if (scene_->samples() > 1 || draw_->smooth) {
    draw_triangle<FragmentSampleWave>(*item.triangle, batch, item.covers);
  } else {
    draw_triangle<FragmentWave>(*item.triangle, batch, item.covers);
  }
}

void TileWorker::draw_items(uint32_t first, uint32_t count) {
  for (const Item* item = items_ + first; item < items_ + first + count; ++item) {
    const Batch& batch = batch_of(*item);
    change_draw(batch);
    draw_item(*item, batch);
  }
}

// 16 items. Small triangles that are not seen cost nothing more.
void TileWorker::draw_group(uint32_t first, uint32_t count) {
  const Item* const items = items_ + first;
  const Batch* batches[kLanes] = {&batch_of(items[0])};
  bool same = true;  // nearly always
  for (uint32_t i = 1; i < count; ++i) {
    batches[i] = &batch_of(items[i]);
    same &= batches[i] == batches[0];
  }
  group_.hi_z = nullptr;
  if (same) {
    change_draw(*batches[0]);
    if (draw_->is_clear || draw_->smooth) [[unlikely]]
      return draw_items(first, count);
    if (group_batch_ != batches[0]) group_.batches.set_all(*batches[0]);
    group_batch_ = batches[0];
    if (hi_z_on_ && group_.samples == 1 && hi_z_.bounded(*draw_)) use_hi_z(depth_ceiling(*draw_, viewport_));
  } else {
    set_mixed_group({batches, count});
  }
  cover_group(first, count);
  for (uint32_t left = (group_.seen | ~group_.small) & ((1u << count) - 1); left != 0; left &= left - 1) {
    const auto i = static_cast<uint32_t>(__builtin_ctz(left));
    change_draw(*batches[i]);
    if (group_.small >> i & 1) {
      draw_small(i);
    } else if ((group_.near >> i & 1) && draw_rect_full_) {
      group_.samples == 1 ? draw_near<FragmentWave>(i) : draw_near<FragmentSampleWave>(i);
    } else {
      draw_item(items[i], *batches[i]);
    }
  }
}

// Items of several batches. Hi-Z's bounds must hold for all of their draws.
void TileWorker::set_mixed_group(std::span<const Batch* const> batches) {
  group_batch_ = nullptr;
  bool bounded = hi_z_on_ && group_.samples == 1;
  float ceiling = std::numeric_limits<float>::infinity();
  const Batch* last = nullptr;
  for (uint32_t i = 0; i < batches.size(); ++i) {
    const Batch& batch = *batches[i];
    if (&batch == last) {
      group_.batches.repeat(i);
      continue;
    }
    group_.batches.set(i, batch);
    bounded = bounded && !batch.draw->is_clear && hi_z_.bounded(*batch.draw);
    const bool other = !last || batch.draw != last->draw || batch.viewport != last->viewport;
    if (bounded && other) ceiling = std::min(ceiling, depth_ceiling(*batch.draw, batch.viewport));
    last = &batch;
  }
  if (bounded) use_hi_z(ceiling);
}

inline void TileWorker::use_hi_z(float ceiling) {
  small_hi_z_ = hi_z_.bounds(ceiling);
  group_.hi_z = &small_hi_z_;
}

// Covers the small triangles among the items from `first` on.
void TileWorker::cover_group(uint32_t first, uint32_t count) {
  for (uint32_t i = 0; i < kLanes; ++i) group_.triangles[i] = items_[first + std::min(i, count - 1)].triangle;
  // The records of the next group: a cache miss each, as many as the core can have in flight.
  const uint32_t ahead = std::min(first + 2 * kLanes, item_count_);
  for (uint32_t i = first + kLanes; i < ahead; ++i) __builtin_prefetch(items_[i].triangle);
  group_.x_px = position_.x_px;
  group_.y_px = position_.y_px;
  group_.size_px = position_.size_px;
  small_group_(group_);
  count_hidden(group_.hidden);
}

void TileWorker::begin_draw(const Draw& draw, uint32_t viewport) {
  draw_ = &draw;
  viewport_ = viewport;
  const Rect tile{position_.x_px, position_.y_px, position_.x_px + position_.size_px, position_.y_px + position_.size_px};
  const Rect& rect = draw.rect_at(viewport);
  draw_rect_full_ = rect.contains(tile);
  const Rect r = intersect(rect, tile);
  draw_rect_ = {r.x0 - tile.x0, r.y0 - tile.y0, r.x1 - tile.x0, r.y1 - tile.y0};
  if (hi_z_on_) hi_z_.begin_draw(draw);
  if (draw.smooth && sample_waves_.empty()) sample_waves_.append(std::size(waves_));
  wave_limit_ = hi_z_on_ && draw.hi_z != HiZMode::kNone && draw.writes_depth ? kEagerWaves : kMaxWaves;
}

void TileWorker::clear_rect(const Scene& scene, const Draw& draw, const Triangle& record) {
  const Rect all{record.x_fx8[0], record.y_fx8[0], record.x_fx8[1], record.y_fx8[1]};
  const Rect r = intersect(all, position_.rect);
  if (r.empty()) return;
  const Rect in_tile{r.x0 - position_.x_px, r.y0 - position_.y_px, r.x1 - position_.x_px, r.y1 - position_.y_px};
  attachments_.fill_rect(scene, draw.clear_slot, draw.clear_texel.data(), in_tile);
  if (draw.clear_slot == Scene::kDepthSlot && hi_z_on_) hi_z_.forget();
}

namespace {

inline Rect record_bounds(const Triangle& t, const FragmentWave*) { return pixel_rect(t); }
inline Rect record_bounds(const Triangle& t, const FragmentSampleWave*) { return touched_rect(t); }

}  // namespace

// Covered blocks of the pixels in `box_px` (tile coordinates).
uint32_t TileWorker::cover(const Triangle& t, bool covers, const Rect& box_px, FragmentWave* out) {
  TileEdges edges{};
  if (!covers && make_tile_edges(t, position_.x_px, position_.y_px, position_.size_px, edges) == TileCover::kNone) return 0;
  const CoverFn cover = t.shape() == Shape::kParallelogram ? coverage_->cover_parallelogram : coverage_->cover;
  return cover(edges, block_range(box_px), position_.xy_px(), out);
}

uint32_t TileWorker::cover(const Triangle& t, bool covers, const Rect& box_px, FragmentSampleWave* out) {
  SampleEdges edges{};
  const uint32_t samples = scene_->samples();
  if (!covers && make_sample_edges(t, position_.x_px, position_.y_px, position_.size_px, samples, edges) == TileCover::kNone)
    return 0;
  return cover_samples_(edges, block_range(box_px), position_.xy_px(), out);
}

// Writes waves for the covered blocks of the current draw's rectangle behind those that are queued.
template <class Wave>
uint32_t TileWorker::find_blocks(const Triangle& t, bool covers) {
  Wave* const out = queue<Wave>();
  const Rect box = record_bounds(t, out);
  const Rect r =
      intersect({box.x0 - position_.x_px, box.y0 - position_.y_px, box.x1 - position_.x_px, box.y1 - position_.y_px}, draw_rect_);
  if (r.empty()) return 0;
  if constexpr (std::is_same_v<Wave, FragmentSampleWave>) {
    if (draw_->smooth) return cover_smooth(t, r, out);
  }
  uint32_t count = cover(t, covers, r, out);
  if (draw_->stipples && t.shape() == Shape::kParallelogram) count = cut_by_stipple_length(t, count, out);
  if (t.shape() >= Shape::kPixelLineX) {  // its ends, and what the stipple leaves
    count = cut_to_rect<Wave>(r, count);
    return draw_->packet.line.stippled ? cut_by_stipple<Wave>(t, count) : count;
  }
  return draw_rect_full_ ? count : cut_to_rect<Wave>(draw_rect_, count);
}

template <class Wave>
uint32_t TileWorker::cut_to_rect(const Rect& rect, uint32_t count) {
  Wave* const waves = queue<Wave>();
  uint32_t kept = 0;
  for (uint32_t i = 0; i < count; ++i) {
    Wave wave = waves[i];
    keep_lanes(wave, rect_lanes(rect, header(wave).x_px - position_.x_px, header(wave).y_px - position_.y_px));
    waves[kept] = wave;
    kept += header(wave).coverage != 0;
  }
  return kept;
}

// Calls each(macro, blocks, first, end) for runs of the new waves in one macro block.
template <class Wave, class Each>
inline void TileWorker::for_macros(uint32_t count, const Each& each) {
  Wave* const waves = queue<Wave>();
  const auto block_of = [&](uint32_t i) { return header(waves[i]).block_index; };
  for (uint32_t i = 0; i < count;) {
    const uint32_t macro = block_of(i) / kLanes;
    uint32_t end = i, blocks = 0;
    if (i + kLanes <= count && block_of(i + kLanes - 1) / kLanes == macro) {  // all of its blocks
      end = i + kLanes;
      blocks = 0xFFFF;
    } else {
      for (; end < count && block_of(end) / kLanes == macro; ++end) blocks |= 1u << block_of(end) % kLanes;
    }
    each(macro, blocks, i, end);
    i = end;
  }
}

// Drops new waves whose every fragment must fail the depth test.
template <class Wave>
uint32_t TileWorker::reject_hidden(uint32_t count, const FragmentPrim& prim) {
  Wave* const waves = queue<Wave>();
  uint32_t kept = 0;
  if (count <= kHiZFewBlocks) {
    const float least = least_depth(prim, *draw_, position_);
    for (uint32_t i = 0; i < count; ++i) {
      waves[kept] = waves[i];
      kept += !hi_z_.hides(header(waves[kept]).block_index, least);
    }
  } else {
    const TriangleDepth depth = triangle_depth(prim, *draw_, position_);
    for_macros<Wave>(count, [&](uint32_t macro, uint32_t blocks, uint32_t first, uint32_t end) {
      const uint32_t survivors = hi_z_.survivors(macro, blocks, depth);
      if (survivors == blocks) {
        if (kept != first) std::memmove(waves + kept, waves + first, (end - first) * sizeof(Wave));
        kept += end - first;
        return;
      }
      for (uint32_t i = first; i < end && survivors != 0; ++i) {
        waves[kept] = waves[i];
        kept += survivors >> header(waves[kept]).block_index % kLanes & 1;
      }
    });
  }
  statistics.blocks_hi_z_rejected += count - kept;
  if (kept != count) {
    hi_z_patience_ = kHiZPatience;
  } else if (hi_z_patience_ != 0) {
    --hi_z_patience_;
  }
  return kept;
}

// Where nothing is hidden, looking costs small triangles more than it brings: after a while only every kHiZRetry-th is tested.
inline bool TileWorker::wants_hi_z(uint32_t count) {
  if (!hi_z_on_ || draw_->hi_z == HiZMode::kNone) return false;
  if (count >= kHiZWorthBlocks || hi_z_patience_ != 0) return true;
  hi_z_skipped_ = hi_z_skipped_ + 1 == kHiZRetry ? 0 : hi_z_skipped_ + 1;
  return hi_z_skipped_ == 0;
}

inline void TileWorker::count_hidden(uint32_t blocks) {
  statistics.blocks_hi_z_rejected += blocks;
  if (blocks != 0) hi_z_patience_ = kHiZPatience;
}

// Writes waves for the covered blocks of small triangle i of the group behind those that are queued.
inline uint32_t TileWorker::put_small(uint32_t i) {
  FragmentWave* const waves = waves_ + wave_count_;
  const bool look = group_.hi_z && wants_hi_z(1);  // again: bounds that were stale when the group was tested may hide it now
  uint32_t count = 0, hidden = 0;
  for (uint32_t b = 0; b < 4; ++b) {
    const auto mask = static_cast<uint32_t>(group_.masks[b][i]);
    if (mask == 0) continue;
    const auto xy_px = static_cast<uint32_t>(group_.xy_px[b][i]), block = static_cast<uint32_t>(group_.block[b][i]);
    waves[count] = {0xFFFF, mask, static_cast<uint16_t>(xy_px), static_cast<uint16_t>(xy_px >> 16), block};
    if (look && hi_z_.hides(block, group_.least[i])) {
      ++hidden;
    } else {
      ++count;
    }
  }
  count_hidden(hidden);
  if (hidden == 0 && look && hi_z_patience_ != 0) --hi_z_patience_;
  return count;
}

// Triangle i of the group.
inline void TileWorker::draw_small(uint32_t i) {
  if (prim_count_ == kMaxPrims || wave_count_ >= wave_limit_) flush();
  uint32_t count = put_small(i);
  if (!draw_rect_full_) count = cut_to_rect<FragmentWave>(draw_rect_, count);
  if (count == 0) return;
  prims_[prim_count_] = group_.prims[i];
  if (!group_.hi_z && wants_hi_z(count)) {
    count = reject_hidden<FragmentWave>(count, prims_[prim_count_]);
    if (count == 0) return;
  }
  queue_prim<FragmentWave>(count);
}

inline uint32_t TileWorker::cover_near(uint32_t i, FragmentWave* out) const {
  return coverage_->cover(group_.edges[i], group_.blocks[i], position_.xy_px(), out);
}
inline uint32_t TileWorker::cover_near(uint32_t i, FragmentSampleWave* out) const {
  return cover_samples_(group_.sample_edges[i], group_.blocks[i], position_.xy_px(), out);
}

// Triangle i of the group, with more blocks or samples.
template <class Wave>
inline void TileWorker::draw_near(uint32_t i) {
  if (prim_count_ == kMaxPrims || wave_count_ >= wave_limit_) flush();
  uint32_t count = cover_near(i, queue<Wave>());
  if (count == 0) return;
  prims_[prim_count_] = group_.prims[i];
  if (wants_hi_z(count)) {
    count = reject_hidden<Wave>(count, prims_[prim_count_]);
    if (count == 0) return;
  }
  queue_prim<Wave>(count);
}

// The waves behind those that are queued are of prims_[prim_count_].
template <class Wave>
inline void TileWorker::queue_prim(uint32_t count) {
  if (hi_z_on_ && draw_->writes_depth) {
    if (count <= kHiZFewBlocks) {
      for (uint32_t i = 0; i < count; ++i) {
        const uint32_t block = header(queue<Wave>()[i]).block_index;
        hi_z_.queued(block / kLanes, 1u << block % kLanes);
      }
    } else {
      for_macros<Wave>(count, [&](uint32_t macro, uint32_t blocks, uint32_t, uint32_t) { hi_z_.queued(macro, blocks); });
    }
  }
  records_[prim_count_] = {&prims_[prim_count_], wave_count_, count};
  ++prim_count_;
  wave_count_ += count;
}

template <class Wave>
void TileWorker::draw_triangle(const Triangle& triangle, const Batch& batch, bool covers) {
  if (prim_count_ == kMaxPrims || wave_count_ >= wave_limit_) flush();
  FragmentPrim& prim = prims_[prim_count_];
  uint32_t count = find_blocks<Wave>(triangle, covers);
  if (count == 0) return;
  fill_planes(triangle, prim);
  fill_prim(triangle, batch, prim);
  if (draw_->stipples) prim.dz2 = 0;
  // The depths of pixel lines and smooth ones go on past their ends.
  if (wants_hi_z(count) && triangle.shape() < Shape::kPixelLineX && !draw_->smooth) {
    count = reject_hidden<Wave>(count, prim);
    if (count == 0) return;
  }
  queue_prim<Wave>(count);
}

void TileWorker::flush() {
  if (prim_count_ == 0) return;
  const DrawPacket& packet = draw_->packet;
  ThreadContext& context = attachments_.context();
  if (scene_->samples() == 1 && !draw_->smooth) {
    for (uint32_t i = 0; i < wave_count_; ++i) count_lanes(waves_[i].coverage);
    packet.fragment(packet.context, &context, records_, prim_count_, waves_);
  } else if (!packet.per_sample) {
    for (uint32_t i = 0; i < wave_count_; ++i) count_lanes(sample_waves_[i].wave.coverage);
    packet.fragment(packet.context, &context, records_, prim_count_, sample_waves_.data());
  } else if (draw_->smooth) {
    flush_smooth_samples();
  } else {
    flush_samples();
  }
  statistics.blocks_shaded += wave_count_;
  if (draw_->counters) [[unlikely]]
    draw_->counters->blocks_shaded += wave_count_;
  prim_count_ = wave_count_ = 0;
  if (hi_z_on_) hi_z_.flushed();
  if (packet.samples_passed)
    packet.samples_passed->fetch_add(std::exchange(context.samples_passed, 0), std::memory_order_relaxed);
}

// A kernel that runs for each sample: a wave for each sample that some lane covers.
void TileWorker::flush_samples() {
  const uint32_t samples = scene_->samples();
  expanded_.clear();
  for (uint32_t p = 0; p < prim_count_; ++p) {
    PrimRecord& record = records_[p];
    const auto first = static_cast<uint32_t>(expanded_.size());
    for (uint32_t w = record.first_wave; w < record.first_wave + record.wave_count; ++w) {
      const FragmentSampleWave& wave = sample_waves_[w];
      attachments_.separate_samples(*scene_, wave.wave.block_index);
      for (uint32_t s = 0; s < samples; ++s) {
        uint32_t lanes = 0;
        for (uint32_t lane = 0; lane < kLanes; ++lane) lanes |= (wave.samples[lane] >> s & 1u) << lane;
        if (lanes == 0) continue;
        FragmentWave one = wave.wave;
        one.coverage = lanes;
        one.block_index = wave.wave.block_index * samples + s;
        expanded_.push_back(one);
        count_lanes(lanes);
      }
    }
    record.first_wave = first;
    record.wave_count = static_cast<uint32_t>(expanded_.size()) - first;
  }
  draw_->packet.fragment(draw_->packet.context, &attachments_.context(), records_, prim_count_, expanded_.data());
}

}  // namespace pineda::raster
