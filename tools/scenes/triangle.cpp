#include <array>
#include <cstdint>

#include "shaders/triangle_frag.h"
#include "shaders/triangle_vert.h"
#include "tools/scenes/scenes.h"

namespace pineda::tools {
namespace {

struct Vertex {
  float position[2], colour[3];
};

constexpr std::array<Vertex, 3> kVertices{{
    {{0.0f, -0.78f}, {1.00f, 0.33f, 0.29f}},
    {{0.72f, 0.70f}, {0.20f, 0.85f, 0.50f}},
    {{-0.72f, 0.70f}, {0.25f, 0.45f, 1.00f}},
}};

class TriangleScene final : public RenderScene {
 protected:
  void create(VkContext& context, const RenderTarget& target) override {
    vertices_ = create_buffer(context, kVertices, VK_BUFFER_USAGE_VERTEX_BUFFER_BIT);
    layout_ = create_pipeline_layout(context, {}, {});
    pipeline_ = create_graphics_pipeline(context, target,
                                         {.vertex_shader = triangle_vert,
                                          .fragment_shader = triangle_frag,
                                          .vertex_bindings = {{0, sizeof(Vertex), VK_VERTEX_INPUT_RATE_VERTEX}},
                                          .vertex_attributes = {{0, 0, VK_FORMAT_R32G32_SFLOAT, offsetof(Vertex, position)},
                                                                {1, 0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(Vertex, colour)}},
                                          .layout = layout_});
  }
  void draw(VkCommandBuffer commands) const override {
    const VkDeviceSize offset = 0;
    const VkBuffer buffer = vertices_.handle;
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline_);
    vkCmdBindVertexBuffers(commands, 0, 1, &buffer, &offset);
    vkCmdDraw(commands, 3, 1, 0, 0);
  }
  std::array<float, 4> clear_colour() const override { return {0.075f, 0.086f, 0.114f, 1.0f}; }

 private:
  Buffer vertices_;
  PipelineLayoutHandle layout_;
  PipelineHandle pipeline_;
};

}  // namespace

std::unique_ptr<Scene> make_triangle_scene() { return std::make_unique<TriangleScene>(); }

}  // namespace pineda::tools
