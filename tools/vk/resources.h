// Buffers, textures, and the off-screen target that every scene draws into.
#pragma once

#include <array>
#include <cstddef>
#include <ranges>
#include <span>
#include <vector>

#include "tools/image.h"
#include "tools/vk/context.h"

namespace pineda::tools {

MemoryHandle allocate(VkContext& context, const VkMemoryRequirements& requirements, VkMemoryPropertyFlags wanted);

struct Buffer {  // host-visible and mapped for its whole life: the drivers compared here run on the CPU
  BufferHandle handle;
  MemoryHandle memory;
  std::byte* mapped = nullptr;
  VkDeviceSize size_bytes = 0;
};

Buffer create_buffer(VkContext& context, VkDeviceSize size_bytes, VkBufferUsageFlags usage);
Buffer create_buffer(VkContext& context, std::span<const std::byte> content, VkBufferUsageFlags usage);
template <std::ranges::contiguous_range Range>
Buffer create_buffer(VkContext& context, const Range& content, VkBufferUsageFlags usage) {
  const std::span<const std::byte> bytes = std::as_bytes(std::span(content));
  return create_buffer(context, bytes, usage);
}

struct Image2D {
  ImageHandle handle;
  MemoryHandle memory;
  ImageViewHandle view;
  VkExtent2D extent{};
  uint32_t mip_levels = 1;
};

Image2D create_image(VkContext& context, VkExtent2D extent, uint32_t mip_levels, VkFormat format, VkImageUsageFlags usage,
                     VkSampleCountFlagBits samples = VK_SAMPLE_COUNT_1_BIT);
// Uploads all levels by one buffer-to-image copy; ready for sampling. The format has the texels of an Image: R8G8B8A8_UNORM or
// _SRGB.
Image2D create_texture(VkContext& context, std::span<const Image> mip_levels, VkFormat format);
// The same of any format: each level's bytes as vkCmdCopyBufferToImage takes them, without gaps.
Image2D create_texture(VkContext& context, VkExtent2D extent, std::span<const std::vector<uint8_t>> levels, VkFormat format);
SamplerHandle create_trilinear_sampler(VkContext& context);

void transition(VkCommandBuffer commands, const Image2D& image, VkImageLayout from, VkImageLayout to, VkAccessFlags source_access,
                VkAccessFlags target_access, VkPipelineStageFlags source_stage, VkPipelineStageFlags target_stage);

// A colour image (RGBA8 unless another format is asked for), with depth if wanted (D32 unless another
// format is asked for), the render pass that clears both and
// leaves the colour ready to be read back.
class RenderTarget {
 public:
  enum class Attachments { kColour, kColourDepth, kColourStencil, kDepth };  // kColourStencil: D32 with S8
  // With several samples a pixel the colour is resolved at the pass's end; of those asked for, as many as the driver has.
  RenderTarget(VkContext& context, VkExtent2D extent, Attachments attachments, uint32_t samples = 1,
               VkFormat colour_format = VK_FORMAT_R8G8B8A8_UNORM, VkFormat other_depth_format = VK_FORMAT_UNDEFINED);

  void begin(VkCommandBuffer commands, std::array<float, 4> clear_colour) const;
  VkExtent2D extent() const { return extent_; }
  VkRenderPass render_pass() const { return render_pass_; }
  bool has_colour() const { return attachments_ != Attachments::kDepth; }
  bool has_depth() const { return attachments_ != Attachments::kColour; }
  VkFormat depth_format() const {
    if (depth_format_ != VK_FORMAT_UNDEFINED) return depth_format_;
    return attachments_ == Attachments::kColourStencil ? VK_FORMAT_D32_SFLOAT_S8_UINT : VK_FORMAT_D32_SFLOAT;
  }
  const Image2D& colour() const { return colour_; }
  VkSampleCountFlagBits samples() const { return samples_; }

 private:
  void create_render_pass(VkContext& context);
  bool resolves() const { return has_colour() && samples_ != VK_SAMPLE_COUNT_1_BIT; }

  VkExtent2D extent_;
  Attachments attachments_;
  VkFormat colour_format_, depth_format_;  // depth: UNDEFINED for the usual one
  VkSampleCountFlagBits samples_;
  Image2D colour_, samples_colour_, depth_;
  RenderPassHandle render_pass_;
  FramebufferHandle framebuffer_;
};

// Makes what a stage wrote to a buffer visible to the host, once the fence is waited for.
void make_visible_to_host(VkCommandBuffer commands, const Buffer& buffer, VkPipelineStageFlags stage, VkAccessFlags access);

// Copies an image in TRANSFER_SRC_OPTIMAL to the host: an RGBA8 one; one of four floats a pixel; the bytes of any colour format.
Image read_back(VkContext& context, const Image2D& image);
std::vector<float> read_back_floats(VkContext& context, const Image2D& image);
std::vector<std::byte> read_back_bytes(VkContext& context, const Image2D& image, uint32_t bytes_per_pixel);

}  // namespace pineda::tools
