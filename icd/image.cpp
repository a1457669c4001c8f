#include "icd/image.h"

#include <algorithm>
#include <bit>

#include "icd/api.h"
#include "icd/chain.h"
#include "icd/device.h"
#include "icd/device_memory.h"
#include "icd/format_caps.h"

namespace pineda::icd {

namespace {

// Which planes an image has, and where; nothing when one does not fit 32-bit offsets.
struct Planes {
  std::array<ImagePlane, Image::kPlanes> plane;
  VkDeviceSize size_bytes = 0;
};

// The other format of the compatibility class: the two are neighbours in VkFormat, from BC1 on.
VkFormat sibling(const FormatInfo& format) {
  const bool second = (format.format - VK_FORMAT_BC1_RGB_UNORM_BLOCK) % 2 == 1;
  return static_cast<VkFormat>(format.format + (second ? -1 : 1));
}

// Whether the blocks of both decode to the same bits: RGBA codes, sRGB or not.
bool decodes_alike(const FormatInfo& a, const FormatInfo& b) {
  const auto is_rgba8 = [](VkFormat f) { return f == VK_FORMAT_R8G8B8A8_UNORM || f == VK_FORMAT_R8G8B8A8_SRGB; };
  return is_rgba8(a.decoded) && is_rgba8(b.decoded);
}

std::optional<Planes> image_planes(const VkImageCreateInfo& info) {
  const FormatInfo& format = *find_format(info.format);
  Planes planes;
  const auto add = [&](uint32_t index, VkFormat plane_format, uint32_t shift_x, uint32_t shift_y) {
    ImagePlane& plane = planes.plane[index];
    plane.format = find_format(plane_format);
    const auto layout = image_layout({.extent = {info.extent.width >> shift_x, info.extent.height >> shift_y, info.extent.depth},
                                      .level_count = info.mipLevels,
                                      .layer_count = info.arrayLayers,
                                      .sample_count = static_cast<uint32_t>(info.samples),
                                      .block_bytes = plane.format->texel_bytes,
                                      .block_width = plane.format->block_width,
                                      .block_height = plane.format->block_height});
    if (!layout) return false;
    plane.layout = *layout;
    plane.offset_bytes = planes.size_bytes;
    planes.size_bytes = (planes.size_bytes + layout->size_bytes + kResourceAlignment_bytes - 1) / kResourceAlignment_bytes *
                        kResourceAlignment_bytes;
    return true;
  };
  for (uint32_t i = 0; i < format.plane_count(); ++i) {
    if (!add(i, format.plane_format(i), i ? format.plane_shift_x : 0, i ? format.plane_shift_y : 0)) return std::nullopt;
  }
  // Transfers that only move blocks need no decoded copy.
  if (!format.is_compressed() || !(info.usage & (VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT))) return planes;
  const FormatInfo& other = *find_format(sibling(format));
  const bool both = (info.flags & VK_IMAGE_CREATE_MUTABLE_FORMAT_BIT) && !decodes_alike(format, other);
  uint32_t index = Image::kFirstDecoded;
  for (const FormatInfo* decoded : {&format, both ? &other : nullptr}) {
    if (!decoded) continue;
    if (!add(index, decoded->decoded, 0, 0)) return std::nullopt;
    planes.plane[index++].decodes = decoded->format;
  }
  return planes;
}

}  // namespace

// The specification makes exceeding vkGetPhysicalDeviceImageFormatProperties invalid; being exact here keeps sizes within 32
// bits.
VkResult Image::check(Device&, const VkImageCreateInfo& info) {
  VkImageFormatProperties limits;
  const auto* stencil =
      find_in_chain<VkImageStencilUsageCreateInfo>(info.pNext, VK_STRUCTURE_TYPE_IMAGE_STENCIL_USAGE_CREATE_INFO);
  const ImageQuery query{info.format, info.imageType, info.tiling, info.usage, info.flags, stencil ? stencil->stencilUsage : 0};
  if (image_format_properties(query, &limits) != VK_SUCCESS) {
    return not_supported(
        "vkCreateImage: vkGetPhysicalDeviceImageFormatProperties refuses this format, type, usage or these flags");
  }
  const VkExtent3D& extent = info.extent;
  const bool fits = extent.width >= 1 && extent.height >= 1 && extent.depth >= 1 && extent.width <= limits.maxExtent.width &&
                    extent.height <= limits.maxExtent.height && extent.depth <= limits.maxExtent.depth;
  const uint32_t largest = std::max({extent.width, extent.height, extent.depth});
  const bool levels_fit = info.mipLevels >= 1 && info.mipLevels <= uint32_t(std::bit_width(largest)) &&
                          (info.mipLevels == 1 || info.samples == VK_SAMPLE_COUNT_1_BIT);
  const FormatInfo& format = *find_format(info.format);
  const bool whole_planes = extent.width % (1u << format.plane_shift_x) == 0 && extent.height % (1u << format.plane_shift_y) == 0;
  const bool cube_fits = !(info.flags & VK_IMAGE_CREATE_CUBE_COMPATIBLE_BIT) || extent.width == extent.height;
  if (!fits || !levels_fit || !whole_planes || !cube_fits || info.arrayLayers < 1 || info.arrayLayers > limits.maxArrayLayers ||
      !std::has_single_bit(static_cast<uint32_t>(info.samples)) || !(info.samples & limits.sampleCounts)) {
    return not_supported("vkCreateImage: extent, levels, layers or samples are beyond vkGetPhysicalDeviceImageFormatProperties");
  }
  return image_planes(info) ? VK_SUCCESS : VK_ERROR_OUT_OF_DEVICE_MEMORY;  // "exceeds maxResourceSize"
}

Image::Image(const Allocator& from, Device&, const VkImageCreateInfo& info)
    : Object(from),
      type(info.imageType),
      format(*find_format(info.format)),
      level_count(info.mipLevels),
      layer_count(info.arrayLayers),
      sample_count(static_cast<uint32_t>(info.samples)),
      flags(info.flags),
      usage(info.usage) {
  const Planes planes = *image_planes(info);
  planes_ = planes.plane;
  size_bytes_ = planes.size_bytes;
}

const ImagePlane* Image::decoded_plane(VkFormat view_format) const {
  for (uint32_t i = kFirstDecoded; i < kPlanes; ++i) {
    if (planes_[i].format && planes_[i].decodes == view_format) return &planes_[i];
  }
  const bool shared =
      planes_[kFirstDecoded].format && view_format == sibling(format) && decodes_alike(format, *find_format(view_format));
  return shared ? &planes_[kFirstDecoded] : nullptr;
}

VkResult api::CreateImage(VkDevice device, const VkImageCreateInfo* info, const VkAllocationCallbacks* callbacks, VkImage* out) {
  return create_device_object<Image>(device, info, callbacks, out);
}

void api::DestroyImage(VkDevice device, VkImage image, const VkAllocationCallbacks* callbacks) {
  destroy_device_object(device, image, callbacks);
}

void api::GetImageMemoryRequirements(VkDevice, VkImage image, VkMemoryRequirements* out) {
  const bool transient = (from(image)->usage & VK_IMAGE_USAGE_TRANSIENT_ATTACHMENT_BIT) != 0;
  *out = {.size = from(image)->size_bytes(),
          .alignment = kResourceAlignment_bytes,
          .memoryTypeBits = 1u << kMappedMemoryType | (transient ? 1u << kLazyMemoryType : 0)};
}

void api::GetImageSparseMemoryRequirements(VkDevice, VkImage, uint32_t* count, VkSparseImageMemoryRequirements*) { *count = 0; }

VkResult api::BindImageMemory(VkDevice, VkImage image, VkDeviceMemory memory, VkDeviceSize offset) {
  from(image)->bind(from(memory)->data() + offset);
  return VK_SUCCESS;
}

void api::GetImageSubresourceLayout(VkDevice, VkImage handle, const VkImageSubresource* subresource, VkSubresourceLayout* out) {
  const Image& image = *from(handle);
  const ImagePlane& plane = image.plane(plane_of(image.format, subresource->aspectMask));
  const LevelLayout& level = plane.layout.level[subresource->mipLevel];
  *out = {.offset = plane.offset_bytes + uint64_t(subresource->arrayLayer) * plane.layout.layer_pitch_bytes + level.offset_bytes,
          .size = uint64_t(level.slice_pitch_bytes) * level.extent.depth,
          .rowPitch = level.row_pitch_bytes,
          .arrayPitch = plane.layout.layer_pitch_bytes,
          .depthPitch = level.slice_pitch_bytes};
}

}  // namespace pineda::icd
