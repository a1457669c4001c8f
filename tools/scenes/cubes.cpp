#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "shaders/cubes_frag.h"
#include "shaders/cubes_vert.h"
#include "tools/camera.h"
#include "tools/scenes/backdrop.h"
#include "tools/scenes/scenes.h"

namespace pineda::tools {
namespace {

constexpr uint32_t kSide = 10, kInstanceCount = kSide * kSide * kSide;

struct Vertex {
  glm::vec3 position, normal;
};
struct Instance {
  glm::vec4 place_and_size, turn, colour;
};
struct View {
  glm::mat4 view_projection;
  glm::vec4 light_direction;
};

std::vector<Vertex> make_cube_vertices() {
  std::vector<Vertex> vertices;
  for (int axis = 0; axis < 3; ++axis) {
    for (const float side : {-1.0f, 1.0f}) {
      for (const auto& [u, v] : {std::pair{-1.0f, -1.0f}, {1.0f, -1.0f}, {1.0f, 1.0f}, {-1.0f, 1.0f}}) {
        Vertex vertex{};
        vertex.normal[axis] = side;
        vertex.position[axis] = side;
        vertex.position[(axis + 1) % 3] = side * u;  // keeps the corners counter-clockwise from outside
        vertex.position[(axis + 2) % 3] = v;
        vertices.push_back(vertex);
      }
    }
  }
  return vertices;
}

std::vector<uint16_t> make_cube_indices() {
  std::vector<uint16_t> indices;
  for (int face = 0; face < 6; ++face) {
    for (const int corner : {0, 1, 2, 0, 2, 3}) indices.push_back(static_cast<uint16_t>(4 * face + corner));
  }
  return indices;
}

// A number in [0, 1) from a counter (a Weyl sequence of the golden ratio, scrambled): the same on every machine.
float noise(uint32_t seed) {
  uint32_t x = seed * 0x9e3779b9u;
  x = (x ^ x >> 16) * 0x7feb352du;
  x = (x ^ x >> 15) * 0x846ca68bu;
  return static_cast<float>((x ^ x >> 16) >> 8) / 16777216.0f;
}

std::vector<Instance> make_instances() {
  std::vector<Instance> instances;
  constexpr float kStep = 2.0f / kSide;
  for (uint32_t i = 0; i < kInstanceCount; ++i) {
    const glm::vec3 cell(i % kSide, i / kSide % kSide, i / (kSide * kSide));
    const glm::vec3 place = (cell - 0.5f * (kSide - 1)) * kStep;
    const glm::vec4 turn(noise(6 * i) - 0.5f, noise(6 * i + 1) - 0.5f, noise(6 * i + 2) - 0.5f, 0.6f);
    const glm::vec3 t = cell / static_cast<float>(kSide - 1);
    const glm::vec3 warm = glm::mix(glm::vec3(0.98f, 0.42f, 0.33f), glm::vec3(1.00f, 0.80f, 0.38f), t.y);
    const glm::vec3 cold = glm::mix(glm::vec3(0.24f, 0.30f, 0.72f), glm::vec3(0.32f, 0.82f, 0.86f), t.y);
    const glm::vec3 colour = glm::mix(cold, warm, 0.5f * (t.x + t.z));
    const float size = kStep * (0.20f + 0.12f * noise(6 * i + 3));
    instances.push_back({glm::vec4(place, size), turn / glm::length(turn), glm::vec4(colour, 1)});
  }
  return instances;
}

class CubesScene final : public RenderScene {
 public:
  CubesScene() : RenderScene(RenderTarget::Attachments::kColourDepth) {}

 protected:
  void create(VkContext& context, const RenderTarget& target) override {
    backdrop_.emplace(context, target, Backdrop::Colours{{0.235f, 0.255f, 0.310f, 1}, {0.070f, 0.078f, 0.105f, 1}});
    const std::vector<Vertex> vertices = make_cube_vertices();
    const std::vector<Instance> instances = make_instances();
    vertices_ = create_buffer(context, vertices, VK_BUFFER_USAGE_VERTEX_BUFFER_BIT);
    indices_ = create_buffer(context, make_cube_indices(), VK_BUFFER_USAGE_INDEX_BUFFER_BIT);
    instances_ = create_buffer(context, instances, VK_BUFFER_USAGE_VERTEX_BUFFER_BIT);
    create_view(context, target.extent());
    create_pipeline(context, target);
  }

  void draw(VkCommandBuffer commands) const override {
    backdrop_->draw(commands);
    const VkDeviceSize offsets[2] = {0, 0};
    const VkBuffer buffers[2] = {vertices_.handle, instances_.handle};
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline_);
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, layout_, 0, 1, &set_, 0, nullptr);
    vkCmdBindVertexBuffers(commands, 0, 2, buffers, offsets);
    vkCmdBindIndexBuffer(commands, indices_.handle, 0, VK_INDEX_TYPE_UINT16);
    vkCmdDrawIndexed(commands, 36, kInstanceCount, 0, 0, 0);
  }

 private:
  void create_view(VkContext& context, VkExtent2D extent) {
    std::vector<glm::vec3> corners;
    for (const float x : {-1.02f, 1.02f})
      for (const float y : {-1.02f, 1.02f})
        for (const float z : {-1.02f, 1.02f}) corners.emplace_back(x, y, z);
    const float aspect = static_cast<float>(extent.width) / static_cast<float>(extent.height);
    const glm::vec3 direction = glm::normalize(glm::vec3(-0.62f, -0.50f, -0.80f));
    const Camera camera = fit_camera(corners, direction, aspect, 0.36f, 0.94f);
    const View view{camera.view_projection, glm::vec4(glm::normalize(glm::vec3(0.35f, 0.85f, 0.75f)), 0)};
    view_ = create_buffer(context, std::span(&view, 1), VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT);

    const Binding binding{0, VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, VK_SHADER_STAGE_VERTEX_BIT};
    set_layout_ = create_set_layout(context, {&binding, 1});
    descriptors_.emplace(context, 1, 1);
    set_ = descriptors_->allocate(set_layout_);
    descriptors_->write_buffer(set_, 0, VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, view_);
  }

  void create_pipeline(VkContext& context, const RenderTarget& target) {
    const VkDescriptorSetLayout set_layout = set_layout_;
    layout_ = create_pipeline_layout(context, {&set_layout, 1}, {});
    pipeline_ =
        create_graphics_pipeline(context, target,
                                 {.vertex_shader = cubes_vert,
                                  .fragment_shader = cubes_frag,
                                  .vertex_bindings = {{0, sizeof(Vertex), VK_VERTEX_INPUT_RATE_VERTEX},
                                                      {1, sizeof(Instance), VK_VERTEX_INPUT_RATE_INSTANCE}},
                                  .vertex_attributes = {{0, 0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(Vertex, position)},
                                                        {1, 0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(Vertex, normal)},
                                                        {2, 1, VK_FORMAT_R32G32B32A32_SFLOAT, offsetof(Instance, place_and_size)},
                                                        {3, 1, VK_FORMAT_R32G32B32A32_SFLOAT, offsetof(Instance, turn)},
                                                        {4, 1, VK_FORMAT_R32G32B32A32_SFLOAT, offsetof(Instance, colour)}},
                                  .depth_test = true,
                                  .depth_write = true,
                                  .cull_mode = VK_CULL_MODE_BACK_BIT,
                                  .layout = layout_});
  }

  std::optional<Backdrop> backdrop_;
  std::optional<DescriptorAllocator> descriptors_;
  Buffer vertices_, indices_, instances_, view_;
  DescriptorSetLayoutHandle set_layout_;
  VkDescriptorSet set_ = VK_NULL_HANDLE;
  PipelineLayoutHandle layout_;
  PipelineHandle pipeline_;
};

}  // namespace

std::unique_ptr<Scene> make_cubes_scene() { return std::make_unique<CubesScene>(); }

}  // namespace pineda::tools
