#include "icd/pipeline.h"

#include "base/config.h"
#include "icd/api.h"
#include "icd/descriptor_set.h"
#include "icd/device.h"

namespace pineda::icd {

bool PipelineTextures::add(const spirv::Module& module, const PipelineLayout& layout) {
  for (const spirv::ImageUse& use : spirv::info(module).images) {
    if (!use.sampled) continue;
    Slot slot{use.image, use.sampler, use.view_type, {}, {}};
    if (!layout.find_texture(use.image, &slot.image_at)) {
      report(Severity::kError, "a shader samples set " + std::to_string(use.image.set) + " binding " +
                                   std::to_string(use.image.binding) + ", which the pipeline layout does not have");
      return false;
    }
    if (use.dynamic) continue;
    // A fetch has no sampler; its ref then names nothing and the image's own ids serve.
    if (!layout.find_texture(use.sampler, &slot.sampler_at)) slot.sampler_at = slot.image_at;
    slots_.push_back(slot);
  }
  return true;
}

void PipelineTextures::key(const DescriptorSet* const* sets, std::vector<TextureIds>& out) const {
  out.clear();
  for (const Slot& slot : slots_) {
    const DescriptorSet* image_set = sets[slot.image_at.set];
    const DescriptorSet* sampler_set = sets[slot.sampler_at.set];
    out.push_back({.view = image_set ? image_set->texture(slot.image_at.index).view : 0,
                   .sampler = sampler_set ? sampler_set->texture(slot.sampler_at.index).sampler : 0});
  }
}

std::vector<compiler::TextureUse> PipelineTextures::uses(std::span<const TextureIds> key, const TextureStates& states) const {
  std::vector<compiler::TextureUse> uses;
  for (size_t i = 0; i < slots_.size(); ++i) {
    compiler::TextureUse use{slots_[i].image, slots_[i].sampler, states.combine(key[i].view, key[i].sampler)};
    if (key[i].view == 0) use.state.view_type = slots_[i].view_type;      // a null image fits every shader
    if (std::ranges::find(uses, use) == uses.end()) uses.push_back(use);  // both stages may sample the same pair
  }
  return uses;
}

uint32_t uses_before_specialization() { return specializes_at_once() ? 1 : 2; }
bool specializes_at_once() { return !debug(kDebugGeneral) && (config().mode != Mode::kJit || debug(kDebugSpecialize)); }

const TextureStates& texture_states(const Device& device) { return device.texture_states; }

compiler::CodeGenerator code_generator(Device& device) {
  if (config().mode != Mode::kJit || render_threads() == 1) return {};
  return [&device](const compiler::KernelPtr& kernel) {
    device.code_generation.submit(nullptr, [unfinished = std::weak_ptr(kernel)] {
      try {
        if (const compiler::KernelPtr wanted = unfinished.lock()) wanted->finish_unless_begun();
      } catch (const std::exception&) {  // out of memory: whoever uses the kernel tries again and reports it
      }
    });
  };
}

bool finish(compiler::Kernel& kernel) {
  const auto done = kernel.finish();
  if (!done) report(Severity::kError, done.error().text);
  return done.has_value();
}

void run_in_background(Device& device, const void* owner, std::function<void()> work) {
  if (!debug(kDebugGeneral)) device.background.submit(owner, std::move(work));
}

void api::DestroyPipeline(VkDevice device, VkPipeline pipeline, const VkAllocationCallbacks* callbacks) {
  destroy_device_object(device, pipeline, callbacks);
}

}  // namespace pineda::icd
