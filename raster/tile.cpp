#include "raster/tile.h"

namespace pineda::raster {
namespace {

// Interpolation's planes from the snapped vertices (base/abi.h). Area and edges are exact in double; each derivative is rounded
// twice.
void fill_planes(const Triangle& t, FragmentPrim& p) {
  if (t.shape() >= Shape::kPixelLineX) {  // l1: the projection on the line
    const double dx = t.x_fx8[1] - t.x_fx8[0], dy = t.y_fx8[1] - t.y_fx8[0];
    const double per_px = kSubpixels / (dx * dx + dy * dy);
    p.l1_dx = static_cast<float>(dx * per_px);
    p.l1_dy = static_cast<float>(dy * per_px);
    p.l2_dx = p.l2_dy = 0;
    return;
  }
  const double x1 = t.x_fx8[1] - t.x_fx8[0], y1 = t.y_fx8[1] - t.y_fx8[0];
  const double x2 = t.x_fx8[2] - t.x_fx8[0], y2 = t.y_fx8[2] - t.y_fx8[0];
  const double per_px = kSubpixels / (x1 * y2 - y1 * x2);
  p.l1_dx = static_cast<float>(y2 * per_px);
  p.l1_dy = static_cast<float>(-x2 * per_px);
  p.l2_dx = static_cast<float>(-y1 * per_px);
  p.l2_dy = static_cast<float>(x1 * per_px);
}

// Everything but the planes.
inline void fill_prim(const Triangle& t, const Batch& batch, FragmentPrim& p) {
  p.x0_px = static_cast<float>(t.x_fx8[0]) * (1.0f / kSubpixels);
  p.y0_px = static_cast<float>(t.y_fx8[0]) * (1.0f / kSubpixels);
  p.z0 = t.z0;
  p.dz1 = t.dz1;
  p.dz2 = t.dz2;
  p.iw0 = t.iw[0];
  p.iw1 = t.iw[1];
  p.iw2 = t.iw[2];
  const size_t wave_floats = size_t{batch.draw->packet.vertex_slots} * kLanes;
  const auto vertex = [&](uint32_t v) { return batch.vertices + v / kLanes * wave_floats + v % kLanes; };
  for (int k = 0; k < 3; ++k) p.vertex[k] = vertex(t.vertex[k]);
  p.front_facing = (t.provoking_and_flags & Triangle::kFront) != 0;
  p.primitive_id = t.primitive_id;
  p.layer = 0;
  p.viewport_index = batch.viewport;
  p.reserved = 0;
  p.flat_offset_bytes = static_cast<int32_t>((vertex(t.provoking_and_flags & Triangle::kProvokingMask) - p.vertex[0]) *
                                             static_cast<ptrdiff_t>(sizeof(float)));
}

}  // namespace

// Moves to a tile and makes room for its attachments.
void TileWorker::place(const Scene& scene, uint32_t tile) {
  const int32_t size = scene.grid.tile_px;
  position_ = {static_cast<int32_t>(tile % scene.grid.columns) * size, static_cast<int32_t>(tile / scene.grid.columns) * size,
               size, scene.grid.rect(tile)};
  const auto px = static_cast<size_t>(size) * static_cast<size_t>(size);
  size_t bytes = 0;
  for (uint32_t i = 0; i <= scene.color_count; ++i) {
    const PassAttachment& a = i < scene.color_count ? scene.color[i] : scene.depth;
    buffer_offset_[i] = bytes;
    bytes += a.address ? px * a.texel_bytes : 0;
  }
  if (buffers_.size() < bytes) buffers_.append(bytes - buffers_.size());
  for (uint32_t i = 0; i < kMaxColorAttachments; ++i) {
    context_.color[i] = i < scene.color_count && scene.color[i].address ? buffers_.data() + buffer_offset_[i] : nullptr;
  }
  context_.depth = scene.depth.address ? buffers_.data() + buffer_offset_[scene.color_count] : nullptr;
}

void TileWorker::load(const Scene& scene, const TileState& state) {
  const auto load_one = [&](const PassAttachment& a, uint8_t* buffer) {
    if (a.load || state.in_memory) {
      load_tile(a, position_, buffer);
    } else {
      clear_tile(a.texel_bytes, a.clear_texel.data(), position_.size_px, buffer);
    }
  };
  for (uint32_t i = 0; i < scene.color_count; ++i) {
    if (context_.color[i] && !state.covered) load_one(scene.color[i], context_.color[i]);
  }
  if (context_.depth) load_one(scene.depth, context_.depth);
}

void TileWorker::store(const Scene& scene) {
  const auto store_one = [&](const PassAttachment& a, const uint8_t* buffer) {
    if (a.store || !scene.last_flush) store_tile(a, position_, buffer);
  };
  for (uint32_t i = 0; i < scene.color_count; ++i) {
    if (context_.color[i]) store_one(scene.color[i], context_.color[i]);
  }
  if (context_.depth) store_one(scene.depth, context_.depth);
}

void TileWorker::run(const Scene& scene, uint32_t tile, TileState& state) {
  place(scene, tile);
  coverage_ = &coverage_functions(scene.options.isa);
  load(scene, state);
  hi_z_on_ = scene.options.hi_z && context_.depth && hi_z_supports(scene.depth.format);
  hi_z_patience_ = kHiZPatience;
  hi_z_skipped_ = 0;
  if (hi_z_on_) hi_z_.begin_tile(scene.depth.format, context_.depth, position_.size_px, !scene.depth.load && !state.in_memory);
  draw_list(scene, state);
  store(scene);
  state.in_memory = true;
  ++statistics.tiles_touched;
}

void TileWorker::run_untouched(const Scene& scene, uint32_t tile, const TileState& state) {
  if (state.in_memory) return;
  bool filled = false;
  const auto fill = [&](const PassAttachment& a) {
    if (!a.address || a.load || !a.store) return;
    filled = true;
    if (scene.options.fast_clear) {
      fill_memory_rect(a, a.clear_texel.data(), position_.rect);
    } else {  // the long way round, for comparison
      uint8_t* buffer = buffers_.data();
      clear_tile(a.texel_bytes, a.clear_texel.data(), position_.size_px, buffer);
      store_tile(a, position_, buffer);
    }
  };
  place(scene, tile);
  for (uint32_t i = 0; i < scene.color_count; ++i) fill(scene.color[i]);
  fill(scene.depth);
  ++(filled ? statistics.tiles_filled : statistics.tiles_untouched);
}

// Fills items_ from the list on; false at its end.
bool TileWorker::gather(const TileState& state, size_t& segment, uint32_t& entry) {
  item_count_ = 0;
  while (segment < state.segments.size() && item_count_ < kMaxItems) {
    constexpr size_t kAhead = 3;
    if (segment + kAhead < state.segments.size()) {
      const TileSegment& next = state.segments[segment + kAhead];
      __builtin_prefetch(next.chunk->entries.data() + next.first);
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

void TileWorker::draw_list(const Scene& scene, const TileState& state) {
  draw_ = nullptr;
  size_t segment = 0;
  uint32_t entry = 0;
  while (gather(state, segment, entry)) {
    for (uint32_t i = 0; i < item_count_; ++i) {
      if (i % kLanes == 0) prepare_group(i);
      const Item& item = items_[i];
      const Batch& batch = item.batches[item.triangle->batch];
      if (batch.draw != draw_) {
        flush();
        begin_draw(*batch.draw);
      }
      if (batch.draw->is_clear) [[unlikely]] {
        clear_rect(scene, *batch.draw, *item.triangle);
      } else {
        draw_triangle(i % kLanes, *item.triangle, batch, item.covers);
      }
    }
  }
  flush();
}

// Covers the small triangles among the 16 items from `first` on.
void TileWorker::prepare_group(uint32_t first) {
  const Triangle* triangles[kLanes];
  for (uint32_t i = 0; i < kLanes; ++i) triangles[i] = items_[std::min(first + i, item_count_ - 1)].triangle;
  // The records of the next group: a cache miss each, as many as the core can have in flight.
  const uint32_t ahead = std::min(first + 2 * kLanes, item_count_);
  for (uint32_t i = first + kLanes; i < ahead; ++i) __builtin_prefetch(items_[i].triangle);
  coverage_->cover_small(triangles, position_.x_px, position_.y_px, position_.size_px, group_);
}

void TileWorker::begin_draw(const Draw& draw) {
  draw_ = &draw;
  const Rect tile{position_.x_px, position_.y_px, position_.x_px + position_.size_px, position_.y_px + position_.size_px};
  draw_rect_full_ = draw.rect.contains(tile);
  const Rect r = intersect(draw.rect, tile);
  draw_rect_ = {r.x0 - tile.x0, r.y0 - tile.y0, r.x1 - tile.x0, r.y1 - tile.y0};
  if (hi_z_on_) hi_z_.begin_draw(draw);
  wave_limit_ = hi_z_on_ && draw.hi_z != HiZMode::kNone && draw.writes_depth ? kEagerWaves : kMaxWaves;
}

void TileWorker::clear_rect(const Scene& scene, const Draw& draw, const Triangle& record) {
  const Rect all{record.x_fx8[0], record.y_fx8[0], record.x_fx8[1], record.y_fx8[1]};
  const Rect r = intersect(all, position_.rect);
  if (r.empty()) return;
  const bool is_depth = draw.clear_attachment == Pass::kDepth;
  const PassAttachment& a = is_depth ? scene.depth : scene.color[draw.clear_attachment];
  const Rect in_tile{r.x0 - position_.x_px, r.y0 - position_.y_px, r.x1 - position_.x_px, r.y1 - position_.y_px};
  fill_tile_rect(a.texel_bytes, draw.clear_texel.data(), in_tile,
                 is_depth ? context_.depth : context_.color[draw.clear_attachment]);
  if (is_depth && hi_z_on_) hi_z_.forget();
}

// Writes waves for the covered blocks of the current draw's rectangle behind those that are queued.
uint32_t TileWorker::find_blocks(const Triangle& t, bool covers) {
  const Rect box = pixel_rect(t);
  const Rect r =
      intersect({box.x0 - position_.x_px, box.y0 - position_.y_px, box.x1 - position_.x_px, box.y1 - position_.y_px}, draw_rect_);
  if (r.empty()) return 0;
  TileEdges edges{};
  if (!covers && make_tile_edges(t, position_.x_px, position_.y_px, position_.size_px, edges) == TileCover::kNone) return 0;
  const auto block = [](int32_t px) { return static_cast<uint32_t>(px) / kBlockDim; };
  const BlockRange range{block(r.x0), block(r.y0), block(r.x1 + 3), block(r.y1 + 3)};
  const uint32_t tile_xy_px = static_cast<uint32_t>(position_.x_px) + (static_cast<uint32_t>(position_.y_px) << 16);
  const CoverFn cover = t.shape() == Shape::kParallelogram ? coverage_->cover_parallelogram : coverage_->cover;
  const uint32_t count = cover(edges, range, tile_xy_px, waves_ + wave_count_);
  if (t.shape() >= Shape::kPixelLineX) return cut_to_rect(r, count);  // its ends
  return draw_rect_full_ ? count : cut_to_rect(draw_rect_, count);
}

uint32_t TileWorker::cut_to_rect(const Rect& rect, uint32_t count) {
  FragmentWave* const waves = waves_ + wave_count_;
  uint32_t kept = 0;
  for (uint32_t i = 0; i < count; ++i) {
    FragmentWave wave = waves[i];
    wave.coverage &= rect_lanes(rect, wave.x_px - position_.x_px, wave.y_px - position_.y_px);
    waves[kept] = wave;
    kept += wave.coverage != 0;
  }
  return kept;
}

// Calls each(macro, blocks, first, end) for runs of the new waves in one macro block.
template <class Each>
inline void TileWorker::for_macros(uint32_t count, const Each& each) {
  const FragmentWave* const waves = waves_ + wave_count_;
  for (uint32_t i = 0; i < count;) {
    const uint32_t macro = waves[i].block_index / kLanes;
    uint32_t end = i, blocks = 0;
    if (i + kLanes <= count && waves[i + kLanes - 1].block_index / kLanes == macro) {  // all of its blocks
      end = i + kLanes;
      blocks = 0xFFFF;
    } else {
      for (; end < count && waves[end].block_index / kLanes == macro; ++end) blocks |= 1u << waves[end].block_index % kLanes;
    }
    each(macro, blocks, i, end);
    i = end;
  }
}

// Drops new waves whose every fragment must fail the depth test.
uint32_t TileWorker::reject_hidden(uint32_t count, const FragmentPrim& prim) {
  FragmentWave* const waves = waves_ + wave_count_;
  uint32_t kept = 0;
  if (count <= kHiZFewBlocks) {
    const float least = least_depth(prim, *draw_, position_);
    for (uint32_t i = 0; i < count; ++i) {
      waves[kept] = waves[i];
      kept += !hi_z_.hides(waves[kept].block_index, least);
    }
  } else {
    const TriangleDepth depth = triangle_depth(prim, *draw_, position_);
    for_macros(count, [&](uint32_t macro, uint32_t blocks, uint32_t first, uint32_t end) {
      const uint32_t survivors = hi_z_.survivors(macro, blocks, depth);
      if (survivors == blocks) {
        if (kept != first) std::memmove(waves + kept, waves + first, (end - first) * sizeof(FragmentWave));
        kept += end - first;
        return;
      }
      for (uint32_t i = first; i < end && survivors != 0; ++i) {
        waves[kept] = waves[i];
        kept += survivors >> waves[kept].block_index % kLanes & 1;
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

// Writes waves for the covered blocks of small triangle i of the group behind those that are queued.
inline uint32_t TileWorker::put_small(uint32_t i) {
  FragmentWave* const waves = waves_ + wave_count_;
  uint32_t count = 0;
  for (uint32_t b = 0; b < 4; ++b) {
    const auto mask = static_cast<uint32_t>(group_.masks[b][i]), xy_px = static_cast<uint32_t>(group_.xy_px[b][i]);
    waves[count] = {0xFFFF, mask, static_cast<uint16_t>(xy_px), static_cast<uint16_t>(xy_px >> 16),
                    static_cast<uint32_t>(group_.block[b][i])};
    count += mask != 0;
  }
  return count;
}

// Triangle i of the group.
void TileWorker::draw_triangle(uint32_t i, const Triangle& triangle, const Batch& batch, bool covers) {
  if (prim_count_ == kMaxPrims || wave_count_ >= wave_limit_) flush();
  FragmentPrim& prim = prims_[prim_count_];
  uint32_t count;
  if ((group_.small >> i & 1) && triangle.shape() == Shape::kTriangle) {
    if ((group_.masks[0][i] | group_.masks[1][i] | group_.masks[2][i] | group_.masks[3][i]) == 0) return;
    count = put_small(i);
    if (!draw_rect_full_) count = cut_to_rect(draw_rect_, count);
    if (count == 0) return;
    prim.l1_dx = group_.planes[0][i];
    prim.l1_dy = group_.planes[1][i];
    prim.l2_dx = group_.planes[2][i];
    prim.l2_dy = group_.planes[3][i];
  } else {
    count = find_blocks(triangle, covers);
    if (count == 0) return;
    fill_planes(triangle, prim);
  }
  fill_prim(triangle, batch, prim);
  if (wants_hi_z(count) && triangle.shape() < Shape::kPixelLineX) {  // whose depths go on past their ends
    count = reject_hidden(count, prim);
    if (count == 0) return;
  }
  if (hi_z_on_ && draw_->writes_depth) {
    for_macros(count, [&](uint32_t macro, uint32_t blocks, uint32_t, uint32_t) { hi_z_.queued(macro, blocks); });
  }
  records_[prim_count_] = {&prim, wave_count_, count};
  ++prim_count_;
  wave_count_ += count;
}

void TileWorker::flush() {
  if (prim_count_ == 0) return;
  draw_->packet.fragment(draw_->packet.context, &context_, records_, prim_count_, waves_);
  statistics.blocks_shaded += wave_count_;
  prim_count_ = wave_count_ = 0;
  if (hi_z_on_) hi_z_.flushed();
}

}  // namespace pineda::raster
