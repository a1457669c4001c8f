// Execution of vkCmdBlitImage ("Image Blits"): for each texel of the destination, the source is sampled at the centre that
// corresponds, clamped to the edge of the source level. Texels are decoded and encoded through the table of formats, so every
// colour format blits to every other of its kind; between equal formats and without a filter, texels are copied.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "icd/device.h"
#include "icd/executor.h"
#include "icd/transfer.h"

namespace pineda::icd {
namespace {

// One axis: destination texel i, at its centre, is source coordinate (i + 0.5 - to0) * scale + from0. Corners may be swapped on
// either side, which mirrors. Doubles: products of 15-bit numbers and a quotient, far from any rounding that would move a texel.
struct Axis {
  double scale, from0, to0;
  int32_t begin, end;  // destination texels, in ascending order
  uint32_t limit;      // source texels of the level

  Axis(int32_t source0, int32_t source1, int32_t to_0, int32_t to_1, uint32_t source_limit)
      : scale(to_1 == to_0 ? 0 : (double(source1) - source0) / (double(to_1) - to_0)),
        from0(source0),
        to0(to_0),
        begin(std::min(to_0, to_1)),
        end(std::max(to_0, to_1)),
        limit(source_limit) {}

  double coordinate(int32_t i) const { return (i + 0.5 - to0) * scale + from0; }
  uint32_t clamp(double texel) const { return static_cast<uint32_t>(std::clamp(texel, 0.0, double(limit) - 1)); }
  uint32_t nearest(int32_t i) const { return clamp(std::floor(coordinate(i))); }
};

struct Blit {
  const FormatInfo& source;
  const FormatInfo& destination;
  Axis x, y;
  uint8_t* from;
  uint8_t* to;
  uint64_t from_pitch_bytes, to_pitch_bytes;
  bool linear;

  const uint8_t* source_texel(uint32_t tx, uint32_t ty) const {
    return from + ty * from_pitch_bytes + uint64_t(tx) * source.texel_bytes;
  }
  uint8_t* destination_texel(int32_t tx, int32_t ty) const {
    return to + uint64_t(ty) * to_pitch_bytes + uint64_t(tx) * destination.texel_bytes;
  }
};

void copy_row(const Blit& blit, int32_t y) {
  const uint32_t sy = blit.y.nearest(y);
  for (int32_t x = blit.x.begin; x < blit.x.end; ++x) {
    std::memcpy(blit.destination_texel(x, y), blit.source_texel(blit.x.nearest(x), sy), blit.source.texel_bytes);
  }
}

void convert_row(const Blit& blit, int32_t y) {
  const uint32_t sy = blit.y.nearest(y);
  for (int32_t x = blit.x.begin; x < blit.x.end; ++x) {
    const VkClearColorValue color = unpack_texel(blit.source, blit.source_texel(blit.x.nearest(x), sy));
    pack_clear_color(blit.destination, color, blit.destination_texel(x, y));
  }
}

// "Texel Filtering", VK_FILTER_LINEAR in two dimensions, in binary32.
void filter_row(const Blit& blit, int32_t y) {
  const double v = blit.y.coordinate(y) - 0.5;
  const double v0 = std::floor(v);
  const auto beta = static_cast<float>(v - v0);
  const uint32_t row[2] = {blit.y.clamp(v0), blit.y.clamp(v0 + 1)};
  for (int32_t x = blit.x.begin; x < blit.x.end; ++x) {
    const double u = blit.x.coordinate(x) - 0.5;
    const double u0 = std::floor(u);
    const auto alpha = static_cast<float>(u - u0);
    const uint32_t column[2] = {blit.x.clamp(u0), blit.x.clamp(u0 + 1)};
    VkClearColorValue t[2][2], out;
    for (int j = 0; j < 2; ++j) {
      for (int i = 0; i < 2; ++i) t[j][i] = unpack_texel(blit.source, blit.source_texel(column[i], row[j]));
    }
    for (int c = 0; c < 4; ++c) {
      const float top = t[0][0].float32[c] * (1 - alpha) + t[0][1].float32[c] * alpha;
      const float bottom = t[1][0].float32[c] * (1 - alpha) + t[1][1].float32[c] * alpha;
      out.float32[c] = top * (1 - beta) + bottom * beta;
    }
    pack_clear_color(blit.destination, out, blit.destination_texel(x, y));
  }
}

void blit_rows(raster::ThreadPool& pool, const Blit& blit) {
  const bool same_format = blit.source.format == blit.destination.format;
  constexpr uint64_t kTexelsWorthAThread = 4096;
  const auto rows = static_cast<uint32_t>(blit.y.end - blit.y.begin);
  const bool helpers = uint64_t(rows) * uint64_t(blit.x.end - blit.x.begin) >= kTexelsWorthAThread;
  pool.parallel_for(
      rows,
      [&](uint32_t index, uint32_t) {
        const int32_t y = blit.y.begin + int32_t(index);
        blit.linear ? filter_row(blit, y) : same_format ? copy_row(blit, y) : convert_row(blit, y);
      },
      helpers);
}

// Offsets of a blit as a region, whatever the order of its corners. Blocks count as the texels of their decoded copy.
std::optional<ImageRegion> corners(const Image& image, const VkImageSubresourceLayers& subresource,
                                   const VkOffset3D (&offsets)[2]) {
  const auto [x0, x1] = std::minmax(offsets[0].x, offsets[1].x);
  const auto [y0, y1] = std::minmax(offsets[0].y, offsets[1].y);
  const auto [z0, z1] = std::minmax(offsets[0].z, offsets[1].z);
  return image_region(image, subresource, {x0, y0, z0},
                      {uint32_t(x1) - uint32_t(x0), uint32_t(y1) - uint32_t(y0), uint32_t(z1) - uint32_t(z0)});
}

void blit_aspect(raster::ThreadPool& pool, const cmd::BlitImage& command, VkImageBlit region, VkImageAspectFlags aspect) {
  const Image& source = *command.source;
  const Image& destination = *command.destination;
  region.srcSubresource.aspectMask = region.dstSubresource.aspectMask = aspect;
  const auto from = corners(source, region.srcSubresource, region.srcOffsets);
  const auto to = corners(destination, region.dstSubresource, region.dstOffsets);
  if (!from || !to) return;
  const LevelLayout& from_level = from->plane->layout.level[region.srcSubresource.mipLevel];
  const LevelLayout& to_level = to->plane->layout.level[region.dstSubresource.mipLevel];
  const FormatInfo& from_format = *from->plane->format;
  for (uint32_t i = 0; i < std::min(from->slices, to->slices); ++i) {
    blit_rows(
        pool,
        {.source = from_format,
         .destination = *to->plane->format,
         .x = {region.srcOffsets[0].x, region.srcOffsets[1].x, region.dstOffsets[0].x, region.dstOffsets[1].x,
               from_level.extent.width},
         .y = {region.srcOffsets[0].y, region.srcOffsets[1].y, region.dstOffsets[0].y, region.dstOffsets[1].y,
               from_level.extent.height},
         .from = source.subresource(*from->plane, region.srcSubresource.mipLevel, region.srcSubresource.baseArrayLayer + i),
         .to = destination.subresource(*to->plane, region.dstSubresource.mipLevel, region.dstSubresource.baseArrayLayer + i),
         .from_pitch_bytes = from_level.row_pitch_bytes,
         .to_pitch_bytes = to_level.row_pitch_bytes,
         .linear = command.filter == VK_FILTER_LINEAR && !from_format.is_integer() && aspect == VK_IMAGE_ASPECT_COLOR_BIT});
  }
}

}  // namespace

void Executor::execute(const cmd::BlitImage& command) {
  const Image& source = *command.source;
  const Image& destination = *command.destination;
  const bool color = !source.format.is_depth_or_stencil() && !destination.format.is_depth_or_stencil();
  if (!color && source.format.format != destination.format.format) return;  // invalid usage
  if (source.type == VK_IMAGE_TYPE_3D || destination.type == VK_IMAGE_TYPE_3D) {
    device_.lose("vkCmdBlitImage of a volume is not supported");
    return;
  }
  for (const VkImageBlit& region : command.regions) {
    for (const VkImageAspectFlags aspect : {VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_ASPECT_DEPTH_BIT, VK_IMAGE_ASPECT_STENCIL_BIT}) {
      if (region.srcSubresource.aspectMask & source.format.aspects & aspect) blit_aspect(device_.pool, command, region, aspect);
    }
  }
}

}  // namespace pineda::icd
