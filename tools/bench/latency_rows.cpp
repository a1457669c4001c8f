#include "tools/bench/latency_rows.h"

#include <unistd.h>

#include <chrono>
#include <cstdint>
#include <optional>

#include "shaders/cold_comp.h"
#include "shaders/cold_frag.h"
#include "shaders/cold_vert.h"
#include "tools/error.h"
#include "tools/scene.h"
#include "tools/stopwatch.h"

namespace pineda::tools {
namespace {

class EmptySubmitRow final : public BenchRow {
 public:
  explicit EmptySubmitRow(VkContext& context) : context_(context), commands_(context.record([](VkCommandBuffer) {})) {}
  ~EmptySubmitRow() override { context_.release(commands_); }
  double run_sample() override {
    constexpr int kRepeats = 16;  // one alone is close to the resolution of the clock
    const Stopwatch watch;
    for (int i = 0; i < kRepeats; ++i) context_.submit_and_wait(commands_);
    return watch.elapsed_ms() / kRepeats;
  }

 private:
  VkContext& context_;
  VkCommandBuffer commands_;
};

// A specialization constant that differs from sample to sample and from run to run, so that no cache, in memory or on disk, can
// hit.
class FreshConstant {
 public:
  FreshConstant() {
    const auto now = std::chrono::steady_clock::now().time_since_epoch().count();
    value_ = static_cast<uint32_t>(now / 1000) * 2654435761u ^ static_cast<uint32_t>(getpid());
  }
  uint32_t value() const { return value_; }
  VkSpecializationInfo next() {
    ++value_;
    return {1, &entry_, sizeof value_, &value_};
  }

 private:
  VkSpecializationMapEntry entry_{.constantID = 0, .offset = 0, .size = sizeof(uint32_t)};
  uint32_t value_ = 0;
};

class ColdComputeRow final : public BenchRow {
 public:
  explicit ColdComputeRow(VkContext& context) : context_(context), descriptors_(context, 1, 1) {
    constexpr VkDeviceSize kResultBytes = 64 * sizeof(uint32_t);
    results_ = create_buffer(context, kResultBytes, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
    const Binding binding{0, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, VK_SHADER_STAGE_COMPUTE_BIT};
    set_layout_ = create_set_layout(context, {&binding, 1});
    set_ = descriptors_.allocate(set_layout_);
    descriptors_.write_buffer(set_, 0, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, results_);
    const VkDescriptorSetLayout set_layout = set_layout_;
    layout_ = create_pipeline_layout(context, {&set_layout, 1}, {});
  }

  double run_sample() override {
    const VkSpecializationInfo specialization = constant_.next();
    const Stopwatch watch;
    const PipelineHandle pipeline = create_compute_pipeline(context_, cold_comp, layout_, &specialization);
    context_.run_once([&](VkCommandBuffer commands) {
      vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline);
      vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout_, 0, 1, &set_, 0, nullptr);
      vkCmdDispatch(commands, 1, 1, 1);
      make_visible_to_host(commands, results_, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_ACCESS_SHADER_WRITE_BIT);
    });
    const double elapsed_ms = watch.elapsed_ms();
    const uint32_t result = *reinterpret_cast<const uint32_t*>(results_.mapped);
    if (result != constant_.value()) fail("cold-compute: result {} instead of {}", result, constant_.value());
    return elapsed_ms;
  }

 private:
  VkContext& context_;
  FreshConstant constant_;
  DescriptorAllocator descriptors_;
  Buffer results_;
  DescriptorSetLayoutHandle set_layout_;
  VkDescriptorSet set_ = VK_NULL_HANDLE;
  PipelineLayoutHandle layout_;
};

class ColdGraphicsRow final : public BenchRow {
 public:
  ColdGraphicsRow(VkContext& context, VkExtent2D extent)
      : context_(context), target_(context, extent, RenderTarget::Attachments::kColourDepth) {
    layout_ = create_pipeline_layout(context, {}, {});
  }

  double run_sample() override {
    const VkSpecializationInfo specialization = constant_.next();
    const Stopwatch watch;
    const PipelineHandle pipeline = create_graphics_pipeline(context_, target_,
                                                             {.vertex_shader = cold_vert,
                                                              .fragment_shader = cold_frag,
                                                              .depth_test = true,
                                                              .depth_write = true,
                                                              .layout = layout_,
                                                              .specialization = &specialization});
    context_.run_once([&](VkCommandBuffer commands) {
      target_.begin(commands, {0, 0, 0, 1});
      vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline);
      vkCmdDraw(commands, 3, 1, 0, 0);
      vkCmdEndRenderPass(commands);
    });
    return watch.elapsed_ms();
  }

 private:
  VkContext& context_;
  FreshConstant constant_;
  RenderTarget target_;
  PipelineLayoutHandle layout_;
};

}  // namespace

std::unique_ptr<BenchRow> make_empty_submit_row(VkContext& context, VkExtent2D) {
  return std::make_unique<EmptySubmitRow>(context);
}
std::unique_ptr<BenchRow> make_cold_compute_row(VkContext& context, VkExtent2D) {
  return std::make_unique<ColdComputeRow>(context);
}
std::unique_ptr<BenchRow> make_cold_graphics_row(VkContext& context, VkExtent2D extent) {
  return std::make_unique<ColdGraphicsRow>(context, extent);
}

}  // namespace pineda::tools
