// Order-independent transparency: cards that cut through each other, blended by depth whatever the order of drawing. One pass
// stores fragments by atomics, the next one blends what it finds in each pixel.
#include <array>
#include <cstdint>
#include <optional>

#include "shaders/oit_list_blend_frag.h"
#include "shaders/oit_list_frag.h"
#include "shaders/oit_nearest_blend_frag.h"
#include "shaders/oit_nearest_frag.h"
#include "shaders/oit_vert.h"
#include "shaders/screen_vert.h"
#include "tools/scenes/scenes.h"

namespace pineda::tools {
namespace {

struct Vertex {
  float position[3], colour[4];
  uint32_t card;
};

constexpr uint32_t kCards = 12;
constexpr float kCos30 = 0.8660254f, kSin30 = 0.5f;  // constants, because libm may differ between machines
constexpr VkDeviceSize kNodesPerPixel = 3, kNodeBytes = 12, kKeysPerPixel = 4;

// A wheel whose cards reach from one depth at the hub to another at the rim.
std::vector<Vertex> make_cards(float aspect) {
  constexpr float kHub = 0.10f, kRim = 0.92f, kHubHalfWidth = 0.20f, kRimHalfWidth = 0.34f;
  constexpr float kCorners[6][2] = {{kHub, -kHubHalfWidth}, {kRim, -kRimHalfWidth}, {kRim, kRimHalfWidth},
                                    {kHub, -kHubHalfWidth}, {kRim, kRimHalfWidth},  {kHub, kHubHalfWidth}};
  std::vector<Vertex> vertices;
  float cosine = 0, sine = -1;
  for (uint32_t card = 0; card < kCards; ++card) {
    const auto level = [&](uint32_t step) { return 0.1f + 0.8f * static_cast<float>(card * step % kCards) / kCards; };
    const float hue = static_cast<float>(card) / kCards;
    for (const auto& [along, across] : kCorners) {
      const bool at_rim = along == kRim;
      // Tilted across, too, so that neighbours cut each other.
      const float depth = level(at_rim ? 7 : 5) + (across > 0 ? 0.07f : -0.07f);
      vertices.push_back({{(along * cosine - across * sine) / aspect, along * sine + across * cosine, depth},
                          {0.25f + 0.7f * hue, 0.85f - 0.6f * hue, at_rim ? 0.85f : 0.35f, at_rim ? 0.65f : 0.5f},
                          card});
    }
    const float next = cosine * kCos30 - sine * kSin30;
    sine = cosine * kSin30 + sine * kCos30;
    cosine = next;
  }
  return vertices;
}

class OitScene final : public Scene {
 public:
  explicit OitScene(OitKind kind) : kind_(kind) {}

  void prepare(VkContext& context, VkExtent2D extent) override {
    store_target_.emplace(context, extent, RenderTarget::Attachments::kColour);
    target_.emplace(context, extent, RenderTarget::Attachments::kColour);
    const auto [width, height] = extent;
    vertices_ = create_buffer(context, make_cards(static_cast<float>(width) / static_cast<float>(height)),
                              VK_BUFFER_USAGE_VERTEX_BUFFER_BIT);
    constexpr VkBufferUsageFlags kUsage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
    const VkDeviceSize pixels = VkDeviceSize{width} * height;
    const bool lists = kind_ == OitKind::kABuffer;
    buffers_[0] = create_buffer(context, pixels * 4 * (lists ? 1 : kKeysPerPixel), kUsage);
    buffers_[1] = create_buffer(context, lists ? 4 + pixels * kNodesPerPixel * kNodeBytes : 4, kUsage);
    create_set(context);
    const VkDescriptorSetLayout set_layout = set_layout_;
    const VkPushConstantRange range{VK_SHADER_STAGE_FRAGMENT_BIT, 0, sizeof(uint32_t)};
    layout_ = create_pipeline_layout(context, {&set_layout, 1}, {&range, 1});
    store_ = create_graphics_pipeline(context, *store_target_,
                                      {.vertex_shader = oit_vert,
                                       .fragment_shader = lists ? Spirv(oit_list_frag) : Spirv(oit_nearest_frag),
                                       .vertex_bindings = {{0, sizeof(Vertex), VK_VERTEX_INPUT_RATE_VERTEX}},
                                       .vertex_attributes = {{0, 0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(Vertex, position)},
                                                             {1, 0, VK_FORMAT_R32G32B32A32_SFLOAT, offsetof(Vertex, colour)},
                                                             {2, 0, VK_FORMAT_R32_UINT, offsetof(Vertex, card)}},
                                       // The shader's colour is transparent: nothing changes. Without blending, lavapipe takes
                                       // the cards for opaque and drops the stores of those under them (docs/differences.md).
                                       .alpha_blend = true,
                                       .layout = layout_});
    blend_ = create_graphics_pipeline(context, *target_,
                                      {.vertex_shader = screen_vert,
                                       .fragment_shader = lists ? Spirv(oit_list_blend_frag) : Spirv(oit_nearest_blend_frag),
                                       .layout = layout_});
  }

  void record(VkCommandBuffer commands) const override {
    vkCmdFillBuffer(commands, buffers_[0].handle, 0, VK_WHOLE_SIZE, kind_ == OitKind::kABuffer ? 0 : ~0u);
    vkCmdFillBuffer(commands, buffers_[1].handle, 0, 4, 0);
    constexpr VkAccessFlags kShader = VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT;
    barrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT, kShader);
    draw(commands, *store_target_, store_, static_cast<uint32_t>(6 * kCards));
    barrier(commands, VK_PIPELINE_STAGE_FRAGMENT_SHADER_BIT, kShader, kShader);
    draw(commands, *target_, blend_, 3);
  }

  const Image2D& picture() const override { return target_->colour(); }

 private:
  void create_set(VkContext& context) {
    std::array<Binding, 2> bindings;
    for (uint32_t i = 0; i < 2; ++i) bindings[i] = {i, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, VK_SHADER_STAGE_FRAGMENT_BIT};
    set_layout_ = create_set_layout(context, bindings);
    descriptors_.emplace(context, 1, 2);
    set_ = descriptors_->allocate(set_layout_);
    for (uint32_t i = 0; i < 2; ++i) descriptors_->write_buffer(set_, i, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, buffers_[i]);
  }

  static void barrier(VkCommandBuffer commands, VkPipelineStageFlags stage, VkAccessFlags from, VkAccessFlags to) {
    const VkMemoryBarrier memory{.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER, .srcAccessMask = from, .dstAccessMask = to};
    vkCmdPipelineBarrier(commands, stage, VK_PIPELINE_STAGE_FRAGMENT_SHADER_BIT, 0, 1, &memory, 0, nullptr, 0, nullptr);
  }

  void draw(VkCommandBuffer commands, const RenderTarget& target, VkPipeline pipeline, uint32_t vertex_count) const {
    target.begin(commands, {0.953f, 0.957f, 0.965f, 1.0f});
    const VkDeviceSize offset = 0;
    const VkBuffer buffer = vertices_.handle;
    const uint32_t width = target.extent().width;
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline);
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, layout_, 0, 1, &set_, 0, nullptr);
    vkCmdBindVertexBuffers(commands, 0, 1, &buffer, &offset);
    vkCmdPushConstants(commands, layout_, VK_SHADER_STAGE_FRAGMENT_BIT, 0, sizeof width, &width);
    vkCmdDraw(commands, vertex_count, 1, 0, 0);
    vkCmdEndRenderPass(commands);
  }

  const OitKind kind_;
  std::optional<RenderTarget> store_target_, target_;
  Buffer vertices_;
  std::array<Buffer, 2> buffers_;
  std::optional<DescriptorAllocator> descriptors_;
  DescriptorSetLayoutHandle set_layout_;
  VkDescriptorSet set_ = VK_NULL_HANDLE;
  PipelineLayoutHandle layout_;
  PipelineHandle store_, blend_;
};

}  // namespace

std::unique_ptr<Scene> make_oit_scene(OitKind kind) { return std::make_unique<OitScene>(kind); }

}  // namespace pineda::tools
