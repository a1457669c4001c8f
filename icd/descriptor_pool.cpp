#include "icd/descriptor_pool.h"

#include <algorithm>

#include "icd/api.h"
#include "icd/chain.h"
#include "icd/device.h"

namespace pineda::icd {

DescriptorPool::DescriptorPool(const Allocator& from, Device& device, const VkDescriptorPoolCreateInfo& info)
    : Object(from), device_(device), free_sets_(info.maxSets) {
  for (uint32_t i = 0; i < info.poolSizeCount; ++i) {
    const VkDescriptorPoolSize& size = info.pPoolSizes[i];
    if (size.type < kDescriptorTypeCount) free_[size.type] += size.descriptorCount;  // others can be in no layout
  }
}

VkResult DescriptorPool::allocate(const DescriptorSetLayout& layout, uint32_t variable_count, DescriptorSet** out) {
  DescriptorCounts wanted{};
  for (const BindingLayout& binding : layout.bindings()) wanted[binding.type] += binding.count;
  if (layout.has_variable_count()) {
    const BindingLayout& last = layout.bindings().back();
    wanted[last.type] -= last.count - std::min(variable_count, last.count);
  }
  if (free_sets_ == 0) return VK_ERROR_OUT_OF_POOL_MEMORY;
  for (size_t type = 0; type < kDescriptorTypeCount; ++type) {
    if (wanted[type] > free_[type]) return VK_ERROR_OUT_OF_POOL_MEMORY;
  }
  DescriptorSet* set = DescriptorSet::make(allocator, layout, wanted).release();
  --free_sets_;
  for (size_t type = 0; type < kDescriptorTypeCount; ++type) free_[type] -= wanted[type];
  set->next = first_;
  if (first_) first_->previous = set;
  first_ = set;
  *out = set;
  return VK_SUCCESS;
}

void DescriptorPool::release(DescriptorSet* set) {
  if (!set) return;
  ++free_sets_;
  for (size_t type = 0; type < kDescriptorTypeCount; ++type) free_[type] += set->counts()[type];
  (set->previous ? set->previous->next : first_) = set->next;
  if (set->next) set->next->previous = set->previous;
  device_.forget_name(reinterpret_cast<uint64_t>(set));
  set->allocator = allocator;  // vkDestroyDescriptorPool may have brought other callbacks
  release_object(set);
}

void DescriptorPool::reset() {
  while (first_) release(first_);
}

VkResult api::CreateDescriptorPool(VkDevice device, const VkDescriptorPoolCreateInfo* info,
                                   const VkAllocationCallbacks* callbacks, VkDescriptorPool* out) {
  return create_device_object<DescriptorPool>(device, info, callbacks, out);
}

void api::DestroyDescriptorPool(VkDevice device, VkDescriptorPool pool, const VkAllocationCallbacks* callbacks) {
  destroy_device_object(device, pool, callbacks);
}

VkResult api::ResetDescriptorPool(VkDevice, VkDescriptorPool pool, VkDescriptorPoolResetFlags) {
  from(pool)->reset();
  return VK_SUCCESS;
}

VkResult api::AllocateDescriptorSets(VkDevice, const VkDescriptorSetAllocateInfo* info, VkDescriptorSet* out) {
  DescriptorPool& pool = *from(info->descriptorPool);
  const auto* variable = find_in_chain<VkDescriptorSetVariableDescriptorCountAllocateInfo>(
      info->pNext, VK_STRUCTURE_TYPE_DESCRIPTOR_SET_VARIABLE_DESCRIPTOR_COUNT_ALLOCATE_INFO);
  for (uint32_t i = 0; i < info->descriptorSetCount; ++i) out[i] = VK_NULL_HANDLE;
  const VkResult result = guarded([&] {
    for (uint32_t i = 0; i < info->descriptorSetCount; ++i) {
      DescriptorSet* set = nullptr;
      const uint32_t count = variable && i < variable->descriptorSetCount ? variable->pDescriptorCounts[i] : 0;
      if (const VkResult failed = pool.allocate(*from(info->pSetLayouts[i]), count, &set); failed != VK_SUCCESS) return failed;
      out[i] = to_handle(set);
    }
    return VK_SUCCESS;
  });
  if (result == VK_SUCCESS) return result;
  for (uint32_t i = 0; i < info->descriptorSetCount; ++i) {  // all or nothing
    pool.release(from(out[i]));
    out[i] = VK_NULL_HANDLE;
  }
  return result;
}

VkResult api::FreeDescriptorSets(VkDevice, VkDescriptorPool pool, uint32_t count, const VkDescriptorSet* sets) {
  for (uint32_t i = 0; i < count; ++i) from(pool)->release(from(sets[i]));
  return VK_SUCCESS;
}

}  // namespace pineda::icd
