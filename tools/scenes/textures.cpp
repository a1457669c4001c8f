// Scenes of four textures: blocks of four compressed formats, and what blits make.
#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "shaders/blits_frag.h"
#include "shaders/blocks_frag.h"
#include "shaders/sampling_vert.h"
#include "tools/scene.h"
#include "tools/scenes/scenes.h"
#include "tools/vk/block_texture.h"

namespace pineda::tools {
namespace {

constexpr uint32_t kSide = 256, kTextures = 4;

// Rings of slowly changing colour with sharp discs among them: smooth parts, edges and all hues.
Image make_picture() {
  Image image{.width = kSide, .height = kSide, .rgba = std::vector<uint8_t>(size_t{4} * kSide * kSide)};
  for (uint32_t y = 0; y < kSide; ++y) {
    for (uint32_t x = 0; x < kSide; ++x) {
      const uint32_t dx = x % 64 < 32 ? 32 - x % 64 : x % 64 - 32, dy = y % 64 < 32 ? 32 - y % 64 : y % 64 - 32;
      const uint32_t radius = dx * dx + dy * dy;
      const uint8_t smooth[4] = {static_cast<uint8_t>(x), static_cast<uint8_t>(radius / 8), static_cast<uint8_t>(255 - y), 255};
      const uint8_t disc[4] = {static_cast<uint8_t>(255 - x), 40, static_cast<uint8_t>(y), 255};
      std::copy_n(radius < 256 ? disc : smooth, 4, image.pixel(x, y));
    }
  }
  return image;
}

class FourTextures : public RenderScene {
 public:
  explicit FourTextures(Spirv fragment_shader) : fragment_shader_(fragment_shader) {}

 protected:
  virtual std::array<Image2D, kTextures> make_textures(VkContext& context) = 0;

  void create(VkContext& context, const RenderTarget& target) override {
    textures_ = make_textures(context);
    sampler_ = create_trilinear_sampler(context);
    create_set(context);
    const VkDescriptorSetLayout set_layout = bound_.set_layout;
    bound_.layout = create_pipeline_layout(context, {&set_layout, 1}, {});
    bound_.pipeline = create_graphics_pipeline(
        context, target, {.vertex_shader = sampling_vert, .fragment_shader = fragment_shader_, .layout = bound_.layout});
  }

  void draw(VkCommandBuffer commands) const override {
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, bound_.pipeline);
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, bound_.layout, 0, 1, &bound_.set, 0, nullptr);
    vkCmdDraw(commands, 3, 1, 0, 0);
  }

 private:
  void create_set(VkContext& context) {
    const VkDescriptorSetLayoutBinding binding{0, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, kTextures,
                                               VK_SHADER_STAGE_FRAGMENT_BIT, nullptr};
    const VkDescriptorSetLayoutCreateInfo info{
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO, .bindingCount = 1, .pBindings = &binding};
    VkDescriptorSetLayout set_layout = VK_NULL_HANDLE;
    check(vkCreateDescriptorSetLayout(context.device(), &info, nullptr, &set_layout), "vkCreateDescriptorSetLayout");
    bound_.set_layout = {context.device(), set_layout};
    bound_.descriptors.emplace(context, 1, kTextures);
    bound_.set = bound_.descriptors->allocate(bound_.set_layout);
    std::array<VkDescriptorImageInfo, kTextures> images;
    for (uint32_t i = 0; i < kTextures; ++i) images[i] = {sampler_, textures_[i].view, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
    const VkWriteDescriptorSet write{.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                     .dstSet = bound_.set,
                                     .descriptorCount = kTextures,
                                     .descriptorType = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER,
                                     .pImageInfo = images.data()};
    vkUpdateDescriptorSets(context.device(), 1, &write, 0, nullptr);
  }

  Spirv fragment_shader_;
  std::array<Image2D, kTextures> textures_;
  SamplerHandle sampler_;
  BoundPipeline bound_;
};

class BlocksScene final : public FourTextures {
 public:
  BlocksScene() : FourTextures(blocks_frag) {}

 protected:
  std::array<Image2D, kTextures> make_textures(VkContext& context) override {
    const std::vector<Image> levels = make_mip_chain(make_picture());
    return {create_block_texture(context, levels, BlockFormat::kBc1), create_block_texture(context, levels, BlockFormat::kBc7),
            create_block_texture(context, levels, BlockFormat::kEtc2),
            create_block_texture(context, levels, BlockFormat::kAstc4x4)};
  }
};

class BlitsScene final : public FourTextures {
 public:
  BlitsScene() : FourTextures(blits_frag) {}

 protected:
  std::array<Image2D, kTextures> make_textures(VkContext& context) override {
    const Image picture = make_picture();
    constexpr VkExtent2D kWide{410, 190};
    return {blitted(context, picture, VK_FORMAT_R8G8B8A8_UNORM, {kSide, kSide}, VK_FORMAT_R8G8B8A8_UNORM, true),
            blitted(context, picture, VK_FORMAT_R8G8B8A8_UNORM, kWide, VK_FORMAT_R8G8B8A8_UNORM, false),
            blitted(context, picture, VK_FORMAT_R8G8B8A8_UNORM, kWide, VK_FORMAT_R16G16B16A16_SFLOAT, false),
            blitted(context, picture, VK_FORMAT_R8G8B8A8_SRGB, kWide, VK_FORMAT_R8G8B8A8_SRGB, false)};
  }

 private:
  // The picture scaled to `extent`; without a chain mirrored in x.
  static Image2D blitted(VkContext& context, const Image& picture, VkFormat from, VkExtent2D extent, VkFormat to, bool chain) {
    constexpr VkImageUsageFlags kUsage =
        VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT | VK_IMAGE_USAGE_SAMPLED_BIT;
    const Image2D source = create_image(context, {picture.width, picture.height}, 1, from, kUsage);
    Image2D target = create_image(context, extent, chain ? 9 : 1, to, kUsage);
    const Buffer staging = create_buffer(context, picture.rgba, VK_BUFFER_USAGE_TRANSFER_SRC_BIT);
    context.run_once([&](VkCommandBuffer commands) {
      const auto to_general = [&](const Image2D& image) {
        transition(commands, image, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_GENERAL, 0, VK_ACCESS_TRANSFER_WRITE_BIT,
                   VK_PIPELINE_STAGE_TOP_OF_PIPE_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT);
      };
      const auto wait = [&](const Image2D& image) {
        transition(commands, image, VK_IMAGE_LAYOUT_GENERAL, VK_IMAGE_LAYOUT_GENERAL, VK_ACCESS_TRANSFER_WRITE_BIT,
                   VK_ACCESS_TRANSFER_READ_BIT | VK_ACCESS_TRANSFER_WRITE_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT,
                   VK_PIPELINE_STAGE_TRANSFER_BIT);
      };
      to_general(source);
      to_general(target);
      const VkBufferImageCopy copy{.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1},
                                   .imageExtent = {picture.width, picture.height, 1}};
      vkCmdCopyBufferToImage(commands, staging.handle, source.handle, VK_IMAGE_LAYOUT_GENERAL, 1, &copy);
      wait(source);
      const auto blit = [&](const Image2D& of, uint32_t from_level, uint32_t to_level) {
        const auto size = [](uint32_t texels, uint32_t level) { return static_cast<int32_t>(std::max(texels >> level, 1u)); };
        VkImageBlit region{{VK_IMAGE_ASPECT_COLOR_BIT, from_level, 0, 1},
                           {{}, {size(of.extent.width, from_level), size(of.extent.height, from_level), 1}},
                           {VK_IMAGE_ASPECT_COLOR_BIT, to_level, 0, 1},
                           {{}, {size(extent.width, to_level), size(extent.height, to_level), 1}}};
        if (!chain) std::swap(region.dstOffsets[0].x, region.dstOffsets[1].x);
        vkCmdBlitImage(commands, of.handle, VK_IMAGE_LAYOUT_GENERAL, target.handle, VK_IMAGE_LAYOUT_GENERAL, 1, &region,
                       VK_FILTER_LINEAR);
      };
      blit(source, 0, 0);
      for (uint32_t level = 1; level < target.mip_levels; ++level) {
        wait(target);
        blit(target, level - 1, level);
      }
      transition(commands, target, VK_IMAGE_LAYOUT_GENERAL, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL,
                 VK_ACCESS_TRANSFER_WRITE_BIT, VK_ACCESS_SHADER_READ_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT,
                 VK_PIPELINE_STAGE_FRAGMENT_SHADER_BIT);
    });
    return target;
  }
};

}  // namespace

std::unique_ptr<Scene> make_blocks_scene() { return std::make_unique<BlocksScene>(); }
std::unique_ptr<Scene> make_blits_scene() { return std::make_unique<BlitsScene>(); }

}  // namespace pineda::tools
