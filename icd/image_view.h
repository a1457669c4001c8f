// VkImageView: the descriptor of a range of an image, ready to be copied into sets, and the attachments that a framebuffer makes
// of it. The image's memory is bound before a view is made (VUID-VkImageViewCreateInfo-image-01020), so addresses are final.
//
// A descriptor shows one plane: that of the view's aspect; for a block-compressed format, the decoded copy; for an uncompressed
// view of a compressed image (VK_IMAGE_CREATE_BLOCK_TEXEL_VIEW_COMPATIBLE_BIT), the blocks as texels.
#pragma once

#include "icd/image.h"
#include "raster/raster.h"

namespace pineda::icd {

// compiler::TextureState::swizzle of a component mapping.
uint8_t swizzle_source(VkComponentSwizzle component, uint8_t identity);

class ImageView : public Object {
 public:
  static VkResult check(Device& device, const VkImageViewCreateInfo& info);
  ImageView(const Allocator& from, Device& device, const VkImageViewCreateInfo& info);

  const ImageDescriptor& descriptor() const { return descriptor_; }  // sampler words are zero
  uint32_t state_id() const { return descriptor_.state_id; }         // TextureStates
  uint32_t layer_count() const { return layer_count_; }              // of a two-dimensional view of a volume: slices
  VkExtent2D extent() const { return {descriptor_.width, descriptor_.height}; }
  uint32_t sample_count() const { return image_.sample_count; }

  // Layer `layer` of the view as an attachment; load and store operations are the caller's. A view of a format with depth and
  // stencil gives depth as the first; an aspect that the view does not have gives a null address.
  raster::Attachment attachment(uint32_t layer) const;
  raster::Attachment stencil_attachment(uint32_t layer) const;

 private:
  raster::Attachment plane_attachment(const ImagePlane& plane, VkFormat format, uint32_t layer) const;
  const ImagePlane& shown_plane(const VkImageViewCreateInfo& info) const;
  void show_planes(const uint8_t* start);

  const Image& image_;
  const VkFormat format_;
  const VkImageAspectFlags aspects_;
  const uint32_t base_level_, base_layer_, layer_count_;
  const bool layers_are_slices_;  // a two-dimensional view of a volume
  ImageDescriptor descriptor_{};
};

}  // namespace pineda::icd
