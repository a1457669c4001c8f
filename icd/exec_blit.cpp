// Execution of vkCmdBlitImage ("Image Blits"): resolves images, levels and aspects for raster::blit. Block-compressed sources are
// read from their decoded copies.
#include <algorithm>

#include "icd/device.h"
#include "icd/executor.h"
#include "icd/transfer.h"
#include "raster/blit.h"

namespace pineda::icd {
namespace {

// Whether the region's corners are inside the level, in texels, and its layers inside the image.
bool inside(const Image& image, const ImagePlane& plane, const VkImageSubresourceLayers& layers, const VkOffset3D (&offsets)[2]) {
  if (!image.data() || layers.mipLevel >= image.level_count || image.sample_count != 1) return false;
  const VkExtent3D& extent = plane.layout.level[layers.mipLevel].extent;
  for (const VkOffset3D& o : offsets) {
    if (o.x < 0 || o.y < 0 || o.z < 0) return false;
    if (uint32_t(o.x) > extent.width || uint32_t(o.y) > extent.height || uint32_t(o.z) > extent.depth) return false;
  }
  return layers.baseArrayLayer <= image.layer_count;
}

uint32_t layer_count(const Image& image, const VkImageSubresourceLayers& layers) {
  const uint32_t rest = image.layer_count - layers.baseArrayLayer;
  return std::min(layers.layerCount, rest);  // VK_REMAINING_ARRAY_LAYERS is the largest number
}

const ImagePlane* blit_plane(const Image& image, VkImageAspectFlags aspect) {
  if (image.format.is_compressed()) return image.decoded_plane(image.format.format);
  return &image.plane(plane_of(image.format, aspect));
}

raster::BlitSide side(const Image& image, const ImagePlane& plane, const VkImageSubresourceLayers& layers, uint32_t layer) {
  const LevelLayout& level = plane.layout.level[layers.mipLevel];
  return {plane.format, image.subresource(plane, layers.mipLevel, layers.baseArrayLayer + layer), level.row_pitch_bytes,
          level.slice_pitch_bytes};
}

void blit_aspect(raster::ThreadPool& pool, const cmd::BlitImage& command, const VkImageBlit& region, VkImageAspectFlags aspect) {
  const Image& source = *command.source;
  const Image& destination = *command.destination;
  const ImagePlane* from = blit_plane(source, aspect);
  const ImagePlane* to = blit_plane(destination, aspect);
  if (!from || !to || !inside(source, *from, region.srcSubresource, region.srcOffsets) ||
      !inside(destination, *to, region.dstSubresource, region.dstOffsets)) {
    return;  // invalid usage
  }
  const VkExtent3D& limit = from->layout.level[region.srcSubresource.mipLevel].extent;
  const VkOffset3D *a = region.srcOffsets, *b = region.dstOffsets;
  const bool linear = command.filter == VK_FILTER_LINEAR && !from->format->is_integer() && aspect == VK_IMAGE_ASPECT_COLOR_BIT;
  const uint32_t layers = std::min(layer_count(source, region.srcSubresource), layer_count(destination, region.dstSubresource));
  for (uint32_t i = 0; i < layers; ++i) {
    raster::blit(pool, {.source = side(source, *from, region.srcSubresource, i),
                        .destination = side(destination, *to, region.dstSubresource, i),
                        .x = {a[0].x, a[1].x, b[0].x, b[1].x, limit.width},
                        .y = {a[0].y, a[1].y, b[0].y, b[1].y, limit.height},
                        .z = {a[0].z, a[1].z, b[0].z, b[1].z, limit.depth},
                        .linear = linear,
                        .linear_z = linear && source.type == VK_IMAGE_TYPE_3D});
  }
}

}  // namespace

void Executor::execute(const cmd::BlitImage& command) {
  const Image& source = *command.source;
  const Image& destination = *command.destination;
  const bool color = !source.format.is_depth_or_stencil() && !destination.format.is_depth_or_stencil();
  if (!color && source.format.format != destination.format.format) return;  // invalid usage
  for (const VkImageBlit& region : command.regions) {
    for (const VkImageAspectFlags aspect : {VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_ASPECT_DEPTH_BIT, VK_IMAGE_ASPECT_STENCIL_BIT}) {
      if (region.srcSubresource.aspectMask & source.format.aspects & aspect) blit_aspect(device_.pool, command, region, aspect);
    }
  }
}

}  // namespace pineda::icd
