// Any model file: all meshes of all nodes, base-colour textures with mipmaps, depth, a directional light, the camera fitted to
// the model.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include "shaders/model_frag.h"
#include "shaders/model_vert.h"
#include "tools/error.h"
#include "tools/model.h"
#include "tools/scenes/backdrop.h"
#include "tools/scenes/scenes.h"

namespace pineda::tools {
namespace {

constexpr VkFormat kTextureFormat = VK_FORMAT_R8G8B8A8_SRGB;  // what base-colour textures hold (glTF 2.0, 3.9.2)

struct View {  // the uniform buffer of model.vert and model.frag
  glm::mat4 view_projection;
  glm::vec4 eye, light_direction;
};

struct DrawConstants {  // the push constants of model.vert
  glm::vec4 world_rows[3], normal_rows[3], base_colour;
};

DrawConstants make_constants(const ModelDraw& draw, const ModelMaterial& material) {
  const glm::mat4 rows = glm::transpose(draw.world);
  const glm::vec3 x(rows[0]), y(rows[1]), z(rows[2]);
  // The rows of the cofactor matrix: normals stay normal to the surface under any affine map, without an inverse.
  const glm::vec3 cofactors[3] = {glm::cross(y, z), glm::cross(z, x), glm::cross(x, y)};
  // A mirror turns the winding as well as the cofactors' sign, so that facing and normal still agree with each other.
  DrawConstants constants{};
  float largest = 0;
  for (const glm::vec3& row : cofactors) largest = std::max({largest, std::abs(row.x), std::abs(row.y), std::abs(row.z)});
  const float scale = largest > 0 ? 1 / largest : 1;  // keeps normals of tiny or huge models in the range of a float
  for (int i = 0; i < 3; ++i) {
    constants.world_rows[i] = rows[i];
    constants.normal_rows[i] = glm::vec4(cofactors[i] * scale, 0);
  }
  constants.base_colour = material.base_colour;
  return constants;
}

class ModelScene final : public RenderScene {
 public:
  explicit ModelScene(const std::string& path)
      : RenderScene(RenderTarget::Attachments::kColourDepth), path_(path), model_(load_model(path)) {
    for (const ModelDraw& draw : model_.draws) constants_.push_back(make_constants(draw, model_.materials[draw.material]));
  }
  std::vector<std::string> notes() const override {
    std::vector<std::string> notes = model_.notes;
    notes.push_back(
        fmt::format("{} triangles, {} draws, {} textures", model_.triangle_count(), model_.draws.size(), model_.textures.size()));
    return notes;
  }

 protected:
  void create(VkContext& context, const RenderTarget& target) override {
    backdrop_.emplace(context, target, Backdrop::Colours{{0.905f, 0.918f, 0.937f, 1}, {0.600f, 0.635f, 0.694f, 1}});
    vertices_ = create_buffer(context, model_.vertices, VK_BUFFER_USAGE_VERTEX_BUFFER_BIT);
    indices_ = create_buffer(context, model_.indices, VK_BUFFER_USAGE_INDEX_BUFFER_BIT);
    create_view(context, target.extent());
    create_textures(context);
    create_descriptors(context);
    create_pipelines(context, target);
  }

  void draw(VkCommandBuffer commands) const override {
    backdrop_->draw(commands);
    const VkDeviceSize offset = 0;
    const VkBuffer buffer = vertices_.handle;
    vkCmdBindVertexBuffers(commands, 0, 1, &buffer, &offset);
    vkCmdBindIndexBuffer(commands, indices_.handle, 0, VK_INDEX_TYPE_UINT32);
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, layout_, 0, 1, &view_set_, 0, nullptr);
    VkPipeline bound_pipeline = VK_NULL_HANDLE;
    VkDescriptorSet bound_set = VK_NULL_HANDLE;
    for (size_t i = 0; i < model_.draws.size(); ++i) {
      const ModelDraw& draw = model_.draws[i];
      const int texture = model_.materials[draw.material].texture;
      const VkPipeline pipeline = texture >= 0 ? textured_ : plain_;
      if (pipeline != bound_pipeline) vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline);
      // The last texture is the white one that stands in where there is none.
      const VkDescriptorSet set = texture >= 0 ? texture_sets_[static_cast<size_t>(texture)] : texture_sets_.back();
      if (set != bound_set) vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, layout_, 1, 1, &set, 0, nullptr);
      vkCmdPushConstants(commands, layout_, VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof(DrawConstants), &constants_[i]);
      vkCmdDrawIndexed(commands, draw.index_count, 1, draw.first_index, static_cast<int32_t>(draw.vertex_offset), 0);
      bound_pipeline = pipeline;
      bound_set = set;
    }
  }

 private:
  void create_view(VkContext& context, VkExtent2D extent) {
    const float aspect = static_cast<float>(extent.width) / static_cast<float>(extent.height);
    const glm::vec3 direction = glm::normalize(glm::vec3(-0.62f, -0.42f, -0.86f));
    const Camera camera = fit_camera(model_.world_positions(), direction, aspect, 0.32f, 0.88f);
    const View view{camera.view_projection, glm::vec4(camera.eye, 1),
                    glm::vec4(glm::normalize(glm::vec3(0.10f, 0.82f, 0.62f)), 0)};
    view_ = create_buffer(context, std::span(&view, 1), VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT);
  }

  void create_textures(VkContext& context) {
    sampler_ = create_trilinear_sampler(context);
    for (const Image& texture : model_.textures)
      textures_.push_back(create_texture(context, make_mip_chain(texture), kTextureFormat));
    const Image white{.width = 1, .height = 1, .rgba = {255, 255, 255, 255}};
    textures_.push_back(create_texture(context, {&white, 1}, kTextureFormat));
  }

  void create_descriptors(VkContext& context) {
    const Binding view_binding{0, VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT};
    const Binding texture_binding{0, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, VK_SHADER_STAGE_FRAGMENT_BIT};
    view_layout_ = create_set_layout(context, {&view_binding, 1});
    texture_layout_ = create_set_layout(context, {&texture_binding, 1});
    const uint32_t set_count = 1 + static_cast<uint32_t>(textures_.size());
    descriptors_.emplace(context, set_count, set_count);
    view_set_ = descriptors_->allocate(view_layout_);
    descriptors_->write_buffer(view_set_, 0, VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, view_);
    for (const Image2D& texture : textures_) {
      texture_sets_.push_back(descriptors_->allocate(texture_layout_));
      descriptors_->write_texture(texture_sets_.back(), 0, texture, sampler_);
    }
  }

  void create_pipelines(VkContext& context, const RenderTarget& target) {
    const std::array<VkDescriptorSetLayout, 2> set_layouts{view_layout_, texture_layout_};
    const VkPushConstantRange range{VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof(DrawConstants)};
    layout_ = create_pipeline_layout(context, set_layouts, {&range, 1});
    const auto create = [&](VkBool32 textured) {
      const VkSpecializationMapEntry entry{.constantID = 0, .offset = 0, .size = sizeof textured};
      const VkSpecializationInfo specialization{1, &entry, sizeof textured, &textured};
      return create_graphics_pipeline(context, target,
                                      {.vertex_shader = model_vert,
                                       .fragment_shader = model_frag,
                                       .vertex_bindings = {{0, sizeof(ModelVertex), VK_VERTEX_INPUT_RATE_VERTEX}},
                                       .vertex_attributes = {{0, 0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(ModelVertex, position)},
                                                             {1, 0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(ModelVertex, normal)},
                                                             {2, 0, VK_FORMAT_R32G32_SFLOAT, offsetof(ModelVertex, uv)},
                                                             {3, 0, VK_FORMAT_R8G8B8A8_UNORM, offsetof(ModelVertex, colour)}},
                                       .depth_test = true,
                                       .depth_write = true,
                                       .layout = layout_,
                                       .specialization = &specialization});
    };
    const auto is_textured = [&](const ModelDraw& draw) { return model_.materials[draw.material].texture >= 0; };
    if (std::ranges::any_of(model_.draws, is_textured)) textured_ = create(VK_TRUE);
    if (!std::ranges::all_of(model_.draws, is_textured)) plain_ = create(VK_FALSE);
  }

  std::string path_;
  Model model_;
  std::vector<DrawConstants> constants_;
  std::optional<Backdrop> backdrop_;
  Buffer vertices_, indices_, view_;
  SamplerHandle sampler_;
  std::vector<Image2D> textures_;
  std::optional<DescriptorAllocator> descriptors_;
  DescriptorSetLayoutHandle view_layout_, texture_layout_;
  VkDescriptorSet view_set_ = VK_NULL_HANDLE;
  std::vector<VkDescriptorSet> texture_sets_;
  PipelineLayoutHandle layout_;
  PipelineHandle textured_, plain_;
};

}  // namespace

std::unique_ptr<Scene> make_model_scene(const std::string& path) { return std::make_unique<ModelScene>(path); }

}  // namespace pineda::tools
