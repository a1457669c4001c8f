#include "icd/descriptor_set.h"

#include <cstring>

#include "icd/api.h"
#include "icd/buffer.h"
#include "icd/buffer_view.h"
#include "icd/device.h"
#include "icd/image_view.h"
#include "icd/sampler.h"

namespace pineda::icd {
namespace {

// A combined descriptor is an image descriptor whose tail is the sampler.
constexpr size_t kSamplerOffset = offsetof(ImageDescriptor, lod_bias);
static_assert(kSamplerOffset + sizeof(SamplerDescriptor) == sizeof(ImageDescriptor));

size_t sampler_offset(VkDescriptorType type) { return type == VK_DESCRIPTOR_TYPE_SAMPLER ? 0 : kSamplerOffset; }

// Walks consecutive descriptors: past the end of a binding the update goes on in the next one ("consecutive binding updates").
struct Cursor {
  const DescriptorSetLayout& layout;
  const BindingLayout* binding;
  uint32_t element;

  Cursor(const DescriptorSetLayout& set_layout, uint32_t first_binding, uint32_t first_element)
      : layout(set_layout), binding(set_layout.find(first_binding)), element(first_element) {
    settle();
  }
  void step() {
    ++element;
    settle();
  }
  void settle() {
    while (binding && element >= binding->count) {
      element -= binding->count;
      binding = binding + 1 < layout.bindings().data() + layout.bindings().size() ? binding + 1 : nullptr;
    }
  }
};

}  // namespace

DescriptorSet::DescriptorSet(const Allocator& from, const DescriptorSetLayout& layout, const DescriptorCounts& counts)
    : Object(from),
      layout_(layout),
      memory_(reinterpret_cast<uint8_t*>(this) + (sizeof(DescriptorSet) + kAlignment - 1) / kAlignment * kAlignment),
      textures_(reinterpret_cast<TextureIds*>(memory_ + layout.size_bytes())),
      counts_(counts) {
  std::memset(memory_, 0, layout.size_bytes());
  std::uninitialized_fill_n(textures_, layout.texture_count(), TextureIds{});
  for (const BindingLayout& binding : layout.bindings()) {
    if (binding.immutable_index == BindingLayout::kNone) continue;
    for (uint32_t i = 0; i < binding.count; ++i) {
      const ImmutableSampler& sampler = layout.immutable_samplers()[binding.immutable_index + i];
      uint8_t* out = memory_ + binding.offset_bytes + i * binding.stride_bytes + sampler_offset(binding.type);
      std::memcpy(out, &sampler.descriptor, sizeof(SamplerDescriptor));
      textures_[binding.texture_index + i].sampler = sampler.state_id;
    }
  }
}

Owned<DescriptorSet> DescriptorSet::make(const Allocator& allocator, const DescriptorSetLayout& layout,
                                         const DescriptorCounts& counts) {
  static_assert(alignof(TextureIds) <= sizeof(BufferDescriptor), "descriptors keep the ids aligned");
  const size_t object_bytes = (sizeof(DescriptorSet) + kAlignment - 1) / kAlignment * kAlignment;
  const size_t bytes = object_bytes + layout.size_bytes() + layout.texture_count() * sizeof(TextureIds);
  void* memory = allocator.allocate(bytes, kAlignment, VK_SYSTEM_ALLOCATION_SCOPE_OBJECT);
  if (!memory) throw std::bad_alloc();
  return Owned<DescriptorSet>(new (memory) DescriptorSet(allocator, layout, counts));
}

void DescriptorSet::write_one(const BindingLayout& binding, uint32_t element, const VkWriteDescriptorSet& write,
                              uint32_t source) {
  uint8_t* out = memory_ + binding.offset_bytes + element * binding.stride_bytes;
  if (!has_texture_ids(binding.type)) {
    const VkDescriptorBufferInfo& info = write.pBufferInfo[source];
    const BufferDescriptor descriptor = info.buffer ? from(info.buffer)->descriptor(info.offset, info.range) : BufferDescriptor{};
    std::memcpy(out, &descriptor, sizeof(descriptor));
    return;
  }
  if (is_texel_buffer(binding.type)) {
    const BufferView* view = from(write.pTexelBufferView[source]);
    const ImageDescriptor descriptor = view ? view->descriptor() : ImageDescriptor{};
    std::memcpy(out, &descriptor, sizeof(descriptor));
    textures_[binding.texture_index + element] = {.view = descriptor.state_id, .sampler = 0};
    return;
  }
  const VkDescriptorImageInfo& info = write.pImageInfo[source];
  TextureIds& ids = textures_[binding.texture_index + element];
  if (has_image(binding.type)) {
    const ImageView* view = from(info.imageView);
    const ImageDescriptor descriptor = view ? view->descriptor() : ImageDescriptor{};
    std::memcpy(out, &descriptor, kSamplerOffset);
    ids.view = view ? view->state_id() : 0;
  }
  if (has_sampler(binding.type) && binding.immutable_index == BindingLayout::kNone) {
    const Sampler* sampler = from(info.sampler);
    const SamplerDescriptor descriptor = sampler ? sampler->descriptor() : SamplerDescriptor{};
    std::memcpy(out + sampler_offset(binding.type), &descriptor, sizeof(descriptor));
    ids.sampler = sampler ? sampler->state_id() : 0;
  }
}

void DescriptorSet::write(const VkWriteDescriptorSet& write) {
  Cursor to(layout_, write.dstBinding, write.dstArrayElement);
  for (uint32_t i = 0; i < write.descriptorCount && to.binding; ++i, to.step()) {
    if (to.binding->type != write.descriptorType) return;  // invalid usage: another array of infos would be read
    write_one(*to.binding, to.element, write, i);
  }
}

void DescriptorSet::copy(const VkCopyDescriptorSet& copy) {
  const DescriptorSet& source = *from(copy.srcSet);
  Cursor read(source.layout_, copy.srcBinding, copy.srcArrayElement);
  Cursor to(layout_, copy.dstBinding, copy.dstArrayElement);
  for (uint32_t i = 0; i < copy.descriptorCount && read.binding && to.binding; ++i, read.step(), to.step()) {
    if (read.binding->type != to.binding->type) return;  // invalid usage
    const bool keeps_sampler = to.binding->immutable_index != BindingLayout::kNone;
    const size_t bytes = keeps_sampler ? sampler_offset(to.binding->type) : to.binding->stride_bytes;
    std::memmove(memory_ + to.binding->offset_bytes + to.element * to.binding->stride_bytes,
                 source.memory_ + read.binding->offset_bytes + read.element * read.binding->stride_bytes, bytes);
    if (!has_texture_ids(to.binding->type)) continue;
    const TextureIds ids = source.textures_[read.binding->texture_index + read.element];
    TextureIds& out = textures_[to.binding->texture_index + to.element];
    out = {ids.view, keeps_sampler ? out.sampler : ids.sampler};
  }
}

void api::UpdateDescriptorSets(VkDevice, uint32_t write_count, const VkWriteDescriptorSet* writes, uint32_t copy_count,
                               const VkCopyDescriptorSet* copies) {
  for (uint32_t i = 0; i < write_count; ++i) from(writes[i].dstSet)->write(writes[i]);
  for (uint32_t i = 0; i < copy_count; ++i) from(copies[i].dstSet)->copy(copies[i]);
}

}  // namespace pineda::icd
