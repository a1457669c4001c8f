#include "tools/bench/grid_scenes.h"

#include <cmath>
#include <cstdint>
#include <glm/gtc/matrix_transform.hpp>
#include <memory>
#include <numbers>
#include <vector>

#include "shaders/lit_mesh_frag.h"
#include "shaders/lit_mesh_vert.h"
#include "tools/camera.h"

namespace pineda::tools {
namespace {

struct Vertex {
  glm::vec3 position, normal;
};

std::vector<Vertex> make_torus(uint32_t columns, uint32_t rows) {
  std::vector<Vertex> vertices;
  vertices.reserve(size_t{columns + 1} * (rows + 1));
  for (uint32_t row = 0; row <= rows; ++row) {
    for (uint32_t column = 0; column <= columns; ++column) {
      const float around = 2 * std::numbers::pi_v<float> * static_cast<float>(column) / static_cast<float>(columns);
      const float tube = 2 * std::numbers::pi_v<float> * static_cast<float>(row) / static_cast<float>(rows);
      const glm::vec3 outward(std::cos(around), 0, std::sin(around));
      const glm::vec3 normal = outward * std::cos(tube) + glm::vec3(0, std::sin(tube), 0);
      vertices.push_back({outward + 0.45f * normal, normal});
    }
  }
  return vertices;
}

std::vector<uint32_t> make_grid_indices(uint32_t columns, uint32_t rows) {
  std::vector<uint32_t> indices;
  indices.reserve(size_t{6} * columns * rows);
  for (uint32_t row = 0; row < rows; ++row) {
    for (uint32_t column = 0; column < columns; ++column) {
      const uint32_t a = row * (columns + 1) + column, b = a + columns + 1;
      indices.insert(indices.end(), {a, b, a + 1, a + 1, b, b + 1});
    }
  }
  return indices;
}

// The torus, ready to be drawn into targets like the one that it is made for.
class LitMesh {
 public:
  explicit LitMesh(const LitMeshOptions& options) : options_(options) {}

  void create(VkContext& context, const RenderTarget& target) {
    const std::vector<Vertex> vertices = make_torus(options_.columns, options_.rows);
    const std::vector<uint32_t> indices = make_grid_indices(options_.columns, options_.rows);
    index_count_ = static_cast<uint32_t>(indices.size());
    vertices_ = create_buffer(context, vertices, VK_BUFFER_USAGE_VERTEX_BUFFER_BIT);
    indices_ = create_buffer(context, indices, VK_BUFFER_USAGE_INDEX_BUFFER_BIT);

    std::vector<glm::vec3> positions;
    for (const Vertex& vertex : vertices) positions.push_back(vertex.position);
    const auto [width, height] = target.extent();
    const float aspect = static_cast<float>(width) / static_cast<float>(height);
    Camera camera = fit_camera(positions, glm::normalize(glm::vec3(-0.3f, -0.8f, -0.7f)), aspect, 0.4f, 0.95f);
    camera.view_projection = glm::translate(glm::mat4(1), glm::vec3(options_.shift_x, 0, 0)) * camera.view_projection;
    view_ = create_buffer(context, std::span(&camera.view_projection, 1), VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT);
    const Binding binding{0, VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, VK_SHADER_STAGE_VERTEX_BIT};
    bound_.set_layout = create_set_layout(context, {&binding, 1});
    bound_.descriptors.emplace(context, 1, 1);
    bound_.set = bound_.descriptors->allocate(bound_.set_layout);
    bound_.descriptors->write_buffer(bound_.set, 0, VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, view_);

    const VkDescriptorSetLayout set_layout = bound_.set_layout;
    bound_.layout = create_pipeline_layout(context, {&set_layout, 1}, {});
    bound_.pipeline =
        create_graphics_pipeline(context, target,
                                 {.vertex_shader = lit_mesh_vert,
                                  .fragment_shader = options_.depth_only ? Spirv{} : Spirv{lit_mesh_frag},
                                  .vertex_bindings = {{0, sizeof(Vertex), VK_VERTEX_INPUT_RATE_VERTEX}},
                                  .vertex_attributes = {{0, 0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(Vertex, position)},
                                                        {1, 0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(Vertex, normal)}},
                                  .depth_test = true,
                                  .depth_write = true,
                                  .cull_mode = options_.culled ? VK_CULL_MODE_FRONT_AND_BACK : VK_CULL_MODE_NONE,
                                  .layout = bound_.layout});
  }

  void draw(VkCommandBuffer commands) const {
    const VkDeviceSize offset = 0;
    const VkBuffer buffer = vertices_.handle;
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, bound_.pipeline);
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, bound_.layout, 0, 1, &bound_.set, 0, nullptr);
    vkCmdBindVertexBuffers(commands, 0, 1, &buffer, &offset);
    vkCmdBindIndexBuffer(commands, indices_.handle, 0, VK_INDEX_TYPE_UINT32);
    const uint32_t part = index_count_ / options_.draw_count;
    for (uint32_t i = 0; i < options_.draw_count; ++i) vkCmdDrawIndexed(commands, part, 1, i * part, 0, 0);
  }

 private:
  LitMeshOptions options_;
  uint32_t index_count_ = 0;
  Buffer vertices_, indices_, view_;
  BoundPipeline bound_;
};

class LitMeshScene final : public RenderScene {
 public:
  explicit LitMeshScene(const LitMeshOptions& options)
      : RenderScene(options.depth_only ? RenderTarget::Attachments::kDepth : RenderTarget::Attachments::kColourDepth),
        mesh_(options) {}

 protected:
  void create(VkContext& context, const RenderTarget& target) override { mesh_.create(context, target); }
  void draw(VkCommandBuffer commands) const override { mesh_.draw(commands); }

 private:
  LitMesh mesh_;
};

// The mesh in many render passes that do not depend on each other: each has a target of its own.
class ManyPassesScene final : public Scene {
 public:
  ManyPassesScene(const LitMeshOptions& options, uint32_t pass_count) : mesh_(options), pass_count_(pass_count) {}

  void prepare(VkContext& context, VkExtent2D extent) override {
    for (uint32_t i = 0; i < pass_count_; ++i) {
      targets_.push_back(std::make_unique<RenderTarget>(context, extent, RenderTarget::Attachments::kColourDepth));
    }
    mesh_.create(context, *targets_[0]);
  }
  void record(VkCommandBuffer commands) const override {
    for (const std::unique_ptr<RenderTarget>& target : targets_) {
      target->begin(commands, {0, 0, 0, 1});
      mesh_.draw(commands);
      vkCmdEndRenderPass(commands);
    }
  }
  const Image2D& picture() const override { return targets_.back()->colour(); }

 private:
  LitMesh mesh_;
  uint32_t pass_count_;
  std::vector<std::unique_ptr<RenderTarget>> targets_;
};

}  // namespace

std::unique_ptr<Scene> make_lit_mesh_scene(const LitMeshOptions& options) { return std::make_unique<LitMeshScene>(options); }
std::unique_ptr<Scene> make_many_passes_scene(const LitMeshOptions& options, uint32_t pass_count) {
  return std::make_unique<ManyPassesScene>(options, pass_count);
}

}  // namespace pineda::tools
