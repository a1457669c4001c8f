#include "tools/bench/layer_scenes.h"

#include <cstdint>
#include <vector>

#include "shaders/layer_flat_frag.h"
#include "shaders/layer_lit_frag.h"
#include "shaders/layer_textured_frag.h"
#include "shaders/layer_vert.h"
#include "tools/vk/block_texture.h"

namespace pineda::tools {
namespace {

struct Layer {  // the push constants of all layer shaders
  float colour[4];
  float depth;
  float texture_scale;
};

constexpr VkShaderStageFlags kLayerStages = VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT;
constexpr uint32_t kTextureSide = 1024;

Image make_pattern() {
  Image image{
      .width = kTextureSide, .height = kTextureSide, .rgba = std::vector<uint8_t>(size_t{4} * kTextureSide * kTextureSide)};
  for (uint32_t y = 0; y < kTextureSide; ++y) {
    for (uint32_t x = 0; x < kTextureSide; ++x) {
      const uint8_t texel[4] = {static_cast<uint8_t>(x ^ y), static_cast<uint8_t>(x >> 2), static_cast<uint8_t>(y >> 2), 255};
      std::copy(texel, texel + 4, image.pixel(x, y));
    }
  }
  return image;
}

Spirv fragment_shader_of(LayerKind kind) {
  switch (kind) {
    case LayerKind::kTrilinear:
    case LayerKind::kTrilinearBc7:
    case LayerKind::kTrilinearAstc:
      return layer_textured_frag;
    case LayerKind::kLitFrontToBack:
      return layer_lit_frag;
    default:
      return layer_flat_frag;
  }
}

class LayerScene final : public RenderScene {
 public:
  LayerScene(LayerKind kind, uint32_t layer_count)
      : RenderScene(kind == LayerKind::kLitFrontToBack ? RenderTarget::Attachments::kColourDepth
                                                       : RenderTarget::Attachments::kColour),
        kind_(kind),
        layer_count_(layer_count) {}

 protected:
  void create(VkContext& context, const RenderTarget& target) override {
    if (is_textured()) create_texture_set(context);
    const VkDescriptorSetLayout set_layout = bound_.set_layout;
    const VkPushConstantRange range{kLayerStages, 0, sizeof(Layer)};
    bound_.layout = create_pipeline_layout(context, {&set_layout, bound_.set ? 1u : 0u}, {&range, 1});
    bound_.pipeline = create_graphics_pipeline(context, target,
                                               {.vertex_shader = layer_vert,
                                                .fragment_shader = fragment_shader_of(kind_),
                                                .depth_test = kind_ == LayerKind::kLitFrontToBack,
                                                .depth_write = kind_ == LayerKind::kLitFrontToBack,
                                                .alpha_blend = kind_ == LayerKind::kBlended,
                                                .layout = bound_.layout});
  }

  void draw(VkCommandBuffer commands) const override {
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, bound_.pipeline);
    if (bound_.set)
      vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, bound_.layout, 0, 1, &bound_.set, 0, nullptr);
    for (uint32_t i = 0; i < layer_count_; ++i) {
      const float t = static_cast<float>(i + 1) / static_cast<float>(layer_count_ + 1);
      const Layer layer{.colour = {t, 1 - t, 0.5f, 0.5f}, .depth = t, .texture_scale = 1.5f + t};
      vkCmdPushConstants(commands, bound_.layout, kLayerStages, 0, sizeof layer, &layer);
      vkCmdDraw(commands, 6, 1, 0, 0);
    }
  }

 private:
  bool is_textured() const {
    return kind_ == LayerKind::kTrilinear || kind_ == LayerKind::kTrilinearBc7 || kind_ == LayerKind::kTrilinearAstc;
  }

  void create_texture_set(VkContext& context) {
    const std::vector<Image> levels = make_mip_chain(make_pattern());
    texture_ = kind_ == LayerKind::kTrilinear
                   ? create_texture(context, levels, VK_FORMAT_R8G8B8A8_UNORM)
                   : create_block_texture(context, levels,
                                          kind_ == LayerKind::kTrilinearBc7 ? BlockFormat::kBc7 : BlockFormat::kAstc4x4);
    sampler_ = create_trilinear_sampler(context);
    const Binding binding{0, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, VK_SHADER_STAGE_FRAGMENT_BIT};
    bound_.set_layout = create_set_layout(context, {&binding, 1});
    bound_.descriptors.emplace(context, 1, 1);
    bound_.set = bound_.descriptors->allocate(bound_.set_layout);
    bound_.descriptors->write_texture(bound_.set, 0, texture_, sampler_);
  }

  LayerKind kind_;
  uint32_t layer_count_;
  Image2D texture_;
  SamplerHandle sampler_;
  BoundPipeline bound_;
};

}  // namespace

std::unique_ptr<Scene> make_layer_scene(LayerKind kind, uint32_t layer_count) {
  return std::make_unique<LayerScene>(kind, layer_count);
}

}  // namespace pineda::tools
