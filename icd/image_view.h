// VkImageView: the descriptor of a range of an image, ready to be copied into sets, and the attachment that a framebuffer makes
// of it. The image's memory is bound before a view is made (VUID-VkImageViewCreateInfo-image-01020), so addresses are final.
#pragma once

#include "icd/image.h"
#include "raster/raster.h"

namespace pineda::icd {

class ImageView : public Object {
 public:
  static VkResult check(Device& device, const VkImageViewCreateInfo& info);
  ImageView(const Allocator& from, Device& device, const VkImageViewCreateInfo& info);

  const ImageDescriptor& descriptor() const { return descriptor_; }  // sampler words are zero
  uint32_t state_id() const { return state_id_; }                    // TextureStates
  uint32_t layer_count() const { return layer_count_; }
  VkExtent2D extent() const { return {descriptor_.width, descriptor_.height}; }

  // Layer `layer` of the view as an attachment; load and store operations are the caller's.
  raster::Attachment attachment(uint32_t layer) const;

 private:
  const Image& image_;
  const VkFormat format_;
  const uint32_t base_level_, base_layer_, layer_count_;
  ImageDescriptor descriptor_{};
  uint32_t state_id_ = 0;
};

}  // namespace pineda::icd
