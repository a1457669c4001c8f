#include "icd/descriptor_set_layout.h"

#include <algorithm>
#include <optional>

#include "icd/api.h"
#include "icd/chain.h"
#include "icd/descriptor_set.h"
#include "icd/device.h"
#include "icd/sampler.h"

namespace pineda::icd {

bool is_dynamic(VkDescriptorType type) {
  return type == VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER_DYNAMIC || type == VK_DESCRIPTOR_TYPE_STORAGE_BUFFER_DYNAMIC;
}

bool has_sampler(VkDescriptorType type) {
  return type == VK_DESCRIPTOR_TYPE_SAMPLER || type == VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
}

bool is_texel_buffer(VkDescriptorType type) {
  return type == VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER || type == VK_DESCRIPTOR_TYPE_STORAGE_TEXEL_BUFFER;
}

bool has_image(VkDescriptorType type) {
  return type == VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER || type == VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE ||
         type == VK_DESCRIPTOR_TYPE_STORAGE_IMAGE || type == VK_DESCRIPTOR_TYPE_INPUT_ATTACHMENT;
}

bool has_texture_ids(VkDescriptorType type) { return has_sampler(type) || has_image(type) || is_texel_buffer(type); }

uint32_t descriptor_bytes(VkDescriptorType type) {
  switch (type) {
    case VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER:
    case VK_DESCRIPTOR_TYPE_STORAGE_BUFFER:
    case VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER_DYNAMIC:
    case VK_DESCRIPTOR_TYPE_STORAGE_BUFFER_DYNAMIC:
      return sizeof(BufferDescriptor);
    case VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER:
    case VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE:
    case VK_DESCRIPTOR_TYPE_STORAGE_IMAGE:
    case VK_DESCRIPTOR_TYPE_INPUT_ATTACHMENT:
    case VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER:
    case VK_DESCRIPTOR_TYPE_STORAGE_TEXEL_BUFFER:
      return sizeof(ImageDescriptor);
    case VK_DESCRIPTOR_TYPE_SAMPLER:
      return sizeof(SamplerDescriptor);
    default:
      return 0;
  }
}

namespace {

// What is wrong with a set layout; empty when it can be made.
std::string unsupported(const VkDescriptorSetLayoutCreateInfo& info) {
  // Sets are read when commands are executed: whatever VkDescriptorSetLayoutBindingFlagsCreateInfo allows is how every binding
  // works.
  constexpr VkDescriptorSetLayoutCreateFlags kFlags = VK_DESCRIPTOR_SET_LAYOUT_CREATE_UPDATE_AFTER_BIND_POOL_BIT;
  if (info.flags & ~kFlags) return "flags of extensions are not supported";
  uint64_t size_bytes = 0;
  for (uint32_t i = 0; i < info.bindingCount; ++i) {
    const VkDescriptorSetLayoutBinding& binding = info.pBindings[i];
    if (binding.descriptorCount == 0) continue;
    const uint32_t bytes = descriptor_bytes(binding.descriptorType);
    if (bytes == 0) {
      return "descriptor type " + std::to_string(binding.descriptorType) + " of binding " + std::to_string(binding.binding) +
             " is not supported";
    }
    size_bytes += uint64_t(bytes) * binding.descriptorCount;
  }
  return size_bytes <= kMaxSetBytes ? "" : "too many descriptors";
}

// The number of the binding whose count each set chooses: the highest one
// (VUID-VkDescriptorSetLayoutBindingFlagsCreateInfo-pBindingFlags-03004).
std::optional<uint32_t> variable_binding(const VkDescriptorSetLayoutCreateInfo& info) {
  const auto* flags = find_in_chain<VkDescriptorSetLayoutBindingFlagsCreateInfo>(
      info.pNext, VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_BINDING_FLAGS_CREATE_INFO);
  for (uint32_t i = 0; flags && i < std::min(flags->bindingCount, info.bindingCount); ++i) {
    if (flags->pBindingFlags[i] & VK_DESCRIPTOR_BINDING_VARIABLE_DESCRIPTOR_COUNT_BIT) return info.pBindings[i].binding;
  }
  return std::nullopt;
}

// As many as fit beside the other bindings; 0 without such a binding.
uint32_t max_variable_count(const VkDescriptorSetLayoutCreateInfo& info) {
  const std::optional<uint32_t> variable = variable_binding(info);
  uint64_t others_bytes = 0;
  uint32_t stride_bytes = 0;
  for (uint32_t i = 0; variable && i < info.bindingCount; ++i) {
    const VkDescriptorSetLayoutBinding& binding = info.pBindings[i];
    const uint32_t bytes = descriptor_bytes(binding.descriptorType);
    if (binding.binding == *variable) {
      stride_bytes = bytes;
    } else {
      others_bytes += uint64_t(bytes) * binding.descriptorCount;
    }
  }
  if (stride_bytes == 0 || others_bytes > kMaxSetBytes) return 0;
  return static_cast<uint32_t>((kMaxSetBytes - others_bytes) / stride_bytes);
}

}  // namespace

VkResult DescriptorSetLayout::check(Device&, const VkDescriptorSetLayoutCreateInfo& info) {
  const std::string reason = unsupported(info);
  return reason.empty() ? VK_SUCCESS : not_supported("vkCreateDescriptorSetLayout: " + reason);
}

DescriptorSetLayout::DescriptorSetLayout(const Allocator& from_allocator, Device&, const VkDescriptorSetLayoutCreateInfo& info)
    : Object(from_allocator),
      bindings_(HostAllocator<BindingLayout>(&allocator)),
      immutable_samplers_(HostAllocator<ImmutableSampler>(&allocator)) {
  HostVector<VkDescriptorSetLayoutBinding> sorted(
      info.pBindings, info.pBindings + info.bindingCount,
      HostAllocator<VkDescriptorSetLayoutBinding>(&allocator, VK_SYSTEM_ALLOCATION_SCOPE_COMMAND));
  std::ranges::sort(sorted, {}, &VkDescriptorSetLayoutBinding::binding);
  bindings_.reserve(sorted.size());
  for (const VkDescriptorSetLayoutBinding& source : sorted) {
    if (source.descriptorCount == 0) continue;
    BindingLayout binding{.binding = source.binding,
                          .type = source.descriptorType,
                          .count = source.descriptorCount,
                          .offset_bytes = size_bytes_,
                          .stride_bytes = descriptor_bytes(source.descriptorType)};
    size_bytes_ += binding.count * binding.stride_bytes;
    if (has_texture_ids(binding.type)) {
      binding.texture_index = texture_count_;
      texture_count_ += binding.count;
    }
    if (is_dynamic(binding.type)) {
      binding.dynamic_index = dynamic_count_;
      dynamic_count_ += binding.count;
    }
    if (has_sampler(binding.type) && source.pImmutableSamplers) {
      binding.immutable_index = static_cast<uint32_t>(immutable_samplers_.size());
      for (uint32_t i = 0; i < binding.count; ++i) {
        const Sampler& sampler = *from(source.pImmutableSamplers[i]);
        immutable_samplers_.push_back({sampler.descriptor(), sampler.state_id()});
      }
    }
    bindings_.push_back(binding);
  }
  has_variable_count_ = !bindings_.empty() && variable_binding(info) == bindings_.back().binding;
}

const BindingLayout* DescriptorSetLayout::find(uint32_t binding) const {
  const auto found = std::ranges::lower_bound(bindings_, binding, {}, &BindingLayout::binding);
  return found == bindings_.end() ? nullptr : &*found;
}

VkResult api::CreateDescriptorSetLayout(VkDevice device, const VkDescriptorSetLayoutCreateInfo* info,
                                        const VkAllocationCallbacks* callbacks, VkDescriptorSetLayout* out) {
  return create_device_object<DescriptorSetLayout>(device, info, callbacks, out);
}

void api::DestroyDescriptorSetLayout(VkDevice device, VkDescriptorSetLayout layout, const VkAllocationCallbacks* callbacks) {
  destroy_device_object(device, layout, callbacks);
}

void api::GetDescriptorSetLayoutSupport(VkDevice, const VkDescriptorSetLayoutCreateInfo* info,
                                        VkDescriptorSetLayoutSupport* out) {
  out->supported = VK_FALSE;
  (void)guarded([&] {
    out->supported = unsupported(*info).empty();
    auto* variable = find_in_chain<VkDescriptorSetVariableDescriptorCountLayoutSupport>(
        out->pNext, VK_STRUCTURE_TYPE_DESCRIPTOR_SET_VARIABLE_DESCRIPTOR_COUNT_LAYOUT_SUPPORT);
    if (variable) variable->maxVariableDescriptorCount = max_variable_count(*info);
    return VK_SUCCESS;
  });
}

}  // namespace pineda::icd
