// VkDescriptorSetLayout: where each binding's descriptors are in a set's memory (base/abi.h), and which numbers they have among
// the set's textures and dynamic offsets.
#pragma once

#include "base/abi.h"
#include "icd/object.h"

namespace pineda::icd {

struct ImmutableSampler {
  SamplerDescriptor descriptor;
  uint32_t state_id;
};

struct BindingLayout {
  uint32_t binding = 0;
  VkDescriptorType type = VK_DESCRIPTOR_TYPE_SAMPLER;
  uint32_t count = 0;
  uint32_t offset_bytes = 0, stride_bytes = 0;
  uint32_t texture_index = 0;        // of element 0 in DescriptorSet::textures, for images and samplers
  uint32_t dynamic_index = 0;        // of element 0 among the set's dynamic offsets
  uint32_t immutable_index = kNone;  // of element 0 in DescriptorSetLayout::immutable_samplers
  static constexpr uint32_t kNone = ~0u;
};

bool is_dynamic(VkDescriptorType type);
bool has_texture_ids(VkDescriptorType type);  // images, samplers and texel buffers
bool is_texel_buffer(VkDescriptorType type);
bool has_sampler(VkDescriptorType type);
bool has_image(VkDescriptorType type);
// 0 for a type that is not supported.
uint32_t descriptor_bytes(VkDescriptorType type);

class DescriptorSetLayout : public Object {
 public:
  static VkResult check(Device& device, const VkDescriptorSetLayoutCreateInfo& info);
  DescriptorSetLayout(const Allocator& from, Device&, const VkDescriptorSetLayoutCreateInfo& info);

  // In order of binding numbers.
  const HostVector<BindingLayout>& bindings() const { return bindings_; }
  const HostVector<ImmutableSampler>& immutable_samplers() const { return immutable_samplers_; }
  // First binding with a number >= `binding` that holds descriptors; null when there is none.
  const BindingLayout* find(uint32_t binding) const;

  uint32_t size_bytes() const { return size_bytes_; }
  uint32_t texture_count() const { return texture_count_; }
  uint32_t dynamic_count() const { return dynamic_count_; }
  // Whether vkAllocateDescriptorSets tells how many descriptors the last binding has. A set has room for all of them anyway, as a
  // shader's index is checked against the layout's count; only the pool counts what was asked for.
  bool has_variable_count() const { return has_variable_count_; }

 private:
  HostVector<BindingLayout> bindings_;
  HostVector<ImmutableSampler> immutable_samplers_;
  uint32_t size_bytes_ = 0, texture_count_ = 0, dynamic_count_ = 0;
  bool has_variable_count_ = false;
};

}  // namespace pineda::icd
