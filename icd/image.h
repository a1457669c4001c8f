// VkImage: a layout over a range of device memory.
#pragma once

#include "base/format.h"
#include "icd/image_layout.h"
#include "icd/object.h"

namespace pineda::icd {

class Image : public Object {
 public:
  static VkResult check(Device& device, const VkImageCreateInfo& info);
  Image(const Allocator& from, Device&, const VkImageCreateInfo& info);

  void bind(uint8_t* address) { address_ = address; }
  uint8_t* data() const { return address_; }  // null until memory is bound

  // First texel of a level and layer, or of slice z of a volume's level.
  uint8_t* subresource(uint32_t level, uint32_t layer, uint32_t z = 0) const {
    return address_ + uint64_t(layer) * layout.layer_pitch_bytes + layout.level[level].offset_bytes +
           uint64_t(z) * layout.level[level].slice_pitch_bytes;
  }

  const VkImageType type;
  const FormatInfo& format;
  const uint32_t level_count, layer_count;
  const ImageLayout layout;

  // VK_REMAINING_* resolved.
  uint32_t levels_of(const VkImageSubresourceRange& range) const {
    return range.levelCount == VK_REMAINING_MIP_LEVELS ? level_count - range.baseMipLevel : range.levelCount;
  }
  uint32_t layers_of(const VkImageSubresourceRange& range) const {
    return range.layerCount == VK_REMAINING_ARRAY_LAYERS ? layer_count - range.baseArrayLayer : range.layerCount;
  }

 private:
  uint8_t* address_ = nullptr;
};

}  // namespace pineda::icd
