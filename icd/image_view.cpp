#include "icd/image_view.h"

#include <algorithm>

#include "icd/api.h"
#include "icd/device.h"

namespace pineda::icd {
namespace {

bool is_two_dimensional(VkImageViewType type) {
  return type == VK_IMAGE_VIEW_TYPE_2D || type == VK_IMAGE_VIEW_TYPE_2D_ARRAY || type == VK_IMAGE_VIEW_TYPE_1D ||
         type == VK_IMAGE_VIEW_TYPE_1D_ARRAY;
}

// "Image Views": which view types an image type has. A volume has two-dimensional views of its slices.
bool type_fits(const Image& image, VkImageViewType type) {
  switch (type) {
    case VK_IMAGE_VIEW_TYPE_1D:
    case VK_IMAGE_VIEW_TYPE_1D_ARRAY:
      return image.type == VK_IMAGE_TYPE_1D;
    case VK_IMAGE_VIEW_TYPE_2D:
      if (image.type == VK_IMAGE_TYPE_3D && (image.flags & VK_IMAGE_CREATE_2D_VIEW_COMPATIBLE_BIT_EXT)) return true;
      [[fallthrough]];
    case VK_IMAGE_VIEW_TYPE_2D_ARRAY:
      return image.type == VK_IMAGE_TYPE_2D ||
             (image.type == VK_IMAGE_TYPE_3D && (image.flags & VK_IMAGE_CREATE_2D_ARRAY_COMPATIBLE_BIT));
    case VK_IMAGE_VIEW_TYPE_3D:
      return image.type == VK_IMAGE_TYPE_3D;
    case VK_IMAGE_VIEW_TYPE_CUBE:
    case VK_IMAGE_VIEW_TYPE_CUBE_ARRAY:
      return (image.flags & VK_IMAGE_CREATE_CUBE_COMPATIBLE_BIT) != 0;
    default:
      return false;
  }
}

bool is_block_texel_view(const Image& image, const FormatInfo& view) {
  return image.format.is_compressed() && !view.is_compressed();
}

// Layers of the view: array layers, or slices of a volume that is seen as layers.
uint32_t view_layers(const Image& image, const VkImageViewCreateInfo& info) {
  const VkImageSubresourceRange& range = info.subresourceRange;
  if (image.type != VK_IMAGE_TYPE_3D || !is_two_dimensional(info.viewType)) return image.layers_of(range);
  const uint32_t slices = image.layout().level[range.baseMipLevel].extent.depth;
  return range.layerCount == VK_REMAINING_ARRAY_LAYERS ? slices - std::min(range.baseArrayLayer, slices) : range.layerCount;
}

bool range_fits(const Image& image, const VkImageViewCreateInfo& info) {
  const VkImageSubresourceRange& range = info.subresourceRange;
  if (range.baseMipLevel >= image.level_count) return false;
  const uint32_t levels = image.levels_of(range);
  if (levels == 0 || levels > image.level_count - range.baseMipLevel) return false;
  const bool slices = image.type == VK_IMAGE_TYPE_3D && is_two_dimensional(info.viewType);
  if (slices && levels != 1) return false;  // VUID-VkImageViewCreateInfo-image-04970
  const uint32_t limit = slices ? image.layout().level[range.baseMipLevel].extent.depth : image.layer_count;
  const uint32_t layers = view_layers(image, info);
  return range.baseArrayLayer < limit && layers >= 1 && layers <= limit - range.baseArrayLayer;
}

compiler::TextureState view_half(const VkImageViewCreateInfo& info, VkFormat format, uint32_t level_count) {
  compiler::TextureState state;
  state.format = format;
  state.view_type = info.viewType;
  state.single_level = level_count == 1;
  state.swizzle = {swizzle_source(info.components.r, 0), swizzle_source(info.components.g, 1),
                   swizzle_source(info.components.b, 2), swizzle_source(info.components.a, 3)};
  return state;
}

// The aspect that a descriptor shows: depth when the view has depth and stencil (it is an attachment then).
VkImageAspectFlags shown_aspect(VkImageAspectFlags aspects) { return aspects & ~(aspects - 1); }
static_assert(VK_IMAGE_ASPECT_COLOR_BIT < VK_IMAGE_ASPECT_DEPTH_BIT && VK_IMAGE_ASPECT_DEPTH_BIT < VK_IMAGE_ASPECT_STENCIL_BIT);

}  // namespace

uint8_t swizzle_source(VkComponentSwizzle component, uint8_t identity) {
  constexpr uint8_t kZero = 4, kOne = 5;  // compiler::TextureState::swizzle
  switch (component) {
    case VK_COMPONENT_SWIZZLE_ZERO:
      return kZero;
    case VK_COMPONENT_SWIZZLE_ONE:
      return kOne;
    case VK_COMPONENT_SWIZZLE_R:
      return 0;
    case VK_COMPONENT_SWIZZLE_G:
      return 1;
    case VK_COMPONENT_SWIZZLE_B:
      return 2;
    case VK_COMPONENT_SWIZZLE_A:
      return 3;
    default:
      return identity;
  }
}

VkResult ImageView::check(Device&, const VkImageViewCreateInfo& info) {
  const FormatInfo* format = find_format(info.format);
  const Image& image = *from(info.image);
  if (!format) return not_supported("vkCreateImageView: the format is not supported");
  const VkFormat plane_format = aspect_format(image.format.format, shown_aspect(info.subresourceRange.aspectMask));
  if (plane_format == VK_FORMAT_UNDEFINED) return not_supported("vkCreateImageView: the image lacks the aspect");
  // "Compatible formats": equal sizes of texels or blocks; depth, stencil and planes only as they are.
  const bool same = info.format == image.format.format || info.format == plane_format;
  const bool compatible = format->is_plain() || format->is_compressed()
                              ? format->texel_bytes == texel_bytes(plane_format) && !format->is_depth_or_stencil()
                              : false;
  if (!same && !compatible) return not_supported("vkCreateImageView: the format is not compatible with the image's");
  if (format->is_compressed() && !image.decoded_plane(info.format)) {
    return not_supported("vkCreateImageView: the image has no decoded copy for this format: not sampled, or not of its class");
  }
  if (!type_fits(image, info.viewType)) {
    return not_supported("vkCreateImageView: this type of view does not exist for images of this type and these flags");
  }
  if (!range_fits(image, info)) return not_supported("vkCreateImageView: levels or layers are not inside the image");
  if (is_block_texel_view(image, *format) && image.levels_of(info.subresourceRange) != 1) {
    return not_supported("vkCreateImageView: an uncompressed view of a compressed image has one level");
  }
  if (!image.data()) return not_supported("vkCreateImageView: the image has no memory bound");
  return VK_SUCCESS;
}

ImageView::ImageView(const Allocator& from_allocator, Device& device, const VkImageViewCreateInfo& info)
    : Object(from_allocator),
      image_(*from(info.image)),
      format_(info.format),
      aspects_(info.subresourceRange.aspectMask),
      base_level_(info.subresourceRange.baseMipLevel),
      base_layer_(info.subresourceRange.baseArrayLayer),
      layer_count_(view_layers(image_, info)),
      layers_are_slices_(image_.type == VK_IMAGE_TYPE_3D && is_two_dimensional(info.viewType)) {
  const uint32_t level_count = image_.levels_of(info.subresourceRange);
  const ImagePlane& plane = shown_plane(info);
  const LevelLayout& first = plane.layout.level[base_level_];
  const uint8_t* start = layers_are_slices_ ? image_.subresource(plane, base_level_, 0, base_layer_)
                                            : image_.subresource(plane, base_level_, base_layer_);
  const uint64_t start_bytes = static_cast<uint64_t>(start - image_.data()) - plane.offset_bytes;
  descriptor_.address = reinterpret_cast<uint64_t>(start);
  descriptor_.size_bytes = static_cast<uint32_t>(plane.layout.size_bytes - start_bytes);
  descriptor_.width = first.extent.width;
  descriptor_.height = first.extent.height;
  descriptor_.depth = layers_are_slices_ ? 1 : std::max(first.extent.depth, image_.sample_count);
  if (is_block_texel_view(image_, *find_format(info.format))) {
    descriptor_.width = first.columns;
    descriptor_.height = first.rows;
  }
  descriptor_.level_count = level_count;
  descriptor_.layer_count = layer_count_;
  descriptor_.layer_pitch_bytes = layers_are_slices_ ? first.slice_pitch_bytes : plane.layout.layer_pitch_bytes;
  for (uint32_t i = 0; i < level_count; ++i) {
    const LevelLayout& level = plane.layout.level[base_level_ + i];
    descriptor_.levels[i] = {level.offset_bytes - first.offset_bytes, level.row_pitch_bytes};
  }
  const FormatInfo& view_format = *find_format(info.format);
  if (view_format.plane_count() > 1 && !view_format.is_depth_or_stencil()) show_planes(start);
  // A decoded copy may be shared by two formats: the view's own says how to read it.
  const VkFormat shown = view_format.is_plain()        ? info.format
                         : view_format.is_compressed() ? view_format.decoded
                                                       : plane.format->format;
  descriptor_.format = static_cast<uint32_t>(shown);
  descriptor_.state_id = device.texture_states.intern_view(view_half(info, shown, level_count));
}

// The further planes of a view that is sampled through a YCbCr conversion: levels[p] is plane p
// (compiler/kernels/sample_ycbcr.h).
void ImageView::show_planes(const uint8_t* start) {
  for (uint32_t p = 1; p < image_.format.plane_count(); ++p) {
    const ImagePlane& plane = image_.plane(p);
    const uint8_t* at = image_.subresource(plane, base_level_, base_layer_);
    const LevelLayout& level = plane.layout.level[base_level_];
    descriptor_.levels[p] = {static_cast<uint32_t>(at - start), level.row_pitch_bytes};
    descriptor_.size_bytes = static_cast<uint32_t>(at - start) + level.slice_pitch_bytes;
  }
}

const ImagePlane& ImageView::shown_plane(const VkImageViewCreateInfo& info) const {
  if (find_format(info.format)->is_compressed()) return *image_.decoded_plane(info.format);
  return image_.plane(plane_of(image_.format, shown_aspect(aspects_)));
}

raster::Attachment ImageView::plane_attachment(const ImagePlane& plane, VkFormat format, uint32_t layer) const {
  raster::Attachment attachment;
  const uint32_t index = base_layer_ + layer;
  attachment.address =
      layers_are_slices_ ? image_.subresource(plane, base_level_, 0, index) : image_.subresource(plane, base_level_, index);
  attachment.row_pitch_bytes = plane.layout.level[base_level_].row_pitch_bytes;
  attachment.format = format;
  attachment.samples = image_.sample_count;
  attachment.sample_pitch_bytes = plane.layout.level[base_level_].slice_pitch_bytes;
  attachment.layer_pitch_bytes =
      layers_are_slices_ ? plane.layout.level[base_level_].slice_pitch_bytes : plane.layout.layer_pitch_bytes;
  return attachment;
}

raster::Attachment ImageView::attachment(uint32_t layer) const {
  const VkImageAspectFlags aspect = shown_aspect(aspects_);
  if (aspect == VK_IMAGE_ASPECT_STENCIL_BIT) return {};
  const ImagePlane& plane = image_.plane(plane_of(image_.format, aspect));
  return plane_attachment(plane, find_format(format_)->is_plain() ? format_ : plane.format->format, layer);
}

raster::Attachment ImageView::stencil_attachment(uint32_t layer) const {
  if (!image_.format.has_stencil() || !(aspects_ & VK_IMAGE_ASPECT_STENCIL_BIT)) return {};
  const ImagePlane& plane = image_.plane(plane_of(image_.format, VK_IMAGE_ASPECT_STENCIL_BIT));
  return plane_attachment(plane, plane.format->format, layer);
}

VkResult api::CreateImageView(VkDevice device, const VkImageViewCreateInfo* info, const VkAllocationCallbacks* callbacks,
                              VkImageView* out) {
  return create_device_object<ImageView>(device, info, callbacks, out);
}

void api::DestroyImageView(VkDevice device, VkImageView view, const VkAllocationCallbacks* callbacks) {
  destroy_device_object(device, view, callbacks);
}

}  // namespace pineda::icd
