#include <array>
#include <cstdint>

#include "shaders/blend_frag.h"
#include "shaders/blend_vert.h"
#include "tools/scenes/scenes.h"

namespace pineda::tools {
namespace {

struct Vertex {
  float position[2], colour[4];
};

constexpr int kQuadCount = 12;
constexpr float kCos30 = 0.8660254f, kSin30 = 0.5f;  // a turn by one quad; constants, because libm may differ between machines

constexpr std::array<std::array<float, 3>, kQuadCount> kHues{{{0.93f, 0.26f, 0.27f},
                                                              {0.96f, 0.47f, 0.20f},
                                                              {0.98f, 0.69f, 0.19f},
                                                              {0.86f, 0.84f, 0.24f},
                                                              {0.50f, 0.80f, 0.33f},
                                                              {0.20f, 0.73f, 0.49f},
                                                              {0.13f, 0.71f, 0.71f},
                                                              {0.20f, 0.58f, 0.86f},
                                                              {0.30f, 0.43f, 0.90f},
                                                              {0.48f, 0.35f, 0.88f},
                                                              {0.69f, 0.32f, 0.80f},
                                                              {0.88f, 0.29f, 0.56f}}};

// A wheel of cards: each lies over its neighbours, clearer towards the hub.
std::array<Vertex, 4 * kQuadCount> make_vertices(float aspect) {
  constexpr float kHub = 0.16f, kRim = 0.90f, kHubHalfWidth = 0.12f, kRimHalfWidth = 0.31f;
  constexpr float kCorners[4][2] = {{kHub, -kHubHalfWidth}, {kRim, -kRimHalfWidth}, {kRim, kRimHalfWidth}, {kHub, kHubHalfWidth}};
  std::array<Vertex, 4 * kQuadCount> vertices;
  float cosine = 0, sine = -1;  // the first points up
  for (int quad = 0; quad < kQuadCount; ++quad) {
    for (int corner = 0; corner < 4; ++corner) {
      const auto [along, across] = kCorners[corner];
      const float alpha = along == kHub ? 0.45f : 0.62f;
      vertices[4 * quad + corner] = {{(along * cosine - across * sine) / aspect, along * sine + across * cosine},
                                     {kHues[quad][0], kHues[quad][1], kHues[quad][2], alpha}};
    }
    const float next = cosine * kCos30 - sine * kSin30;
    sine = cosine * kSin30 + sine * kCos30;
    cosine = next;
  }
  return vertices;
}

std::array<uint16_t, 6 * kQuadCount> make_indices() {
  std::array<uint16_t, 6 * kQuadCount> indices;
  constexpr int kQuad[6] = {0, 1, 2, 0, 2, 3};
  for (int i = 0; i < 6 * kQuadCount; ++i) indices[i] = static_cast<uint16_t>(4 * (i / 6) + kQuad[i % 6]);
  return indices;
}

class BlendScene final : public RenderScene {
 protected:
  void create(VkContext& context, const RenderTarget& target) override {
    const auto [width, height] = target.extent();
    const auto vertices = make_vertices(static_cast<float>(width) / static_cast<float>(height));
    vertices_ = create_buffer(context, vertices, VK_BUFFER_USAGE_VERTEX_BUFFER_BIT);
    indices_ = create_buffer(context, make_indices(), VK_BUFFER_USAGE_INDEX_BUFFER_BIT);
    layout_ = create_pipeline_layout(context, {}, {});
    pipeline_ = create_graphics_pipeline(context, target,
                                         {.vertex_shader = blend_vert,
                                          .fragment_shader = blend_frag,
                                          .vertex_bindings = {{0, sizeof(Vertex), VK_VERTEX_INPUT_RATE_VERTEX}},
                                          .vertex_attributes = {{0, 0, VK_FORMAT_R32G32_SFLOAT, offsetof(Vertex, position)},
                                                                {1, 0, VK_FORMAT_R32G32B32A32_SFLOAT, offsetof(Vertex, colour)}},
                                          .alpha_blend = true,
                                          .layout = layout_});
  }
  void draw(VkCommandBuffer commands) const override {
    const VkDeviceSize offset = 0;
    const VkBuffer buffer = vertices_.handle;
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline_);
    vkCmdBindVertexBuffers(commands, 0, 1, &buffer, &offset);
    vkCmdBindIndexBuffer(commands, indices_.handle, 0, VK_INDEX_TYPE_UINT16);
    vkCmdDrawIndexed(commands, 6 * kQuadCount, 1, 0, 0, 0);
  }
  std::array<float, 4> clear_colour() const override { return {0.953f, 0.957f, 0.965f, 1.0f}; }

 private:
  Buffer vertices_, indices_;
  PipelineLayoutHandle layout_;
  PipelineHandle pipeline_;
};

}  // namespace

std::unique_ptr<Scene> make_blend_scene() { return std::make_unique<BlendScene>(); }

}  // namespace pineda::tools
