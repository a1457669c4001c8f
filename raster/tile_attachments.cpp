#include "raster/tile_attachments.h"

#include "base/srgb.h"
#include "raster/coverage.h"

namespace pineda::raster {
namespace {

// What resolve kernels read of a draw: the tables of sRGB.
const DrawContext& resolve_context() {
  static const DrawContext context = [] {
    DrawContext c{};
    set_srgb_tables(c);
    return c;
  }();
  return context;
}

}  // namespace

uint8_t* TileAttachments::buffer(uint32_t slot) {
  if (slot == Scene::kDepthSlot) return context_.depth;
  if (slot == Scene::kStencilSlot) return context_.stencil;
  return context_.color[slot];
}

// Texel (0, 0) of a sample in the tile's layer.
uint8_t* TileAttachments::memory(const PassAttachment& a, uint32_t sample) const {
  return a.address + position_.layer * a.layer_pitch_bytes + sample * a.sample_pitch_bytes;
}

uint8_t* TileAttachments::resolve_memory(const PassAttachment& a) const {
  return a.resolve_address + position_.layer * a.resolve_layer_pitch_bytes;
}

void TileAttachments::place(const Scene& scene, const TilePosition& position) {
  position_ = position;
  const size_t texels = static_cast<size_t>(position.size_px) * static_cast<size_t>(position.size_px) * scene.samples();
  std::array<size_t, Scene::kSlots> offset{};
  size_t bytes = 0;
  for (uint32_t slot = 0; slot < Scene::kSlots; ++slot) {
    offset[slot] = bytes;
    if (scene.attachments[slot].address) bytes += texels * scene.attachments[slot].texel_bytes;
  }
  if (buffers_.size() < bytes) buffers_.append(bytes - buffers_.size());
  const auto at = [&](uint32_t slot) { return scene.attachments[slot].address ? buffers_.data() + offset[slot] : nullptr; };
  for (uint32_t i = 0; i < kMaxColorAttachments; ++i) context_.color[i] = at(i);
  context_.depth = at(Scene::kDepthSlot);
  context_.stencil = at(Scene::kStencilSlot);
  if (equal_.size() < kMaxTileBlocks) equal_.append(kMaxTileBlocks);
  context_.equal_samples = equal_.data();
}

// `once`: only sample 0.
void TileAttachments::load_slot(const Scene& scene, const TileState& state, uint32_t slot, bool once) {
  const PassAttachment& a = scene.attachments[slot];
  const size_t plane_bytes = size_t{kLanes} * a.texel_bytes;
  for (uint32_t s = 0; s < (once ? 1 : scene.samples()); ++s) {
    const SamplePlane to{buffer(slot) + s * plane_bytes, scene.samples()};
    if (a.load || state.in_memory) {
      load_tile(a, memory(a, s), position_, to);
    } else {
      clear_tile(a.texel_bytes, a.clear_texel.data(), position_.size_px, to);
    }
  }
}

void TileAttachments::load(const Scene& scene, const TileState& state) {
  bool from_memory = state.in_memory;
  for (uint32_t i = 0; i < scene.color_count; ++i) from_memory |= context_.color[i] && scene.attachments[i].load;
  const bool once = !from_memory && scene.options.equal_samples;
  if (scene.samples() > 1) {
    const bool replaced = state.covered && scene.options.lazy_memory;
    std::memset(equal_.data(), scene.options.equal_samples && (once || replaced), block_count());
  }
  const bool covered = state.covered && scene.options.lazy_memory;
  for (uint32_t i = 0; i < scene.color_count; ++i) {
    if (context_.color[i] && !covered) load_slot(scene, state, i, once);
  }
  if (context_.depth) load_slot(scene, state, Scene::kDepthSlot, false);
  if (context_.stencil) load_slot(scene, state, Scene::kStencilSlot, false);
}

void TileAttachments::store_slot(const Scene& scene, uint32_t slot) {
  const PassAttachment& a = scene.attachments[slot];
  const size_t plane_bytes = size_t{kLanes} * a.texel_bytes;
  const bool is_color = slot < scene.color_count;
  const EqualBlocks equal{is_color && scene.samples() > 1 ? equal_.data() : nullptr, buffer(slot)};
  for (uint32_t s = 0; s < scene.samples(); ++s) {
    store_tile(a, memory(a, s), a.row_pitch_bytes, position_, {buffer(slot) + s * plane_bytes, scene.samples()}, equal);
  }
}

void TileAttachments::resolve_slot(const Scene& scene, uint32_t slot) {
  const PassAttachment& a = scene.attachments[slot];
  const size_t block_bytes = size_t{kLanes} * a.texel_bytes;
  if (resolved_.size() < block_count() * block_bytes) resolved_.append(block_count() * block_bytes - resolved_.size());
  waves_.clear();
  for (uint32_t block = 0; block < block_count(); ++block) {
    const Rect r{position_.x_px + static_cast<int32_t>(morton_x(block) * 4),
                 position_.y_px + static_cast<int32_t>(morton_y(block) * 4),
                 position_.x_px + static_cast<int32_t>(morton_x(block) * 4 + 4),
                 position_.y_px + static_cast<int32_t>(morton_y(block) * 4 + 4)};
    if (intersect(r, position_.rect).empty()) continue;
    if (slot < scene.color_count && equal_[block]) {
      std::memcpy(resolved_.data() + block * block_bytes, buffer(slot) + block * block_bytes * scene.samples(), block_bytes);
    } else {
      waves_.push_back({.exec_mask = 0xFFFF, .coverage = 0xFFFF, .x_px = 0, .y_px = 0, .block_index = block});
    }
  }
  if (!waves_.empty()) {
    ThreadContext context{};
    context.color[0] = buffer(slot);
    context.color[1] = resolved_.data();
    const PrimRecord record{nullptr, 0, static_cast<uint32_t>(waves_.size())};
    a.resolve(&resolve_context(), &context, &record, 1, waves_.data());
  }
  store_tile(a, resolve_memory(a), a.resolve_row_pitch_bytes, position_, {resolved_.data()});
}

void TileAttachments::store(const Scene& scene) {
  for (uint32_t slot = 0; slot < Scene::kSlots; ++slot) {
    const PassAttachment& a = scene.attachments[slot];
    if (!buffer(slot)) continue;
    if (a.resolve.fn && scene.last_flush) resolve_slot(scene, slot);
    if (a.store || !scene.last_flush) store_slot(scene, slot);
  }
}

bool TileAttachments::finish_untouched(const Scene& scene, const Rect& rect, const TileState& state) {
  bool written = false;
  for (uint32_t slot = 0; slot < Scene::kSlots; ++slot) {
    const PassAttachment& a = scene.attachments[slot];
    if (!a.address) continue;
    const bool in_memory = a.load || state.in_memory, resolves = a.resolve.fn != nullptr;
    if ((in_memory || !a.store) && !resolves && scene.options.lazy_memory) continue;
    written = true;
    if (in_memory || !scene.options.fast_clear) {  // the long way round: with fast clears only to resolve what is in memory
      if (slot < scene.color_count) std::memset(equal_.data(), 0, block_count());
      load_slot(scene, state, slot, false);
      if (resolves) resolve_slot(scene, slot);
      if (a.store && (!in_memory || !scene.options.lazy_memory)) store_slot(scene, slot);
      continue;
    }
    const uint8_t* texel = a.clear_texel.data();
    if (resolves) fill_memory_rect(a.texel_bytes, resolve_memory(a), a.resolve_row_pitch_bytes, texel, rect, scene.streams_fills);
    for (uint32_t s = 0; a.store && s < scene.samples(); ++s)
      fill_memory_rect(a.texel_bytes, memory(a, s), a.row_pitch_bytes, texel, rect, scene.streams_fills);
  }
  return written;
}

void TileAttachments::fill_rect(const Scene& scene, uint32_t slot, const uint8_t* texel, const Rect& rect) {
  const PassAttachment& a = scene.attachments[slot];
  if (!buffer(slot)) return;
  const size_t plane_bytes = size_t{kLanes} * a.texel_bytes;
  // Blocks of equal samples stay equal, so filling the samples that are not in the buffer does no harm.
  for (uint32_t s = 0; s < scene.samples(); ++s)
    fill_tile_rect(a.texel_bytes, texel, rect, {buffer(slot) + s * plane_bytes, scene.samples()});
}

void TileAttachments::separate_samples(const Scene& scene, uint32_t block) {
  if (!equal_[block]) return;
  for (uint32_t slot = 0; slot < scene.color_count; ++slot) {
    if (!context_.color[slot]) continue;
    const size_t plane_bytes = size_t{kLanes} * scene.attachments[slot].texel_bytes;
    uint8_t* first = context_.color[slot] + block * plane_bytes * scene.samples();
    for (uint32_t s = 1; s < scene.samples(); ++s) std::memcpy(first + s * plane_bytes, first, plane_bytes);
  }
  equal_[block] = 0;
}

}  // namespace pineda::raster
