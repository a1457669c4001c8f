// Execution of render passes: each subpass is one raster::Pass.
#include <algorithm>
#include <atomic>
#include <bit>
#include <cstdio>
#include <string>
#include <utility>

#include "base/config.h"
#include "icd/device.h"
#include "icd/executor.h"
#include "icd/explain.h"
#include "icd/image_view.h"
#include "icd/render_pass.h"
#include "icd/transfer.h"
#include "raster/statistics_report.h"

namespace pineda::icd {
namespace {

void write_file(const std::string& path, const char* mode, const std::string& bytes) {
  std::FILE* file = std::fopen(path.c_str(), mode);
  const bool written = file && std::fwrite(bytes.data(), 1, bytes.size(), file) == bytes.size();
  if (!file || std::fclose(file) != 0 || !written) report(Severity::kWarning, path + " cannot be written");
}

// What PINEDA_DEBUG=stats, PINEDA_STATS and PINEDA_DEBUG=heatmap ask for.
void report_statistics(const raster::Pass& pass, const raster::PassStatistics& statistics) {
  if (debug(kDebugStats)) report(Severity::kInfo, "render pass: " + raster::statistics_text(statistics, pass.thread_times()));
  if (!config().stats_file.empty()) {
    write_file(config().stats_file, "ae",
               raster::statistics_json(statistics, pass.draw_statistics(), pass.thread_times()) + "\n");
  }
  if (debug(kDebugHeatMap)) {
    static std::atomic<uint32_t> number = 0;
    const raster::Pass::HeatMap map = pass.heat_map();
    const std::string directory = config().debug_dir.empty() ? "." : config().debug_dir;
    write_file(directory + "/bins-" + std::to_string(number++) + ".pgm", "we",
               raster::heat_map_pgm(map.columns, map.rows, map.entries));
  }
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
  to.resolve_layer_pitch_bytes = target.layer_pitch_bytes;
}

raster::Attachment attachment(const cmd::BeginRenderPass& begin, const SubpassAttachment& use, uint32_t layer) {
  if (use.index == VK_ATTACHMENT_UNUSED) return {};
  raster::Attachment to = begin.view(use.index).attachment(layer);
  to.load = use.load;
  to.store = use.store;
  to.clear = clear_value(begin, use.index);
  if (use.resolve) set_resolve(to, use.resolve, begin.view(use.resolve_index).attachment(layer));
  return to;
}

raster::Attachment stencil_attachment(const cmd::BeginRenderPass& begin, const SubpassAttachment& use, uint32_t layer) {
  if (use.index == VK_ATTACHMENT_UNUSED) return {};
  raster::Attachment to = begin.view(use.index).stencil_attachment(layer);
  to.load = use.stencil_load;
  to.store = use.stencil_store;
  to.clear = clear_value(begin, use.index);
  if (use.stencil_resolve) set_resolve(to, use.stencil_resolve, begin.view(use.resolve_index).stencil_attachment(layer));
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
    if (begin.view(use.index).layer_count() < uint32_t(std::bit_width(subpass.view_mask))) return false;
    const bool resolves = use.resolve || use.stencil_resolve;
    return view_matches(begin.view(use.index), use.format, subpass.samples) &&
           (!resolves || view_matches(begin.view(use.resolve_index), use.format, 1));
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
  if (begin_->render_pass->waits_for_passes() || begin_->render_pass->subpass_count() != 1 || subpass.view_mask != 0 ||
      !subpass.cleared_first.empty()) {
    finish_passes();
  }
  if (subpass.view_mask == 0) return begin_view(0);
  start_ = SubpassStart{current_, graphics_, compute_, pipeline_, compute_pipeline_, dynamic_, index_};
  view_ordinal_ = 0;
  begin_view(uint32_t(std::countr_zero(subpass.view_mask)));
}

// The load operation of an attachment is performed by the first subpass that uses it; with multiview, by the first for each view.
VkAttachmentLoadOp Executor::load_of(const SubpassAttachment& use, VkAttachmentLoadOp SubpassAttachment::*load) const {
  if (!start_) return use.*load;
  VkAttachmentLoadOp first = use.*load;
  bool found = false;
  for (uint32_t s = 0; s < subpass_; ++s) {
    const Subpass& earlier = begin_->render_pass->subpass(s);
    const auto visit = [&](const SubpassAttachment& other) {
      if (other.index != use.index) return;
      if (!std::exchange(found, true)) first = other.*load;
      if (earlier.view_mask >> view_ & 1) first = VK_ATTACHMENT_LOAD_OP_LOAD;
    };
    for (uint32_t i = 0; i < earlier.color_count; ++i) visit(earlier.color[i]);
    visit(earlier.depth);
  }
  return first;
}

// Begins the subpass for one view: layer `view` of the attachments. Without multiview that is all layers, from 0 on.
void Executor::begin_view(uint32_t view) {
  const Subpass& subpass = begin_->render_pass->subpass(subpass_);
  view_ = view;
  pass_desc_ = {};
  pass_desc_.extent = begin_->extent;
  pass_desc_.render_area = clip(begin_->area, pass_desc_.extent);
  pass_desc_.samples = std::max(1u, subpass.samples);
  pass_desc_.layers = start_ ? 1 : begin_->layer_count;
  pass_desc_.color_count = subpass.color_count;
  for (const SubpassAttachment& use : subpass.cleared_first) clear_first(use);
  for (uint32_t i = 0; i < subpass.color_count; ++i) {
    pass_desc_.color[i] = attachment(*begin_, subpass.color[i], view);
    pass_desc_.color[i].load = load_of(subpass.color[i], &SubpassAttachment::load);
  }
  pass_desc_.depth = attachment(*begin_, subpass.depth, view);
  pass_desc_.depth.load = load_of(subpass.depth, &SubpassAttachment::load);
  pass_desc_.stencil = stencil_attachment(*begin_, subpass.depth, view);
  pass_desc_.stencil.load = load_of(subpass.depth, &SubpassAttachment::stencil_load);
  pass_.emplace(device_.pool, pass_desc_);
  if (std::ranges::any_of(waiting_, [&](const WaitingPass& w) { return w.pass.shares_memory(*pass_); })) finish_passes();
  dirty_ |= kPacket | kContext;  // the pipeline is held against the new attachments
}

// False when the subpass has been drawn for all of its views.
bool Executor::begin_next_view() {
  const uint32_t later = start_ ? begin_->render_pass->subpass(subpass_).view_mask >> view_ >> 1 : 0;
  if (later == 0) {
    start_.reset();
    view_ordinal_ = 0;
    view_ = 0;
    return false;
  }
  graphics_ = start_->graphics;
  compute_ = start_->compute;
  pipeline_ = start_->pipeline;
  compute_pipeline_ = start_->compute_pipeline;
  compute_kernel_ = nullptr;
  dynamic_ = start_->dynamic;
  index_ = start_->index;
  dirty_ = kAll;
  ++view_ordinal_;
  replay_from_ = start_->header;
  begin_view(view_ + 1 + uint32_t(std::countr_zero(later)));
  return true;
}

// Whether the pass in progress may run later. Queries that count it want it to have run when they end.
bool Executor::may_wait() const {
  return begin_->render_pass->subpass_count() == 1 && !start_ && !occlusion_.pool && !statistics_.pool && ended_.empty() &&
         pass_->may_wait();
}

void Executor::run_pass() {
  const raster::PassStatistics statistics = pass_->end();
  report_statistics(*pass_, statistics);
  if (debug(kDebugExplain)) say_once(explain_pass(pass_desc_, statistics));
  pass_.reset();
  finish_passes();
  arena_.reset();
  dirty_ |= kContext;  // the last context was in the arena
  finish_queries(statistics);
}

// Runs the passes that wait.
void Executor::finish_passes() {
  if (waiting_.empty()) return;
  std::vector<raster::Pass*> passes;
  for (WaitingPass& waiting : waiting_) passes.push_back(&waiting.pass);
  if (!device_.lost()) raster::Pass::end_together(passes);
  for (const WaitingPass& waiting : waiting_) {
    report_statistics(waiting.pass, waiting.pass.statistics());
    if (debug(kDebugExplain)) say_once(explain_pass(waiting.desc, waiting.pass.statistics()));
  }
  waiting_.clear();
  if (pass_) return;  // its contexts are in the arena too
  arena_.reset();
  dirty_ |= kPacket | kContext;
}

void Executor::end_subpass() {
  if (!may_wait()) return run_pass();
  waiting_.push_back({std::move(*pass_), pass_desc_});
  pass_.reset();
  if (begin_->render_pass->awaited_by_passes() || waiting_.size() == kMaxWaiting) finish_passes();
}

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

// The clears of an attachment that the subpass reads: before it, in memory.
void Executor::clear_first(const SubpassAttachment& use) {
  const ImageView& view = begin_->view(use.index);
  const VkClearValue value = clear_value(*begin_, use.index);
  const VkRect2D rect = clip(begin_->area, begin_->extent);
  const auto clear = [&](const raster::Attachment& layer, VkAttachmentLoadOp load) {
    if (layer.address && load == VK_ATTACHMENT_LOAD_OP_CLEAR) fill_attachment(device_.pool, layer, rect, value);
  };
  const auto clear_layer = [&](uint32_t layer) {
    clear(view.attachment(layer), load_of(use, &SubpassAttachment::load));
    clear(view.stencil_attachment(layer), load_of(use, &SubpassAttachment::stencil_load));
  };
  if (start_) return clear_layer(view_);  // multiview: the layer of this view is the only one
  for (uint32_t layer = 0; layer < begin_->layer_count; ++layer) clear_layer(layer);
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
  if (begin_next_view()) return;
  ++subpass_;
  begin_subpass();
}

void Executor::execute(const cmd::EndRenderPass&) {
  if (pass_) {
    end_subpass();
    if (begin_next_view()) return;
  }
  begin_ = nullptr;
}

// One aspect of vkCmdClearAttachments: index is that of raster::Pass::clear.
void Executor::clear_attachment(uint32_t index, const SubpassAttachment& use, const VkClearValue& value,
                                std::span<const VkClearRect> rects) {
  if (use.index == VK_ATTACHMENT_UNUSED) return;
  for (const VkClearRect& rect : rects) pass_->clear(index, value, {&rect.rect, 1}, rect.baseArrayLayer, rect.layerCount);
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

// Inside a subpass a barrier is there for input attachments that are drawn to as well: what was drawn must be in memory. Outside
// it may order render passes, unless nothing is before it: TOP_OF_PIPE is no stage of theirs.
void Executor::execute(const cmd::PipelineBarrier& command) {
  if (!pass_ && (command.source_stages & ~VkPipelineStageFlags(VK_PIPELINE_STAGE_TOP_OF_PIPE_BIT)) != 0) finish_passes();
  if (pass_ && begin_->render_pass->subpass(subpass_).reads_own_output) split_subpass(pass_desc_.samples);
}

}  // namespace pineda::icd
