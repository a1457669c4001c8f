// VkPipelineLayout: set layouts flattened into what the compiler wants to know, and where a set's dynamic offsets start.
#pragma once

#include <array>
#include <memory>

#include "compiler/compile.h"
#include "icd/object.h"

namespace pineda::icd {

// Where the TextureIds of a shader's image or sampler are: set and DescriptorSet::texture index.
struct TextureSlot {
  uint32_t set = 0, index = 0;
};

class PipelineLayout : public Object {
 public:
  static VkResult check(Device& device, const VkPipelineLayoutCreateInfo& info);
  PipelineLayout(const Allocator& from, Device&, const VkPipelineLayoutCreateInfo& info);

  // Shared with pipelines, which may outlive this object.
  const std::shared_ptr<const compiler::PipelineLayout>& compiler_layout() const { return compiler_layout_; }
  // Index in DrawContext::dynamic_offsets of the set's first dynamic descriptor. Compatible layouts agree on it: everything
  // before a set is the same.
  uint32_t dynamic_base(uint32_t set) const { return dynamic_base_[set]; }
  // False when the layout has no such image or sampler.
  bool find_texture(const spirv::ImageRef& ref, TextureSlot* out) const;

 private:
  struct TextureRange {
    uint32_t set, binding, count, first_index;
  };
  std::shared_ptr<const compiler::PipelineLayout> compiler_layout_;
  HostVector<TextureRange> textures_;
  std::array<uint32_t, kMaxSets> dynamic_base_{};
};

}  // namespace pineda::icd
