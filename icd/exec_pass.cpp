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

void set_resolve(raster::Attachment& to, const compiler::KernelPtr& kernel, const raster::Attachment& target) {
  if (!kernel || !target.address) return;
  to.resolve = kernel->handle;
  to.resolve_address = target.address;
  to.resolve_row_pitch_bytes = target.row_pitch_bytes;
}

raster::Attachment attachment(const cmd::BeginRenderPass& begin, const SubpassAttachment& use) {
  if (use.index == VK_ATTACHMENT_UNUSED) return {};
  raster::Attachment to = begin.framebuffer->view(use.index).attachment(0);
  to.load = use.load;
  to.store = use.store;
  to.clear = clear_value(begin, use.index);
  if (use.resolve) set_resolve(to, use.resolve, begin.framebuffer->view(use.resolve_index).attachment(0));
  return to;
}

raster::Attachment stencil_attachment(const cmd::BeginRenderPass& begin, const SubpassAttachment& use) {
  if (use.index == VK_ATTACHMENT_UNUSED) return {};
  raster::Attachment to = begin.framebuffer->view(use.index).stencil_attachment(0);
  to.load = use.stencil_load;
  to.store = use.stencil_store;
  to.clear = clear_value(begin, use.index);
  if (use.stencil_resolve) set_resolve(to, use.stencil_resolve, begin.framebuffer->view(use.resolve_index).stencil_attachment(0));
  return to;
}

// Whether a framebuffer's view has the aspects and texels that an attachment of the render pass says (otherwise usage is invalid,
// and kernels would write beyond it).
bool view_matches(const ImageView& view, VkFormat format, uint32_t samples) {
  const FormatInfo& info = *find_format(format);
  if (view.sample_count() != samples) return false;
  const raster::Attachment first = view.attachment(0), stencil = view.stencil_attachment(0);
  if (!info.is_depth_or_stencil()) return first.format == format;
  return first.format == aspect_format(format, VK_IMAGE_ASPECT_DEPTH_BIT) &&
         stencil.format == aspect_format(format, VK_IMAGE_ASPECT_STENCIL_BIT);
}

bool formats_match(const cmd::BeginRenderPass& begin, const Subpass& subpass) {
  const auto matches = [&](const SubpassAttachment& use) {
    if (use.index == VK_ATTACHMENT_UNUSED) return true;
    const bool resolves = use.resolve || use.stencil_resolve;
    return view_matches(begin.framebuffer->view(use.index), use.format, subpass.samples) &&
           (!resolves || view_matches(begin.framebuffer->view(use.resolve_index), use.format, 1));
  };
  return matches(subpass.depth) && std::all_of(subpass.color.begin(), subpass.color.begin() + subpass.color_count, matches);
}

// The attachments as they are in memory in the middle of a subpass.
void continue_from_memory(raster::PassDesc& desc) {
  const auto load = [](raster::Attachment& a) { a.load = VK_ATTACHMENT_LOAD_OP_LOAD; };
  for (raster::Attachment& color : desc.color) load(color);
  load(desc.depth);
  load(desc.stencil);
}

}  // namespace

void Executor::begin_subpass() {
  const Subpass& subpass = begin_->render_pass->subpass(subpass_);
  if (!formats_match(*begin_, subpass)) {
    device_.lose("a framebuffer's views have other formats or samples than the attachments of its render pass");
    return;
  }
  pass_desc_ = {};
  pass_desc_.extent = begin_->framebuffer->extent();
  pass_desc_.render_area = clip(begin_->area, pass_desc_.extent);
  pass_desc_.samples = std::max(1u, subpass.samples);
  pass_desc_.color_count = subpass.color_count;
  for (const SubpassAttachment& use : subpass.cleared_first) clear_layers(use, 0);
  for (uint32_t i = 0; i < subpass.color_count; ++i) {
    pass_desc_.color[i] = attachment(*begin_, subpass.color[i]);
    clear_layers(subpass.color[i], 1);
  }
  pass_desc_.depth = attachment(*begin_, subpass.depth);
  pass_desc_.stencil = stencil_attachment(*begin_, subpass.depth);
  clear_layers(subpass.depth, 1);
  pass_.emplace(device_.pool, pass_desc_);
  dirty_ |= kPacket;  // the pipeline is held against the new attachments
}

void Executor::run_pass() {
  const raster::PassStatistics statistics = pass_->end();
  pass_.reset();
  arena_.reset();
  dirty_ |= kContext;  // the last context was in the arena
  if (debug(kDebugStats)) report_statistics(statistics);
  finish_queries(statistics);
}

void Executor::end_subpass() { run_pass(); }

// Runs what the subpass has so far, so that what follows finds it in memory. Attachments keep their precision, so no bit shows.
void Executor::split_subpass(uint32_t samples) {
  const Subpass& subpass = begin_->render_pass->subpass(subpass_);
  raster::PassDesc next = pass_desc_;
  continue_from_memory(next);
  if (subpass.samples == 0) next.samples = samples;
  pass_->keep_in_memory();
  run_pass();
  pass_desc_ = next;
  pass_.emplace(device_.pool, pass_desc_);
  dirty_ |= kPacket;
}

// Layers from `first` on: without a geometry shader all primitives go to layer 0, so of the others only the load operation shows.
void Executor::clear_layers(const SubpassAttachment& use, uint32_t first) {
  if (use.index == VK_ATTACHMENT_UNUSED) return;
  const ImageView& view = begin_->framebuffer->view(use.index);
  const VkClearValue value = clear_value(*begin_, use.index);
  const VkRect2D rect = clip(begin_->area, begin_->framebuffer->extent());
  const auto clear = [&](const raster::Attachment& layer, VkAttachmentLoadOp load) {
    if (layer.address && load == VK_ATTACHMENT_LOAD_OP_CLEAR) fill_attachment(device_.pool, layer, rect, value);
  };
  for (uint32_t layer = first; layer < begin_->framebuffer->layer_count(); ++layer) {
    clear(view.attachment(layer), use.load);
    clear(view.stencil_attachment(layer), use.stencil_load);
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

// One aspect of vkCmdClearAttachments: index is that of raster::Pass::clear.
void Executor::clear_attachment(uint32_t index, const SubpassAttachment& use, const VkClearValue& value,
                                std::span<const VkClearRect> rects) {
  if (use.index == VK_ATTACHMENT_UNUSED) return;
  const ImageView& view = begin_->framebuffer->view(use.index);
  for (const VkClearRect& rect : rects) {
    if (rect.baseArrayLayer == 0 && rect.layerCount > 0) pass_->clear(index, value, {&rect.rect, 1});
    for (uint32_t i = 0; i < rect.layerCount; ++i) {
      const uint32_t layer = rect.baseArrayLayer + i;
      if (layer == 0 || layer >= begin_->framebuffer->layer_count()) continue;
      const raster::Attachment to = index == raster::Pass::kStencil ? view.stencil_attachment(layer) : view.attachment(layer);
      if (to.address) fill_attachment(device_.pool, to, clip(rect.rect, begin_->framebuffer->extent()), value);
    }
  }
}

void Executor::execute(const cmd::ClearAttachments& command) {
  if (!pass_) return;
  const Subpass& subpass = begin_->render_pass->subpass(subpass_);
  for (const VkClearAttachment& clear : command.attachments) {
    if ((clear.aspectMask & VK_IMAGE_ASPECT_COLOR_BIT) && clear.colorAttachment < subpass.color_count) {
      clear_attachment(clear.colorAttachment, subpass.color[clear.colorAttachment], clear.clearValue, command.rects);
    }
    if (clear.aspectMask & VK_IMAGE_ASPECT_DEPTH_BIT)
      clear_attachment(raster::Pass::kDepth, subpass.depth, clear.clearValue, command.rects);
    if (clear.aspectMask & VK_IMAGE_ASPECT_STENCIL_BIT)
      clear_attachment(raster::Pass::kStencil, subpass.depth, clear.clearValue, command.rects);
  }
}

// Inside a subpass a barrier is there for input attachments that are drawn to as well: what was drawn must be in memory.
void Executor::execute(const cmd::PipelineBarrier&) {
  if (pass_ && begin_->render_pass->subpass(subpass_).reads_own_output) split_subpass(pass_desc_.samples);
}

}  // namespace pineda::icd
