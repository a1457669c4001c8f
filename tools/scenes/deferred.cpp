// Deferred shading: one subpass fills three attachments of different formats, the next reads them as input attachments and adds
// the lights. They are not stored after it.
#include <array>
#include <cstdint>
#include <optional>

#include "shaders/deferred_frag.h"
#include "shaders/deferred_light_frag.h"
#include "shaders/deferred_vert.h"
#include "shaders/screen_vert.h"
#include "tools/scenes/scenes.h"

namespace pineda::tools {
namespace {

constexpr uint32_t kCubes = 24, kInputs = 3, kAttachments = kInputs + 2;  // the picture, the inputs, depth
constexpr std::array<VkFormat, kAttachments> kFormats{VK_FORMAT_R8G8B8A8_UNORM, VK_FORMAT_R8G8B8A8_UNORM,
                                                      VK_FORMAT_A2B10G10R10_UNORM_PACK32, VK_FORMAT_R16G16B16A16_SFLOAT,
                                                      VK_FORMAT_D32_SFLOAT};

class DeferredScene final : public Scene {
 public:
  void prepare(VkContext& context, VkExtent2D extent) override {
    extent_ = extent;
    std::array<VkImageView, kAttachments> views;
    for (uint32_t i = 0; i < kAttachments; ++i) {
      constexpr VkImageUsageFlags kInput = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_INPUT_ATTACHMENT_BIT;
      constexpr VkImageUsageFlags kPicture = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT;
      const bool is_depth = i + 1 == kAttachments;
      images_[i] = create_image(context, extent, 1, kFormats[i],
                                is_depth ? VkImageUsageFlags{VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT}
                                : i == 0 ? kPicture
                                         : kInput);
      views[i] = images_[i].view;
    }
    create_render_pass(context);
    const VkFramebufferCreateInfo info{.sType = VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO,
                                       .renderPass = render_pass_,
                                       .attachmentCount = kAttachments,
                                       .pAttachments = views.data(),
                                       .width = extent.width,
                                       .height = extent.height,
                                       .layers = 1};
    VkFramebuffer framebuffer = VK_NULL_HANDLE;
    check(vkCreateFramebuffer(context.device(), &info, nullptr, &framebuffer), "vkCreateFramebuffer");
    framebuffer_ = {context.device(), framebuffer};
    create_pipelines(context);
  }

  void record(VkCommandBuffer commands) const override {
    std::array<VkClearValue, kAttachments> clears{};
    clears[kAttachments - 1].depthStencil.depth = 1;
    const VkRenderPassBeginInfo info{.sType = VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO,
                                     .renderPass = render_pass_,
                                     .framebuffer = framebuffer_,
                                     .renderArea = {{0, 0}, extent_},
                                     .clearValueCount = kAttachments,
                                     .pClearValues = clears.data()};
    vkCmdBeginRenderPass(commands, &info, VK_SUBPASS_CONTENTS_INLINE);
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, fill_);
    vkCmdDraw(commands, 36, kCubes, 0, 0);
    vkCmdNextSubpass(commands, VK_SUBPASS_CONTENTS_INLINE);
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, light_);
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, layout_, 0, 1, &set_, 0, nullptr);
    vkCmdDraw(commands, 3, 1, 0, 0);
    vkCmdEndRenderPass(commands);
  }

  const Image2D& picture() const override { return images_[0]; }

 private:
  void create_render_pass(VkContext& context) {
    std::array<VkAttachmentDescription, kAttachments> attachments;
    for (uint32_t i = 0; i < kAttachments; ++i) {
      attachments[i] = {.format = kFormats[i],
                        .samples = VK_SAMPLE_COUNT_1_BIT,
                        .loadOp = i == 0 ? VK_ATTACHMENT_LOAD_OP_DONT_CARE : VK_ATTACHMENT_LOAD_OP_CLEAR,
                        .storeOp = i == 0 ? VK_ATTACHMENT_STORE_OP_STORE : VK_ATTACHMENT_STORE_OP_DONT_CARE,
                        .stencilLoadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE,
                        .stencilStoreOp = VK_ATTACHMENT_STORE_OP_DONT_CARE,
                        .initialLayout = VK_IMAGE_LAYOUT_UNDEFINED,
                        .finalLayout = i == 0                  ? VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL
                                       : i + 1 == kAttachments ? VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL
                                                               : VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
    }
    std::array<VkAttachmentReference, kInputs> outputs, inputs;
    for (uint32_t i = 0; i < kInputs; ++i) {
      outputs[i] = {i + 1, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
      inputs[i] = {i + 1, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
    }
    const VkAttachmentReference picture{0, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
    const VkAttachmentReference depth{kAttachments - 1, VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL};
    const std::array<VkSubpassDescription, 2> subpasses{VkSubpassDescription{.pipelineBindPoint = VK_PIPELINE_BIND_POINT_GRAPHICS,
                                                                             .colorAttachmentCount = kInputs,
                                                                             .pColorAttachments = outputs.data(),
                                                                             .pDepthStencilAttachment = &depth},
                                                        VkSubpassDescription{.pipelineBindPoint = VK_PIPELINE_BIND_POINT_GRAPHICS,
                                                                             .inputAttachmentCount = kInputs,
                                                                             .pInputAttachments = inputs.data(),
                                                                             .colorAttachmentCount = 1,
                                                                             .pColorAttachments = &picture}};
    constexpr VkPipelineStageFlags kOutput = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT,
                                   kDepth =
                                       VK_PIPELINE_STAGE_EARLY_FRAGMENT_TESTS_BIT | VK_PIPELINE_STAGE_LATE_FRAGMENT_TESTS_BIT,
                                   kFragment = VK_PIPELINE_STAGE_FRAGMENT_SHADER_BIT, kTransfer = VK_PIPELINE_STAGE_TRANSFER_BIT;
    constexpr VkAccessFlags kWrites = VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT,
                            kDepthAccess =
                                VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_READ_BIT | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT;
    const std::array<VkSubpassDependency, 4> dependencies{
        VkSubpassDependency{VK_SUBPASS_EXTERNAL, 0, kOutput | kDepth | kFragment, kOutput | kDepth, kWrites | kDepthAccess,
                            kWrites | kDepthAccess, 0},
        VkSubpassDependency{VK_SUBPASS_EXTERNAL, 1, kOutput | kTransfer, kOutput, kWrites, kWrites, 0},
        VkSubpassDependency{0, 1, kOutput, kFragment, kWrites, VK_ACCESS_INPUT_ATTACHMENT_READ_BIT, VK_DEPENDENCY_BY_REGION_BIT},
        VkSubpassDependency{1, VK_SUBPASS_EXTERNAL, kOutput, kTransfer, kWrites, VK_ACCESS_TRANSFER_READ_BIT, 0}};
    const VkRenderPassCreateInfo info{.sType = VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO,
                                      .attachmentCount = kAttachments,
                                      .pAttachments = attachments.data(),
                                      .subpassCount = static_cast<uint32_t>(subpasses.size()),
                                      .pSubpasses = subpasses.data(),
                                      .dependencyCount = static_cast<uint32_t>(dependencies.size()),
                                      .pDependencies = dependencies.data()};
    VkRenderPass render_pass = VK_NULL_HANDLE;
    check(vkCreateRenderPass(context.device(), &info, nullptr, &render_pass), "vkCreateRenderPass");
    render_pass_ = {context.device(), render_pass};
  }

  void create_pipelines(VkContext& context) {
    std::array<Binding, kInputs> bindings;
    for (uint32_t i = 0; i < kInputs; ++i) bindings[i] = {i, VK_DESCRIPTOR_TYPE_INPUT_ATTACHMENT, VK_SHADER_STAGE_FRAGMENT_BIT};
    set_layout_ = create_set_layout(context, bindings);
    descriptors_.emplace(context, 1, kInputs);
    set_ = descriptors_->allocate(set_layout_);
    for (uint32_t i = 0; i < kInputs; ++i) descriptors_->write_input_attachment(set_, i, images_[i + 1]);
    const VkDescriptorSetLayout set_layout = set_layout_;
    layout_ = create_pipeline_layout(context, {&set_layout, 1}, {});
    fill_ =
        create_graphics_pipeline(context, PipelineTarget{.render_pass = render_pass_, .extent = extent_, .colour_count = kInputs},
                                 {.vertex_shader = deferred_vert,
                                  .fragment_shader = deferred_frag,
                                  .depth_test = true,
                                  .depth_write = true,
                                  .layout = layout_});
    light_ = create_graphics_pipeline(context, PipelineTarget{.render_pass = render_pass_, .subpass = 1, .extent = extent_},
                                      {.vertex_shader = screen_vert, .fragment_shader = deferred_light_frag, .layout = layout_});
  }

  VkExtent2D extent_{};
  std::array<Image2D, kAttachments> images_;
  RenderPassHandle render_pass_;
  FramebufferHandle framebuffer_;
  std::optional<DescriptorAllocator> descriptors_;
  DescriptorSetLayoutHandle set_layout_;
  VkDescriptorSet set_ = VK_NULL_HANDLE;
  PipelineLayoutHandle layout_;
  PipelineHandle fill_, light_;
};

}  // namespace

std::unique_ptr<Scene> make_deferred_scene() { return std::make_unique<DeferredScene>(); }

}  // namespace pineda::tools
