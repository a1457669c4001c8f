// VkShaderModule: a copy of the words. Nothing is checked here, because what a module means depends on the entry point and the
// specialization constants; pipelines parse it.
#pragma once

#include <span>

#include "icd/object.h"

namespace pineda::icd {

class ShaderModule : public Object {
 public:
  ShaderModule(const Allocator& from, Device&, const VkShaderModuleCreateInfo& info)
      : Object(from), words_(info.pCode, info.pCode + info.codeSize / 4, HostAllocator<uint32_t>(&allocator)) {}

  std::span<const uint32_t> words() const { return words_; }

 private:
  HostVector<uint32_t> words_;
};

}  // namespace pineda::icd
