#include "tools/vk/resources.h"

#include <algorithm>
#include <cstring>

namespace pineda::tools {
namespace {

constexpr VkMemoryPropertyFlags kHostMemory = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;

VkImageAspectFlags aspect_of(VkFormat format) {
  switch (format) {
    case VK_FORMAT_D24_UNORM_S8_UINT:
    case VK_FORMAT_D32_SFLOAT_S8_UINT:
      return VK_IMAGE_ASPECT_DEPTH_BIT | VK_IMAGE_ASPECT_STENCIL_BIT;
    case VK_FORMAT_D16_UNORM:
    case VK_FORMAT_X8_D24_UNORM_PACK32:
    case VK_FORMAT_D32_SFLOAT:
      return VK_IMAGE_ASPECT_DEPTH_BIT;
    default:
      return VK_IMAGE_ASPECT_COLOR_BIT;
  }
}

}  // namespace

MemoryHandle allocate(VkContext& context, const VkMemoryRequirements& requirements, VkMemoryPropertyFlags wanted) {
  const VkMemoryAllocateInfo info{.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
                                  .allocationSize = requirements.size,
                                  .memoryTypeIndex = context.memory_type(requirements.memoryTypeBits, wanted)};
  VkDeviceMemory memory = VK_NULL_HANDLE;
  check(vkAllocateMemory(context.device(), &info, nullptr, &memory), "vkAllocateMemory");
  return {context.device(), memory};
}

Buffer create_buffer(VkContext& context, VkDeviceSize size_bytes, VkBufferUsageFlags usage) {
  const VkBufferCreateInfo info{.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO, .size = size_bytes, .usage = usage};
  VkBuffer handle = VK_NULL_HANDLE;
  check(vkCreateBuffer(context.device(), &info, nullptr, &handle), "vkCreateBuffer");
  Buffer buffer{.handle = {context.device(), handle}, .size_bytes = size_bytes};
  VkMemoryRequirements requirements;
  vkGetBufferMemoryRequirements(context.device(), handle, &requirements);
  buffer.memory = allocate(context, requirements, kHostMemory);
  check(vkBindBufferMemory(context.device(), handle, buffer.memory, 0), "vkBindBufferMemory");
  void* mapped = nullptr;
  check(vkMapMemory(context.device(), buffer.memory, 0, VK_WHOLE_SIZE, 0, &mapped), "vkMapMemory");
  buffer.mapped = static_cast<std::byte*>(mapped);
  return buffer;
}

Buffer create_buffer(VkContext& context, std::span<const std::byte> content, VkBufferUsageFlags usage) {
  Buffer buffer = create_buffer(context, content.size(), usage);
  std::memcpy(buffer.mapped, content.data(), content.size());
  return buffer;
}

Image2D create_image(VkContext& context, VkExtent2D extent, uint32_t mip_levels, VkFormat format, VkImageUsageFlags usage,
                     VkSampleCountFlagBits samples) {
  const VkImageCreateInfo info{.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
                               .imageType = VK_IMAGE_TYPE_2D,
                               .format = format,
                               .extent = {extent.width, extent.height, 1},
                               .mipLevels = mip_levels,
                               .arrayLayers = 1,
                               .samples = samples,
                               .tiling = VK_IMAGE_TILING_OPTIMAL,
                               .usage = usage,
                               .initialLayout = VK_IMAGE_LAYOUT_UNDEFINED};
  VkImage handle = VK_NULL_HANDLE;
  check(vkCreateImage(context.device(), &info, nullptr, &handle), "vkCreateImage");
  Image2D image{.handle = {context.device(), handle}, .extent = extent, .mip_levels = mip_levels};
  VkMemoryRequirements requirements;
  vkGetImageMemoryRequirements(context.device(), handle, &requirements);
  image.memory = allocate(context, requirements, 0);
  check(vkBindImageMemory(context.device(), handle, image.memory, 0), "vkBindImageMemory");

  const VkImageViewCreateInfo view_info{.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
                                        .image = handle,
                                        .viewType = VK_IMAGE_VIEW_TYPE_2D,
                                        .format = format,
                                        .subresourceRange = {aspect_of(format), 0, mip_levels, 0, 1}};
  VkImageView view = VK_NULL_HANDLE;
  check(vkCreateImageView(context.device(), &view_info, nullptr, &view), "vkCreateImageView");
  image.view = {context.device(), view};
  return image;
}

void transition(VkCommandBuffer commands, const Image2D& image, VkImageLayout from, VkImageLayout to, VkAccessFlags source_access,
                VkAccessFlags target_access, VkPipelineStageFlags source_stage, VkPipelineStageFlags target_stage) {
  const VkImageMemoryBarrier barrier{.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER,
                                     .srcAccessMask = source_access,
                                     .dstAccessMask = target_access,
                                     .oldLayout = from,
                                     .newLayout = to,
                                     .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
                                     .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
                                     .image = image.handle,
                                     .subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, image.mip_levels, 0, 1}};
  vkCmdPipelineBarrier(commands, source_stage, target_stage, 0, 0, nullptr, 0, nullptr, 1, &barrier);
}

Image2D create_texture(VkContext& context, std::span<const Image> mip_levels, VkFormat format) {
  std::vector<std::vector<uint8_t>> levels;
  for (const Image& level : mip_levels) levels.push_back(level.rgba);
  return create_texture(context, {mip_levels[0].width, mip_levels[0].height}, levels, format);
}

Image2D create_texture(VkContext& context, VkExtent2D extent, std::span<const std::vector<uint8_t>> levels, VkFormat format) {
  Image2D texture = create_image(context, extent, static_cast<uint32_t>(levels.size()), format,
                                 VK_IMAGE_USAGE_TRANSFER_DST_BIT | VK_IMAGE_USAGE_SAMPLED_BIT);
  std::vector<uint8_t> staging_bytes;
  std::vector<VkBufferImageCopy> copies;
  for (uint32_t level = 0; level < levels.size(); ++level) {
    copies.push_back({.bufferOffset = staging_bytes.size(),
                      .imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, level, 0, 1},
                      .imageExtent = {std::max(extent.width >> level, 1u), std::max(extent.height >> level, 1u), 1}});
    staging_bytes.insert(staging_bytes.end(), levels[level].begin(), levels[level].end());
  }
  const Buffer staging = create_buffer(context, staging_bytes, VK_BUFFER_USAGE_TRANSFER_SRC_BIT);
  context.run_once([&](VkCommandBuffer commands) {
    transition(commands, texture, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 0,
               VK_ACCESS_TRANSFER_WRITE_BIT, VK_PIPELINE_STAGE_TOP_OF_PIPE_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT);
    vkCmdCopyBufferToImage(commands, staging.handle, texture.handle, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                           static_cast<uint32_t>(copies.size()), copies.data());
    transition(commands, texture, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL,
               VK_ACCESS_TRANSFER_WRITE_BIT, VK_ACCESS_SHADER_READ_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT,
               VK_PIPELINE_STAGE_FRAGMENT_SHADER_BIT);
  });
  return texture;
}

SamplerHandle create_trilinear_sampler(VkContext& context) {
  const VkSamplerCreateInfo info{.sType = VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO,
                                 .magFilter = VK_FILTER_LINEAR,
                                 .minFilter = VK_FILTER_LINEAR,
                                 .mipmapMode = VK_SAMPLER_MIPMAP_MODE_LINEAR,
                                 .addressModeU = VK_SAMPLER_ADDRESS_MODE_REPEAT,
                                 .addressModeV = VK_SAMPLER_ADDRESS_MODE_REPEAT,
                                 .addressModeW = VK_SAMPLER_ADDRESS_MODE_REPEAT,
                                 .maxLod = VK_LOD_CLAMP_NONE};
  VkSampler sampler = VK_NULL_HANDLE;
  check(vkCreateSampler(context.device(), &info, nullptr, &sampler), "vkCreateSampler");
  return {context.device(), sampler};
}

RenderTarget::RenderTarget(VkContext& context, VkExtent2D extent, Attachments attachments, uint32_t samples,
                           VkFormat colour_format, VkFormat other_depth_format)
    : extent_(extent), attachments_(attachments), colour_format_(colour_format), depth_format_(other_depth_format) {
  while (samples > 1 && !(context.sample_counts() & samples)) samples /= 2;
  samples_ = static_cast<VkSampleCountFlagBits>(samples);
  std::vector<VkImageView> views;
  if (has_colour()) {
    colour_ =
        create_image(context, extent, 1, colour_format_, VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT);
    if (resolves()) {
      constexpr VkImageUsageFlags kUsage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSIENT_ATTACHMENT_BIT;
      samples_colour_ = create_image(context, extent, 1, colour_format_, kUsage, samples_);
    }
    views.push_back(resolves() ? samples_colour_.view : colour_.view);
  }
  if (has_depth()) {
    depth_ = create_image(context, extent, 1, depth_format(), VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT, samples_);
    views.push_back(depth_.view);
  }
  if (resolves()) views.push_back(colour_.view);
  create_render_pass(context);
  const VkFramebufferCreateInfo info{.sType = VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO,
                                     .renderPass = render_pass_,
                                     .attachmentCount = static_cast<uint32_t>(views.size()),
                                     .pAttachments = views.data(),
                                     .width = extent.width,
                                     .height = extent.height,
                                     .layers = 1};
  VkFramebuffer framebuffer = VK_NULL_HANDLE;
  check(vkCreateFramebuffer(context.device(), &info, nullptr, &framebuffer), "vkCreateFramebuffer");
  framebuffer_ = {context.device(), framebuffer};
}

void RenderTarget::create_render_pass(VkContext& context) {
  const VkAttachmentDescription colour{.format = colour_format_,
                                       .samples = samples_,
                                       .loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR,
                                       .storeOp = VK_ATTACHMENT_STORE_OP_STORE,
                                       .stencilLoadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE,
                                       .stencilStoreOp = VK_ATTACHMENT_STORE_OP_DONT_CARE,
                                       .initialLayout = VK_IMAGE_LAYOUT_UNDEFINED,
                                       .finalLayout = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL};
  VkAttachmentDescription depth = colour;
  depth.format = depth_format();
  depth.stencilLoadOp = VK_ATTACHMENT_LOAD_OP_CLEAR;  // ignored without a stencil
  // Depth is kept only where it is the whole product; else the driver may leave it in its tiles.
  depth.storeOp = has_colour() ? VK_ATTACHMENT_STORE_OP_DONT_CARE : VK_ATTACHMENT_STORE_OP_STORE;
  depth.finalLayout = VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL;

  std::vector<VkAttachmentDescription> attachments;
  if (has_colour()) attachments.push_back(colour);
  if (has_depth()) attachments.push_back(depth);
  const VkAttachmentReference resolve_reference{static_cast<uint32_t>(attachments.size()),
                                                VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
  if (resolves()) {  // the samples stay in the tiles, their average is the product
    attachments.push_back(colour);
    attachments.back().samples = VK_SAMPLE_COUNT_1_BIT;
    attachments.back().loadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE;
    attachments[0].storeOp = VK_ATTACHMENT_STORE_OP_DONT_CARE;
    attachments[0].finalLayout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
  }
  const VkAttachmentReference colour_reference{0, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
  const VkAttachmentReference depth_reference{has_colour() ? 1u : 0u, VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL};
  const VkSubpassDescription subpass{.pipelineBindPoint = VK_PIPELINE_BIND_POINT_GRAPHICS,
                                     .colorAttachmentCount = has_colour() ? 1u : 0u,
                                     .pColorAttachments = has_colour() ? &colour_reference : nullptr,
                                     .pResolveAttachments = resolves() ? &resolve_reference : nullptr,
                                     .pDepthStencilAttachment = has_depth() ? &depth_reference : nullptr};
  constexpr VkPipelineStageFlags kAttachmentStages = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT |
                                                     VK_PIPELINE_STAGE_EARLY_FRAGMENT_TESTS_BIT |
                                                     VK_PIPELINE_STAGE_LATE_FRAGMENT_TESTS_BIT;
  constexpr VkAccessFlags kAttachmentWrites = VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT;
  constexpr VkAccessFlags kAttachmentReads = VK_ACCESS_COLOR_ATTACHMENT_READ_BIT | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_READ_BIT;
  const std::array<VkSubpassDependency, 2> dependencies{
      VkSubpassDependency{.srcSubpass = VK_SUBPASS_EXTERNAL,
                          .dstSubpass = 0,
                          .srcStageMask = kAttachmentStages | VK_PIPELINE_STAGE_TRANSFER_BIT,
                          .dstStageMask = kAttachmentStages,
                          .srcAccessMask = kAttachmentWrites,
                          .dstAccessMask = kAttachmentWrites | kAttachmentReads},
      VkSubpassDependency{.srcSubpass = 0,
                          .dstSubpass = VK_SUBPASS_EXTERNAL,
                          .srcStageMask = kAttachmentStages,
                          .dstStageMask = VK_PIPELINE_STAGE_TRANSFER_BIT,
                          .srcAccessMask = kAttachmentWrites,
                          .dstAccessMask = VK_ACCESS_TRANSFER_READ_BIT}};
  const VkRenderPassCreateInfo info{.sType = VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO,
                                    .attachmentCount = static_cast<uint32_t>(attachments.size()),
                                    .pAttachments = attachments.data(),
                                    .subpassCount = 1,
                                    .pSubpasses = &subpass,
                                    .dependencyCount = static_cast<uint32_t>(dependencies.size()),
                                    .pDependencies = dependencies.data()};
  VkRenderPass render_pass = VK_NULL_HANDLE;
  check(vkCreateRenderPass(context.device(), &info, nullptr, &render_pass), "vkCreateRenderPass");
  render_pass_ = {context.device(), render_pass};
}

void RenderTarget::begin(VkCommandBuffer commands, std::array<float, 4> clear_colour) const {
  std::vector<VkClearValue> clears;
  if (has_colour()) {
    VkClearValue& value = clears.emplace_back();
    std::memcpy(value.color.float32, clear_colour.data(), sizeof value.color.float32);
  }
  if (has_depth()) clears.emplace_back().depthStencil = {.depth = 1.0f, .stencil = 0};
  const VkRenderPassBeginInfo info{.sType = VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO,
                                   .renderPass = render_pass_,
                                   .framebuffer = framebuffer_,
                                   .renderArea = {{0, 0}, extent_},
                                   .clearValueCount = static_cast<uint32_t>(clears.size()),
                                   .pClearValues = clears.data()};
  vkCmdBeginRenderPass(commands, &info, VK_SUBPASS_CONTENTS_INLINE);
}

void make_visible_to_host(VkCommandBuffer commands, const Buffer& buffer, VkPipelineStageFlags stage, VkAccessFlags access) {
  const VkBufferMemoryBarrier barrier{.sType = VK_STRUCTURE_TYPE_BUFFER_MEMORY_BARRIER,
                                      .srcAccessMask = access,
                                      .dstAccessMask = VK_ACCESS_HOST_READ_BIT,
                                      .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
                                      .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
                                      .buffer = buffer.handle,
                                      .size = VK_WHOLE_SIZE};
  vkCmdPipelineBarrier(commands, stage, VK_PIPELINE_STAGE_HOST_BIT, 0, 0, nullptr, 1, &barrier, 0, nullptr);
}

std::vector<std::byte> read_back_bytes(VkContext& context, const Image2D& image, uint32_t bytes_per_pixel) {
  const auto [width, height] = image.extent;
  const VkDeviceSize size_bytes = VkDeviceSize{bytes_per_pixel} * width * height;
  const Buffer buffer = create_buffer(context, size_bytes, VK_BUFFER_USAGE_TRANSFER_DST_BIT);
  context.run_once([&](VkCommandBuffer commands) {
    const VkBufferImageCopy copy{.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1}, .imageExtent = {width, height, 1}};
    vkCmdCopyImageToBuffer(commands, image.handle, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, buffer.handle, 1, &copy);
    make_visible_to_host(commands, buffer, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT);
  });
  return {buffer.mapped, buffer.mapped + size_bytes};
}

Image read_back(VkContext& context, const Image2D& image) {
  const std::vector<std::byte> bytes = read_back_bytes(context, image, 4);
  Image result{.width = image.extent.width, .height = image.extent.height, .rgba = std::vector<uint8_t>(bytes.size())};
  std::memcpy(result.rgba.data(), bytes.data(), bytes.size());
  return result;
}

std::vector<float> read_back_floats(VkContext& context, const Image2D& image) {
  const std::vector<std::byte> bytes = read_back_bytes(context, image, 4 * sizeof(float));
  std::vector<float> result(bytes.size() / sizeof(float));
  std::memcpy(result.data(), bytes.data(), bytes.size());
  return result;
}

}  // namespace pineda::tools
