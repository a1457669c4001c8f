// VkImage: layouts over a range of device memory, one for each plane.
//
// Most formats have one plane. Depth and stencil of a format with both, and the planes of a YCbCr format, are kept apart. A
// block-compressed image that shaders or blits may read has a decoded copy behind its blocks, in the same memory: every command
// that writes blocks decodes them (icd/decode.h), and nothing else can write an image of optimal tiling. So views, descriptors
// and kernels know plain formats only.
#pragma once

#include <optional>

#include "base/format.h"
#include "icd/image_layout.h"
#include "icd/object.h"

namespace pineda::icd {

struct ImagePlane {
  const FormatInfo* format = nullptr;  // null: the image has no such plane
  ImageLayout layout;
  VkDeviceSize offset_bytes = 0;           // in the image's memory
  VkFormat decodes = VK_FORMAT_UNDEFINED;  // decoded copies: the format that plane 0's blocks are taken for
};

class Image : public Object {
 public:
  static VkResult check(Device& device, const VkImageCreateInfo& info);
  Image(const Allocator& from, Device&, const VkImageCreateInfo& info);

  void bind(uint8_t* address) { address_ = address; }
  uint8_t* data() const { return address_; }  // null until memory is bound

  // Planes 0 to 2 are the format's own. Two more are decoded copies: for the image's format, and for the format that shares its
  // compatibility class when views may have it (VK_IMAGE_CREATE_MUTABLE_FORMAT_BIT) and it decodes to other bits.
  static constexpr uint32_t kFirstDecoded = 3, kPlanes = 5;
  const ImagePlane& plane(uint32_t index) const { return planes_[index]; }
  const ImageLayout& layout(uint32_t plane = 0) const { return planes_[plane].layout; }
  // The decoded copy for views of this format, or null.
  const ImagePlane* decoded_plane(VkFormat view_format) const;

  // First texel (or block) of a level and layer; of slice z of a volume's level, or sample z.
  uint8_t* subresource(const ImagePlane& plane, uint32_t level, uint32_t layer, uint32_t z = 0) const {
    return address_ + plane.offset_bytes + uint64_t(layer) * plane.layout.layer_pitch_bytes +
           plane.layout.level[level].offset_bytes + uint64_t(z) * plane.layout.level[level].slice_pitch_bytes;
  }

  const VkImageType type;
  const FormatInfo& format;
  const uint32_t level_count, layer_count, sample_count;
  const VkImageCreateFlags flags;
  const VkImageUsageFlags usage;
  VkDeviceSize size_bytes() const { return size_bytes_; }

  // VK_REMAINING_* resolved.
  uint32_t levels_of(const VkImageSubresourceRange& range) const {
    return range.levelCount == VK_REMAINING_MIP_LEVELS ? level_count - range.baseMipLevel : range.levelCount;
  }
  uint32_t layers_of(const VkImageSubresourceRange& range) const {
    return range.layerCount == VK_REMAINING_ARRAY_LAYERS ? layer_count - range.baseArrayLayer : range.layerCount;
  }

 private:
  std::array<ImagePlane, kPlanes> planes_;
  VkDeviceSize size_bytes_ = 0;
  uint8_t* address_ = nullptr;
};

}  // namespace pineda::icd
