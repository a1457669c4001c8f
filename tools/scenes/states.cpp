// Scenes whose cells differ in fixed-function state: blending, stencil, depth bias, the modes of lines, primitive restart. A cell
// is a list of steps, each a pipeline and a range of vertices.
#include "tools/scenes/states.h"

#include <array>
#include <functional>
#include <vector>

#include "shaders/states_frag.h"
#include "shaders/states_vert.h"

namespace pineda::tools {
namespace {

struct Vertex {
  float position[3], colour[4];
};
using Colour = std::array<float, 4>;

struct Step {
  VkPrimitiveTopology topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
  std::vector<Vertex> vertices;
  std::vector<uint16_t> indices;  // with primitive restart; empty: none
  std::function<void(const PipelineParts&)> state;
};
using Cell = std::vector<Step>;

Vertex vertex(float x, float y, float z, const Colour& c) { return {{x, y, z}, {c[0], c[1], c[2], c[3]}}; }

// Two triangles; the corners have colours of their own.
std::vector<Vertex> quad(float half, float z_left, float z_right, const std::array<Colour, 4>& c) {
  const Vertex v[4] = {vertex(-half, -half, z_left, c[0]), vertex(half, -half, z_right, c[1]), vertex(-half, half, z_left, c[2]),
                       vertex(half, half, z_right, c[3])};
  return {v[0], v[1], v[2], v[2], v[1], v[3]};
}

constexpr Colour kWarm{0.93f, 0.42f, 0.2f, 1}, kCool{0.15f, 0.45f, 0.85f, 1}, kPale{0.9f, 0.9f, 0.8f, 1},
    kDark{0.1f, 0.12f, 0.2f, 1}, kLeaf{0.3f, 0.7f, 0.35f, 1};

// A closed star of five points that crosses itself, as a fan of triangles around its first point; constants, because libm may
// differ between machines.
std::vector<Vertex> star(float size, const Colour& colour) {
  constexpr float kPoints[5][2] = {
      {0, -1}, {0.5877853f, 0.8090170f}, {-0.9510565f, -0.3090170f}, {0.9510565f, -0.3090170f}, {-0.5877853f, 0.8090170f}};
  std::vector<Vertex> triangles;
  for (int i = 1; i + 1 < 5; ++i) {
    for (const int k : {0, i, i + 1}) triangles.push_back(vertex(size * kPoints[k][0], size * kPoints[k][1], 0.5f, colour));
  }
  return triangles;
}

// ---- blending: every factor and operation at least once ---------------------------------------------------------------------

std::vector<Cell> blend_cells() {
  struct Mode {
    VkBlendFactor source, target;
    VkBlendOp operation;
  };
  constexpr Mode kModes[] = {{VK_BLEND_FACTOR_SRC_ALPHA, VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA, VK_BLEND_OP_ADD},
                             {VK_BLEND_FACTOR_ONE, VK_BLEND_FACTOR_ONE, VK_BLEND_OP_ADD},
                             {VK_BLEND_FACTOR_DST_COLOR, VK_BLEND_FACTOR_ZERO, VK_BLEND_OP_ADD},
                             {VK_BLEND_FACTOR_ONE_MINUS_DST_COLOR, VK_BLEND_FACTOR_ONE, VK_BLEND_OP_ADD},
                             {VK_BLEND_FACTOR_SRC_COLOR, VK_BLEND_FACTOR_ONE_MINUS_SRC_COLOR, VK_BLEND_OP_ADD},
                             {VK_BLEND_FACTOR_DST_ALPHA, VK_BLEND_FACTOR_ONE_MINUS_DST_ALPHA, VK_BLEND_OP_ADD},
                             {VK_BLEND_FACTOR_CONSTANT_COLOR, VK_BLEND_FACTOR_ONE_MINUS_CONSTANT_COLOR, VK_BLEND_OP_ADD},
                             {VK_BLEND_FACTOR_CONSTANT_ALPHA, VK_BLEND_FACTOR_ONE_MINUS_CONSTANT_ALPHA, VK_BLEND_OP_ADD},
                             {VK_BLEND_FACTOR_SRC_ALPHA_SATURATE, VK_BLEND_FACTOR_ONE, VK_BLEND_OP_ADD},
                             {VK_BLEND_FACTOR_ONE, VK_BLEND_FACTOR_ONE, VK_BLEND_OP_SUBTRACT},
                             {VK_BLEND_FACTOR_ONE, VK_BLEND_FACTOR_ONE, VK_BLEND_OP_REVERSE_SUBTRACT},
                             {VK_BLEND_FACTOR_ONE, VK_BLEND_FACTOR_ONE, VK_BLEND_OP_MIN},
                             {VK_BLEND_FACTOR_ONE, VK_BLEND_FACTOR_ONE, VK_BLEND_OP_MAX},
                             {VK_BLEND_FACTOR_ZERO, VK_BLEND_FACTOR_SRC_ALPHA, VK_BLEND_OP_ADD},
                             {VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA, VK_BLEND_FACTOR_SRC_ALPHA, VK_BLEND_OP_ADD},
                             {VK_BLEND_FACTOR_ONE_MINUS_DST_ALPHA, VK_BLEND_FACTOR_DST_ALPHA, VK_BLEND_OP_REVERSE_SUBTRACT}};
  std::vector<Cell> cells;
  for (const Mode& mode : kModes) {
    Step under{.vertices = quad(0.95f, 0.5f, 0.5f, {kCool, kPale, Colour{0.2f, 0.1f, 0.3f, 0.25f}, kLeaf})};
    Step over{.vertices = quad(0.7f, 0.5f, 0.5f,
                               {Colour{1, 0.2f, 0, 1}, Colour{1, 0.8f, 0.2f, 0.1f}, Colour{0.4f, 0, 0.6f, 0.6f}, kWarm}),
              .state = [mode](const PipelineParts& p) {
                p.blend.blendEnable = VK_TRUE;
                p.blend.srcColorBlendFactor = p.blend.srcAlphaBlendFactor = mode.source;
                p.blend.dstColorBlendFactor = p.blend.dstAlphaBlendFactor = mode.target;
                p.blend.colorBlendOp = p.blend.alphaBlendOp = mode.operation;
              }};
    cells.push_back({under, over});
  }
  return cells;
}

// ---- stencil ----------------------------------------------------------------------------------------------------------------

std::function<void(const PipelineParts&)> stencil(VkCompareOp compare, VkStencilOp pass, uint32_t reference, bool draws = true) {
  return [=](const PipelineParts& p) {
    p.depth.stencilTestEnable = VK_TRUE;
    p.depth.front = p.depth.back = {.failOp = VK_STENCIL_OP_KEEP,
                                    .passOp = pass,
                                    .depthFailOp = VK_STENCIL_OP_KEEP,
                                    .compareOp = compare,
                                    .compareMask = 0xFF,
                                    .writeMask = 0xFF,
                                    .reference = reference};
    if (!draws) p.blend.colorWriteMask = 0;
  };
}

std::vector<Cell> stencil_cells() {
  const auto all = quad(1, 0.5f, 0.5f, {kPale, kWarm, kCool, kLeaf});
  Cell outline{{.vertices = star(0.75f, kWarm), .state = stencil(VK_COMPARE_OP_ALWAYS, VK_STENCIL_OP_REPLACE, 1)},
               {.vertices = star(0.95f, kDark), .state = stencil(VK_COMPARE_OP_NOT_EQUAL, VK_STENCIL_OP_KEEP, 1)}};
  Cell parity{{.vertices = star(0.95f, kWarm), .state = stencil(VK_COMPARE_OP_ALWAYS, VK_STENCIL_OP_INVERT, 0, false)},
              {.vertices = all, .state = stencil(VK_COMPARE_OP_EQUAL, VK_STENCIL_OP_KEEP, 0xFF)}};
  Cell depth_complexity{
      {.vertices = star(0.95f, kWarm), .state = stencil(VK_COMPARE_OP_ALWAYS, VK_STENCIL_OP_INCREMENT_AND_CLAMP, 0, false)},
      {.vertices = star(-0.8f, kWarm), .state = stencil(VK_COMPARE_OP_ALWAYS, VK_STENCIL_OP_INCREMENT_AND_WRAP, 0, false)}};
  constexpr Colour kByCount[] = {kDark, kCool, kLeaf, kPale, kWarm, kDark};
  for (uint32_t count = 1; count <= 5; ++count) {
    const Colour& c = kByCount[count];
    depth_complexity.push_back(
        {.vertices = quad(1, 0.5f, 0.5f, {c, c, c, c}), .state = stencil(VK_COMPARE_OP_EQUAL, VK_STENCIL_OP_KEEP, count)});
  }
  Cell hole{{.vertices = star(0.6f, kWarm), .state = stencil(VK_COMPARE_OP_ALWAYS, VK_STENCIL_OP_DECREMENT_AND_WRAP, 0, false)},
            {.vertices = all, .state = stencil(VK_COMPARE_OP_GREATER, VK_STENCIL_OP_ZERO, 0x80)}};
  return {outline, parity, depth_complexity, hole};
}

// ---- depth bias ---------------------------------------------------------------------------------------------------------------

// A slanted plane, and the same plane as a decal under another bias: in front of it where the bias is negative.
std::vector<Cell> depth_bias_cells() {
  std::vector<Cell> cells;
  struct Bias {
    float constant, slope;
  };
  for (const Bias& bias : {Bias{-8, 0}, Bias{8, 0}, Bias{0, -1}, Bias{0, 1}, Bias{-64, 0.001f}, Bias{65536, -2}}) {
    const auto state = [bias](const PipelineParts& p) {
      p.depth.depthTestEnable = p.depth.depthWriteEnable = VK_TRUE;
      p.depth.depthCompareOp = VK_COMPARE_OP_LESS;
      p.rasterization.depthBiasEnable = VK_TRUE;
      p.rasterization.depthBiasConstantFactor = bias.constant;
      p.rasterization.depthBiasSlopeFactor = bias.slope;
    };
    const auto plain = [](const PipelineParts& p) {
      p.depth.depthTestEnable = p.depth.depthWriteEnable = VK_TRUE;
      p.depth.depthCompareOp = VK_COMPARE_OP_LESS;
    };
    cells.push_back({{.vertices = quad(0.9f, 0.25f, 0.75f, {kCool, kPale, kCool, kPale}), .state = plain},
                     {.vertices = quad(0.9f, 0.25f, 0.75f, {kWarm, kWarm, kLeaf, kLeaf}), .state = state}});
  }
  return cells;
}

// ---- lines --------------------------------------------------------------------------------------------------------------------

std::vector<Vertex> spokes() {
  std::vector<Vertex> lines;
  constexpr float kTurn[2] = {0.9238795f, 0.3826834f};  // 22.5 degrees
  float x = 1, y = 0.07f;
  for (int i = 0; i < 16; ++i) {
    lines.push_back(vertex(0.15f * x, 0.15f * y, 0.5f, kPale));
    lines.push_back(vertex(0.9f * x, 0.9f * y, 0.5f, i % 2 == 0 ? kWarm : kCool));
    const float next = x * kTurn[0] - y * kTurn[1];
    y = x * kTurn[1] + y * kTurn[0];
    x = next;
  }
  return lines;
}

// Rows: rectangular, Bresenham, smooth. Columns: thin, wide, stippled, stippled and wide.
std::vector<Cell> line_cells() {
  std::vector<Cell> cells;
  for (const VkLineRasterizationModeEXT mode :
       {VK_LINE_RASTERIZATION_MODE_RECTANGULAR_EXT, VK_LINE_RASTERIZATION_MODE_BRESENHAM_EXT,
        VK_LINE_RASTERIZATION_MODE_RECTANGULAR_SMOOTH_EXT}) {
    for (int column = 0; column < 4; ++column) {
      const bool stippled = column >= 2, wide = column % 2 == 1;
      const auto state = [=](const PipelineParts& p) {
        p.line.lineRasterizationMode = mode;
        p.line.stippledLineEnable = stippled;
        p.line.lineStippleFactor = 2;
        p.line.lineStipplePattern = 0x5F35;
        p.rasterization.pNext = &p.line;
        p.rasterization.lineWidth = wide ? 5 : 1;
        p.blend.blendEnable = mode == VK_LINE_RASTERIZATION_MODE_RECTANGULAR_SMOOTH_EXT;
      };
      cells.push_back({{.topology = VK_PRIMITIVE_TOPOLOGY_LINE_LIST, .vertices = spokes(), .state = state}});
    }
  }
  return cells;
}

// ---- primitive restart --------------------------------------------------------------------------------------------------------

std::vector<Cell> restart_cells() {
  std::vector<Vertex> grid;
  for (int i = 0; i < 25; ++i) {
    const float x = static_cast<float>(i % 5) * 0.4f - 0.8f, y = static_cast<float>(i / 5) * 0.4f - 0.8f;
    grid.push_back(vertex(x, y, 0.5f, {static_cast<float>(i % 5) / 4, static_cast<float>(i / 5) / 4, (i * 7 % 5) / 4.0f, 1}));
  }
  constexpr uint16_t kCut = 0xFFFF;
  const std::vector<uint16_t> strips{0,  5,  1,    6,  2,  kCut, 3,  8,  4,  9,    kCut, kCut, 10,
                                     15, 11, kCut, 12, 17, 13,   18, 14, 19, kCut, 20,   21};
  const std::vector<uint16_t> fans{6, 0, 1, 2, 7, 12, kCut, 18, 13, 14, 19, 24, 23, kCut, 15, 16, 21, 20};
  const std::vector<uint16_t> lines{0, 6, 12, 18, 24, kCut, 4, 8, kCut, 20, 16, 22, 18, kCut, 10, kCut, 2, 14, 22, 10, 2};
  std::vector<Cell> cells;
  for (const auto& [topology, indices] : {std::pair{VK_PRIMITIVE_TOPOLOGY_TRIANGLE_STRIP, strips},
                                          {VK_PRIMITIVE_TOPOLOGY_TRIANGLE_FAN, fans},
                                          {VK_PRIMITIVE_TOPOLOGY_LINE_STRIP, lines}}) {
    cells.push_back({{.topology = topology, .vertices = grid, .indices = indices}});
  }
  return cells;
}

// ---- the scene ----------------------------------------------------------------------------------------------------------------

class StatesScene final : public RenderScene {
 public:
  StatesScene(std::vector<Cell> cells, uint32_t columns, RenderTarget::Attachments attachments)
      : RenderScene(attachments), cells_(std::move(cells)), columns_(columns) {}

 protected:
  void create(VkContext& context, const RenderTarget& target) override {
    const VkPushConstantRange range{VK_SHADER_STAGE_VERTEX_BIT, 0, 16};
    layout_ = create_pipeline_layout(context, {}, {&range, 1});
    std::vector<Vertex> vertices;
    std::vector<uint16_t> indices;
    for (size_t cell = 0; cell < cells_.size(); ++cell) {
      for (const Step& step : cells_[cell]) {
        Draw& draw = draws_.emplace_back();
        draw.cell = static_cast<uint32_t>(cell);
        draw.first_vertex = static_cast<uint32_t>(vertices.size());
        draw.first_index = static_cast<uint32_t>(indices.size());
        draw.vertex_count = static_cast<uint32_t>(step.vertices.size());
        draw.index_count = static_cast<uint32_t>(step.indices.size());
        vertices.insert(vertices.end(), step.vertices.begin(), step.vertices.end());
        indices.insert(indices.end(), step.indices.begin(), step.indices.end());
        draw.pipeline =
            create_graphics_pipeline(context, target,
                                     {.vertex_shader = states_vert,
                                      .fragment_shader = states_frag,
                                      .vertex_bindings = {{0, sizeof(Vertex), VK_VERTEX_INPUT_RATE_VERTEX}},
                                      .vertex_attributes = {{0, 0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(Vertex, position)},
                                                            {1, 0, VK_FORMAT_R32G32B32A32_SFLOAT, offsetof(Vertex, colour)}},
                                      .layout = layout_,
                                      .topology = step.topology,
                                      .adjust = [&](const PipelineParts& parts) {
                                        parts.assembly.primitiveRestartEnable = !step.indices.empty();
                                        if (step.state) step.state(parts);
                                      }});
      }
    }
    indices.push_back(0);  // never empty
    vertices_ = create_buffer(context, vertices, VK_BUFFER_USAGE_VERTEX_BUFFER_BIT);
    indices_ = create_buffer(context, indices, VK_BUFFER_USAGE_INDEX_BUFFER_BIT);
  }
  void draw(VkCommandBuffer commands) const override {
    const VkDeviceSize offset = 0;
    const VkBuffer buffer = vertices_.handle;
    vkCmdBindVertexBuffers(commands, 0, 1, &buffer, &offset);
    vkCmdBindIndexBuffer(commands, indices_.handle, 0, VK_INDEX_TYPE_UINT16);
    const auto rows = static_cast<uint32_t>((cells_.size() + columns_ - 1) / columns_);
    const float width = 2.0f / static_cast<float>(columns_), height = 2.0f / static_cast<float>(rows);
    for (const Draw& draw : draws_) {
      const float place[4] = {-1 + width * (static_cast<float>(draw.cell % columns_) + 0.5f),
                              -1 + height * (static_cast<float>(draw.cell / columns_) + 0.5f), 0.46f * width, 0.46f * height};
      vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, draw.pipeline);
      vkCmdPushConstants(commands, layout_, VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof(place), place);
      if (draw.index_count != 0) {
        vkCmdDrawIndexed(commands, draw.index_count, 1, draw.first_index, static_cast<int32_t>(draw.first_vertex), 0);
      } else {
        vkCmdDraw(commands, draw.vertex_count, 1, draw.first_vertex, 0);
      }
    }
  }
  std::array<float, 4> clear_colour() const override { return {0.2f, 0.22f, 0.26f, 1}; }

 private:
  struct Draw {
    uint32_t cell, first_vertex, first_index, vertex_count, index_count;
    PipelineHandle pipeline;
  };
  std::vector<Cell> cells_;
  uint32_t columns_;
  std::vector<Draw> draws_;
  Buffer vertices_, indices_;
  PipelineLayoutHandle layout_;
};

}  // namespace

std::unique_ptr<Scene> make_states_scene(StatesKind kind) {
  using Attachments = RenderTarget::Attachments;
  switch (kind) {
    case StatesKind::kBlendModes:
      return std::make_unique<StatesScene>(blend_cells(), 4, Attachments::kColour);
    case StatesKind::kStencil:
      return std::make_unique<StatesScene>(stencil_cells(), 2, Attachments::kColourStencil);
    case StatesKind::kDepthBias:
      return std::make_unique<StatesScene>(depth_bias_cells(), 3, Attachments::kColourDepth);
    case StatesKind::kLineModes:
      return std::make_unique<StatesScene>(line_cells(), 4, Attachments::kColour);
    case StatesKind::kRestart:
      return std::make_unique<StatesScene>(restart_cells(), 3, Attachments::kColour);
  }
  return nullptr;
}

}  // namespace pineda::tools
