#include "tools/scenes/sampling.h"

#include <bit>
#include <cstdint>

#include "shaders/blur_frag.h"
#include "shaders/borders_frag.h"
#include "shaders/cube_seams_frag.h"
#include "shaders/filtering_frag.h"
#include "shaders/gathers_frag.h"
#include "shaders/lookup_table_frag.h"
#include "shaders/receding_plane_frag.h"
#include "shaders/sampling_vert.h"
#include "shaders/shadow_map_frag.h"
#include "shaders/upscale_frag.h"
#include "shaders/volume_frag.h"
#include "tools/vk/textures.h"

namespace pineda::tools {
namespace {

uint32_t rgb(uint32_t r, uint32_t g, uint32_t b) { return (r & 255) | (g & 255) << 8 | (b & 255) << 16 | 0xFF000000u; }

// Squares with lines around them; each level has a tint of its own.
uint32_t checker(const TexelPlace& p) {
  const uint32_t side = std::max(16u >> p.level, 1u);
  const bool dark = ((p.x / side + p.y / side) & 1) != 0;
  const uint32_t light = dark ? 40 : 225, tint = 24 * p.level;
  const bool line = p.x % side == 0 || p.y % side == 0;
  return line ? rgb(230, 90 + tint, 60) : rgb(light, light - tint / 2, light + tint / 2);
}

// Squares alone: every level has the same mean, so pictures with other footprints stay comparable.
uint32_t squares(const TexelPlace& p) {
  constexpr uint32_t kDark = 40, kLight = 224;
  if (p.level > 4) return rgb((kDark + kLight) / 2, (kDark + kLight) / 2, (kDark + kLight) / 2);
  const uint32_t side = 16u >> p.level, light = (p.x / side + p.y / side) % 2 == 0 ? kLight : kDark;
  return rgb(light, light, light);
}

uint32_t random_texel(const TexelPlace& p) {
  uint32_t x = (p.x * 73 + p.y * 1031 + p.z * 9176 + p.layer * 70001) * 0x9e3779b9u;
  x = (x ^ x >> 15) * 0x846ca68bu;
  return (x ^ x >> 16) | 0xFF000000u;
}

uint32_t cube_texel(const TexelPlace& p) {
  constexpr uint32_t kTint[6] = {0x3060E0, 0x3030A0, 0x50C040, 0x207030, 0xE09040, 0x905020};
  const uint32_t bright = (p.x + p.y) & 1 ? 0x1A1A1A : 0;
  return (kTint[p.layer] + bright) | 0xFF000000u;
}

uint32_t table_texel(const TexelPlace& p) { return rgb(p.x * 8 + p.y, p.y * 8 + p.z, p.z * 8 + p.x); }

// Depths of a slope with holes.
uint32_t depth_texel(const TexelPlace& p) {
  const float slope = static_cast<float>(p.x) / 256;
  const bool hole = (p.x / 24 + p.y / 24) % 2 == 0;
  return std::bit_cast<uint32_t>(hole ? 1.0f : slope * 0.9f + 0.02f);
}

struct Row {
  SamplingKind kind;
  Spirv fragment_shader;
  TextureShape shape;
  uint32_t (*texel)(const TexelPlace&);
  VkFilter filter;
  float anisotropy;
  bool compares;
};

const Row& row_of(SamplingKind kind) {
  constexpr VkImageViewType k2D = VK_IMAGE_VIEW_TYPE_2D, kCube = VK_IMAGE_VIEW_TYPE_CUBE, k3D = VK_IMAGE_VIEW_TYPE_3D;
  constexpr VkFilter kLinear = VK_FILTER_LINEAR;
  const TextureShape chain{k2D, {256, 256, 1}, 9, 1}, table{k3D, {32, 32, 32}};
  static const Row kRows[] = {
      {SamplingKind::kFiltering, filtering_frag, chain, checker, kLinear, 1, false},
      {SamplingKind::kRecedingPlane, receding_plane_frag, chain, squares, kLinear, 16, false},
      {SamplingKind::kCubeSeams, cube_seams_frag, {kCube, {4, 4, 1}, 1, 6}, cube_texel, kLinear, 1, false},
      {SamplingKind::kBorders, borders_frag, {k2D, {8, 8, 1}}, random_texel, kLinear, 1, false},
      {SamplingKind::kVolume, volume_frag, {k3D, {16, 16, 16}}, random_texel, kLinear, 1, false},
      {SamplingKind::kShadowMap,
       shadow_map_frag,
       {k2D, {256, 256, 1}, 1, 1, VK_FORMAT_D32_SFLOAT},
       depth_texel,
       kLinear,
       1,
       true},
      {SamplingKind::kGathers, gathers_frag, {k2D, {24, 24, 1}}, random_texel, kLinear, 1, false},
      {SamplingKind::kUpscale, upscale_frag, {k2D, {240, 135, 1}}, random_texel, kLinear, 1, false},
      {SamplingKind::kLookupTable, lookup_table_frag, table, table_texel, kLinear, 1, false},
      {SamplingKind::kBlur, blur_frag, {k2D, {1024, 1024, 1}}, random_texel, kLinear, 1, false},
  };
  return kRows[static_cast<size_t>(kind)];
}

class SamplingScene final : public RenderScene {
 public:
  SamplingScene(const Row& row, uint32_t layer_count) : row_(row), layer_count_(layer_count) {}

 protected:
  void create(VkContext& context, const RenderTarget& target) override {
    texture_ = create_texture(context, row_.shape, row_.texel);
    const bool borders = row_.kind == SamplingKind::kBorders;
    const uint32_t count = borders ? 5 : 1;
    for (uint32_t i = 0; i < count; ++i) samplers_.push_back(create_sampler(context, sampler_info(borders ? i : 0)));
    create_set(context, count);
    const VkDescriptorSetLayout set_layout = bound_.set_layout;
    bound_.layout = create_pipeline_layout(context, {&set_layout, 1}, {});
    bound_.pipeline = create_graphics_pipeline(
        context, target, {.vertex_shader = sampling_vert, .fragment_shader = row_.fragment_shader, .layout = bound_.layout});
  }

  void draw(VkCommandBuffer commands) const override {
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, bound_.pipeline);
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, bound_.layout, 0, 1, &bound_.set, 0, nullptr);
    for (uint32_t i = 0; i < layer_count_; ++i) vkCmdDraw(commands, 3, 1, 0, 0);
  }

 private:
  // The address modes in their order: repeat, mirrored repeat, clamp to edge, clamp to border (two colours).
  VkSamplerCreateInfo sampler_info(uint32_t mode) const {
    VkSamplerCreateInfo info{.magFilter = row_.filter,
                             .minFilter = row_.filter,
                             .mipmapMode = VK_SAMPLER_MIPMAP_MODE_LINEAR,
                             .anisotropyEnable = row_.anisotropy > 1,
                             .maxAnisotropy = row_.anisotropy,
                             .compareEnable = row_.compares,
                             .compareOp = VK_COMPARE_OP_LESS_OR_EQUAL,
                             .maxLod = VK_LOD_CLAMP_NONE,
                             .borderColor = mode == 4 ? VK_BORDER_COLOR_FLOAT_OPAQUE_WHITE : VK_BORDER_COLOR_FLOAT_OPAQUE_BLACK};
    info.addressModeU = info.addressModeV = info.addressModeW = static_cast<VkSamplerAddressMode>(std::min(mode, 3u));
    return info;
  }

  void create_set(VkContext& context, uint32_t count) {
    const VkDescriptorSetLayoutBinding binding{0, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, count, VK_SHADER_STAGE_FRAGMENT_BIT,
                                               nullptr};
    const VkDescriptorSetLayoutCreateInfo info{
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO, .bindingCount = 1, .pBindings = &binding};
    VkDescriptorSetLayout set_layout = VK_NULL_HANDLE;
    check(vkCreateDescriptorSetLayout(context.device(), &info, nullptr, &set_layout), "vkCreateDescriptorSetLayout");
    bound_.set_layout = {context.device(), set_layout};
    bound_.descriptors.emplace(context, 1, count);
    bound_.set = bound_.descriptors->allocate(bound_.set_layout);
    for (uint32_t i = 0; i < count; ++i) {
      const VkDescriptorImageInfo image{samplers_[i], texture_.view, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
      const VkWriteDescriptorSet write{.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                       .dstSet = bound_.set,
                                       .dstArrayElement = i,
                                       .descriptorCount = 1,
                                       .descriptorType = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER,
                                       .pImageInfo = &image};
      vkUpdateDescriptorSets(context.device(), 1, &write, 0, nullptr);
    }
  }

  const Row& row_;
  const uint32_t layer_count_;
  Texture texture_;
  std::vector<SamplerHandle> samplers_;
  BoundPipeline bound_;
};

}  // namespace

std::unique_ptr<Scene> make_sampling_scene(SamplingKind kind, uint32_t layer_count) {
  return std::make_unique<SamplingScene>(row_of(kind), layer_count);
}

}  // namespace pineda::tools
