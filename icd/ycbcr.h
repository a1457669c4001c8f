// VkSamplerYcbcrConversion: a part of the sampler's state that selects code.
#pragma once

#include <optional>

#include "compiler/compile.h"
#include "icd/object.h"

namespace pineda::icd {

class SamplerYcbcrConversion : public Object {
 public:
  static VkResult check(Device& device, const VkSamplerYcbcrConversionCreateInfo& info);
  SamplerYcbcrConversion(const Allocator& from, Device&, const VkSamplerYcbcrConversionCreateInfo& info);

  // Nothing when the conversion changes nothing: a format of one plane and the identity.
  const std::optional<compiler::YcbcrState>& state() const { return state_; }

 private:
  std::optional<compiler::YcbcrState> state_;
};

}  // namespace pineda::icd
