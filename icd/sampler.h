// VkSampler: the data words of a descriptor, and the id of what selects code.
#pragma once

#include "base/abi.h"
#include "icd/object.h"

namespace pineda::icd {

class Sampler : public Object {
 public:
  static VkResult check(Device& device, const VkSamplerCreateInfo& info);
  Sampler(const Allocator& from, Device& device, const VkSamplerCreateInfo& info);

  const SamplerDescriptor& descriptor() const { return descriptor_; }
  uint32_t state_id() const { return descriptor_.state_id; }  // TextureStates

 private:
  SamplerDescriptor descriptor_{};
};

}  // namespace pineda::icd
