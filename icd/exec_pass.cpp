// Execution of render passes: each subpass is one raster::Pass.
#include <algorithm>

#include "base/config.h"
#include "icd/device.h"
#include "icd/executor.h"
#include "icd/framebuffer.h"
#include "icd/image_view.h"
#include "icd/render_pass.h"
#include "icd/transfer.h"

namespace pineda::icd {
namespace {

void report_statistics(const raster::PassStatistics& s) {
  const auto n = [](uint64_t value) { return std::to_string(value); };
  report(Severity::kInfo, "render pass: " + n(s.draws) + " draws, " + n(s.vertices_shaded) + " vertices, triangles " +
                              n(s.triangles_in) + " in, " + n(s.triangles_culled) + " culled, " + n(s.triangles_clipped) +
                              " clipped, " + n(s.triangles_binned) + " binned in " + n(s.bin_entries) + " entries; blocks " +
                              n(s.blocks_shaded) + " shaded, " + n(s.blocks_hi_z_rejected) + " rejected by Hi-Z; tiles " +
                              n(s.tiles_touched) + " touched, " + n(s.tiles_filled) + " filled, " + n(s.tiles_untouched) +
                              " untouched; " + n(s.flushes) + " flushes");
}

VkClearValue clear_value(const cmd::BeginRenderPass& begin, uint32_t index) {
  return index < begin.clear_values.size() ? begin.clear_values[index] : VkClearValue{};
}

// The part of rect inside the framebuffer.
VkRect2D clip(const VkRect2D& rect, VkExtent2D extent) {
  const auto axis = [](int32_t offset, uint32_t size, uint32_t limit) {
    const int64_t begin = std::clamp<int64_t>(offset, 0, limit), end = std::clamp<int64_t>(int64_t(offset) + size, begin, limit);
    return std::pair(static_cast<int32_t>(begin), static_cast<uint32_t>(end - begin));
  };
  const auto [x, width] = axis(rect.offset.x, rect.extent.width, extent.width);
  const auto [y, height] = axis(rect.offset.y, rect.extent.height, extent.height);
  return {{x, y}, {width, height}};
}

raster::Attachment attachment(const cmd::BeginRenderPass& begin, const SubpassAttachment& use) {
  if (use.index == VK_ATTACHMENT_UNUSED) return {};
  raster::Attachment to = begin.framebuffer->view(use.index).attachment(0);
  to.load = use.load;
  to.store = use.store;
  to.clear = clear_value(begin, use.index);
  return to;
}

// Whether the framebuffer's views have the formats that the render pass says (invalid otherwise; texels would have another size).
bool formats_match(const cmd::BeginRenderPass& begin, const Subpass& subpass) {
  const auto matches = [&](const SubpassAttachment& use) {
    return use.index == VK_ATTACHMENT_UNUSED || begin.framebuffer->view(use.index).attachment(0).format == use.format;
  };
  return matches(subpass.depth) && std::all_of(subpass.color.begin(), subpass.color.begin() + subpass.color_count, matches);
}

}  // namespace

void Executor::begin_subpass() {
  const Subpass& subpass = begin_->render_pass->subpass(subpass_);
  if (!formats_match(*begin_, subpass)) {
    device_.lose("a framebuffer's views have other formats than the attachments of its render pass");
    return;
  }
  raster::PassDesc desc;
  desc.extent = begin_->framebuffer->extent();
  desc.render_area = clip(begin_->area, desc.extent);
  desc.color_count = subpass.color_count;
  for (uint32_t i = 0; i < subpass.color_count; ++i) {
    desc.color[i] = attachment(*begin_, subpass.color[i]);
    clear_other_layers(subpass.color[i], desc.color[i].clear);
  }
  desc.depth = attachment(*begin_, subpass.depth);
  clear_other_layers(subpass.depth, desc.depth.clear);
  pass_.emplace(device_.pool, desc);
  dirty_ |= kPacket;  // the pipeline is held against the new attachments
}

void Executor::end_subpass() {
  const raster::PassStatistics statistics = pass_->end();
  pass_.reset();
  arena_.reset();
  dirty_ |= kContext;  // the last context was in the arena
  if (debug(kDebugStats)) report_statistics(statistics);
}

// Without a geometry shader all primitives go to layer 0, so of the others only the load operation shows.
void Executor::clear_other_layers(const SubpassAttachment& use, const VkClearValue& value) {
  if (use.index == VK_ATTACHMENT_UNUSED || use.load != VK_ATTACHMENT_LOAD_OP_CLEAR) return;
  for (uint32_t layer = 1; layer < begin_->framebuffer->layer_count(); ++layer) {
    fill_attachment(device_.pool, begin_->framebuffer->view(use.index).attachment(layer),
                    clip(begin_->area, begin_->framebuffer->extent()), value);
  }
}

void Executor::execute(const cmd::BeginRenderPass& command) {
  if (command.render_pass->subpass_count() == 0) return;
  begin_ = &command;
  subpass_ = 0;
  begin_subpass();
}

void Executor::execute(const cmd::NextSubpass&) {
  if (!pass_ || subpass_ + 1 >= begin_->render_pass->subpass_count()) return;
  end_subpass();
  ++subpass_;
  begin_subpass();
}

void Executor::execute(const cmd::EndRenderPass&) {
  if (pass_) end_subpass();
  begin_ = nullptr;
}

void Executor::execute(const cmd::ClearAttachments& command) {
  if (!pass_) return;
  const Subpass& subpass = begin_->render_pass->subpass(subpass_);
  for (const VkClearAttachment& clear : command.attachments) {
    const bool is_color = (clear.aspectMask & VK_IMAGE_ASPECT_COLOR_BIT) != 0;
    if (is_color && clear.colorAttachment >= subpass.color_count) continue;
    if (!is_color && !(clear.aspectMask & VK_IMAGE_ASPECT_DEPTH_BIT)) continue;
    const SubpassAttachment& use = is_color ? subpass.color[clear.colorAttachment] : subpass.depth;
    if (use.index == VK_ATTACHMENT_UNUSED) continue;
    for (const VkClearRect& rect : command.rects) {
      const uint32_t index = is_color ? clear.colorAttachment : raster::Pass::kDepth;
      if (rect.baseArrayLayer == 0 && rect.layerCount > 0) pass_->clear(index, clear.clearValue, {&rect.rect, 1});
      for (uint32_t i = 0; i < rect.layerCount; ++i) {
        const uint32_t layer = rect.baseArrayLayer + i;
        if (layer == 0 || layer >= begin_->framebuffer->layer_count()) continue;
        fill_attachment(device_.pool, begin_->framebuffer->view(use.index).attachment(layer),
                        clip(rect.rect, begin_->framebuffer->extent()), clear.clearValue);
      }
    }
  }
}

}  // namespace pineda::icd
