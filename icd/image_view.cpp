#include "icd/image_view.h"

#include "icd/api.h"
#include "icd/device.h"

namespace pineda::icd {
namespace {

uint8_t swizzle(VkComponentSwizzle component, uint8_t identity) {
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

compiler::TextureState view_half(const VkImageViewCreateInfo& info, uint32_t level_count) {
  compiler::TextureState state;
  state.format = info.format;
  state.view_type = info.viewType;
  state.single_level = level_count == 1;
  state.swizzle = {swizzle(info.components.r, 0), swizzle(info.components.g, 1), swizzle(info.components.b, 2),
                   swizzle(info.components.a, 3)};
  return state;
}

}  // namespace

VkResult ImageView::check(Device&, const VkImageViewCreateInfo& info) {
  const FormatInfo* format = find_format(info.format);
  if (!format || format->texel_bytes != from(info.image)->format.texel_bytes) {
    return not_supported("vkCreateImageView: the format is not supported or not compatible with the image's");
  }
  switch (info.viewType) {
    case VK_IMAGE_VIEW_TYPE_1D:
    case VK_IMAGE_VIEW_TYPE_2D:
    case VK_IMAGE_VIEW_TYPE_1D_ARRAY:
    case VK_IMAGE_VIEW_TYPE_2D_ARRAY:
      break;
    default:
      return not_supported("vkCreateImageView: cube and 3D views are not supported");
  }
  if (!from(info.image)->data()) return not_supported("vkCreateImageView: the image has no memory bound");
  return VK_SUCCESS;
}

ImageView::ImageView(const Allocator& from_allocator, Device& device, const VkImageViewCreateInfo& info)
    : Object(from_allocator),
      image_(*from(info.image)),
      format_(info.format),
      base_level_(info.subresourceRange.baseMipLevel),
      base_layer_(info.subresourceRange.baseArrayLayer),
      layer_count_(image_.layers_of(info.subresourceRange)) {
  const uint32_t level_count = image_.levels_of(info.subresourceRange);
  const LevelLayout& first = image_.layout.level[base_level_];
  const uint64_t start_bytes = uint64_t(base_layer_) * image_.layout.layer_pitch_bytes + first.offset_bytes;
  descriptor_.address = reinterpret_cast<uint64_t>(image_.data()) + start_bytes;
  descriptor_.size_bytes = static_cast<uint32_t>(image_.layout.size_bytes - start_bytes);
  descriptor_.width = first.extent.width;
  descriptor_.height = first.extent.height;
  descriptor_.depth = first.extent.depth;
  descriptor_.level_count = level_count;
  descriptor_.layer_count = layer_count_;
  descriptor_.layer_pitch_bytes = image_.layout.layer_pitch_bytes;
  for (uint32_t i = 0; i < level_count; ++i) {
    const LevelLayout& level = image_.layout.level[base_level_ + i];
    descriptor_.levels[i] = {level.offset_bytes - first.offset_bytes, level.row_pitch_bytes};
  }
  state_id_ = device.texture_states.intern_view(view_half(info, level_count));
}

raster::Attachment ImageView::attachment(uint32_t layer) const {
  raster::Attachment attachment;
  attachment.address = image_.subresource(base_level_, base_layer_ + layer);
  attachment.row_pitch_bytes = image_.layout.level[base_level_].row_pitch_bytes;
  attachment.format = format_;
  return attachment;
}

VkResult api::CreateImageView(VkDevice device, const VkImageViewCreateInfo* info, const VkAllocationCallbacks* callbacks,
                              VkImageView* out) {
  return create_device_object<ImageView>(device, info, callbacks, out);
}

void api::DestroyImageView(VkDevice device, VkImageView view, const VkAllocationCallbacks* callbacks) {
  destroy_device_object(device, view, callbacks);
}

}  // namespace pineda::icd
