// VkDescriptorSet: descriptor memory in the layout that kernels read, and beside it the ids of what selects code. Object, memory
// and ids are one allocation, owned by the pool.
#pragma once

#include <array>

#include "icd/descriptor_set_layout.h"
#include "icd/object.h"
#include "icd/texture_state.h"

namespace pineda::icd {

inline constexpr uint32_t kMaxSetBytes = 256u << 20;  // more than kMaxUpdateAfterBindDescriptors of any type

// Descriptors of each core type, indexed by VkDescriptorType.
inline constexpr size_t kDescriptorTypeCount = VK_DESCRIPTOR_TYPE_INPUT_ATTACHMENT + 1;
using DescriptorCounts = std::array<uint32_t, kDescriptorTypeCount>;

class DescriptorSet : public Object {
 public:
  static constexpr size_t kAlignment = 64;
  // Throws std::bad_alloc. Immutable samplers are written; the rest is zero: reads of a zero descriptor give zero.
  static Owned<DescriptorSet> make(const Allocator& allocator, const DescriptorSetLayout& layout, const DescriptorCounts& counts);

  const uint8_t* memory() const { return memory_; }
  const TextureIds& texture(uint32_t index) const { return textures_[index]; }
  const DescriptorCounts& counts() const { return counts_; }

  void write(const VkWriteDescriptorSet& write);
  void copy(const VkCopyDescriptorSet& copy);

  DescriptorSet* previous = nullptr;  // of the pool's list
  DescriptorSet* next = nullptr;

 private:
  DescriptorSet(const Allocator& from, const DescriptorSetLayout& layout, const DescriptorCounts& counts);
  void write_one(const BindingLayout& binding, uint32_t element, const VkWriteDescriptorSet& write, uint32_t source);

  const DescriptorSetLayout& layout_;  // for updates only: they are invalid after the layout's destruction
  uint8_t* memory_;
  TextureIds* textures_;
  DescriptorCounts counts_;  // taken from the pool
};

}  // namespace pineda::icd
