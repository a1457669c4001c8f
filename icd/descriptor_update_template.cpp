#include "icd/descriptor_update_template.h"

#include "icd/api.h"
#include "icd/descriptor_set.h"
#include "icd/device.h"

namespace pineda::icd {

VkResult DescriptorUpdateTemplate::check(Device&, const VkDescriptorUpdateTemplateCreateInfo& info) {
  if (info.templateType == VK_DESCRIPTOR_UPDATE_TEMPLATE_TYPE_DESCRIPTOR_SET) return VK_SUCCESS;
  return not_supported("vkCreateDescriptorUpdateTemplate: push descriptors are not supported");
}

// One descriptor at a time: an entry's stride is the application's, an array of a VkWriteDescriptorSet is dense. The element may
// lie past the end of the binding; write() goes on in the next one, as for any write.
void DescriptorUpdateTemplate::update(DescriptorSet& set, const void* data) const {
  for (const VkDescriptorUpdateTemplateEntry& entry : entries_) {
    for (uint32_t i = 0; i < entry.descriptorCount; ++i) {
      const uint8_t* info = static_cast<const uint8_t*>(data) + entry.offset + i * entry.stride;
      const VkWriteDescriptorSet write{.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                       .dstBinding = entry.dstBinding,
                                       .dstArrayElement = entry.dstArrayElement + i,
                                       .descriptorCount = 1,
                                       .descriptorType = entry.descriptorType,
                                       .pImageInfo = reinterpret_cast<const VkDescriptorImageInfo*>(info),
                                       .pBufferInfo = reinterpret_cast<const VkDescriptorBufferInfo*>(info),
                                       .pTexelBufferView = reinterpret_cast<const VkBufferView*>(info)};
      set.write(write);
    }
  }
}

VkResult api::CreateDescriptorUpdateTemplate(VkDevice device, const VkDescriptorUpdateTemplateCreateInfo* info,
                                             const VkAllocationCallbacks* callbacks, VkDescriptorUpdateTemplate* out) {
  return create_device_object<DescriptorUpdateTemplate>(device, info, callbacks, out);
}

void api::DestroyDescriptorUpdateTemplate(VkDevice device, VkDescriptorUpdateTemplate update_template,
                                          const VkAllocationCallbacks* callbacks) {
  destroy_device_object(device, update_template, callbacks);
}

void api::UpdateDescriptorSetWithTemplate(VkDevice, VkDescriptorSet set, VkDescriptorUpdateTemplate update_template,
                                          const void* data) {
  from(update_template)->update(*from(set), data);
}

}  // namespace pineda::icd
