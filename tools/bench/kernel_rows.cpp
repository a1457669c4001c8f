#include "tools/bench/kernel_rows.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "shaders/histogram_comp.h"
#include "shaders/reduce_comp.h"
#include "shaders/scan_comp.h"
#include "shaders/sgemm_comp.h"
#include "shaders/transcendentals_comp.h"
#include "tools/error.h"
#include "tools/stopwatch.h"
#include "tools/vk/pipelines.h"

namespace pineda::tools {
namespace {

constexpr VkDescriptorType kStorage = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;

struct Kernel {
  std::span<const uint32_t> code;
  std::vector<size_t> buffer_words;  // binding i
  uint32_t push_constant = 0;
  std::array<uint32_t, 2> groups{1, 1};
  std::function<void(std::vector<uint32_t*>&)> fill;   // inputs; everything starts at zero
  std::function<void(std::vector<uint32_t*>&)> check;  // fails when the results are wrong
};

class KernelRow final : public BenchRow {
 public:
  KernelRow(VkContext& context, Kernel kernel)
      : context_(context),
        kernel_(std::move(kernel)),
        descriptors_(context, 1, static_cast<uint32_t>(kernel_.buffer_words.size())) {
    std::vector<Binding> bindings;
    for (uint32_t i = 0; i < kernel_.buffer_words.size(); ++i) {
      bindings.push_back({i, kStorage, VK_SHADER_STAGE_COMPUTE_BIT});
      buffers_.push_back(create_buffer(context, kernel_.buffer_words[i] * sizeof(uint32_t), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT));
      words_.push_back(reinterpret_cast<uint32_t*>(buffers_[i].mapped));
      std::fill_n(words_[i], kernel_.buffer_words[i], 0);
    }
    kernel_.fill(words_);
    set_layout_ = create_set_layout(context, bindings);
    set_ = descriptors_.allocate(set_layout_);
    for (uint32_t i = 0; i < buffers_.size(); ++i) descriptors_.write_buffer(set_, i, kStorage, buffers_[i]);
    const VkDescriptorSetLayout set_layout = set_layout_;
    const VkPushConstantRange range{VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof(uint32_t)};
    layout_ = create_pipeline_layout(context, {&set_layout, 1}, {&range, 1});
    pipeline_ = create_compute_pipeline(context, kernel_.code, layout_);
    commands_ = context.record([&](VkCommandBuffer commands) {
      vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline_);
      vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout_, 0, 1, &set_, 0, nullptr);
      vkCmdPushConstants(commands, layout_, VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof(uint32_t), &kernel_.push_constant);
      vkCmdDispatch(commands, kernel_.groups[0], kernel_.groups[1], 1);
      make_visible_to_host(commands, buffers_.back(), VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_ACCESS_SHADER_WRITE_BIT);
    });
    context_.submit_and_wait(commands_);
    kernel_.check(words_);
  }
  ~KernelRow() override { context_.release(commands_); }

  double run_sample() override {
    const Stopwatch watch;
    context_.submit_and_wait(commands_);
    return watch.elapsed_ms();
  }

 private:
  VkContext& context_;
  const Kernel kernel_;
  DescriptorAllocator descriptors_;
  std::vector<Buffer> buffers_;
  std::vector<uint32_t*> words_;
  DescriptorSetLayoutHandle set_layout_;
  VkDescriptorSet set_ = VK_NULL_HANDLE;
  PipelineLayoutHandle layout_;
  PipelineHandle pipeline_;
  VkCommandBuffer commands_ = VK_NULL_HANDLE;
};

uint32_t hash(size_t i) { return static_cast<uint32_t>(i) * 2654435761u >> 5; }

void fill_with_hashes(uint32_t* words, size_t count) {
  for (size_t i = 0; i < count; ++i) words[i] = hash(i);
}

void expect_words(const char* row, const uint32_t* got, const std::vector<uint32_t>& want) {
  const auto [wrong, right] = std::mismatch(got, got + want.size(), want.begin());
  if (right != want.end()) fail("{}: {} instead of {} at {}", row, *wrong, *right, wrong - got);
}

// Multiples of 1/16 in [-1, 1): every product and partial sum of 512 is exact in binary32, whatever the order, fused or not.
float matrix_element(size_t i) { return static_cast<float>(static_cast<int32_t>(hash(i) % 32) - 16) / 16; }

void check_sgemm(const float* c, uint32_t size) {
  std::vector<float> row(size);
  for (uint32_t y = 0; y < size; y += 37) {
    std::ranges::fill(row, 0.0f);
    for (uint32_t k = 0; k < size; ++k) {
      const float a = matrix_element(y * size + k);
      for (uint32_t x = 0; x < size; ++x) row[x] += a * matrix_element((k * size + x) + size * size);
    }
    for (uint32_t x = 0; x < size; ++x) {
      if (c[y * size + x] != row[x]) fail("sgemm: {} instead of {} at ({}, {})", c[y * size + x], row[x], x, y);
    }
  }
}

}  // namespace

std::unique_ptr<BenchRow> make_sgemm_row(VkContext& context, VkExtent2D) {
  constexpr uint32_t kSize = 512, kWords = kSize * kSize;
  return std::make_unique<KernelRow>(
      context, Kernel{.code = sgemm_comp,
                      .buffer_words = {kWords, kWords, kWords},
                      .push_constant = kSize,
                      .groups = {kSize / 16, kSize / 16},
                      .fill =
                          [](std::vector<uint32_t*>& words) {
                            for (uint32_t i = 0; i < 2 * kWords; ++i)
                              reinterpret_cast<float*>(words[i / kWords])[i % kWords] = matrix_element(i);
                          },
                      .check = [](auto& words) { check_sgemm(reinterpret_cast<const float*>(words[2]), kSize); }});
}

std::unique_ptr<BenchRow> make_transcendentals_row(VkContext& context, VkExtent2D) {
  constexpr uint32_t kCount = 1 << 20, kTurns = 20;
  const auto check = [](std::vector<uint32_t*>& words) {
    const auto* x = reinterpret_cast<const float*>(words[0]);
    constexpr double kTolerance = 1e-2;  // sin and cos may be off by 2^-11 (Vulkan, "Precision"), which the turns do not enlarge
    for (uint32_t i = 0; i < kCount; i += 4099) {
      double v = i / 65536.0 - 8;
      for (uint32_t t = 0; t < kTurns; ++t)
        v = 0.25 * (std::sin(v) + std::cos(v) + std::exp2(-v * v)) + 0.1 * std::log2(1.5 + v * v);
      if (!(std::abs(x[i] - v) < kTolerance)) fail("transcendentals: {} instead of {} at {}", x[i], v, i);
    }
  };
  return std::make_unique<KernelRow>(context, Kernel{.code = transcendentals_comp,
                                                     .buffer_words = {kCount},
                                                     .push_constant = kTurns,
                                                     .groups = {kCount / 64, 1},
                                                     .fill = [](auto&) {},
                                                     .check = check});
}

std::unique_ptr<BenchRow> make_histogram_row(VkContext& context, VkExtent2D) {
  constexpr uint32_t kPerInvocation = 64, kGroups = 256, kCount = 256 * kPerInvocation * kGroups;
  const auto check = [](std::vector<uint32_t*>& words) {
    std::vector<uint32_t> bins(256);
    for (uint32_t i = 0; i < kCount; ++i) ++bins[hash(i) & 255];
    expect_words("histogram", words[1], bins);
  };
  return std::make_unique<KernelRow>(context, Kernel{.code = histogram_comp,
                                                     .buffer_words = {kCount, 256},
                                                     .push_constant = kPerInvocation,
                                                     .groups = {kGroups, 1},
                                                     .fill = [](auto& words) { fill_with_hashes(words[0], kCount); },
                                                     .check = check});
}

std::unique_ptr<BenchRow> make_reduce_row(VkContext& context, VkExtent2D) {
  constexpr uint32_t kPerInvocation = 4, kGroups = 8192, kPerGroup = 256 * kPerInvocation, kCount = kPerGroup * kGroups;
  const auto check = [](std::vector<uint32_t*>& words) {
    std::vector<uint32_t> sums(kGroups);
    for (uint32_t i = 0; i < kCount; ++i) sums[i / kPerGroup] += hash(i);
    expect_words("reduce", words[1], sums);
  };
  return std::make_unique<KernelRow>(context, Kernel{.code = reduce_comp,
                                                     .buffer_words = {kCount, kGroups},
                                                     .push_constant = kPerInvocation,
                                                     .groups = {kGroups, 1},
                                                     .fill = [](auto& words) { fill_with_hashes(words[0], kCount); },
                                                     .check = check});
}

std::unique_ptr<BenchRow> make_scan_row(VkContext& context, VkExtent2D) {
  constexpr uint32_t kGroups = 8192, kCount = 256 * kGroups;
  const auto check = [](std::vector<uint32_t*>& words) {
    std::vector<uint32_t> sums(kCount);
    for (uint32_t i = 0; i < kCount; ++i) sums[i] = hash(i) + (i % 256 == 0 ? 0 : sums[i - 1]);
    expect_words("scan", words[1], sums);
  };
  return std::make_unique<KernelRow>(context, Kernel{.code = scan_comp,
                                                     .buffer_words = {kCount, kCount},
                                                     .groups = {kGroups, 1},
                                                     .fill = [](auto& words) { fill_with_hashes(words[0], kCount); },
                                                     .check = check});
}

}  // namespace pineda::tools
