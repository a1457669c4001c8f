#include "icd/pipeline.h"

#include "icd/api.h"
#include "icd/descriptor_set.h"
#include "icd/device.h"

namespace pineda::icd {

bool PipelineTextures::add(const spirv::Module& module, const PipelineLayout& layout) {
  for (const spirv::ImageUse& use : spirv::info(module).images) {
    if (!use.sampled) continue;
    Slot slot{use.image, use.sampler, {}, {}};
    if (!layout.find_texture(use.image, &slot.image_at)) {
      report(Severity::kError, "a shader samples set " + std::to_string(use.image.set) + " binding " +
                                   std::to_string(use.image.binding) + ", which the pipeline layout does not have");
      return false;
    }
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
    const compiler::TextureUse use{slots_[i].image, slots_[i].sampler, states.combine(key[i].view, key[i].sampler)};
    if (std::ranges::find(uses, use) == uses.end()) uses.push_back(use);  // both stages may sample the same pair
  }
  return uses;
}

void api::DestroyPipeline(VkDevice device, VkPipeline pipeline, const VkAllocationCallbacks* callbacks) {
  destroy_device_object(device, pipeline, callbacks);
}

}  // namespace pineda::icd
