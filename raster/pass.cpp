// Pass: what a pass records. schedule.cpp runs it.
#include <algorithm>
#include <string>

#include "base/format.h"
#include "base/log.h"
#include "raster/assemble.h"
#include "raster/bresenham.h"
#include "raster/pass_state.h"
#include "raster/raster.h"

namespace pineda::raster {
namespace {

constexpr int32_t kMaxExtentPx = 16384;           // geometry_types.h's fixed point is made for this
constexpr size_t kMaxRecordedDraws = 32768;       // then the pass runs what it has
constexpr uint64_t kSmallTargetPx = 96 * 96;      // not worth splitting further
constexpr uint32_t kTileBudgetBytes = 256 << 10;  // about half of an L2

PassAttachment make_attachment(const Attachment& in, const std::array<uint8_t, 16>& clear_texel) {
  PassAttachment a;
  const uint32_t bytes = texel_bytes(in.format);
  if (!in.address || in.format == VK_FORMAT_UNDEFINED) return a;
  if (bytes != 1 && bytes != 2 && bytes != 4 && bytes != 8 && bytes != 16) {
    report(Severity::kError,
           "raster: attachment format " + std::to_string(in.format) + " cannot be rendered to; the attachment is left alone");
    return a;
  }
  a.address = in.address;
  a.row_pitch_bytes = in.row_pitch_bytes;
  a.texel_bytes = bytes;
  a.format = in.format;
  a.load = in.load != VK_ATTACHMENT_LOAD_OP_CLEAR && in.load != VK_ATTACHMENT_LOAD_OP_DONT_CARE;
  a.store = in.store == VK_ATTACHMENT_STORE_OP_STORE;
  if (in.load == VK_ATTACHMENT_LOAD_OP_CLEAR) a.clear_texel = clear_texel;
  a.sample_pitch_bytes = in.sample_pitch_bytes;
  a.layer_pitch_bytes = in.layer_pitch_bytes;
  if (in.resolve_address) {
    a.resolve = in.resolve;
    a.resolve_address = in.resolve_address;
    a.resolve_row_pitch_bytes = in.resolve_row_pitch_bytes;
    a.resolve_layer_pitch_bytes = in.resolve_layer_pitch_bytes;
  }
  return a;
}

std::array<uint8_t, 16> pack_clear(VkFormat format, const VkClearValue& value) {
  std::array<uint8_t, 16> texel{};
  const FormatInfo* info = find_format(format);
  if (!info) return texel;
  if (info->has_stencil()) {
    texel[0] = static_cast<uint8_t>(value.depthStencil.stencil);
  } else if (info->is_depth()) {
    pack_depth(*info, value.depthStencil.depth, texel.data());
  } else {
    pack_clear_color(*info, value.color, texel.data());
  }
  return texel;
}

// The largest tile whose attachments fit half an L2 and that still gives every thread some tiles.
uint32_t choose_tile_px(const Options& options, uint32_t bytes_per_px, const Rect& area, uint32_t threads) {
  if (options.tile_px != 0) return options.tile_px;
  uint32_t px = kMaxTilePx;
  while (px > 16 && px * px * bytes_per_px > kTileBudgetBytes) px /= 2;
  if (area.empty() || threads == 1) return px;
  const auto width = static_cast<uint32_t>(area.x1 - area.x0), height = static_cast<uint32_t>(area.y1 - area.y0);
  if (uint64_t{width} * height <= kSmallTargetPx) return px;
  while (px > 16 && ((width + px - 1) / px) * ((height + px - 1) / px) < 4 * threads) px /= 2;
  return px;
}

HiZMode hi_z_mode(const DrawPacket& packet) {
  // What a rejected fragment would have done to the stencil buffer must be done.
  if (!packet.depth_test || (packet.stencil_test && packet.stencil_write)) return HiZMode::kNone;
  // After the shader: only where what fails before it must fail, and nothing but the fragment is lost.
  if (!packet.early_depth && packet.has_side_effects) return HiZMode::kNone;
  const auto rejects = [&](LateDepth needed) { return packet.early_depth || packet.late_depth == needed; };
  switch (packet.depth_compare) {
    case VK_COMPARE_OP_LESS:
    case VK_COMPARE_OP_LESS_OR_EQUAL:
      return rejects(LateDepth::kNotLess) ? HiZMode::kLess : HiZMode::kNone;
    case VK_COMPARE_OP_GREATER:
    case VK_COMPARE_OP_GREATER_OR_EQUAL:
      return rejects(LateDepth::kNotGreater) ? HiZMode::kGreater : HiZMode::kNone;
    default:
      return HiZMode::kNone;
  }
}

}  // namespace

Pass::State::State(ThreadPool& thread_pool, const PassDesc& desc, const Options& options)
    : pool(thread_pool), store(thread_pool.workspaces()), workspace(store.acquire()) {
  scene.options = options;
  scene.color_count = std::min(desc.color_count, kMaxColorAttachments);
  scene.grid.samples = desc.samples;
  const auto attach = [&](uint32_t slot, const Attachment& from) {
    scene.attachments[slot] = make_attachment(from, pack_clear(from.format, from.clear));
    if (!options.lazy_memory && from.store == VK_ATTACHMENT_STORE_OP_DONT_CARE)
      scene.attachments[slot].store = scene.attachments[slot].address != nullptr;
    bytes_per_px += scene.attachments[slot].texel_bytes * desc.samples;
    add_ranges(from, desc);
  };
  for (uint32_t i = 0; i < scene.color_count; ++i) attach(i, desc.color[i]);
  attach(Scene::kDepthSlot, desc.depth);
  attach(Scene::kStencilSlot, desc.stencil);
  const auto extent = [](uint32_t v) { return static_cast<int32_t>(std::min<uint32_t>(v, kMaxExtentPx)); };
  TileGrid& grid = scene.grid;
  grid.area = intersect(to_rect(desc.render_area), {0, 0, extent(desc.extent.width), extent(desc.extent.height)});
  if (grid.area.empty()) grid.area = {};
  scene.layers = std::max(1u, desc.layers);
  grid.layers = bytes_per_px != 0 ? scene.layers : 1;
  scene.tiles.swap(workspace->tiles);
  choose_tiles(pool.threads());
}

// Before anything has run.
void Pass::State::choose_tiles(uint32_t threads) {
  TileGrid& grid = scene.grid;
  const uint32_t tile_px = choose_tile_px(scene.options, bytes_per_px, grid.area, threads);
  grid.tile_px = static_cast<int32_t>(tile_px);
  grid.shift = static_cast<uint32_t>(__builtin_ctz(tile_px));
  grid.columns = (static_cast<uint32_t>(grid.area.x1) + tile_px - 1) / tile_px;
  grid.rows = (static_cast<uint32_t>(grid.area.y1) + tile_px - 1) / tile_px;
  if (scene.tiles.size() < grid.count())
    scene.tiles.resize(grid.count());  // those that were there are empty and keep their memory
  for (uint32_t i = 0; i < grid.count(); ++i) scene.tiles[i].in_memory = false;
}

void Pass::State::add_ranges(const Attachment& a, const PassDesc& desc) {
  const auto add = [&](const uint8_t* address, size_t row_pitch, size_t layer_pitch, size_t sample_pitch) {
    if (!address) return;
    attachment_ranges.push_back({address, address + row_pitch * desc.extent.height +
                                              layer_pitch * (std::max(1u, desc.layers) - 1) +
                                              sample_pitch * (std::max(1u, desc.samples) - 1)});
  };
  add(a.address, a.row_pitch_bytes, a.layer_pitch_bytes, a.sample_pitch_bytes);
  add(a.resolve_address, a.resolve_row_pitch_bytes, a.resolve_layer_pitch_bytes, 0);
}

void Pass::State::record(const DrawPacket& packet) {
  const TopologyInfo& topology = *find_topology(packet.topology);
  // Points are discarded by their centre and not cut.
  const bool points = topology.kind == PrimitiveKind::kPoint ||
                      (topology.kind == PrimitiveKind::kTriangle && packet.polygon_mode == VK_POLYGON_MODE_POINT);
  // Wide lines are clipped to the view volume by their ends and may reach beyond it by their width.
  const LineState& line = packet.line;
  const bool wide =
      topology.kind == PrimitiveKind::kLine && (line.mode != LineMode::kBresenham || bresenham_width(line.width_px) > 1);
  const bool draws_lines = topology.kind == PrimitiveKind::kLine ||
                           (topology.kind == PrimitiveKind::kTriangle && packet.polygon_mode == VK_POLYGON_MODE_LINE);
  const auto drawable = [&](const VkViewport& viewport, const VkRect2D& scissor) {
    const Rect r = intersect(to_rect(scissor), scene.grid.area);
    return points || wide ? r : intersect(r, viewport_rect(viewport));
  };
  const Rect rect = drawable(packet.viewport, packet.scissor);
  uint64_t vertices = packet.count;
  if (packet.index.address) {  // of the primitives whose indices are all past the buffer's end one is as good as all
    const uint64_t index_bytes = packet.index.type == VK_INDEX_TYPE_UINT32   ? 4
                                 : packet.index.type == VK_INDEX_TYPE_UINT16 ? 2
                                                                             : 1;
    const uint64_t in_buffer = packet.index.size_bytes / index_bytes;
    vertices = std::min<uint64_t>(vertices, (in_buffer > packet.first ? in_buffer - packet.first : 0) + topology.vertices);
  }
  if (vertices < topology.vertices || packet.instance_count == 0 ||
      (rect.empty() && !packet.viewports && !packet.has_side_effects))
    return;
  has_effects |= packet.has_side_effects || packet.samples_passed;
  Draw& draw = workspace->draws.append();
  draw.packet = packet;
  draw.packet.count = static_cast<uint32_t>(vertices);
  draw.kind = topology.kind;
  draw.stipples = line.stippled && draws_lines;
  draw.smooth = line.mode == LineMode::kSmooth && draws_lines;
  draw.in_order = line.stippled && topology.kind == PrimitiveKind::kLine && !topology.is_list;
  if (scene.options.per_draw) draw.counters = &counters.emplace_back();
  if (packet.primitive_restart && packet.index.address) {
    draw.restart_prims = restart_primitives(draw.packet);
    draw.prims_per_instance = draw.restart_prims.size();
  } else {
    draw.prims_per_instance = primitive_count(topology, vertices);
  }
  const auto transform = [&](const VkViewport& viewport) {
    ViewportTransform t = make_viewport_transform(viewport, packet.depth_clip);
    if (wide) {  // no guard band
      t.guard_x_min = t.guard_y_min = -1;
      t.guard_x_max = t.guard_y_max = 1;
    }
    return t;
  };
  draw.viewport = transform(packet.viewport);
  draw.rect = rect;
  if (packet.viewports && packet.outputs.viewport_index != 0) {
    for (uint32_t i = 0; i < std::min(packet.viewports->count, kMaxViewports); ++i) {
      draw.viewports.push_back(transform(packet.viewports->viewport[i]));
      draw.rects.push_back(drawable(packet.viewports->viewport[i], packet.viewports->scissor[i]));
    }
  }
  draw.layers = scene.layers;
  draw.routes = !draw.viewports.empty() || (packet.outputs.layer != 0 && scene.layers > 1);
  const bool has_depth = scene.depth().address != nullptr, tests_depth = packet.depth_test && has_depth;
  const bool tests_stencil = packet.stencil_test && scene.stencil().address;
  draw.depth_format = scene.depth().format;
  draw.samples = scene.samples();
  draw.hi_z = tests_depth ? hi_z_mode(packet) : HiZMode::kNone;
  draw.writes_depth = tests_depth && packet.depth_write;
  const VkCompareOp op = packet.depth_compare;
  const bool leaves_traces = packet.has_side_effects || packet.samples_passed;
  draw.can_cover = packet.opaque && !leaves_traces && !tests_stencil && !(has_depth && packet.depth_bounds_test) &&
                   !(tests_depth && (packet.depth_write || op != VK_COMPARE_OP_ALWAYS));
  draw.blocks_cover = leaves_traces || draw.writes_depth || (tests_stencil && packet.stencil_write);
  recorded_prims += draw.prims_per_instance * packet.instance_count;
  statistics.vertices_in += uint64_t{packet.count} * packet.instance_count;
  statistics.primitives_in += draw.prims_per_instance * packet.instance_count;
}

Pass::Pass(ThreadPool& pool, const PassDesc& desc) : Pass(pool, desc, default_options()) {}
Pass::Pass(ThreadPool& pool, const PassDesc& desc, const Options& options)
    : state_(std::make_unique<State>(pool, desc, options)) {}
Pass::~Pass() = default;
Pass::Pass(Pass&&) noexcept = default;
Pass& Pass::operator=(Pass&&) noexcept = default;

void Pass::draw(const DrawPacket& packet) {
  ++state_->statistics.draws;
  if (!find_topology(packet.topology)) {
    report(Severity::kError, "raster: topology " + std::to_string(packet.topology) + " is not supported; the draw is left out");
    return;
  }
  state_->record(packet);
  if (state_->workspace->draws.size() >= kMaxRecordedDraws) state_->run_recorded(false, state_->everybody());
}

void Pass::clear(uint32_t color_index, const VkClearValue& value, std::span<const VkRect2D> rects, uint32_t first_layer,
                 uint32_t layer_count) {
  State& s = *state_;
  const bool is_color = color_index != kDepth && color_index != kStencil;
  if (is_color && color_index >= s.scene.color_count) return;
  const uint32_t slot = is_color ? color_index : color_index == kDepth ? Scene::kDepthSlot : Scene::kStencilSlot;
  const PassAttachment& attachment = s.scene.attachments[slot];
  if (!attachment.address) return;
  std::vector<Rect> inside;
  for (const VkRect2D& rect : rects) {
    const Rect r = intersect(to_rect(rect), s.scene.grid.area);
    if (!r.empty()) inside.push_back(r);
  }
  if (inside.empty() || first_layer >= s.scene.layers) return;
  Draw& draw = s.workspace->draws.append();
  draw.is_clear = true;
  draw.rect = s.scene.grid.area;
  draw.clear_slot = slot;
  draw.clear_texel = pack_clear(attachment.format, value);
  draw.clear_rects = std::move(inside);
  draw.clear_first_layer = first_layer;
  draw.clear_layers = std::min(layer_count, s.scene.layers - first_layer);
  draw.prims_per_instance = draw.clear_rects.size() * draw.clear_layers;
  draw.packet.instance_count = 1;
  draw.blocks_cover = !is_color;
  s.recorded_prims += draw.prims_per_instance;
}

void Pass::keep_in_memory() {
  for (PassAttachment& a : state_->scene.attachments) {
    a.store = a.address != nullptr;
    a.resolve = {};
  }
}

std::vector<DrawStatistics> Pass::draw_statistics() const {
  std::vector<DrawStatistics> draws;
  for (const DrawCounters& c : state_->counters) {
    draws.push_back(
        {c.vertices_shaded, c.primitives_in, c.triangles_clipped, c.triangles_culled, c.triangles_binned, c.blocks_shaded});
  }
  return draws;
}

std::vector<ThreadTimes> Pass::thread_times() const { return state_->thread_times; }

Pass::HeatMap Pass::heat_map() const {
  const TileGrid& grid = state_->scene.grid;
  return {grid.columns, grid.rows * grid.layers, state_->bin_entries};
}

PassStatistics Pass::end() {
  state_->run_recorded(true, state_->everybody());
  return state_->statistics;
}

const PassStatistics& Pass::statistics() const { return state_->statistics; }

}  // namespace pineda::raster
