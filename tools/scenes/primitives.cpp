// Every kind of primitive in a cell of its own: rows are topologies, then polygon modes; all are cut by a clip distance.
#include <array>
#include <cstdint>

#include "shaders/points_frag.h"
#include "shaders/primitives_frag.h"
#include "shaders/primitives_vert.h"
#include "tools/scenes/scenes.h"

namespace pineda::tools {
namespace {

struct Vertex {
  float position[2], colour[4];
};

constexpr uint32_t kVertexCount = 36;
constexpr uint32_t kColumns = 4, kRows = 3;

struct Cell {
  VkPrimitiveTopology topology;
  VkPolygonMode polygon_mode;
  float line_width;
};
constexpr std::array<Cell, kColumns * kRows> kCells{{
    {VK_PRIMITIVE_TOPOLOGY_POINT_LIST, VK_POLYGON_MODE_FILL, 1},
    {VK_PRIMITIVE_TOPOLOGY_LINE_LIST, VK_POLYGON_MODE_FILL, 1},
    {VK_PRIMITIVE_TOPOLOGY_LINE_STRIP, VK_POLYGON_MODE_FILL, 1},
    {VK_PRIMITIVE_TOPOLOGY_LINE_LIST, VK_POLYGON_MODE_FILL, 5},
    {VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST, VK_POLYGON_MODE_FILL, 1},
    {VK_PRIMITIVE_TOPOLOGY_TRIANGLE_STRIP, VK_POLYGON_MODE_FILL, 1},
    {VK_PRIMITIVE_TOPOLOGY_TRIANGLE_FAN, VK_POLYGON_MODE_FILL, 1},
    {VK_PRIMITIVE_TOPOLOGY_LINE_STRIP, VK_POLYGON_MODE_FILL, 3},
    {VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST, VK_POLYGON_MODE_LINE, 1},
    {VK_PRIMITIVE_TOPOLOGY_TRIANGLE_STRIP, VK_POLYGON_MODE_LINE, 2},
    {VK_PRIMITIVE_TOPOLOGY_TRIANGLE_FAN, VK_POLYGON_MODE_LINE, 1},
    {VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST, VK_POLYGON_MODE_POINT, 1},
}};

// Points all over the cell, from the golden section: near each other in number is far from each other in place.
std::array<Vertex, kVertexCount> make_vertices() {
  std::array<Vertex, kVertexCount> vertices;
  float u = 0.5f, v = 0.5f;
  for (Vertex& vertex : vertices) {
    u += 0.7548777f;  // the plastic number's powers (Roberts, "The Unreasonable Effectiveness of Quasirandom Sequences")
    v += 0.5698403f;
    u -= u >= 1 ? 1 : 0;
    v -= v >= 1 ? 1 : 0;
    vertex = {{2 * u - 1, 2 * v - 1}, {u, v, 1 - u, v * u}};
  }
  return vertices;
}

class PrimitivesScene final : public RenderScene {
 protected:
  void create(VkContext& context, const RenderTarget& target) override {
    vertices_ = create_buffer(context, make_vertices(), VK_BUFFER_USAGE_VERTEX_BUFFER_BIT);
    const VkPushConstantRange range{VK_SHADER_STAGE_VERTEX_BIT, 0, 16};
    layout_ = create_pipeline_layout(context, {}, {&range, 1});
    for (uint32_t i = 0; i < kCells.size(); ++i) {
      const Cell& cell = kCells[i];
      const bool points = cell.topology == VK_PRIMITIVE_TOPOLOGY_POINT_LIST;
      pipelines_[i] =
          create_graphics_pipeline(context, target,
                                   {.vertex_shader = primitives_vert,
                                    .fragment_shader = points ? Spirv(points_frag) : Spirv(primitives_frag),
                                    .vertex_bindings = {{0, sizeof(Vertex), VK_VERTEX_INPUT_RATE_VERTEX}},
                                    .vertex_attributes = {{0, 0, VK_FORMAT_R32G32_SFLOAT, offsetof(Vertex, position)},
                                                          {1, 0, VK_FORMAT_R32G32B32A32_SFLOAT, offsetof(Vertex, colour)}},
                                    .layout = layout_,
                                    .topology = cell.topology,
                                    .polygon_mode = cell.polygon_mode,
                                    .line_width = cell.line_width});
    }
  }
  void draw(VkCommandBuffer commands) const override {
    const VkDeviceSize offset = 0;
    const VkBuffer buffer = vertices_.handle;
    vkCmdBindVertexBuffers(commands, 0, 1, &buffer, &offset);
    for (uint32_t i = 0; i < kCells.size(); ++i) {
      const float width = 2.0f / kColumns, height = 2.0f / kRows;
      const float place[4] = {-1 + width * (static_cast<float>(i % kColumns) + 0.5f),
                              -1 + height * (static_cast<float>(i / kColumns) + 0.5f), 0.44f * width, 0.44f * height};
      vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipelines_[i]);
      vkCmdPushConstants(commands, layout_, VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof(place), place);
      vkCmdDraw(commands, kCells[i].topology == VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST ? kVertexCount : kVertexCount / 3, 1, 0, 0);
    }
  }

 private:
  Buffer vertices_;
  PipelineLayoutHandle layout_;
  std::array<PipelineHandle, kColumns * kRows> pipelines_;
};

}  // namespace

std::unique_ptr<Scene> make_primitives_scene() { return std::make_unique<PrimitivesScene>(); }

}  // namespace pineda::tools
