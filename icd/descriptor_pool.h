// VkDescriptorPool: counts what may be allocated, and owns the sets. Each set is an allocation of its own, so a pool never
// fragments.
#pragma once

#include "icd/descriptor_set.h"
#include "icd/object.h"

namespace pineda::icd {

class DescriptorPool : public Object {
 public:
  DescriptorPool(const Allocator& from, Device& device, const VkDescriptorPoolCreateInfo& info);
  ~DescriptorPool() { reset(); }

  // VK_ERROR_OUT_OF_POOL_MEMORY when the pool has not been made for it. Throws std::bad_alloc.
  // `variable_count`: of the last binding, when the layout says that sets choose it.
  VkResult allocate(const DescriptorSetLayout& layout, uint32_t variable_count, DescriptorSet** out);
  void release(DescriptorSet* set);
  void reset();

 private:
  Device& device_;
  uint32_t free_sets_;
  DescriptorCounts free_{};
  DescriptorSet* first_ = nullptr;
};

}  // namespace pineda::icd
