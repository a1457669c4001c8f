#include "tools/bench/compute_rows.h"

#include <algorithm>
#include <array>
#include <cstdint>

#include "shaders/saxpy_comp.h"
#include "tools/error.h"
#include "tools/stopwatch.h"
#include "tools/vk/pipelines.h"

namespace pineda::tools {
namespace {

constexpr uint32_t kCount = 8u << 20, kGroupSize = 256, kGroupsPerRow = 32'768;

class SaxpyRow final : public BenchRow {
 public:
  explicit SaxpyRow(VkContext& context) : context_(context), descriptors_(context, 1, 2) {
    for (Buffer* buffer : {&x_, &y_}) {
      *buffer = create_buffer(context, kCount * sizeof(float), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
      float* const values = reinterpret_cast<float*>(buffer->mapped);
      std::fill(values, values + kCount, 1.0f);
    }
    const std::array<Binding, 2> bindings{Binding{0, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, VK_SHADER_STAGE_COMPUTE_BIT},
                                          Binding{1, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, VK_SHADER_STAGE_COMPUTE_BIT}};
    set_layout_ = create_set_layout(context, bindings);
    set_ = descriptors_.allocate(set_layout_);
    descriptors_.write_buffer(set_, 0, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, x_);
    descriptors_.write_buffer(set_, 1, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, y_);
    const VkDescriptorSetLayout set_layout = set_layout_;
    const VkPushConstantRange range{VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof(float)};
    layout_ = create_pipeline_layout(context, {&set_layout, 1}, {&range, 1});
    pipeline_ = create_compute_pipeline(context, saxpy_comp, layout_);
    commands_ = context.record([&](VkCommandBuffer commands) {
      const float factor = 0.5f;
      vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline_);
      vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout_, 0, 1, &set_, 0, nullptr);
      vkCmdPushConstants(commands, layout_, VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof factor, &factor);
      vkCmdDispatch(commands, kGroupsPerRow, kCount / kGroupSize / kGroupsPerRow, 1);
      make_visible_to_host(commands, y_, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_ACCESS_SHADER_WRITE_BIT);
    });
  }
  ~SaxpyRow() override { context_.release(commands_); }

  double run_sample() override {
    const Stopwatch watch;
    context_.submit_and_wait(commands_);
    const double elapsed_ms = watch.elapsed_ms();
    expected_ += 0.5f;  // exact: halves, and far fewer samples than 2^23
    const float* const y = reinterpret_cast<const float*>(y_.mapped);
    if (y[0] != expected_ || y[kCount - 1] != expected_) fail("saxpy: {} and {} instead of {}", y[0], y[kCount - 1], expected_);
    return elapsed_ms;
  }

 private:
  VkContext& context_;
  DescriptorAllocator descriptors_;
  Buffer x_, y_;
  float expected_ = 1;
  DescriptorSetLayoutHandle set_layout_;
  VkDescriptorSet set_ = VK_NULL_HANDLE;
  PipelineLayoutHandle layout_;
  PipelineHandle pipeline_;
  VkCommandBuffer commands_ = VK_NULL_HANDLE;
};

}  // namespace

std::unique_ptr<BenchRow> make_saxpy_row(VkContext& context, VkExtent2D) { return std::make_unique<SaxpyRow>(context); }

}  // namespace pineda::tools
