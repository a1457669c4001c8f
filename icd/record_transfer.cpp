// Recording of copies, blits, clears and fills.
#include "icd/api.h"
#include "icd/buffer.h"
#include "icd/command_buffer.h"
#include "icd/image.h"

namespace pineda::icd {
namespace {

uint64_t texels(VkExtent3D extent, uint32_t layers) { return uint64_t(extent.width) * extent.height * extent.depth * layers; }

uint64_t copy_cost_ns(uint64_t texel_count, const Image& image) {
  return texel_count * image.format.texel_bytes / cost::kBytesPer_ns;
}

uint64_t blit_axis(int32_t from, int32_t to) { return uint64_t(from < to ? int64_t(to) - from : int64_t(from) - to); }

}  // namespace

void api::CmdCopyBuffer(VkCommandBuffer handle, VkBuffer source, VkBuffer destination, uint32_t count,
                        const VkBufferCopy* regions) {
  CommandBuffer& cb = *from(handle);
  cb.record([&] {
    cb.append(cmd::CopyBuffer{from(source), from(destination), cb.copy(regions, count)});
    for (uint32_t i = 0; i < count; ++i) cb.add_cost(regions[i].size / cost::kBytesPer_ns);
  });
}

void api::CmdCopyImage(VkCommandBuffer handle, VkImage source, VkImageLayout, VkImage destination, VkImageLayout, uint32_t count,
                       const VkImageCopy* regions) {
  CommandBuffer& cb = *from(handle);
  cb.record([&] {
    cb.append(cmd::CopyImage{from(source), from(destination), cb.copy(regions, count)});
    for (uint32_t i = 0; i < count; ++i) {
      cb.add_cost(copy_cost_ns(texels(regions[i].extent, regions[i].srcSubresource.layerCount), *from(source)));
    }
  });
}

void api::CmdBlitImage(VkCommandBuffer handle, VkImage source, VkImageLayout, VkImage destination, VkImageLayout, uint32_t count,
                       const VkImageBlit* regions, VkFilter filter) {
  CommandBuffer& cb = *from(handle);
  cb.record([&] {
    cb.append(cmd::BlitImage{from(source), from(destination), cb.copy(regions, count), filter});
    for (uint32_t i = 0; i < count; ++i) {
      const VkOffset3D* to = regions[i].dstOffsets;
      cb.add_cost(blit_axis(to[0].x, to[1].x) * blit_axis(to[0].y, to[1].y) * cost::kBlitTexel_ns);
    }
  });
}

void api::CmdCopyBufferToImage(VkCommandBuffer handle, VkBuffer source, VkImage destination, VkImageLayout, uint32_t count,
                               const VkBufferImageCopy* regions) {
  CommandBuffer& cb = *from(handle);
  cb.record([&] {
    cb.append(cmd::CopyBufferToImage{from(source), from(destination), cb.copy(regions, count)});
    for (uint32_t i = 0; i < count; ++i) {
      cb.add_cost(copy_cost_ns(texels(regions[i].imageExtent, regions[i].imageSubresource.layerCount), *from(destination)));
    }
  });
}

void api::CmdCopyImageToBuffer(VkCommandBuffer handle, VkImage source, VkImageLayout, VkBuffer destination, uint32_t count,
                               const VkBufferImageCopy* regions) {
  CommandBuffer& cb = *from(handle);
  cb.record([&] {
    cb.append(cmd::CopyImageToBuffer{from(source), from(destination), cb.copy(regions, count)});
    for (uint32_t i = 0; i < count; ++i) {
      cb.add_cost(copy_cost_ns(texels(regions[i].imageExtent, regions[i].imageSubresource.layerCount), *from(source)));
    }
  });
}

void api::CmdUpdateBuffer(VkCommandBuffer handle, VkBuffer destination, VkDeviceSize offset, VkDeviceSize size,
                          const void* data) {
  CommandBuffer& cb = *from(handle);
  cb.record([&] { cb.append(cmd::UpdateBuffer{from(destination), offset, cb.copy(static_cast<const uint8_t*>(data), size)}); });
}

void api::CmdFillBuffer(VkCommandBuffer handle, VkBuffer destination, VkDeviceSize offset, VkDeviceSize size, uint32_t data) {
  CommandBuffer& cb = *from(handle);
  cb.record([&] {
    cb.append(cmd::FillBuffer{from(destination), offset, size, data});
    cb.add_cost(from(destination)->clamp(offset, size) / cost::kBytesPer_ns);
  });
}

void api::CmdClearColorImage(VkCommandBuffer handle, VkImage image, VkImageLayout, const VkClearColorValue* color, uint32_t count,
                             const VkImageSubresourceRange* ranges) {
  CommandBuffer& cb = *from(handle);
  cb.record([&] {
    cb.append(cmd::ClearColorImage{from(image), *color, cb.copy(ranges, count)});
    cb.add_cost(from(image)->size_bytes() / cost::kBytesPer_ns);
  });
}

void api::CmdClearDepthStencilImage(VkCommandBuffer handle, VkImage image, VkImageLayout, const VkClearDepthStencilValue* value,
                                    uint32_t count, const VkImageSubresourceRange* ranges) {
  CommandBuffer& cb = *from(handle);
  cb.record([&] {
    cb.append(cmd::ClearDepthStencilImage{from(image), *value, cb.copy(ranges, count)});
    cb.add_cost(from(image)->size_bytes() / cost::kBytesPer_ns);
  });
}

void api::CmdResolveImage(VkCommandBuffer handle, VkImage source, VkImageLayout, VkImage destination, VkImageLayout,
                          uint32_t count, const VkImageResolve* regions) {
  CommandBuffer& cb = *from(handle);
  cb.record([&] {
    cb.append(cmd::ResolveImage{from(source), from(destination), cb.copy(regions, count)});
    cb.add_cost(from(source)->size_bytes() / cost::kBytesPer_ns);
  });
}

}  // namespace pineda::icd
