#include <cstdint>

#include "shaders/mandelbrot_comp.h"
#include "tools/scenes/scenes.h"

namespace pineda::tools {
namespace {

struct Window {  // the push constants of mandelbrot.comp
  float corner[2], step[2];
  uint32_t size[2];
  uint32_t max_iterations;
};

constexpr uint32_t kGroupSide = 16;

class MandelbrotScene final : public Scene {
 public:
  void prepare(VkContext& context, VkExtent2D extent) override {
    extent_ = extent;
    pixels_ = create_buffer(context, VkDeviceSize{4} * extent.width * extent.height,
                            VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT);
    picture_ = create_image(context, extent, 1, VK_FORMAT_R8G8B8A8_UNORM,
                            VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT | VK_IMAGE_USAGE_SAMPLED_BIT);
    const Binding binding{0, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, VK_SHADER_STAGE_COMPUTE_BIT};
    bound_.set_layout = create_set_layout(context, {&binding, 1});
    bound_.descriptors.emplace(context, 1, 1);
    bound_.set = bound_.descriptors->allocate(bound_.set_layout);
    bound_.descriptors->write_buffer(bound_.set, 0, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, pixels_);
    const VkDescriptorSetLayout set_layout = bound_.set_layout;
    const VkPushConstantRange range{VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof(Window)};
    bound_.layout = create_pipeline_layout(context, {&set_layout, 1}, {&range, 1});
    bound_.pipeline = create_compute_pipeline(context, mandelbrot_comp, bound_.layout);
  }

  void record(VkCommandBuffer commands) const override {
    const Window window = make_window();
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, bound_.pipeline);
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, bound_.layout, 0, 1, &bound_.set, 0, nullptr);
    vkCmdPushConstants(commands, bound_.layout, VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof window, &window);
    vkCmdDispatch(commands, (extent_.width + kGroupSide - 1) / kGroupSide, (extent_.height + kGroupSide - 1) / kGroupSide, 1);
    copy_to_picture(commands);
  }

  const Image2D& picture() const override { return picture_; }

 private:
  Window make_window() const {
    constexpr float kCentre[2] = {-0.72f, 0.0f};
    constexpr float kHeight = 2.36f;
    const float step = kHeight / static_cast<float>(extent_.height);
    return {.corner = {kCentre[0] - 0.5f * step * static_cast<float>(extent_.width),
                       kCentre[1] - 0.5f * step * static_cast<float>(extent_.height)},
            .step = {step, step},
            .size = {extent_.width, extent_.height},
            .max_iterations = 192};
  }

  void copy_to_picture(VkCommandBuffer commands) const {
    const VkBufferMemoryBarrier computed{.sType = VK_STRUCTURE_TYPE_BUFFER_MEMORY_BARRIER,
                                         .srcAccessMask = VK_ACCESS_SHADER_WRITE_BIT,
                                         .dstAccessMask = VK_ACCESS_TRANSFER_READ_BIT,
                                         .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
                                         .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
                                         .buffer = pixels_.handle,
                                         .size = VK_WHOLE_SIZE};
    vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT, 0, 0, nullptr, 1,
                         &computed, 0, nullptr);
    transition(commands, picture_, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_ACCESS_TRANSFER_READ_BIT,
               VK_ACCESS_TRANSFER_WRITE_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT);
    const VkBufferImageCopy copy{.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1},
                                 .imageExtent = {extent_.width, extent_.height, 1}};
    vkCmdCopyBufferToImage(commands, pixels_.handle, picture_.handle, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &copy);
    transition(commands, picture_, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
               VK_ACCESS_TRANSFER_WRITE_BIT, VK_ACCESS_TRANSFER_READ_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT,
               VK_PIPELINE_STAGE_TRANSFER_BIT);
  }

  VkExtent2D extent_{};
  Buffer pixels_;
  Image2D picture_;
  BoundPipeline bound_;
};

}  // namespace

std::unique_ptr<Scene> make_mandelbrot_scene() { return std::make_unique<MandelbrotScene>(); }

}  // namespace pineda::tools
