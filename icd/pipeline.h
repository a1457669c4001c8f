// VkPipeline: what graphics and compute pipelines share.
//
// Every pipeline is translated at creation, which is when errors of shaders show; its machine code is generated on the device's
// threads from then on, and the first use waits for it (or generates it, if no thread has come to it). Code that samples depends
// on what is bound (format, filter, address modes: compiler::TextureState), so that first, general form calls a function for each
// sample (compiler/sample_functions.h). A combination of textures that is used again gets a variant with the sampling inlined,
// compiled in the background; it computes the same bits. Modes that are for looking at values rather than for speed take the
// variants at once.
//
// The variants belong to the thread that executes for the queue (queue.h: one at a time); the background thread completes them.
// All else is constant after creation, but for kernels that are not finished yet (compiler::Kernel::finish).
#pragma once

#include <algorithm>
#include <atomic>
#include <functional>
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
  // False (reported) when a shader uses a binding that the layout does not have. What is indexed by values is left out.
  bool add(const spirv::Module& module, const PipelineLayout& layout);

  bool empty() const { return slots_.empty(); }
  // The ids that the sets hold now.
  void key(const DescriptorSet* const* sets, std::vector<TextureIds>& out) const;
  std::vector<compiler::TextureUse> uses(std::span<const TextureIds> key, const TextureStates& states) const;

 private:
  struct Slot {
    spirv::ImageRef image, sampler;
    VkImageViewType view_type;
    TextureSlot image_at, sampler_at;
  };
  std::vector<Slot> slots_;
};

// A combination that is used once is not worth a compile.
uint32_t uses_before_specialization();
bool specializes_at_once();
const TextureStates& texture_states(const Device& device);
// Empty when new pipelines are finished at creation: without helper threads, and in the modes that look at values.
compiler::CodeGenerator code_generator(Device& device);
// False (reported) when it fails.
bool finish(compiler::Kernel& kernel);
void run_in_background(Device& device, const void* owner, std::function<void()> work);

// Variants by key. A failed compile (reported) leaves the general kernels in use.
template <typename Kernels>
class Variants {
 public:
  using Compile = std::function<std::unique_ptr<const Kernels>(std::span<const compiler::TextureUse>)>;

  // Kernels for what is bound, or null: then the general ones serve for now. `compile` runs on the background thread, on behalf
  // of `owner`.
  const Kernels* find(Device& device, const void* owner, const PipelineTextures& textures, const DescriptorSet* const* sets,
                      const Compile& compile) {
    textures.key(sets, key_);
    Entry& entry = this->entry(key_);
    if (entry.ready.load(std::memory_order_acquire)) return entry.kernels.get();
    if (++entry.uses != uses_before_specialization()) return nullptr;
    const auto work = [&entry, compile, uses = textures.uses(key_, texture_states(device))] {
      entry.kernels = compile(uses);
      entry.ready.store(true, std::memory_order_release);
    };
    if (specializes_at_once()) {
      work();
      return entry.kernels.get();
    }
    run_in_background(device, owner, work);
    return nullptr;
  }

 private:
  struct Entry {
    std::vector<TextureIds> key;
    uint32_t uses = 0;
    std::unique_ptr<const Kernels> kernels;  // constant once `ready`
    std::atomic<bool> ready{false};
  };

  Entry& entry(std::span<const TextureIds> key) {
    const auto same = [](const TextureIds& a, const TextureIds& b) { return a.view == b.view && a.sampler == b.sampler; };
    for (const auto& entry : entries_) {
      if (std::ranges::equal(entry->key, key, same)) return *entry;
    }
    entries_.push_back(std::make_unique<Entry>());
    entries_.back()->key.assign(key.begin(), key.end());
    return *entries_.back();
  }

  std::vector<std::unique_ptr<Entry>> entries_;
  std::vector<TextureIds> key_;  // scratch
};

class Pipeline : public Object {
 public:
  Pipeline(const Allocator& from, Device& owner, VkPipelineBindPoint point) : Object(from), device(owner), bind_point(point) {}
  virtual ~Pipeline() = default;

  Device& device;
  const VkPipelineBindPoint bind_point;
};

}  // namespace pineda::icd
