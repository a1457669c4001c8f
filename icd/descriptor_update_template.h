// VkDescriptorUpdateTemplate: where in an application's memory the descriptors of a set are.
#pragma once

#include "icd/object.h"

namespace pineda::icd {

class DescriptorUpdateTemplate : public Object {
 public:
  static VkResult check(Device& device, const VkDescriptorUpdateTemplateCreateInfo& info);
  DescriptorUpdateTemplate(const Allocator& from, Device&, const VkDescriptorUpdateTemplateCreateInfo& info)
      : Object(from),
        entries_(info.pDescriptorUpdateEntries, info.pDescriptorUpdateEntries + info.descriptorUpdateEntryCount,
                 HostAllocator<VkDescriptorUpdateTemplateEntry>(&allocator)) {}

  void update(DescriptorSet& set, const void* data) const;

 private:
  HostVector<VkDescriptorUpdateTemplateEntry> entries_;
};

}  // namespace pineda::icd
