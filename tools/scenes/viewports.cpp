// Sixteen viewports that the vertex shader chooses from: at odd places, upside down, with reversed and narrow depth ranges, each
// with a scissor.
#include <cstdint>

#include "shaders/viewports_frag.h"
#include "shaders/viewports_vert.h"
#include "tools/error.h"
#include "tools/scenes/scenes.h"

namespace pineda::tools {
namespace {

constexpr uint32_t kColumns = 4, kViewports = kColumns * kColumns;

class ViewportsScene final : public RenderScene {
 public:
  ViewportsScene() : RenderScene(RenderTarget::Attachments::kColourDepth) {}

 protected:
  void create(VkContext& context, const RenderTarget& target) override {
    if (!context.has_viewport_index()) fail("the driver lacks VK_EXT_shader_viewport_index_layer or 16 viewports");
    layout_ = create_pipeline_layout(context, {}, {});
    GraphicsPipelineDesc desc{.vertex_shader = viewports_vert,
                              .fragment_shader = viewports_frag,
                              .depth_test = true,
                              .depth_write = true,
                              .layout = layout_};
    for (uint32_t i = 0; i < kViewports; ++i) add_viewport(target.extent(), i, desc);
    pipeline_ = create_graphics_pipeline(context, target, desc);
  }
  void draw(VkCommandBuffer commands) const override {
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline_);
    vkCmdDraw(commands, 12, kViewports, 0, 0);
  }
  std::array<float, 4> clear_colour() const override { return {0.2f, 0.22f, 0.26f, 1}; }

 private:
  static void add_viewport(VkExtent2D extent, uint32_t i, GraphicsPipelineDesc& desc) {
    constexpr float kDepthRanges[4][2] = {{0, 1}, {1, 0}, {0.25f, 0.5f}, {0.9f, 0.1f}};
    const float width = static_cast<float>(extent.width) / kColumns, height = static_cast<float>(extent.height) / kColumns;
    const auto column = static_cast<float>(i % kColumns), row = static_cast<float>(i / kColumns);
    const auto& [min_depth, max_depth] = kDepthRanges[i / kColumns];
    VkViewport viewport{
        (column + 0.06f) * width + 0.37f, (row + 0.06f) * height + 0.21f, 0.88f * width, 0.88f * height, min_depth, max_depth};
    if (i % 5 == 2) {  // upside down
      viewport.y += viewport.height;
      viewport.height = -viewport.height;
    }
    VkRect2D scissor{{0, 0}, extent};
    if (i % 3 == 1) {  // a part of the cell
      scissor = {{static_cast<int32_t>((column + 0.2f) * width), static_cast<int32_t>((row + 0.1f) * height)},
                 {static_cast<uint32_t>(0.5f * width), static_cast<uint32_t>(0.75f * height)}};
    }
    if (i % 7 == 6) {  // twice as wide as its cell, which the scissor keeps
      viewport.x -= 0.5f * width;
      viewport.width += width;
      scissor = {{static_cast<int32_t>(column * width), static_cast<int32_t>(row * height)},
                 {static_cast<uint32_t>(width), static_cast<uint32_t>(height)}};
    }
    desc.viewports.push_back(viewport);
    desc.scissors.push_back(scissor);
  }

  PipelineLayoutHandle layout_;
  PipelineHandle pipeline_;
};

}  // namespace

std::unique_ptr<Scene> make_viewports_scene() { return std::make_unique<ViewportsScene>(); }

}  // namespace pineda::tools
