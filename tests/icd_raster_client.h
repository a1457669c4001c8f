// A render pass of one subpass over images of its own, any of which may be left out, for tests of what rasterization does.
#pragma once

#include "icd_pipeline_client.h"
#include "icd_raster_shaders.h"
#include "icd_shaders.h"

namespace pineda::test {

struct TargetInfo {
  uint32_t width = 16, height = 16, layers = 1, samples = 1;
  VkFormat color = VK_FORMAT_R8G8B8A8_UNORM, depth = VK_FORMAT_UNDEFINED;  // UNDEFINED: none
  bool resolves = false;
  VkResolveModeFlagBits depth_resolve = VK_RESOLVE_MODE_NONE, stencil_resolve = VK_RESOLVE_MODE_NONE;
};

class RasterClient : public PipelineClient {
 public:
  explicit RasterClient(const TargetInfo& target, std::initializer_list<const char*> extensions = {})
      : PipelineClient(nullptr, {}, extensions), info(target) {
    EXPECT_EQ(result, VK_SUCCESS);
    whole = {{0, 0}, {info.width, info.height}};
    const auto color_reference = add(info.color, info.samples, &color);
    const auto depth_reference = add(info.depth, info.samples, &depth);
    const auto resolve_reference = info.resolves ? add(info.color, 1, &resolved) : unused();
    const bool resolves_depth = info.depth_resolve || info.stencil_resolve;
    const auto depth_resolve_reference = resolves_depth ? add(info.depth, 1, &resolved_depth) : unused();
    const VkSubpassDescriptionDepthStencilResolve depth_resolve{VK_STRUCTURE_TYPE_SUBPASS_DESCRIPTION_DEPTH_STENCIL_RESOLVE,
                                                                nullptr, info.depth_resolve, info.stencil_resolve,
                                                                &depth_resolve_reference};
    VkSubpassDescription2 subpass{VK_STRUCTURE_TYPE_SUBPASS_DESCRIPTION_2, resolves_depth ? &depth_resolve : nullptr};
    subpass.colorAttachmentCount = info.color == VK_FORMAT_UNDEFINED ? 0 : 1;
    subpass.pColorAttachments = &color_reference;
    subpass.pResolveAttachments = info.resolves ? &resolve_reference : nullptr;
    subpass.pDepthStencilAttachment = &depth_reference;
    VkRenderPassCreateInfo2 create{VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO_2};
    create.attachmentCount = static_cast<uint32_t>(attachments_.size());
    create.pAttachments = attachments_.data();
    create.subpassCount = 1;
    create.pSubpasses = &subpass;
    const std::vector<VkSubpassDependency2> dependencies = dependencies2_of(1);
    create.dependencyCount = static_cast<uint32_t>(dependencies.size());
    create.pDependencies = dependencies.data();
    EXPECT_EQ(VK(*this, CreateRenderPass2KHR)(device, &create, nullptr, &pass), VK_SUCCESS);
    defer([this] { VK(*this, DestroyRenderPass)(device, pass, nullptr); });
    VkFramebufferCreateInfo frame_info{VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO};
    frame_info.renderPass = pass;
    frame_info.attachmentCount = static_cast<uint32_t>(views_.size());
    frame_info.pAttachments = views_.data();
    frame_info.width = info.width;
    frame_info.height = info.height;
    frame_info.layers = info.layers;
    EXPECT_EQ(VK(*this, CreateFramebuffer)(device, &frame_info, nullptr, &frame), VK_SUCCESS);
    defer([this] { VK(*this, DestroyFramebuffer)(device, frame, nullptr); });
    layout = pipeline_layout(std::nullopt, 16);
    vertices = buffer(4096);
    pixels = buffer(size_t{info.width} * info.height * info.layers * 8);
  }

  // Vertices of 4 floats: x and y in pixels, and what the shader makes of the other two.
  void set_vertices(std::vector<std::array<float, 4>> list) {
    for (size_t i = 0; i < list.size(); ++i) {
      list[i][0] = list[i][0] * 2 / static_cast<float>(info.width) - 1;
      list[i][1] = list[i][1] * 2 / static_cast<float>(info.height) - 1;
      std::memcpy(vertices.data + i * 16, list[i].data(), 16);
    }
  }
  // A triangle over all pixels.
  void set_cover(float u = 0, float v = 0) {
    const auto w = static_cast<float>(info.width), h = static_cast<float>(info.height);
    set_vertices({{0, 0, u, v}, {2 * w, 0, u, v}, {0, 2 * h, u, v}});
  }

  VkPipeline pipeline(Drawing drawing, std::span<const uint32_t> vertex, std::span<const uint32_t> fragment) {
    drawing.layout = layout;
    if (!drawing.pass) drawing.pass = pass;
    drawing.vertex = module(vertex);
    drawing.fragment = module(fragment);
    if (drawing.samples == 1) drawing.samples = info.samples;
    VkPipeline out = VK_NULL_HANDLE;
    EXPECT_EQ(graphics_pipeline(drawing, &out), VK_SUCCESS);
    return out;
  }

  void begin(VkCommandBuffer cb, VkSubpassContents contents = VK_SUBPASS_CONTENTS_INLINE) {
    begin_pass(cb, pass, frame, whole, std::vector<VkClearValue>(attachments_.size(), clear), contents);
  }
  using Client::begin;
  void bind(VkCommandBuffer cb, VkPipeline with, std::array<float, 4> constants = {}) {
    VK(*this, CmdBindPipeline)(cb, VK_PIPELINE_BIND_POINT_GRAPHICS, with);
    const VkViewport viewport{0, 0, static_cast<float>(info.width), static_cast<float>(info.height), 0, 1};
    VK(*this, CmdSetViewport)(cb, 0, 1, &viewport);
    VK(*this, CmdSetScissor)(cb, 0, 1, &whole);
    const VkDeviceSize zero = 0;
    VK(*this, CmdBindVertexBuffers)(cb, 0, 1, &vertices.handle, &zero);
    VK(*this, CmdPushConstants)(cb, layout, VK_SHADER_STAGE_ALL, 0, 16, constants.data());
  }
  void end(VkCommandBuffer cb) { VK(*this, CmdEndRenderPass)(cb); }
  void download(VkCommandBuffer cb, VkImage from, VkImageAspectFlags aspect = VK_IMAGE_ASPECT_COLOR_BIT) {
    const VkBufferImageCopy region{0, 0, 0, {aspect, 0, 0, info.layers}, {}, {info.width, info.height, 1}};
    VK(*this, CmdCopyImageToBuffer)(cb, from, VK_IMAGE_LAYOUT_GENERAL, pixels.handle, 1, &region);
  }
  template <typename T = uint32_t>
  T at(uint32_t x, uint32_t y, uint32_t layer = 0) const {
    return pixels.as<T>()[(size_t{layer} * info.height + y) * info.width + x];
  }

  const TargetInfo info;
  VkRect2D whole{};
  VkClearValue clear{};
  VkImage color = VK_NULL_HANDLE, depth = VK_NULL_HANDLE, resolved = VK_NULL_HANDLE, resolved_depth = VK_NULL_HANDLE;
  VkRenderPass pass = VK_NULL_HANDLE;
  VkFramebuffer frame = VK_NULL_HANDLE;
  VkPipelineLayout layout = VK_NULL_HANDLE;
  Buffer pixels, vertices;

 private:
  static VkAttachmentReference2 unused() {
    return {VK_STRUCTURE_TYPE_ATTACHMENT_REFERENCE_2, nullptr, VK_ATTACHMENT_UNUSED, VK_IMAGE_LAYOUT_GENERAL, 0};
  }

  VkAttachmentReference2 add(VkFormat format, uint32_t samples, VkImage* out) {
    if (format == VK_FORMAT_UNDEFINED) return unused();
    const bool has_stencil =
        format == VK_FORMAT_S8_UINT || format == VK_FORMAT_D24_UNORM_S8_UINT || format == VK_FORMAT_D32_SFLOAT_S8_UINT;
    const bool is_color = format == info.color;
    VkImageAspectFlags aspects = VK_IMAGE_ASPECT_COLOR_BIT;
    if (!is_color) {
      aspects = (has_stencil ? uint32_t{VK_IMAGE_ASPECT_STENCIL_BIT} : 0u) |
                (format == VK_FORMAT_S8_UINT ? 0u : uint32_t{VK_IMAGE_ASPECT_DEPTH_BIT});
    }
    VkImageCreateInfo create{VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO};
    create.imageType = VK_IMAGE_TYPE_2D;
    create.format = format;
    create.extent = {info.width, info.height, 1};
    create.mipLevels = 1;
    create.arrayLayers = info.layers;
    create.samples = static_cast<VkSampleCountFlagBits>(samples);
    create.usage = VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_INPUT_ATTACHMENT_BIT |
                   (is_color ? VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT : VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT);
    EXPECT_EQ(VK(*this, CreateImage)(device, &create, nullptr, out), VK_SUCCESS);
    VkMemoryRequirements requirements;
    VK(*this, GetImageMemoryRequirements)(device, *out, &requirements);
    EXPECT_EQ(VK(*this, BindImageMemory)(device, *out, memory(requirements.size), 0), VK_SUCCESS);
    defer([this, image = *out] { VK(*this, DestroyImage)(device, image, nullptr); });
    views_.push_back(array_view(*out, format, aspects));
    attachments_.push_back({VK_STRUCTURE_TYPE_ATTACHMENT_DESCRIPTION_2, nullptr, 0, format, create.samples,
                            VK_ATTACHMENT_LOAD_OP_CLEAR, VK_ATTACHMENT_STORE_OP_STORE, VK_ATTACHMENT_LOAD_OP_CLEAR,
                            VK_ATTACHMENT_STORE_OP_STORE, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_GENERAL});
    return {VK_STRUCTURE_TYPE_ATTACHMENT_REFERENCE_2, nullptr, static_cast<uint32_t>(views_.size() - 1), VK_IMAGE_LAYOUT_GENERAL,
            aspects};
  }

  std::vector<VkAttachmentDescription2> attachments_;
  std::vector<VkImageView> views_;

 public:
  VkImageView array_view(VkImage image, VkFormat format, VkImageAspectFlags aspects) {
    VkImageViewCreateInfo create{VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO};
    create.image = image;
    create.viewType = info.layers > 1 ? VK_IMAGE_VIEW_TYPE_2D_ARRAY : VK_IMAGE_VIEW_TYPE_2D;
    create.format = format;
    create.subresourceRange = {aspects, 0, 1, 0, info.layers};
    VkImageView out = VK_NULL_HANDLE;
    EXPECT_EQ(VK(*this, CreateImageView)(device, &create, nullptr, &out), VK_SUCCESS);
    defer([this, out] { VK(*this, DestroyImageView)(device, out, nullptr); });
    return out;
  }
};

}  // namespace pineda::test
