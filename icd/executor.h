// Walks the commands of a command buffer and turns them into work for raster/: one execute() for each row of commands.inc, in
// exec_*.cpp.
//
// Belongs to the queue; used by one thread at a time (queue.h). State that shaders see is kept as a DrawContext that binds write
// into; a draw copies it into the arena when it has changed since the last draw, because draws of a pass run later, together.
#pragma once

#include <map>
#include <optional>
#include <span>
#include <vector>

#include "icd/address_table.h"
#include "icd/arena.h"
#include "icd/command_list.h"
#include "icd/graphics_pipeline.h"
#include "icd/labels.h"
#include "icd/object.h"
#include "raster/raster.h"

namespace pineda::icd {

struct SubpassAttachment;

class Executor {
 public:
  explicit Executor(Device& device);

  void run(const CommandBuffer& command_buffer);
  // After run() has thrown: drops the render pass in progress.
  void abandon();
  // Those open in the command buffer that executes.
  std::vector<Label> labels() const { return labels_.snapshot(); }

 private:
  // What vkCmdBind* and vkCmdPushConstants have set for graphics or compute.
  struct BindPoint {
    DrawContext context;
    std::array<const DescriptorSet*, kMaxSets> sets;
  };

  // A direct or indirect draw, resolved.
  struct DrawCall {
    raster::IndexBuffer index;  // null address: not indexed
    uint32_t first, count;
    int32_t vertex_offset;
    uint32_t first_instance, instance_count, draw_index;
  };

  // What has changed since the packet and the context were last made.
  enum Dirty : uint32_t { kKernels = 1, kPacket = 2, kContext = 4, kAll = 7 };

#define PINEDA_COMMAND(name) void execute(const cmd::name& command);
#include "icd/commands.inc"

  void walk(const CommandBuffer& command_buffer);
  void execute(const CommandHeader& header);
  void reset_state();
  void update_addresses();

  // exec_pass.cpp
  void begin_subpass();
  void begin_view(uint32_t view);
  bool begin_next_view();
  VkAttachmentLoadOp load_of(const SubpassAttachment& use, VkAttachmentLoadOp SubpassAttachment::*load) const;
  void run_pass();
  bool may_wait() const;
  void finish_passes();
  void end_subpass();
  void split_subpass(uint32_t samples);
  void clear_first(const SubpassAttachment& use);
  void clear_attachment(uint32_t index, const SubpassAttachment& use, const VkClearValue& value,
                        std::span<const VkClearRect> rects);

  // exec_resolve.cpp
  const compiler::Kernel* resolve_kernel(VkFormat format, uint32_t samples);

  // exec_query.cpp
  void finish_queries(const raster::PassStatistics& statistics);

  // exec_draw.cpp
  void draw(const DrawCall& call);
  bool flush();
  bool flush_kernels();
  bool flush_packet();
  void discard_primitives();
  void flush_context(const DrawCall& call);
  raster::IndexBuffer index_buffer() const;

  // exec_dispatch.cpp
  void dispatch(std::array<uint32_t, 3> base, std::array<uint32_t, 3> count);

  Device& device_;
  LabelStack labels_;
  Arena arena_;  // draw contexts of the subpass

  // What pointers may reach. Not changed while a render pass holds contexts that point into it.
  AddressTable::Snapshot addresses_;
  uint64_t addresses_version_ = ~uint64_t{0};

  // Bound state.
  BindPoint graphics_, compute_;
  const GraphicsPipeline* pipeline_ = nullptr;
  const ComputePipeline* compute_pipeline_ = nullptr;
  DynamicState dynamic_;
  cmd::BindIndexBuffer index_{};
  uint32_t dirty_ = kAll;
  bool pristine_ = true;  // nothing has been executed since reset_state()

  // Derived from it.
  const compiler::GraphicsKernels* kernels_ = nullptr;
  const compiler::ComputeKernel* compute_kernel_ = nullptr;
  raster::DrawPacket packet_;  // everything but the draw's own numbers

  // Render pass in progress.
  const cmd::BeginRenderPass* begin_ = nullptr;
  uint32_t subpass_ = 0;

  // Multiview: the commands of a subpass are walked once for each view, each time from the same state.
  struct SubpassStart {
    const CommandHeader* header;  // of the command that began the subpass
    BindPoint graphics, compute;
    const GraphicsPipeline* pipeline;
    const ComputePipeline* compute_pipeline;
    DynamicState dynamic;
    cmd::BindIndexBuffer index;
  };
  std::optional<SubpassStart> start_;
  const CommandHeader* current_ = nullptr;      // of the primary command buffer
  const CommandHeader* replay_from_ = nullptr;  // the walk goes on behind this one
  uint32_t view_ = 0, view_ordinal_ = 0;        // view_ordinal_: how many views of the subpass were before
  std::map<std::pair<VkFormat, uint32_t>, compiler::KernelPtr> resolve_kernels_;  // by format and samples
  raster::PassDesc pass_desc_;
  std::optional<raster::Pass> pass_;

  // Render passes that have ended as commands and have not run. None depends on another, so they will run beside each other, as
  // soon as a command comes that could tell. Their contexts are in the arena.
  struct WaitingPass {
    raster::Pass pass;
    raster::PassDesc desc;
  };
  static constexpr size_t kMaxWaiting = 64;
  std::vector<WaitingPass> waiting_;

  // Queries that are active; those that have ended and wait for the pass in progress.
  struct ActiveQuery {
    QueryPool* pool = nullptr;
    uint32_t query = 0;
  };
  ActiveQuery occlusion_, statistics_;
  std::vector<ActiveQuery> ended_;
};

}  // namespace pineda::icd
