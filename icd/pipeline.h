// VkPipeline: what graphics and compute pipelines share.
//
// Code that samples depends on what is bound (format, filter, address modes: compiler::TextureState). A pipeline that samples
// nothing is compiled at creation; one that samples gets a variant for each combination of textures that a draw shows it, at the
// first such draw. The variants belong to the thread that executes for the queue (queue.h: one at a time), so they need no lock;
// all else is constant after creation.
#pragma once

#include <algorithm>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "icd/object.h"
#include "icd/pipeline_layout.h"
#include "icd/shader_stage.h"
#include "icd/texture_state.h"

namespace pineda::icd {

// The images that a pipeline samples, in a fixed order.
class PipelineTextures {
 public:
  // False (reported) when a shader uses a binding that the layout does not have.
  bool add(const spirv::Module& module, const PipelineLayout& layout);

  bool empty() const { return slots_.empty(); }
  // The ids that the sets hold now.
  void key(const DescriptorSet* const* sets, std::vector<TextureIds>& out) const;
  std::vector<compiler::TextureUse> uses(std::span<const TextureIds> key, const TextureStates& states) const;

 private:
  struct Slot {
    spirv::ImageRef image, sampler;
    TextureSlot image_at, sampler_at;
  };
  std::vector<Slot> slots_;
};

// Variants by key. Addresses are stable; a failed compile is remembered, as empty kernels.
template <typename Kernels>
class Variants {
 public:
  struct Entry {
    std::vector<TextureIds> key;
    std::unique_ptr<const Kernels> kernels;
  };

  const Entry* find(std::span<const TextureIds> key) const {
    const auto same = [](const TextureIds& a, const TextureIds& b) { return a.view == b.view && a.sampler == b.sampler; };
    for (const auto& entry : entries_) {
      if (std::ranges::equal(entry->key, key, same)) return entry.get();
    }
    return nullptr;
  }
  const Entry* add(std::span<const TextureIds> key, std::unique_ptr<const Kernels> kernels) {
    entries_.push_back(std::make_unique<const Entry>(Entry{{key.begin(), key.end()}, std::move(kernels)}));
    return entries_.back().get();
  }

 private:
  std::vector<std::unique_ptr<const Entry>> entries_;
};

class Pipeline : public Object {
 public:
  Pipeline(const Allocator& from, Device& owner, VkPipelineBindPoint point) : Object(from), device(owner), bind_point(point) {}
  virtual ~Pipeline() = default;

  Device& device;
  const VkPipelineBindPoint bind_point;
};

// vkCreate*Pipelines: creates each; a failed one leaves a null handle, and the first failure is the result.
template <typename Info, typename Create>
VkResult create_pipelines(uint32_t count, const Info* infos, VkPipeline* out, Create&& create) {
  VkResult result = VK_SUCCESS;
  for (uint32_t i = 0; i < count; ++i) {
    out[i] = VK_NULL_HANDLE;
    const VkResult one = guarded([&] { return create(infos[i], &out[i]); });
    if (result == VK_SUCCESS) result = one;
  }
  return result;
}

}  // namespace pineda::icd
